//! Where a joint hangs, and which other it follows.

use super::error::ChainError;
use crate::joint::Joint;

/// Where a joint of a branched chain hangs, and whether it has a coordinate of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attachment {
    /// Index of the link that it hangs on, one before its own; `None`: the base.
    pub parent: Option<usize>,
    /// `None` for a joint with a coordinate of its own.
    pub mimic: Option<Mimic>,
}

/// A joint that follows another: `coordinate = multiplier · leader's coordinate + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mimic {
    /// Index of the leader among all joints, those that follow included.
    pub leader: usize,
    /// Its unit is that of the joint's coordinate over the leader's.
    pub multiplier: f64,
    /// rad or m.
    pub offset: f64,
}

/// What moves one axis: `multiplier · coordinates[joint] + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drive {
    /// Index among the joints with a coordinate of their own.
    pub joint: usize,
    pub multiplier: f64,
    pub offset: f64,
}

impl Drive {
    /// Of a joint with a coordinate of its own.
    pub fn own(joint: usize) -> Self {
        Drive { joint, multiplier: 1.0, offset: 0.0 }
    }

    pub fn coordinate(&self, coordinates: &[f64]) -> f64 {
        self.multiplier * coordinates[self.joint] + self.offset
    }
}

/// The drive of each joint; who follows a follower follows its leader's leader.
///
/// # Errors
///
/// A leader that does not exist, numbers that are not finite, joints that follow each other in a circle.
pub(super) fn drives(joints: &[Joint], attachments: &[Attachment]) -> Result<Vec<Drive>, ChainError> {
    let mut own = Vec::with_capacity(joints.len());
    let mut independent = 0;
    for Attachment { mimic, .. } in attachments {
        own.push(independent);
        independent += usize::from(mimic.is_none());
    }
    let drive = |joint: usize| {
        let (mut at, mut multiplier, mut offset) = (joint, 1.0, 0.0);
        for _ in 0..=joints.len() {
            let Some(mimic) = &attachments[at].mimic else {
                return Ok(Drive { joint: own[at], multiplier, offset });
            };
            check(joints, at, mimic)?;
            (at, multiplier, offset) =
                (mimic.leader, multiplier * mimic.multiplier, multiplier * mimic.offset + offset);
        }
        Err(ChainError::MimicCircle { joint: joints[joint].name.clone() })
    };
    (0..joints.len()).map(drive).collect()
}

fn check(joints: &[Joint], joint: usize, mimic: &Mimic) -> Result<(), ChainError> {
    let name = &joints[joint].name;
    if mimic.leader >= joints.len() {
        return Err(ChainError::UnknownLeader { joint: name.clone() });
    }
    if !mimic.multiplier.is_finite() || !mimic.offset.is_finite() {
        return Err(ChainError::NotFinite { what: format!("multiplier or offset by which joint `{name}` mimics") });
    }
    Ok(())
}
