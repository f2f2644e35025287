//! Repeated rows of one standstill become one pose.
//!
//! Of m readings `y_1 … y_m` with independent standard deviations `σ_1 … σ_m`, the pose gets the plain mean
//!
//! ```text
//!     ȳ = (y_1 + … + y_m) / m,      σ(ȳ) = √(σ_1² + … + σ_m²) / m      (= σ/√m where all are equal)
//! ```
//!
//! and no standard deviation if one of them is unknown.

use crate::conditions::mean_conditions;
use crate::static_pose::{Reading, StaticPose};

/// Merges consecutive poses of one sweep with exactly equal positions, reached from the same side. The merged pose keeps the first one's line.
pub(crate) fn merge_repeated(poses: &[StaticPose]) -> Vec<StaticPose> {
    poses.chunk_by(is_repeated).map(merge).collect()
}

fn is_repeated(a: &StaticPose, b: &StaticPose) -> bool {
    a.position == b.position
        && a.orientation == b.orientation
        && a.sweep == b.sweep
        && a.conditions.direction == b.conditions.direction
}

/// `run` is never empty.
fn merge(run: &[StaticPose]) -> StaticPose {
    let mut pose = run[0].clone();
    for (joint, torque) in pose.torque.iter_mut().enumerate() {
        // Of readings some of which are cut off at the end of the range, the mean is off.
        let saturated = run.iter().any(|row| row.saturated.contains(&joint));
        let readings: Vec<Reading> = run.iter().filter_map(|row| row.torque[joint]).collect();
        *torque = mean(&readings).filter(|_| !saturated);
        if saturated && !pose.saturated.contains(&joint) {
            pose.saturated.push(joint);
        }
    }
    for (channel, reading) in pose.instruments.iter_mut().enumerate() {
        let readings: Vec<Reading> = run.iter().filter_map(|row| row.instruments[channel]).collect();
        *reading = mean(&readings);
    }
    pose.conditions = mean_conditions(&run.iter().map(|row| &row.conditions).collect::<Vec<_>>());
    pose.merged = run.iter().map(|row| row.merged).sum();
    pose
}

fn mean(readings: &[Reading]) -> Option<Reading> {
    let first = readings.first()?.value;
    let m = readings.len() as f64;
    // Summing differences keeps digits when readings are alike, and gives back exactly the value when they are equal.
    let value = first + readings.iter().map(|reading| reading.value - first).sum::<f64>() / m;
    let stds: Option<Vec<f64>> = readings.iter().map(|reading| reading.std).collect();
    let std = stds.map(|stds| stds.into_iter().map(|std| std / m).fold(0.0, f64::hypot));
    Some(Reading { value, std })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::Conditions;

    fn pose(line: u64, position: f64, torque: Option<Reading>) -> StaticPose {
        StaticPose {
            line,
            position: vec![position],
            orientation: None,
            torque: vec![torque],
            instruments: Vec::new(),
            saturated: Vec::new(),
            sweep: None,
            conditions: Conditions::default(),
            merged: 1,
        }
    }

    fn reading(value: f64, std: impl Into<Option<f64>>) -> Option<Reading> {
        Some(Reading { value, std: std.into() })
    }

    #[test]
    fn repeated_rows_become_their_mean() {
        let rows: Vec<StaticPose> = (0..4).map(|row| pose(2 + row, 0.5, reading(2000.0 + row as f64, 0.5))).collect();
        assert_eq!(merge_repeated(&rows), [StaticPose { merged: 4, ..pose(2, 0.5, reading(2001.5, 0.25)) }]);
    }

    #[test]
    fn unequal_deviations_add_in_quadrature() {
        let rows = [pose(2, 0.0, reading(1.0, 3.0)), pose(3, 0.0, reading(2.0, 4.0))];
        assert_eq!(merge_repeated(&rows)[0].torque, [reading(1.5, 2.5)]);
    }

    #[test]
    fn only_usable_readings_count() {
        let rows = [pose(2, 0.0, None), pose(3, 0.0, reading(7.0, 0.5)), pose(4, 0.0, None)];
        assert_eq!(merge_repeated(&rows), [StaticPose { merged: 3, ..pose(2, 0.0, reading(7.0, 0.5)) }]);
        assert_eq!(merge_repeated(&rows[..1])[0].torque, [None]);
    }

    #[test]
    fn one_unknown_deviation_makes_the_mean_s_unknown() {
        let rows = [pose(2, 0.0, reading(1.0, 0.5)), pose(3, 0.0, reading(2.0, None))];
        assert_eq!(merge_repeated(&rows)[0].torque, [reading(1.5, None)]);
    }

    #[test]
    fn only_consecutive_rows_with_exactly_equal_positions_merge() {
        let next = 0.1_f64.next_up();
        let rows: Vec<StaticPose> = [0.1, 0.1, next, 0.1].map(|q| pose(2, q, None)).into();
        let merged: Vec<u32> = merge_repeated(&rows).iter().map(|pose| pose.merged).collect();
        assert_eq!(merged, [2, 1, 1]);
    }

    #[test]
    fn sweeps_stay_apart() {
        let sweep = |label: &str| StaticPose { sweep: Some(label.to_owned()), ..pose(2, 0.0, None) };
        assert_eq!(merge_repeated(&[sweep("a"), sweep("b")]).len(), 2);
        assert_eq!(merge_repeated(&[sweep("a"), sweep("a")]).len(), 1);
    }

    #[test]
    fn the_mean_of_equal_readings_is_exactly_theirs() {
        let rows: Vec<StaticPose> = (0..7).map(|_| pose(2, 0.0, reading(0.1, None))).collect();
        assert_eq!(merge_repeated(&rows)[0].torque, [reading(0.1, None)]);
    }
}
