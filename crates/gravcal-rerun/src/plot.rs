//! Series of numbers over a timeline.

use re_sdk::log::TimeColumn;
use re_sdk::time::TimelineName;
use re_sdk::{EntityPath, RecordingStream, RecordingStreamError};
use re_sdk_types::archetypes::{Scalars, SeriesLines, SeriesPoints};
use re_sdk_types::components::Color;

/// How a series is drawn.
pub enum Mark {
    /// As a line of this width, in points of the screen.
    Line(f32),
    /// As dots of this size.
    Dots(f32),
}

/// Logs a series as columns, with its name and colour; nothing where there are no values.
pub fn series(
    stream: &RecordingStream,
    path: EntityPath,
    (name, colour, mark): (&str, Color, Mark),
    times: impl IntoIterator<Item = TimeColumn>,
    values: Vec<f64>,
) -> Result<(), RecordingStreamError> {
    if values.is_empty() {
        return Ok(());
    }
    match mark {
        Mark::Line(width) => {
            let style = SeriesLines::new().with_names([name]).with_colors([colour]).with_widths([width]);
            stream.log_static(path.clone(), &style)?;
        }
        Mark::Dots(size) => {
            let style = SeriesPoints::new().with_names([name]).with_colors([colour]).with_marker_sizes([size]);
            stream.log_static(path.clone(), &style)?;
        }
    }
    stream.send_columns(path, times, Scalars::new(values).columns_of_unit_batches()?)
}

/// Numbers on the timeline `iteration`.
pub fn iterations(numbers: impl IntoIterator<Item = usize>) -> TimeColumn {
    sequence("iteration", numbers)
}

/// Numbers on a timeline.
pub fn sequence(name: impl Into<TimelineName>, numbers: impl IntoIterator<Item = usize>) -> TimeColumn {
    TimeColumn::new_sequence(name, numbers.into_iter().map(to_time))
}

/// No session has more poses than fit.
pub fn to_time(number: usize) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}
