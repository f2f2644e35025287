//! Numbers with as many digits as they deserve.

/// Significant digits of a value at most, however small its standard deviation.
const MOST_DIGITS: i32 = 9;

/// A value and its standard deviation, both down to the second significant digit of the latter: `7.118`, `0.020`.
///
/// Beyond what reads well as a plain number both turn to powers of ten: `7.6699e-4`, `1.2e-7`.
pub fn measured(value: f64, std: f64) -> (String, String) {
    if !(std > 0.0 && std.is_finite() && value.is_finite()) {
        return (shortest(value), shortest(std));
    }
    let first = decade(value.abs().max(std), 2);
    let last = decade(std, 2) - 1;
    if !(-3..7).contains(&first) {
        return (power_of_ten(value, last), format!("{std:.1e}"));
    }
    let most = MOST_DIGITS - 1 - first;
    let decimals = (-last).clamp(0, most) as usize;
    let std = if -last > most { format!("{std:.1e}") } else { format!("{std:.decimals$}") };
    (unsigned_zero(format!("{value:.decimals$}")), std)
}

/// A value down to the decade `last`.
fn power_of_ten(value: f64, last: i32) -> String {
    let first = decade(value, 1);
    if value == 0.0 || first < last {
        return "0".to_owned();
    }
    let digits = (first - last).clamp(0, MOST_DIGITS - 1) as usize;
    format!("{value:.digits$e}")
}

/// A number with so many significant digits, trailing zeros kept: `0.80`.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return shortest(value);
    }
    let first = decade(value, digits);
    let digits = digits.max(1) - 1;
    if (-4..7).contains(&first) {
        let decimals = (digits as i32 - first).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.digits$e}")
    }
}

/// The unit in which people are shown a quantity of this unit, and the factor to it. Files stay in rad.
pub fn shown_unit(unit: &str) -> (&str, f64) {
    match unit {
        "rad" => ("deg", 180.0 / std::f64::consts::PI),
        other => (other, 1.0),
    }
}

/// A number with up to six significant digits, without trailing zeros: `2048`, `6.69`.
pub fn shortest(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return unsigned_zero(value.to_string());
    }
    let rounded = rounded(value, 6);
    if (-4..9).contains(&decade(rounded, 6)) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// A number rounded to so many significant digits.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.max(1) - 1).parse().unwrap_or(value)
}

/// Power of ten of the first digit after rounding to so many digits; 0 for zero.
fn decade(value: f64, digits: usize) -> i32 {
    let rounded = format!("{value:.*e}", digits.max(1) - 1);
    rounded.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// `-0.00` is a rounded value that is not less than zero for all anyone knows.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.parse() == Ok(0.0) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_angles_change_their_unit() {
        let (unit, factor) = shown_unit("rad");
        assert_eq!((unit, factor * std::f64::consts::PI), ("deg", 180.0));
        assert_eq!(shown_unit("rad/count"), ("rad/count", 1.0));
        assert_eq!(shown_unit("m"), ("m", 1.0));
    }

    fn reported(value: f64, std: f64) -> String {
        let (value, std) = measured(value, std);
        format!("{value} ± {std}")
    }

    #[test]
    fn standard_deviation_decides_the_digits() {
        assert_eq!(reported(7.11813, 0.0204), "7.118 ± 0.020");
        assert_eq!(reported(2075.1234, 0.118), "2075.12 ± 0.12");
        assert_eq!(reported(-134.2, 2.46), "-134.2 ± 2.5");
        assert_eq!(reported(2075.6, 31.4), "2076 ± 31");
        assert_eq!(reported(12345.6, 1234.5), "12346 ± 1234");
    }

    #[test]
    fn a_standard_deviation_that_rounds_up_keeps_two_digits() {
        assert_eq!(reported(1.0, 0.0996), "1.00 ± 0.10");
        assert_eq!(reported(50.0, 9.97), "50 ± 10");
    }

    #[test]
    fn small_and_large_numbers_turn_to_powers_of_ten() {
        assert_eq!(reported(7.6699e-4, 1.2e-7), "7.6699e-4 ± 1.2e-7");
        assert_eq!(reported(3.2e8, 1.5e6), "3.200e8 ± 1.5e6");
        assert_eq!(reported(2e-9, 3e-4), "0 ± 3.0e-4");
    }

    #[test]
    fn a_tiny_standard_deviation_does_not_blow_up_the_value() {
        assert_eq!(reported(-9.80665, 1.3e-12), "-9.80665000 ± 1.3e-12");
    }

    #[test]
    fn zero_is_reported_plainly() {
        assert_eq!(reported(-0.0004, 0.1), "0.00 ± 0.10");
        assert_eq!(reported(6.69, 0.0), "6.69 ± 0");
        assert_eq!(reported(-0.0, 0.0), "0 ± 0");
    }

    #[test]
    fn what_is_no_number_is_no_panic() {
        assert_eq!(reported(f64::NAN, 1.0), "NaN ± 1");
        assert_eq!(reported(1.0, f64::INFINITY), "1 ± inf");
        assert_eq!(significant(f64::NAN, 3), "NaN");
    }

    #[test]
    fn shortest_has_no_trailing_digits() {
        assert_eq!(shortest(135f64.to_radians().to_degrees()), "135");
        assert_eq!(shortest(2048.0), "2048");
        assert_eq!(shortest(0.087_266_46), "0.0872665");
        assert_eq!(shortest(7.669_903_9e-6), "7.6699e-6");
        assert_eq!(shortest(-0.0), "0");
    }

    #[test]
    fn significant_digits_are_kept() {
        assert_eq!(significant(0.8, 2), "0.80");
        assert_eq!(significant(1021.34, 5), "1021.3");
        assert_eq!(significant(123_456.0, 3), "123456");
        assert_eq!(significant(1.234e-7, 3), "1.23e-7");
        assert_eq!(significant(0.0, 3), "0");
    }
}
