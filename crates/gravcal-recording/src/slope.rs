//! Velocity and acceleration by numerical differentiation over the rows of a table.
//!
//! The derivative of `x` at row k is the slope of the least-squares line through the rows near it:
//!
//! ```text
//! ẋ_k = Σ (t_i − t̄)(x_i − x̄) / Σ (t_i − t̄)²      over all i with |t_i − t_k| ≤ w/2
//! ```
//!
//! `x`: a joint's coordinate but for its offset, by the nominal gain of its position reading; an angle that begins anew after a turn goes on.
//! Of even rows about k it is off by `w² x⃛ / 40`, and white noise of `x` with standard deviation σ gives it `√12 σ / (w √m)`, m rows
//! in the window: wide enough for the noise, short against the fastest motion.

use crate::conditions::{ConditionColumns, Slope};
use crate::error::{Place, ReadError};
use crate::mapping::PoseMapping;
use crate::static_pose::StaticPose;
use crate::table::Table;
use crate::turns::unwrapped;

/// Gives every row of one table the velocities and accelerations that are slopes. The mapping has been checked.
pub(crate) fn differentiate(rows: &mut [StaticPose], table: &Table, mapping: &PoseMapping) -> Result<(), ReadError> {
    let mapped = &mapping.conditions;
    if let Some(slope) = mapped.velocity.slope() {
        let coordinates = coordinates(rows, mapping);
        let velocities = derivative(rows, slope, table, mapped, |row| &coordinates[row])?;
        rows.iter_mut().zip(velocities).for_each(|(row, velocity)| row.conditions.velocity = velocity);
    }
    if let Some(slope) = mapped.acceleration.slope() {
        let accelerations = derivative(rows, slope, table, mapped, |row| &rows[row].conditions.velocity)?;
        rows.iter_mut().zip(accelerations).for_each(|(row, found)| row.conditions.acceleration = found);
    }
    Ok(())
}

/// By row and joint, the coordinate but for its offset, rad or m.
fn coordinates(rows: &[StaticPose], mapping: &PoseMapping) -> Vec<Vec<f64>> {
    let mut readings: Vec<Vec<f64>> = rows.iter().map(|row| row.position.clone()).collect();
    for (joint, column) in mapping.positions.iter().enumerate() {
        let mut last = None;
        for row in &mut readings {
            row[joint] = unwrapped(row[joint], last, column.unit);
            last = Some(row[joint]);
        }
        readings.iter_mut().for_each(|row| row[joint] *= column.nominal_gain);
    }
    readings
}

/// Derivative of each joint's number at each row.
fn derivative<'a>(
    rows: &[StaticPose],
    slope: Slope,
    table: &Table,
    mapped: &ConditionColumns,
    numbers: impl Fn(usize) -> &'a [f64],
) -> Result<Vec<Vec<f64>>, ReadError> {
    let times: Vec<f64> = rows.iter().filter_map(|row| row.conditions.time).collect();
    let place = |row: usize| {
        let column = mapped.time.as_ref().map_or_else(String::new, |time| time.column.clone());
        Place { path: table.path().to_owned(), line: rows[row].line, column }
    };
    if let Some(row) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(ReadError::TimeStands { place: place(row + 1) });
    }
    let derivative_at = |row: usize| {
        let near = |other: &f64| (other - times[row]).abs() <= slope.window / 2.0;
        let first = times[..row].iter().rposition(|time| !near(time)).map_or(0, |outside| outside + 1);
        let end = times[row..].iter().position(|time| !near(time)).map_or(times.len(), |outside| row + outside);
        if end - first < 2 {
            return Err(ReadError::NoNeighbour { place: place(row), window: slope.window });
        }
        let joints = 0..numbers(row).len();
        let values = |joint: usize| (first..end).map(|row| numbers(row)[joint]).collect::<Vec<f64>>();
        Ok(joints.map(|joint| slope_of_line(&times[first..end], &values(joint))).collect())
    };
    (0..rows.len()).map(derivative_at).collect()
}

