//! Sweeps: runs of poses in which one joint moves and the others stand.
//!
//! **The rule.** Within one table, consecutive poses form a run as long as at most one joint has moved by more than
//! [`HOLD_TOLERANCE`] since the run began (and, where a sweep column labels the poses, as long as the label stays).
//! A run is a sweep if that joint turns, has moved by at least [`SWEEP_RANGE`], and the run has at least
//! [`SWEEP_POSES`] poses. A table's declared swept joint must be the one that moves. Movements are judged with the
//! nominal position gains.

use crate::session::Session;
use gravcal_dynamics::JointKind;

use crate::parameter::SensorParameter;

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

/// Whether every joint stands where it stood in another pose, within [`HOLD_TOLERANCE`].
pub fn stand_alike(session: &Session, pose: usize, other: usize) -> bool {
    session.joints.iter().enumerate().all(|(joint, known)| {
        let gain = known.of(SensorParameter::PositionGain).nominal;
        let [a, b] = [pose, other].map(|pose| session.poses[pose].position[joint]);
        (gain * (a - b)).abs() <= HOLD_TOLERANCE
    })
}

/// Finds the sweeps of a session, in the order of its poses.
pub fn find_sweeps(session: &Session) -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    let mut run = Run::default();
    // Of an arm in motion nothing stands.
    for pose in (0..session.poses.len()).filter(|pose| session.poses[*pose].course.is_none()) {
        if !run.take(session, pose) {
            sweeps.extend(sweep_of(session, &run));
            run = Run::default();
            run.take(session, pose);
        }
    }
    sweeps.extend(sweep_of(session, &run));
    sweeps
}

/// Consecutive poses in which at most one joint moves.
#[derive(Default)]
struct Run {
    poses: Vec<usize>,
    /// Smallest and largest nominal coordinate of each joint so far, rad or m.
    ranges: Vec<[f64; 2]>,
}

impl Run {
    /// Takes a pose into the run if it continues it.
    fn take(&mut self, session: &Session, pose: usize) -> bool {
        let coordinates = (0..session.joints.len()).map(|joint| nominal_coordinate(session, pose, joint));
        let Some(first) = self.poses.first() else {
            self.ranges = coordinates.map(|c| [c, c]).collect();
            self.poses.push(pose);
            return true;
        };
        let (a, b) = (&session.poses[*first], &session.poses[pose]);
        let ranges: Vec<[f64; 2]> =
            self.ranges.iter().zip(coordinates).map(|([low, high], c)| [low.min(c), high.max(c)]).collect();
        let moving = ranges.iter().filter(|[low, high]| high - low > HOLD_TOLERANCE).count();
        let continues = a.table == b.table && a.sweep_label == b.sweep_label && moving <= 1;
        if continues {
            self.ranges = ranges;
            self.poses.push(pose);
        }
        continues
    }

    fn moved(&self, joint: usize) -> f64 {
        self.ranges[joint][1] - self.ranges[joint][0]
    }
}

/// Nominal coordinate of a joint in a pose, without its offset.
fn nominal_coordinate(session: &Session, pose: usize, joint: usize) -> f64 {
    session.joints[joint].of(SensorParameter::PositionGain).nominal * session.poses[pose].position[joint]
}

fn sweep_of(session: &Session, run: &Run) -> Option<Sweep> {
    let first = *run.poses.first()?;
    let table = session.poses[first].table;
    let swept = (0..session.joints.len()).max_by(|a, b| run.moved(*a).total_cmp(&run.moved(*b)))?;
    let declared = session.tables[table].swept;
    let turns = session.robot.chain.joints()[swept].kind == JointKind::Revolute;
    if run.poses.len() < SWEEP_POSES || !turns || run.moved(swept) < SWEEP_RANGE || declared.is_some_and(|d| d != swept)
    {
        return None;
    }
    let mean = |joint: usize| {
        run.poses.iter().map(|pose| nominal_coordinate(session, *pose, joint)).sum::<f64>() / run.poses.len() as f64
    };
    Some(Sweep {
        table,
        poses: run.poses.clone(),
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

/// The joint that sweeps in each pose; nothing where all stand.
pub fn sweeping(session: &Session) -> Vec<Option<usize>> {
    let mut sweeping = vec![None; session.poses.len()];
    let sweeps = find_sweeps(session);
    sweeps.iter().for_each(|sweep| sweep.poses.iter().for_each(|pose| sweeping[*pose] = Some(sweep.swept)));
    sweeping
}
