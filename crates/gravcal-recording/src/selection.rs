//! Which readings of an arm in motion count.
//!
//! A torque reading of a moving arm holds more than gravity:
//!
//! ```text
//! y_i = k_i [τ_i(θ) + Σ_j M_ij(θ) q̈_j + Σ_jk C_ijk(θ) q̇_j q̇_k] + friction(q̇_i) + b_i
//! ```
//!
//! Inertia brings every joint's acceleration and the products of all speeds into every torque, so limits on these are limits of
//! the *arm*: where one joint breaks its limit the whole row is left out. Friction is the joint's own: limits of the *joint*
//! leave out the torque reading of that joint only. Positions are good at any speed.

use crate::conditions::Conditions;
use crate::static_pose::{Reading, StaticPose};

/// The rule. By default everything counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// A row counts where every joint keeps to its limits.
    pub arm: MotionLimits,
    /// A joint's torque reading counts where the joint itself keeps to its limits.
    pub joint: MotionLimits,
}

/// Limits of motion. Each list is empty (no limit) or has one number for each joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionLimits {
    /// The joint's speed must exceed this, rad/s or m/s.
    pub speed_above: Vec<f64>,
    /// It must be less than this, rad/s or m/s.
    pub speed_below: Vec<f64>,
    /// The magnitude of the joint's acceleration must be less than this, rad/s² or m/s².
    pub acceleration_below: Vec<f64>,
}

impl MotionLimits {
    /// Whether speeds are limited.
    pub(crate) fn limit_speed(&self) -> bool {
        !(self.speed_above.is_empty() && self.speed_below.is_empty())
    }

    /// Whether accelerations are limited.
    pub(crate) fn limit_acceleration(&self) -> bool {
        !self.acceleration_below.is_empty()
    }

    /// Whether one joint keeps to its limits.
    fn allow(&self, joint: usize, conditions: &Conditions) -> bool {
        let magnitude = |list: &[f64]| list.get(joint).map_or(f64::NAN, |value| value.abs());
        let (speed, acceleration) = (magnitude(&conditions.velocity), magnitude(&conditions.acceleration));
        let limit = |list: &[f64]| list.get(joint).copied();
        limit(&self.speed_above).is_none_or(|least| speed > least)
            && limit(&self.speed_below).is_none_or(|most| speed < most)
            && limit(&self.acceleration_below).is_none_or(|most| acceleration < most)
    }
}

impl Selection {
    /// The speed, rad/s or m/s, that a joint's torque reading must exceed to count; `None` where any speed will do.
    pub fn least_speed(&self, joint: usize) -> Option<f64> {
        let limits = [&self.arm, &self.joint].map(|limits| limits.speed_above.get(joint).copied());
        limits.into_iter().flatten().reduce(f64::max)
    }

    /// Leaves out readings that do not count, and rows without any that does. Tells how many torque readings of each joint it
    /// left out.
    pub(crate) fn apply(&self, rows: &mut Vec<StaticPose>, joints: usize) -> Vec<usize> {
        let mut left_out = vec![0; joints];
        rows.retain_mut(|row| {
            let arm = (0..joints).all(|joint| self.arm.allow(joint, &row.conditions));
            let mut any = false;
            for (joint, reading) in row.torque.iter_mut().enumerate() {
                let counts = arm && self.joint.allow(joint, &row.conditions);
                any |= counts;
                if !counts && reading.take().is_some() {
                    left_out[joint] += 1;
                }
            }
            any || arm && has_any(&row.instruments)
        });
        left_out
    }
}