/// Slope of the least-squares line; the times are not all equal.
pub(crate) fn slope_of_line(times: &[f64], values: &[f64]) -> f64 {
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    let (t_mean, x_mean) = (mean(times), mean(values));
    let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 { times.iter().zip(values).map(|(t, x)| term(*t, *x)).sum() };
    sum(&|t, x| (t - t_mean) * (x - x_mean)) / sum(&|t, _| (t - t_mean).powi(2))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::conditions::{ConditionColumn, ConditionUnit, MotionSource};
    use crate::csv_lines::CsvFormat;
    use crate::mapping::{PoseMapping, PositionColumn};
    use crate::pose::poses_of;
    use crate::unit::PositionUnit;

    /// Time in ms, one joint in degrees.
    fn mapping(window: f64) -> PoseMapping {
        let slope = MotionSource::Slope(Slope { window });
        PoseMapping {
            positions: vec![PositionColumn::new("q", PositionUnit::Degree)],
            torques: vec![None],
            conditions: ConditionColumns {
                time: Some(ConditionColumn { column: "t".to_owned(), unit: ConditionUnit::TIME[1] }),
                velocity: slope.clone(),
                acceleration: slope,
                ..ConditionColumns::default()
            },
            ..PoseMapping::default()
        }
    }

    fn rows(text: &str, window: f64) -> Result<Vec<StaticPose>, String> {
        let table = Table::parse(Path::new("a.csv"), text.as_bytes(), CsvFormat::default()).unwrap();
        poses_of(&table, &mapping(window)).map(|found| found.poses).map_err(|error| error.to_string())
    }

    #[test]
    fn a_parabola_has_its_velocity_and_acceleration() {
        // 3 t² degrees, t from 0 to 1 s in steps of 10 ms.
        let lines: String =
            (0..=100).map(|k| format!("{},{}\n", 10 * k, 3.0 * (0.01 * f64::from(k)).powi(2))).collect();
        let rows = rows(&format!("t,q\n{lines}"), 0.11).unwrap();
        for (k, row) in rows.iter().enumerate().filter(|(k, _)| (11..=89).contains(k)) {
            let velocity = (6.0 * 0.01 * k as f64).to_radians();
            assert!((row.conditions.velocity[0] - velocity).abs() < 1e-12, "{k}: {:?}", row.conditions);
            assert!((row.conditions.acceleration[0] - 6f64.to_radians()).abs() < 1e-10, "{k}: {:?}", row.conditions);
        }
        // The ends see one side: the slope is that a quarter of the window inside.
        assert!((rows[0].conditions.velocity[0] - (6.0f64 * 0.025).to_radians()).abs() < 1e-12);
    }

    #[test]
    fn an_angle_that_begins_anew_after_a_turn_goes_on_and_a_gain_counts() {
        let text = "t,q\n0,170\n10,175\n20,180\n30,-175\n40,-170\n";
        let table = Table::parse(Path::new("a.csv"), text.as_bytes(), CsvFormat::default()).unwrap();
        let mut mapping = mapping(0.03);
        mapping.positions[0].nominal_gain = -2.0;
        for row in poses_of(&table, &mapping).unwrap().poses {
            assert!((row.conditions.velocity[0] + 1000f64.to_radians()).abs() < 1e-10, "{:?}", row.conditions);
            assert!(row.position[0].abs() < 3.2, "positions stay as they are recorded");
        }
    }

    #[test]
    fn uneven_times_are_no_matter() {
        let rows = rows("t,q\n0,0\n10,1\n40,4\n60,6\n", 0.07).unwrap();
        for row in rows {
            assert!((row.conditions.velocity[0] - 100f64.to_radians()).abs() < 1e-12, "{row:?}");
        }
    }

    #[test]
    fn the_error_is_that_of_the_equation() {
        let (window, t) = (0.2, 1.0);
        let times: Vec<f64> = (-100..=100).map(|k| t + f64::from(k) * 1e-3).collect();
        let values: Vec<f64> = times.iter().map(|t| t.powi(3)).collect();
        let error = slope_of_line(&times, &values) - 3.0 * t * t;
        let predicted = window * window * 6.0 / 40.0;
        assert!((error / predicted - 1.0).abs() < 0.02, "{error} {predicted}");
    }

    #[test]
    fn times_that_do_not_rise_and_lonely_rows_are_errors() {
        assert_eq!(
            rows("t,q\n0,0\n10,1\n10,2\n", 0.1).unwrap_err(),
            "a.csv:4: column `t`: the time does not rise from the row before, and a slope over time needs that it does; \
             sort the rows, or delete those that stand twice"
        );
        assert_eq!(
            rows("t,q\n0,0\n10,1\n2000,2\n", 0.1).unwrap_err(),
            "a.csv:4: column `t`: no other row is within half of the 0.1 s over which the slope is taken; widen that, or \
             delete the row"
        );
    }
}
