//! Static friction that recorded slow sweeps show.

use crate::parameter::{ParameterId, SensorParameter};
use crate::session::{Pose, Session};

impl Session {
    /// Friction of each joint in its own slow sweeps, the largest of them, in the unit of its torque reading; of one that never sweeps that of the
    /// nearest that does. What enters no fit says nothing. Empty where nothing sweeps.
    pub fn find_static_friction(&self) -> Vec<f64> {
        let sweeps = || self.fitted_recordings().flat_map(|searched| &searched.sweeps).flat_map(|sweeps| &sweeps.found);
        if sweeps().next().is_none() {
            return Vec::new();
        }
        let own = |joint: usize| sweeps().filter(move |sweep| sweep.joint == joint);
        let joints = 0..self.joints.len();
        let shown: Vec<f64> = joints
            .clone()
            .map(|joint| own(joint).filter_map(|sweep| sweep.shown_friction()).fold(0.0, f64::max))
            .collect();
        let of_joint = |joint: usize| match own(joint).next() {
            Some(_) => shown[joint],
            None => self.of_nearest(&shown, joint),
        };
        joints.map(of_joint).collect()
    }

    /// The joint that sweeps in a pose of a recorded slow sweep; `None` of any other pose.
    pub fn swept_in_recording(&self, pose: &Pose) -> Option<usize> {
        let recorded = self.searched.iter().any(|searched| searched.table == pose.table && searched.sweeps.is_some());
        let (column, _) = pose.sweep_label.as_ref().filter(|_| recorded)?.rsplit_once(' ')?;
        self.readings.positions.iter().position(|position| position.column == column)
    }

    /// What the nearest other joint of the same kind shows, of two the larger, in the unit of this one's readings; zero where none shows anything.
    pub fn of_nearest(&self, shown: &[f64], joint: usize) -> f64 {
        let chain = self.robot.chain.joints();
        let gain = |joint: usize| self.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
        let shows = |other: &usize| *other != joint && shown[*other] > 0.0 && chain[*other].kind == chain[joint].kind;
        let others = (0..shown.len()).filter(shows);
        let torques = others.map(|other| (other.abs_diff(joint), shown[other] / gain(other)));
        let nearest = torques.min_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        nearest.map_or(0.0, |(_, torque)| torque * gain(joint))
    }
}
