//! Which column of a table is which reading of which joint, and in which unit.

use crate::conditions::{ConditionColumns, Slope};
use crate::csv_lines::CsvWriting;
use crate::mapping_error::MappingError;
use crate::orientation::OrientationColumns;
use crate::selection::Selection;
use crate::unit::{PositionUnit, TorqueUnit};

/// What the columns of a table of static poses mean. Joints are places in the two lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseMapping {
    /// The position reading of every joint.
    pub positions: Vec<PositionColumn>,
    /// The torque reading of every joint, in its unit; `None` for a joint whose torque is not recorded. As long as
    /// `positions`.
    pub torques: Vec<Option<(ReadingColumn, TorqueUnit)>>,
    /// How the body that carries the instruments stood, where no joints tell it.
    pub orientation: Option<OrientationColumns>,
    /// Readings of instruments that belong to no joint, each in its own unit; `None` for an axis that is not recorded.
    pub instruments: Vec<Option<ReadingColumn>>,
    /// A column of labels that say which rows belong together, such as the name of a sweep. An empty cell is no label.
    pub sweep_column: Option<String>,
    /// Whether consecutive rows of one sweep with exactly equal position readings are one pose. Set it when the
    /// table holds single samples of a standstill: they share its position, so they are no independent poses.
    pub merge_repeated: bool,
    /// What else is said of each pose.
    pub conditions: ConditionColumns,
    /// Which readings count, where the arm moves.
    pub selection: Selection,
    /// How CSV files are written.
    pub csv: CsvWriting,
}

/// Where the position of a joint stands.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionColumn {
    /// Name of the column.
    pub column: String,
    /// Unit of its numbers.
    pub unit: PositionUnit,
    /// By how much the joint's coordinate grows, rad or m, where the reading grows by one of its unit (rad, m, or the sensor's own): as far as that is known
    /// beforehand. Velocities and directions that come of readings are those of the coordinate by it.
    pub nominal_gain: f64,
}

impl PositionColumn {
    /// A column whose readings are the joint's coordinate.
    pub fn new(column: impl Into<String>, unit: PositionUnit) -> PositionColumn {
        PositionColumn { column: column.into(), unit, nominal_gain: 1.0 }
    }
}

/// Where a reading of torque or of an instrument stands, and what is known of its noise.
///
/// Without a count, the standard deviation is that of the recorded value. With a count m, the recorded value is the
/// mean of m samples and the standard deviation that of *one* of them; the mean's is then `std/√m`, if samples are
/// independent. (If they are correlated, give the effective number of independent samples; it need not be whole.)
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadingColumn {
    /// Name of the column with the value. An empty cell is a missing reading.
    pub column: String,
    /// Column with the standard deviation, in the unit of the reading.
    pub std_column: Option<String>,
    /// Column with the number of samples.
    pub count_column: Option<String>,
    /// Column that says whether the reading is usable: 1 or true, 0 or false. The other cells of an unusable reading
    /// are not looked at.
    pub usable_column: Option<String>,
    /// Standard deviation of every row, in the unit of the reading; with a `std_column`, of the rows where that is empty.
    pub std: Option<f64>,
    /// Number of samples of every row; with a `count_column`, of the rows where that is empty.
    pub count: Option<f64>,
    /// Ends of the sensor's range, in the unit of the reading. A reading there or beyond is saturated: the true one may be
    /// anything beyond.
    pub lowest: Option<f64>,
    /// The other end.
    pub highest: Option<f64>,
}

impl PoseMapping {
    /// Looks for contradictions that need no table to be seen. [`read_poses`](crate::read_poses) does so itself.
    ///
    /// # Errors
    ///
    /// The lists are empty or of different lengths, a column is mapped to two readings, a constant is out of range,
    /// a count comes without a standard deviation, or velocities and accelerations that are limited or differentiated are
    /// nowhere to be had.
    pub fn check(&self) -> Result<(), MappingError> {
        let (positions, torques) = (self.positions.len(), self.torques.len());
        if positions == 0 && self.orientation.is_none() {
            return Err(MappingError::NoPositions);
        }
        if let Some(OrientationColumns { columns, form, .. }) = &self.orientation
            && columns.len() != form.columns()
        {
            return Err(MappingError::OrientationColumns { expected: form.columns(), found: columns.len() });
        }
        if positions != torques {
            return Err(MappingError::UnequalLengths { positions, torques });
        }
        self.torques.iter().flatten().try_for_each(|(torque, _)| torque.check())?;
        self.instruments.iter().flatten().try_for_each(ReadingColumn::check)?;
        self.check_columns_differ()?;
        self.check_slopes()?;
        self.check_selection()
    }

    fn check_slopes(&self) -> Result<(), MappingError> {
        let (velocity, acceleration) = (self.conditions.velocity.slope(), self.conditions.acceleration.slope());
        for Slope { window } in velocity.into_iter().chain(acceleration) {
            if !(window.is_finite() && window > 0.0) {
                return Err(MappingError::BadWindow { found: window });
            }
            if self.conditions.time.is_none() {
                return Err(MappingError::SlopeWithoutTime);
            }
        }
        if acceleration.is_some() && !self.conditions.velocity.is_known() {
            return Err(MappingError::AccelerationWithoutVelocity);
        }
        match self.positions.iter().find(|position| velocity.is_some() && position.unit.is_sensors_own()) {
            Some(PositionColumn { column, unit, .. }) => {
                Err(MappingError::SlopeOfSensorUnit { column: column.clone(), unit: *unit })
            }
            None => Ok(()),
        }
    }

