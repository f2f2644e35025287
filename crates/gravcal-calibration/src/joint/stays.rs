//! Stays of joints: poses one after the other, all through which a joint stands, and errors that last as long.

use std::sync::Arc;

use gravcal_robot_model::session::ReadingId;

/// Errors that last as long as a joint stands.
#[derive(Clone, Debug)]
pub(in crate::joint) struct Lasting {
    /// By joint, square of the unit of its torque reading; zero of a joint without such errors.
    pub variance: Vec<f64>,
    /// Those of several readings.
    pub stays: Arc<[Stay]>,
    /// By pose, those of its joints, as places in `stays`.
    pub of_pose: Arc<[Vec<usize>]>,
}

/// Poses one after the other, all through which a joint stood.
#[derive(Clone, Debug)]
pub(in crate::joint) struct Stay {
    pub joint: usize,
    pub poses: Vec<usize>,
}

impl Lasting {
    /// The stay of a reading, where others have the same.
    pub fn stay(&self, id: ReadingId) -> Option<usize> {
        let of_pose = self.of_pose.get(id.pose)?;
        of_pose.iter().copied().find(|place| self.stays[*place].joint == id.channel)
    }

    /// Of a channel, square of its unit.
    pub fn variance_of(&self, channel: usize) -> f64 {
        self.variance.get(channel).copied().unwrap_or(0.0)
    }
}

impl Stay {
    /// The reading with which it begins.
    pub fn first(&self) -> ReadingId {
        ReadingId { pose: self.poses[0], channel: self.joint }
    }
}
