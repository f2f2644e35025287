//! Which sweeps feed which step of the paper's procedure.

use std::collections::BTreeSet;

use gravcal_robot_model::session::{ReadingId, Session};
use gravcal_robot_model::sweeps::{Sweep, find_sweeps};

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
    /// Number of the posture of the joints beyond the swept one, up to the load. From the swept joint, moving the load is one and
    /// the same displacement in all pairs of one distance and posture.
    pub posture: usize,
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

    /// Every torque reading that the steps read.
    pub fn readings(&self) -> BTreeSet<ReadingId> {
        self.readings_by_step().into_iter().flatten().collect()
    }

    /// The same in the order of the steps, each reading in the first that reads it: step 1 joint by joint, step 2, step 3
    /// joint by joint. A step without a reading of its own is left out.
    pub fn readings_by_step(&self) -> Vec<BTreeSet<ReadingId>> {
        let poses = |sweep: &usize| self.sweeps[*sweep].poses.iter().copied();
        let of = |sweeps: &mut dyn Iterator<Item = usize>, channel: usize| -> BTreeSet<ReadingId> {
            sweeps
                .flat_map(|sweep| poses(&sweep).map(move |pose| ReadingId { pose, channel }).collect::<Vec<_>>())
                .collect()
        };
        let bias = self.bias.iter().enumerate().map(|(joint, sweeps)| of(&mut sweeps.iter().copied(), joint));
        let gravity = of(&mut self.gravity.iter().copied(), 1);
        let gain = self.gain.iter().enumerate();
        let gain = gain.map(|(joint, pairs)| of(&mut pairs.iter().flat_map(|pair| pair.sweeps), joint));
        let mut read = BTreeSet::new();
        let steps = bias.chain([gravity]).chain(gain).map(|step| {
            let own: BTreeSet<_> = step.difference(&read).copied().collect();
            read.extend(own.iter().copied());
            own
        });
        steps.filter(|step| !step.is_empty()).collect()
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

/// Sweeps of the joint after `joint`, paired by placement at equal positions of all others, each sweep in one pair at most.
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
        let mut left: Vec<usize> = with_load(second).collect();
        let mut postures = Postures { up_to: session.loads[first].link, after: joint + 1, met: Vec::new() };
        for a in with_load(first) {
            let partner = left.iter().position(|b| sweeps[*b].stands_like(&sweeps[a], &[joint + 1]));
            if let Some(partner) = partner {
                let b = left.remove(partner);
                pairs.push(LoadPair { distance: index, sweeps: [a, b], posture: postures.number(&sweeps[a]) });
            }
        }
    }
    pairs
}

/// The postures met so far of the joints after one, up to a link.
struct Postures<'a> {
    after: usize,
    up_to: usize,
    met: Vec<&'a Sweep>,
}

impl<'a> Postures<'a> {
    fn number(&mut self, sweep: &'a Sweep) -> usize {
        let (after, up_to) = (self.after, self.up_to);
        let before_or_beyond = |joint: usize| joint <= after || joint > up_to;
        let other: Vec<usize> = (0..sweep.held.len()).filter(|joint| before_or_beyond(*joint)).collect();
        let known = self.met.iter().position(|met| sweep.stands_like(met, &other));
        known.unwrap_or_else(|| {
            self.met.push(sweep);
            self.met.len() - 1
        })
    }
}