    fn check_selection(&self) -> Result<(), MappingError> {
        let limits = [&self.selection.arm, &self.selection.joint];
        if limits.iter().any(|limits| limits.limit_speed()) && !self.conditions.velocity.is_known() {
            return Err(MappingError::SpeedUnknown);
        }
        if limits.iter().any(|limits| limits.limit_acceleration()) && !self.conditions.acceleration.is_known() {
            return Err(MappingError::AccelerationUnknown);
        }
        Ok(())
    }

    /// Columns of counts, deviations and flags may be shared between joints; those of readings may not.
    fn check_columns_differ(&self) -> Result<(), MappingError> {
        let positions = self.positions.iter().map(|position| &position.column);
        let torques = self.torques.iter().flatten().map(|(torque, _)| &torque.column);
        let mut seen: Vec<&String> = Vec::new();
        let instruments = self.instruments.iter().flatten().map(|reading| &reading.column);
        let orientation = self.orientation.iter().flat_map(|orientation| &orientation.columns);
        for column in positions.chain(orientation).chain(torques).chain(instruments) {
            if seen.contains(&column) {
                return Err(MappingError::ColumnTwice { column: column.clone() });
            }
            seen.push(column);
        }
        Ok(())
    }
}

impl ReadingColumn {
    fn check(&self) -> Result<(), MappingError> {
        let column = || self.column.clone();
        let has_std = self.std.is_some() || self.std_column.is_some();
        let has_count = self.count.is_some() || self.count_column.is_some();
        if has_count && !has_std {
            return Err(MappingError::CountWithoutStd { column: column() });
        }
        if let Some(found) = self.std.filter(|std| !(std.is_finite() && *std > 0.0)) {
            return Err(MappingError::BadStd { column: column(), found });
        }
        if let Some(found) = self.count.filter(|count| !(count.is_finite() && *count >= 1.0)) {
            return Err(MappingError::BadCount { column: column(), found });
        }
        match (self.lowest, self.highest) {
            (Some(lowest), Some(highest)) if lowest >= highest => {
                Err(MappingError::BadRange { column: column(), lowest, highest })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn torque(column: &str) -> ReadingColumn {
        ReadingColumn { column: column.to_owned(), ..ReadingColumn::default() }
    }

    fn mapping(positions: &[&str], torques: &[ReadingColumn]) -> PoseMapping {
        let position = |column: &&str| PositionColumn::new(*column, PositionUnit::Radian);
        PoseMapping {
            positions: positions.iter().map(position).collect(),
            torques: torques.iter().map(|torque| Some((torque.clone(), TorqueUnit::Count))).collect(),
            ..PoseMapping::default()
        }
    }

    fn message(mapping: &PoseMapping) -> String {
        mapping.check().unwrap_err().to_string()
    }

    #[test]
    fn columns_of_noise_may_be_shared() {
        let shared = |column: &str| ReadingColumn {
            std_column: Some("std".to_owned()),
            count_column: Some("n".to_owned()),
            ..torque(column)
        };
        assert_eq!(mapping(&["q1", "q2"], &[shared("tau1"), shared("tau2")]).check(), Ok(()));
    }

    #[test]
    fn lists_must_be_of_the_same_joints() {
        assert_eq!(message(&mapping(&[], &[])), "the mapping names no position column");
        assert_eq!(
            message(&mapping(&["q1", "q2"], &[torque("tau1")])),
            "the mapping has 2 positions but 1 torques; it needs one of each for every joint"
        );
    }

    #[test]
    fn a_column_is_one_reading() {
        let expected = "column `q1` is mapped to two readings; each reading needs its own column";
        assert_eq!(message(&mapping(&["q1", "q1"], &[torque("tau1"), torque("tau2")])), expected);
        assert_eq!(message(&mapping(&["q1"], &[torque("q1")])), expected);
    }

    #[test]
    fn a_count_needs_a_standard_deviation() {
        let expected = "column `tau1`: a number of samples is given but no standard deviation of one sample";
        let constant = ReadingColumn { count: Some(9.0), ..torque("tau1") };
        let column = ReadingColumn { count_column: Some("n".to_owned()), ..torque("tau1") };
        for torque in [constant, column] {
            assert_eq!(message(&mapping(&["q1"], &[torque])), expected);
        }
    }

    #[test]
    fn a_range_goes_from_lower_to_higher() {
        let range = |lowest, highest| ReadingColumn { lowest, highest, ..torque("tau1") };
        assert_eq!(mapping(&["q1"], &[range(Some(0.0), Some(4095.0))]).check(), Ok(()));
        assert_eq!(mapping(&["q1"], &[range(Some(0.0), None)]).check(), Ok(()));
        assert_eq!(
            message(&mapping(&["q1"], &[range(Some(10.0), Some(-10.0))])),
            "column `tau1`: the range of readings must go from lower to higher, found 10 to -10"
        );
    }

    #[test]
    fn constants_must_be_in_range() {
        for (std, shown) in [(0.0, "0"), (-1.0, "-1"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
            let torque = ReadingColumn { std: Some(std), ..torque("tau1") };
            assert_eq!(
                message(&mapping(&["q1"], &[torque])),
                format!("column `tau1`: the standard deviation must be finite and greater than 0, found {shown}")
            );
        }
        for (count, shown) in [(0.5, "0.5"), (0.0, "0"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
            let torque = ReadingColumn { std: Some(1.0), count: Some(count), ..torque("tau1") };
            assert_eq!(
                message(&mapping(&["q1"], &[torque])),
                format!("column `tau1`: the number of samples must be finite and at least 1, found {shown}")
            );
        }
    }
}
