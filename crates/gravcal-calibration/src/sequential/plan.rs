//! Which sweeps feed which step of the paper's procedure.

use std::collections::BTreeSet;

use crate::session::Session;
use crate::sweeps::{Sweep, find_sweeps};

/// The sweeps of a session, sorted by the step that reads them.
#[derive(Clone, Debug)]
pub struct Plan {
    /// All sweeps found.
    pub sweeps: Vec<Sweep>,
    /// Step 1, for each joint: sweeps of that joint, whose own torque is read.
    pub bias: Vec<Vec<usize>>,
    /// Step 2: sweeps of the second joint at several positions of the first, whose own torque is read.
    pub gravity: Vec<usize>,
    /// Step 3, for each joint: pairs of sweeps of the next joint with the two placements; the joint's torque is read.
    pub gain: Vec<Vec<LoadPair>>,
}

/// Two sweeps that differ only by the placement of the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadPair {
    /// Index of the known distance between the two placements.
    pub distance: usize,
    /// Indices of the sweeps: first placement, second placement.
    pub sweeps: [usize; 2],
}

impl Plan {
    /// Sorts the sweeps of a session. No step reads any of a robot that is no serial chain.
    pub fn new(session: &Session) -> Plan {
        let sweeps = find_sweeps(session);
        let joints = session.joints.len();
        if !session.robot.chain.is_serial() {
            return Plan { sweeps, bias: Vec::new(), gravity: Vec::new(), gain: Vec::new() };
        }
        let bias = (0..joints).map(|joint| eligible(session, &sweeps, joint, 1)).collect();
        let gain = (0..joints).map(|joint| load_pairs(session, &sweeps, joint)).collect();
        let gravity = gravity_sweeps(session, &sweeps);
        Plan { sweeps, bias, gravity, gain }
    }

    /// Pose and joint of every torque reading that the steps read.
    pub fn readings(&self) -> BTreeSet<(usize, usize)> {
        let mut readings = BTreeSet::new();
        let mut read = |sweep: usize, joint: usize| {
            readings.extend(self.sweeps[sweep].poses.iter().map(|pose| (*pose, joint)));
        };
        for (joint, sweeps) in self.bias.iter().enumerate() {
            sweeps.iter().for_each(|sweep| read(*sweep, joint));
        }
        self.gravity.iter().for_each(|sweep| read(*sweep, 1));
        for (joint, pairs) in self.gain.iter().enumerate() {
            pairs.iter().flat_map(|pair| pair.sweeps).for_each(|sweep| read(sweep, joint));
        }
        readings
    }
}

/// Sweeps of a joint that a step may read: those declared for it, or where nothing is declared, all.
fn eligible(session: &Session, sweeps: &[Sweep], swept: usize, step: u8) -> Vec<usize> {
    (0..sweeps.len())
        .filter(|i| sweeps[*i].swept == swept)
        .filter(|i| session.tables[sweeps[*i].table].step.is_none_or(|declared| declared == step))
        .collect()
}

/// The largest group of sweeps of joint 2 that differ only by the position of joint 1.
fn gravity_sweeps(session: &Session, sweeps: &[Sweep]) -> Vec<usize> {
    let candidates = eligible(session, sweeps, 1, 2);
    let group = |first: &usize| -> Vec<usize> {
        candidates
            .iter()
            .copied()
            .filter(|i| sweeps[*i].load == sweeps[*first].load && sweeps[*i].stands_like(&sweeps[*first], &[0, 1]))
            .collect()
    };
    let mut best: Vec<usize> = Vec::new();
    for candidate in candidates.iter().map(group) {
        if candidate.len() > best.len() {
            best = candidate;
        }
    }
    best
}

/// Sweeps of the joint after `joint`, paired by placement at equal positions of all others.
fn load_pairs(session: &Session, sweeps: &[Sweep], joint: usize) -> Vec<LoadPair> {
    let candidates = eligible(session, sweeps, joint + 1, 3);
    let with_load = |load: usize| candidates.iter().copied().filter(move |i| sweeps[*i].load == Some(load));
    let mut pairs = Vec::new();
    for (index, distance) in session.load_distances.iter().enumerate() {
        let [first, second] = distance.between;
        // The difference of two placements is m Δr only for one and the same mass.
        if session.loads[first].mass != session.loads[second].mass || session.loads[first].link <= joint {
            continue;
        }
        for a in with_load(first) {
            if let Some(b) = with_load(second).find(|b| sweeps[*b].stands_like(&sweeps[a], &[joint + 1])) {
                pairs.push(LoadPair { distance: index, sweeps: [a, b] });
            }
        }
    }
    pairs
}
