//! Sweeps: runs of poses in which one joint moves and the others stand.
//!
//! **The rule.** Within one table, consecutive poses form a run as long as at most one joint has moved by more than
//! [`HOLD_TOLERANCE`] since the run began (and, where a sweep column labels the poses, as long as the label stays).
//! A run is a sweep if that joint turns, has moved by at least [`SWEEP_RANGE`], and the run has at least
//! [`SWEEP_POSES`] poses. A table's declared swept joint must be the one that moves. Movements are judged with the
//! nominal position gains.

use crate::session::Session;
use gravcal_kinematics::JointKind;

use crate::parameter::Quantity;

/// A joint that moves less than this stands still, rad (or m): 2°, room for joints that deflect under load.
pub const HOLD_TOLERANCE: f64 = 0.035;
/// A sweep covers at least this, rad: 10°; below it, gain, bias and amplitude are one combination.
pub const SWEEP_RANGE: f64 = 0.17;
/// A sweep has at least this many poses: one more than the four numbers of a sinusoid.
pub const SWEEP_POSES: usize = 5;

/// One sweep of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Index of the table it stands in.
    pub table: usize,
    /// Indices of its poses in the session.
    pub poses: Vec<usize>,
    /// Index of the joint that moves.
    pub swept: usize,
    /// Index of the load attached.
    pub load: Option<usize>,
    /// Mean nominal coordinate of each joint, rad (or m); that of the swept joint means nothing.
    pub held: Vec<f64>,
}

/// Finds the sweeps of a session, in the order of its poses.
pub fn find_sweeps(session: &Session) -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    let mut run: Vec<usize> = Vec::new();
    for pose in 0..session.poses.len() {
        if run.first().is_some_and(|first| !continues(session, *first, &run, pose)) {
            sweeps.extend(sweep_of(session, &run));
            run.clear();
        }
        run.push(pose);
    }
    sweeps.extend(sweep_of(session, &run));
    sweeps
}

/// Nominal coordinate of a joint in a pose, without its offset.
fn nominal_coordinate(session: &Session, pose: usize, joint: usize) -> f64 {
    session.joints[joint].of(Quantity::PositionGain).nominal * session.poses[pose].position[joint]
}

/// How far a joint moves within some poses, rad or m.
fn movement(session: &Session, poses: impl Iterator<Item = usize> + Clone, joint: usize) -> f64 {
    let coordinates = poses.map(|pose| nominal_coordinate(session, pose, joint));
    let high = coordinates.clone().fold(f64::NEG_INFINITY, f64::max);
    high - coordinates.fold(f64::INFINITY, f64::min)
}

fn continues(session: &Session, first: usize, run: &[usize], next: usize) -> bool {
    let (a, b) = (&session.poses[first], &session.poses[next]);
    let moving = (0..session.joints.len())
        .filter(|joint| movement(session, run.iter().copied().chain([next]), *joint) > HOLD_TOLERANCE);
    a.table == b.table && a.sweep_label == b.sweep_label && moving.count() <= 1
}

fn sweep_of(session: &Session, run: &[usize]) -> Option<Sweep> {
    let first = *run.first()?;
    let table = session.poses[first].table;
    let moved = |joint: usize| movement(session, run.iter().copied(), joint);
    let swept = (0..session.joints.len()).max_by(|a, b| moved(*a).total_cmp(&moved(*b)))?;
    let declared = session.tables[table].swept;
    let turns = session.robot.chain.joints()[swept].kind == JointKind::Revolute;
    if run.len() < SWEEP_POSES || !turns || moved(swept) < SWEEP_RANGE || declared.is_some_and(|d| d != swept) {
        return None;
    }
    let mean =
        |joint: usize| run.iter().map(|pose| nominal_coordinate(session, *pose, joint)).sum::<f64>() / run.len() as f64;
    Some(Sweep {
        table,
        poses: run.to_vec(),
        swept,
        load: session.poses[first].load,
        held: (0..session.joints.len()).map(mean).collect(),
    })
}

impl Sweep {
    /// Whether the joints other than `except` stand where they stand in `other`.
    pub fn stands_like(&self, other: &Sweep, except: &[usize]) -> bool {
        self.held
            .iter()
            .zip(&other.held)
            .enumerate()
            .all(|(joint, (a, b))| except.contains(&joint) || (a - b).abs() <= HOLD_TOLERANCE)
    }
}
