//! Dates with times as cells hold them, such as `2024-05-01 12:00:00.010000` and `2024-05-01T12:00:00.010+02:00` (ISO 8601).

use jiff::Timestamp;
use jiff::fmt::temporal::Pieces;
use jiff::tz::Offset;

/// Name of the unit of a clock whose cells are dates with times.
pub(crate) const ISO_8601: &str = "ISO 8601";

/// Seconds since 1970-01-01 in UTC, good to a microsecond; `None` where the text is no date with a time. Without an offset it is taken
/// to be in UTC.
pub(crate) fn seconds(text: &str) -> Option<f64> {
    // Most cells are numbers.
    if !text.starts_with(|sign: char| sign.is_ascii_digit()) || text.parse::<f64>().is_ok() {
        return None;
    }
    let pieces = Pieces::parse(text).ok()?;
    let offset = pieces.to_numeric_offset().unwrap_or(Offset::UTC);
    let at = offset.to_timestamp(pieces.date().to_datetime(pieces.time()?)).ok()?;
    Some(at.as_nanosecond() as f64 / 1e9)
}

/// The same backwards, to the millisecond; the number where it is beyond all dates.
pub(crate) fn text(seconds: f64) -> String {
    match Timestamp::from_millisecond((seconds * 1e3).round() as i64) {
        Ok(at) => format!("{at:.3}"),
        Err(_) => format!("{seconds:.3} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_with_times_are_seconds() {
        let noon = 1_714_564_800.0;
        let same = [
            "2024-05-01 12:00:00",
            "2024-05-01T12:00:00.000Z",
            "2024-05-01 12:00:00+00:00",
            "2024-05-01T14:00:00+02:00",
            "2024-05-01 14:00:00+0200",
            "20240501T120000Z",
            "2024-05-01T05:00-07:00",
        ];
        assert_eq!(same.map(seconds), [Some(noon); 7]);
        for text in ["2024-05-01 12:00:00.010000", "2024-05-01T12:00:00,010Z"] {
            assert!((seconds(text).unwrap() - noon - 0.01).abs() < 1e-6, "{text}");
        }
    }

    #[test]
    fn what_is_none_is_none() {
        for text in
            ["", "12.5", "20240501", "2024-05-01", "12:00:00", "2024-13-01 12:00:00", "01.05.2024 12:00", "joint"]
        {
            assert_eq!(seconds(text), None, "{text}");
        }
    }

    #[test]
    fn seconds_are_dates() {
        assert_eq!(text(1_714_564_800.010_4), "2024-05-01T12:00:00.010Z");
        assert_eq!(text(1e30), "1000000000000000019884624838656.000 s");
    }
}
