//! What a mapping of columns gets wrong.

use crate::unit::PositionUnit;

/// Why a mapping cannot be used, whatever the table holds.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MappingError {
    /// The lists are not of the same joints.
    #[error("the mapping has {positions} positions but {torques} torques; it needs one of each for every joint")]
    UnequalLengths {
        /// Length of the list of positions.
        positions: usize,
        /// Length of the list of torques.
        torques: usize,
    },
    /// There are no joints, and nothing else tells how what reads gravity stood.
    #[error("the mapping names no position column")]
    NoPositions,
    /// The number of columns is not that of the form.
    #[error("an orientation of this form has {expected} columns, found {found}")]
    OrientationColumns {
        /// How many the form has.
        expected: usize,
        /// How many are named.
        found: usize,
    },
    /// One column is said to be two readings.
    #[error("column `{column}` is mapped to two readings; each reading needs its own column")]
    ColumnTwice {
        /// Name of the column.
        column: String,
    },
    /// A count without a standard deviation means nothing.
    #[error("column `{column}`: a number of samples is given but no standard deviation of one sample")]
    CountWithoutStd {
        /// Name of the column of the reading.
        column: String,
    },
    /// The constant standard deviation cannot be one.
    #[error("column `{column}`: the standard deviation must be finite and greater than 0, found {found}")]
    BadStd {
        /// Name of the column of the reading.
        column: String,
        /// The number, in the unit of the reading.
        found: f64,
    },
    /// There is nothing between the ends of the range.
    #[error("column `{column}`: the range of readings must go from lower to higher, found {lowest} to {highest}")]
    BadRange {
        /// Name of the column of the reading.
        column: String,
        /// Its lower end, in the unit of the reading.
        lowest: f64,
        /// Its upper end.
        highest: f64,
    },
    /// A slope is taken over time.
    #[error("a slope is taken over time, and no column tells the time: name it")]
    SlopeWithoutTime,
    /// The window of a slope cannot be one.
    #[error("the time over which a slope is taken must be finite and greater than 0, found {found} s")]
    BadWindow {
        /// Its width, s.
        found: f64,
    },
    /// The slope of readings in the sensor's own unit is no velocity.
    #[error(
        "column `{column}`: the slope of positions in {unit} is no velocity, as the sensor's gain is unknown: name the \
         columns of the velocities instead"
    )]
    SlopeOfSensorUnit {
        /// Name of the column of positions.
        column: String,
        /// Its unit.
        unit: PositionUnit,
    },
    /// An acceleration is the slope of a velocity.
    #[error("an acceleration is the slope of a velocity, and nothing tells the velocities: say where they come from")]
    AccelerationWithoutVelocity,
    /// Limits of speed without speeds.
    #[error(
        "speeds are limited, and nothing tells the velocity of each joint: name its columns, or take the slope of its \
         position over time"
    )]
    SpeedUnknown,
    /// Limits of acceleration without accelerations.
    #[error(
        "accelerations are limited, and nothing tells the acceleration of each joint: name its columns, or take the \
         slope of its velocity over time"
    )]
    AccelerationUnknown,
    /// The constant number of samples cannot be one.
    #[error("column `{column}`: the number of samples must be finite and at least 1, found {found}")]
    BadCount {
        /// Name of the column of the reading.
        column: String,
        /// The number.
        found: f64,
    },
}
