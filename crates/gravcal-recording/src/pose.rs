//! Static poses in a table.

use std::path::Path;

use crate::columns::Columns;
use crate::error::ReadError;
use crate::mapping::PoseMapping;
use crate::merge::merge_repeated;
use crate::motion::reader::Part;
use crate::rows::Rows;
use crate::slope::differentiate;
use crate::static_pose::StaticPose;
use crate::table::Table;

/// The poses of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Two at least, in the order of the file.
    pub poses: Vec<StaticPose>,
    /// How many torque readings of each joint the mapping's limits of motion leave out.
    pub in_motion: Vec<usize>,
    /// What the reader says of the file: what was lost, cells that are no numbers.
    pub remarks: Vec<String>,
}

/// Reads a table of static poses.
///
/// # Errors
///
/// Everything that [`Table::read`] refuses; a column that the mapping names and the table has not; a cell that is
/// not what the mapping says; a missing position; a table in which all rows are one pose, or too fast; times over which no
/// slope can be taken; a mapping that contradicts itself.
pub fn read_poses(path: &Path, mapping: &PoseMapping) -> Result<Recording, ReadError> {
    read_part(path, mapping, Part::default())
}

/// The same of the rows that are in a part of the table, by the time that the mapping names; all rows are, where it names none.
///
/// # Errors
///
/// As [`read_poses`]; less than two rows are in the part.
pub fn read_part(path: &Path, mapping: &PoseMapping, part: Part) -> Result<Recording, ReadError> {
    mapping.check()?;
    poses_in(&Table::read_as(path, &mapping.csv)?, mapping, part)
}

/// The same of rows, which are told as those of `path`.
///
/// # Errors
///
/// As [`read_part`].
pub(crate) fn part_of_rows(
    path: &Path,
    rows: &mut dyn Rows,
    mapping: &PoseMapping,
    part: Part,
) -> Result<Recording, ReadError> {
    mapping.check()?;
    poses_in(&Table::of_rows(path, rows)?, mapping, part)
}

/// The poses in a table; `mapping` has been checked.
#[cfg(test)]
pub(crate) fn poses_of(table: &Table, mapping: &PoseMapping) -> Result<Recording, ReadError> {
    poses_in(table, mapping, Part::default())
}