fn has_any(readings: &[Option<Reading>]) -> bool {
    readings.iter().any(Option::is_some)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::conditions::{ConditionColumn, ConditionColumns, ConditionUnit, MotionSource};
    use crate::csv_lines::CsvFormat;
    use crate::mapping::{PoseMapping, PositionColumn, ReadingColumn};
    use crate::pose::{Recording, poses_of};
    use crate::table::Table;
    use crate::unit::{PositionUnit, TorqueUnit};

    /// Two joints with velocities v, w and accelerations a, b.
    fn mapping(selection: Selection) -> PoseMapping {
        let columns = |names: [&str; 2], unit: ConditionUnit| {
            MotionSource::Columns(names.map(|name| ConditionColumn { column: name.to_owned(), unit }).into())
        };
        let position = |name: &str| PositionColumn::new(name, PositionUnit::Radian);
        let torque = |name: &str| {
            Some((ReadingColumn { column: name.to_owned(), ..ReadingColumn::default() }, TorqueUnit::NewtonMeter))
        };
        PoseMapping {
            positions: ["p", "q"].map(position).into(),
            torques: ["x", "y"].map(torque).into(),
            conditions: ConditionColumns {
                velocity: columns(["v", "w"], ConditionUnit::ANGULAR_VELOCITY[0]),
                acceleration: columns(["a", "b"], ConditionUnit::ANGULAR_ACCELERATION[0]),
                ..ConditionColumns::default()
            },
            selection,
            ..PoseMapping::default()
        }
    }

    const ROWS: &str = "p,q,x,y,v,w,a,b\n\
                        0,0,1,1, 0.0,-0.1, 0,0\n\
                        1,0,1,1,-0.5, 0.1, 0,0\n\
                        2,0,1, , 0.5, 0.1, 0,0\n\
                        3,0,1,1, 0.5, 0.1,-3,0\n\
                        4,0,1,1, 0.0, 0.0, 0,0\n";

    fn selected(selection: Selection) -> Result<Recording, String> {
        let mapping = mapping(selection);
        mapping.check().unwrap();
        poses_of(&Table::parse(Path::new("a.csv"), ROWS.as_bytes(), CsvFormat::default()).unwrap(), &mapping)
            .map_err(|e| e.to_string())
    }

    /// Line of each pose with the joints that have a reading.
    fn reported(recording: &Recording) -> Vec<(u64, Vec<usize>)> {
        let joints = |pose: &StaticPose| (0..2).filter(|joint| pose.torque[*joint].is_some()).collect();
        recording.poses.iter().map(|pose| (pose.line, joints(pose))).collect()
    }

    #[test]
    fn limits_of_the_arm_leave_out_rows() {
        let arm =
            MotionLimits { speed_below: vec![0.6, 0.2], acceleration_below: vec![1.0, 1.0], ..MotionLimits::default() };
        let found = selected(Selection { arm, ..Selection::default() }).unwrap();
        assert_eq!(reported(&found), [(2, vec![0, 1]), (3, vec![0, 1]), (4, vec![0]), (6, vec![0, 1])]);
        assert_eq!(found.in_motion, [1, 1]);
    }

    #[test]
    fn limits_of_the_joint_leave_out_its_reading() {
        let joint = MotionLimits { speed_above: vec![0.05; 2], ..MotionLimits::default() };
        let found = selected(Selection { joint, ..Selection::default() }).unwrap();
        assert_eq!(reported(&found), [(2, vec![1]), (3, vec![0, 1]), (4, vec![0]), (5, vec![0, 1])]);
        assert_eq!(found.in_motion, [2, 1]);
    }

    #[test]
    fn without_limits_everything_counts() {
        let found = selected(Selection::default()).unwrap();
        assert_eq!((found.poses.len(), found.in_motion), (5, vec![0, 0]));
    }

    #[test]
    fn nothing_left_is_an_error() {
        let arm = MotionLimits { speed_above: vec![0.6; 2], ..MotionLimits::default() };
        assert_eq!(
            selected(Selection { arm, ..Selection::default() }).unwrap_err(),
            "a.csv: 0 of its 5 rows keep to the limits of speed and acceleration, and two at least are needed; widen them, or \
             leave the table out"
        );
    }
}