/// Those in a part of it.
fn poses_in(table: &Table, mapping: &PoseMapping, part: Part) -> Result<Recording, ReadError> {
    let columns = Columns::find(table, mapping)?;
    let mut rows: Vec<StaticPose> = (0..table.len()).map(|row| columns.pose(row)).collect::<Result<_, _>>()?;
    // Slopes at the ends of a part see the rows beyond.
    differentiate(&mut rows, table, mapping)?;
    let path = || table.path().to_owned();
    let begun = rows.first().and_then(|row| row.conditions.time).unwrap_or(0.0);
    rows.retain(|row| row.conditions.time.is_none_or(|time| part.holds(time - begun)));
    let within = rows.len();
    if within < table.len().min(2) {
        return Err(ReadError::NothingInPart { path: path(), rows: table.len(), left: within });
    }
    let in_motion = mapping.selection.apply(&mut rows, mapping.positions.len());
    if rows.len() < within.min(2) {
        return Err(ReadError::AllInMotion { path: path(), rows: within, left: rows.len() });
    }
    let poses = if mapping.merge_repeated { merge_repeated(&rows) } else { rows };
    match poses.as_slice() {
        [only] => Err(ReadError::OnePose { path: path(), rows: only.merged }),
        _ => Ok(Recording { poses, in_motion, remarks: table.remarks().to_vec() }),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;
    use std::fs;

    use proptest::prelude::*;

    use super::*;
    use crate::conditions::{ConditionColumn, ConditionUnit, Conditions};
    use crate::csv_lines::CsvFormat;
    use crate::mapping::{PositionColumn, ReadingColumn};
    use crate::mapping_error::MappingError;
    use crate::static_pose::Reading;
    use crate::unit::{PositionUnit, TorqueUnit};

    fn torque(column: &str) -> ReadingColumn {
        ReadingColumn { column: column.to_owned(), ..ReadingColumn::default() }
    }

    /// One joint: `q` in degrees, and `tau` as described.
    fn one_joint(torque: ReadingColumn) -> PoseMapping {
        PoseMapping {
            positions: vec![PositionColumn::new("q", PositionUnit::Degree)],
            torques: vec![Some((torque, TorqueUnit::Count))],
            ..PoseMapping::default()
        }
    }

    fn parse(text: &str, mapping: &PoseMapping) -> Result<Vec<StaticPose>, ReadError> {
        mapping.check()?;
        poses_of(&Table::parse(Path::new("poses.csv"), text.as_bytes(), CsvFormat::default())?, mapping)
            .map(|found| found.poses)
    }

    fn message(text: &str, torque: ReadingColumn) -> String {
        parse(text, &one_joint(torque)).unwrap_err().to_string()
    }

    /// The torque readings of the only joint.
    fn torques(text: &str, torque: ReadingColumn) -> Vec<Option<Reading>> {
        let poses = parse(text, &one_joint(torque)).unwrap();
        poses.iter().map(|pose| pose.torque[0]).collect()
    }

    fn reading(value: f64, std: impl Into<Option<f64>>) -> Option<Reading> {
        Some(Reading { value, std: std.into() })
    }

    #[test]
    fn poses_are_in_si_units_and_in_the_order_of_the_file() {
        let mut mapping = one_joint(torque("tau"));
        mapping.positions.push(PositionColumn::new("x", PositionUnit::Millimeter));
        mapping.torques.push(None);
        mapping.sweep_column = Some("sweep".to_owned());
        let poses = parse("tau,x,q,sweep\n2075,250,90,up\n-3,0,-180,\n", &mapping).unwrap();
        let first = StaticPose {
            line: 2,
            position: vec![FRAC_PI_2, 0.25],
            orientation: None,
            torque: vec![reading(2075.0, None), None],
            instruments: Vec::new(),
            saturated: Vec::new(),
            sweep: Some("up".to_owned()),
            conditions: Conditions::default(),
            merged: 1,
        };
        let second = StaticPose {
            line: 3,
            position: vec![-2.0 * FRAC_PI_2, 0.0],
            orientation: None,
            torque: vec![reading(-3.0, None), None],
            instruments: Vec::new(),
            saturated: Vec::new(),
            sweep: None,
            conditions: Conditions::default(),
            merged: 1,
        };
        assert_eq!(poses, [first, second]);
    }

    #[test]
    fn an_empty_torque_cell_is_a_missing_reading() {
        let text = "q,tau\n0,1\n1, \n2,3\n";
        assert_eq!(torques(text, torque("tau")), [reading(1.0, None), None, reading(3.0, None)]);
    }

    #[test]
    fn a_torque_that_is_nan_is_missing_and_a_position_that_is_nan_is_an_error() {
        assert_eq!(torques("q,tau\n0,1\n1,NaN\n", torque("tau")), [reading(1.0, None), None]);
        assert_eq!(
            message("q,tau\n0,1\nnan,2\n", torque("tau")),
            "poses.csv:3: column `q`: the position is missing, and every torque depends on every position; \
             delete the row, or, where positions and torques have rows of their own (two topics, two rates), let poses be found in the \
             recording (readings.still)"
        );
    }

    #[test]
    fn of_a_part_rows_count_by_their_times_after_the_first() {
        let mut mapping = one_joint(torque("tau"));
        mapping.conditions.time = Some(ConditionColumn { column: "t".to_owned(), unit: ConditionUnit::TIME[1] });
        let table = "t,q,tau\n5000,1,0\n6000,2,0\n7000,3,0\n8000,4,0\n9000,5,0\n";
        let table = Table::parse(Path::new("a.csv"), table.as_bytes(), CsvFormat::default()).unwrap();
        let lines = |from, until| {
            let read = poses_in(&table, &mapping, Part { from, until }).map_err(|error| error.to_string())?;
            Ok::<_, String>(read.poses.iter().map(|pose| pose.line).collect::<Vec<_>>())
        };
        assert_eq!(lines(None, None).unwrap(), [2, 3, 4, 5, 6]);
        // Parts that meet share no row.
        assert_eq!((lines(None, Some(2.0)).unwrap(), lines(Some(2.0), None).unwrap()), (vec![2, 3], vec![4, 5, 6]));
        let few = "a.csv: 1 of its 5 rows are between from_s and until_s, and two at least are needed; widen them";
        assert_eq!(lines(Some(1.0), Some(2.0)).unwrap_err(), few);
    }

    #[test]
    fn a_missing_position_is_an_error() {
        assert_eq!(
            message("q,tau\n0,1\n,2\n", torque("tau")),
            "poses.csv:3: column `q`: the position is missing, and every torque depends on every position; \
             delete the row, or, where positions and torques have rows of their own (two topics, two rates), let poses be found in the \
             recording (readings.still)"
        );
    }

    #[test]
    fn a_missing_column_is_an_error() {
        assert_eq!(
            message("q,tau_1\n0,1\n1,2\n", torque("tau1")),
            "poses.csv: there is no column `tau1` (did you mean `tau_1`?); the columns are `q`, `tau_1`"
        );
    }

    #[test]
    fn a_reading_that_is_no_number_is_an_error() {
        assert_eq!(
            message("q,tau\n0,1\n1,inf\n", torque("tau")),
            "poses.csv:3: column `tau`: expected a finite number, found `inf`; \
             leave the cell empty if a reading is missing, and remove a row that gives units or is no reading"
        );
    }

    #[test]
    fn a_deviation_without_count_is_that_of_the_value() {
        let column = ReadingColumn { std_column: Some("s".to_owned()), ..torque("tau") };
        assert_eq!(torques("q,tau,s\n0,1,0.5\n1,2,\n", column), [reading(1.0, 0.5), reading(2.0, None)]);
    }

    #[test]
    fn a_deviation_with_count_is_that_of_one_sample() {
        let columns =
            ReadingColumn { std_column: Some("s".to_owned()), count_column: Some("n".to_owned()), ..torque("tau") };
        let constants = ReadingColumn { std: Some(3.0), count: Some(9.0), ..torque("tau") };
        let text = "q,tau,s,n\n0,1,3,9\n1,2,3,9\n";
        for mapped in [columns, constants] {
            assert_eq!(torques(text, mapped), [reading(1.0, 1.0), reading(2.0, 1.0)]);
        }
    }

    #[test]
    fn constants_fill_empty_cells_of_their_columns() {
        let mapped = ReadingColumn {
            std_column: Some("s".to_owned()),
            count_column: Some("n".to_owned()),
            std: Some(8.0),
            count: Some(4.0),
            ..torque("tau")
        };
        assert_eq!(
            torques("q,tau,s,n\n0,1,,\n1,2,6,\n2,3,,16\n", mapped),
            [reading(1.0, 4.0), reading(2.0, 3.0), reading(3.0, 2.0)]
        );
    }

    #[test]
    fn deviations_must_be_positive() {
        let mapped = ReadingColumn { std_column: Some("s".to_owned()), ..torque("tau") };
        for found in ["0", "-0.5"] {
            assert_eq!(
                message(&format!("q,tau,s\n0,1,{found}\n1,2,1\n"), mapped.clone()),
                format!(
                    "poses.csv:2: column `s`: a standard deviation must be greater than 0, found {found}; \
                     leave the cell empty if it is unknown"
                )
            );
        }
    }

    #[test]
    fn a_deviation_may_not_vanish_in_the_mean() {
        let mapped = ReadingColumn { std: Some(f64::from_bits(1)), count: Some(1e6), ..torque("tau") };
        let error = parse("q,tau\n0,1\n1,2\n", &one_joint(mapped)).unwrap_err();
        assert!(matches!(error, ReadError::BadStd { place, .. } if place.column == "tau"));
    }

    #[test]
    fn counts_must_be_at_least_one_and_present() {
        let mapped = ReadingColumn { std: Some(1.0), count_column: Some("n".to_owned()), ..torque("tau") };
        assert_eq!(
            message("q,tau,n\n0,1,5\n1,2,0\n", mapped.clone()),
            "poses.csv:3: column `n`: a number of samples must be at least 1, found 0"
        );
        assert_eq!(
            message("q,tau,n\n0,1,5\n1,2,\n", mapped.clone()),
            "poses.csv:3: column `n`: the number of samples is missing, and the mean's standard deviation \
             depends on it; fill it in, or leave the reading empty"
        );
        // Of a reading that is missing, no count is missing.
        assert_eq!(torques("q,tau,n\n0,1,4\n1,,\n", mapped), [reading(1.0, 0.5), None]);
    }

    #[test]
    fn unusable_readings_are_none_whatever_stands_there() {
        let mapped = ReadingColumn { usable_column: Some("ok".to_owned()), ..torque("tau") };
        assert_eq!(
            torques("q,tau,ok\n0,1,1\n1,2,0\n2,nan,False\n3,4,true\n4,,1\n", mapped),
            [reading(1.0, None), None, None, reading(4.0, None), None]
        );
    }

    #[test]
    fn usable_is_yes_or_no() {
        let mapped = ReadingColumn { usable_column: Some("ok".to_owned()), ..torque("tau") };
        for found in ["yes", "2", ""] {
            assert_eq!(
                message(&format!("q,tau,ok\n0,1,{found}\n1,2,1\n"), mapped.clone()),
                format!(
                    "poses.csv:2: column `ok`: expected 1 or true (usable), 0 or false (not usable), found `{found}`"
                )
            );
        }
    }

    #[test]
    fn one_pose_is_not_enough() {
        assert_eq!(
            message("q,tau\n0,1\n", torque("tau")),
            "poses.csv: a table of one pose cannot identify anything; record more poses"
        );
        let mut mapping = one_joint(torque("tau"));
        mapping.merge_repeated = true;
        assert_eq!(
            parse("q,tau\n5,1\n5,2\n5,3\n", &mapping).unwrap_err().to_string(),
            "poses.csv: a table of one pose cannot identify anything (its 3 rows all have the same positions); \
             record more poses"
        );
        mapping.merge_repeated = false;
        assert_eq!(parse("q,tau\n5,1\n5,2\n5,3\n", &mapping).unwrap().len(), 3);
    }

    #[test]
    fn a_saturated_reading_is_none_and_spoils_the_mean_that_it_would_enter() {
        let ranged = ReadingColumn { lowest: Some(0.0), highest: Some(4095.0), ..torque("tau") };
        let text = "q,tau\n0,0\n1,1\n2,4095\n3,5000\n";
        assert_eq!(torques(text, ranged.clone()), [None, reading(1.0, None), None, None]);
        let mut mapping = one_joint(ranged);
        mapping.merge_repeated = true;
        let poses = parse("q,tau\n0,4094\n0,4095\n1,7\n", &mapping).unwrap();
        assert_eq!(poses[0].torque, [None]);
        assert_eq!((&poses[0].saturated[..], &poses[1].saturated[..]), (&[0][..], &[][..]));
    }

    #[test]
    fn repeated_rows_are_merged_if_asked_for() {
        let mut mapping = one_joint(ReadingColumn { std: Some(1.0), ..torque("tau") });
        mapping.merge_repeated = true;
        let poses = parse("q,tau\n0,1\n5,1\n5,2\n5,\n5,3\n5,2\n", &mapping).unwrap();
        assert_eq!(poses.iter().map(|pose| (pose.line, pose.merged)).collect::<Vec<_>>(), [(2, 1), (3, 5)]);
        assert_eq!(poses[1].torque, [reading(2.0, 0.5)]);
    }

    #[test]
    fn a_mapping_that_contradicts_itself_is_reported_before_the_file_is_opened() {
        let error = read_poses(Path::new("absent.csv"), &one_joint(torque("q"))).unwrap_err();
        assert_eq!(error.to_string(), "column `q` is mapped to two readings; each reading needs its own column");
    }

    #[test]
    fn instruments_are_read_like_torques_and_merged() {
        let mut mapping = one_joint(torque("tau"));
        mapping.instruments = vec![Some(torque("fx")), None, Some(ReadingColumn { std: Some(0.3), ..torque("fy") })];
        mapping.merge_repeated = true;
        let poses = parse("q,tau,fx,fy\n0,1,2,\n0,1,4,5\n9,1,2,3\n", &mapping).unwrap();
        assert_eq!(poses[0].instruments, [reading(3.0, None), None, reading(5.0, 0.3)]);
        mapping.instruments.push(Some(torque("tau")));
        assert_eq!(mapping.check(), Err(MappingError::ColumnTwice { column: "tau".to_owned() }));
    }

    #[test]
    fn a_file_is_read_from_disk() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.csv");
        fs::write(&path, "q,tau\n0,1\n90,2\n").unwrap();
        let poses = read_poses(&path, &one_joint(torque("tau"))).unwrap().poses;
        assert_eq!(poses[1].position, [FRAC_PI_2]);
    }

    proptest! {
        /// Whatever stands in the cells, there are poses that keep what their documentation says, or an error.
        #[test]
        fn poses_keep_their_promises(
            rows in proptest::collection::vec("(-?[0-3]?|nan|1e300|1e-320),(-?[0-3]?|x),(-?[0-3]?|1e-320),[0-3]?,(0|1|true)", 0..6),
            merge_repeated: bool,
        ) {
            let mut mapping = one_joint(ReadingColumn {
                std_column: Some("s".to_owned()),
                count_column: Some("n".to_owned()),
                usable_column: Some("ok".to_owned()),
                ..torque("tau")
            });
            mapping.merge_repeated = merge_repeated;
            match parse(&format!("q,tau,s,n,ok\n{}", rows.join("\n")), &mapping) {
                Err(error) => prop_assert!(error.to_string().starts_with("poses.csv:")),
                Ok(poses) => {
                    prop_assert!(poses.len() > 1);
                    prop_assert_eq!(poses.iter().map(|pose| pose.merged as usize).sum::<usize>(), rows.len());
                    for std in poses.iter().filter_map(|pose| pose.torque[0]?.std) {
                        prop_assert!(std > 0.0 && std.is_finite());
                    }
                }
            }
        }
    }
}
