//! A load that was taken off or put on while a table was recorded: before or from some pose on its readings are those of an arm that carries something
//! else than the table says.

use std::collections::BTreeMap;
use std::sync::Arc;

use gravcal_estimation::in_parallel;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::starting::start::start_cost;

/// Fewer poses of a table tell nothing of a change.
const FEW: usize = 6;
/// Into so many parts a table is cut at first.
const PARTS: usize = 8;
/// A change somewhere in the right part lowers the cost of a start to less than this share of it; else no closer look is worth it.
const WORTH_A_LOOK: f64 = 0.9;

/// Where the load changes that poses of a table are said to carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::joint) struct ChangedLoad {
    table: usize,
    /// What they are said to carry.
    said: Option<usize>,
    /// Index of the first pose after the change.
    from: usize,
    change: Change,
}

/// What a part of these poses carries instead.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    /// Whether it is the part after the change, or that before it.
    after: bool,
    load: Option<usize>,
}

impl ChangedLoad {
    /// The session as it would be right.
    pub fn made(self, session: &Session) -> Session {
        let mut made = session.clone();
        let part = made.poses.iter_mut().enumerate().filter(|(pose, own)| {
            (own.table, own.load) == (self.table, self.said) && (*pose >= self.from) == self.change.after
        });
        part.for_each(|(_, pose)| pose.load = self.change.load);
        made
    }

    /// What happened, and what to do about it.
    pub fn report(self, session: &Session) -> (String, String) {
        let name = |load: usize| session.loads[load].name.as_str();
        let said = self.said.map_or("", name);
        let (file, line) = session.row_of(self.from);
        let what = match self.change {
            Change { after: true, load: None } => format!("load {said} gone from about line {line} of {file} on"),
            Change { after: false, load: None } => format!("load {said} not there before about line {line} of {file}"),
            Change { after: true, load: Some(load) } => {
                format!("load {} there from about line {line} of {file} on", name(load))
            }
            Change { after: false, load: Some(load) } => {
                format!("load {} still there before about line {line} of {file}", name(load))
            }
        };
        let when =
            self.seconds(session).map_or_else(String::new, |seconds| format!(", about {} s", significant(seconds, 3)));
        let Change { after, load } = self.change;
        let these = if after { "from there on" } else { "before" };
        let with = if load.is_some() { "with that load" } else { "without load" };
        let cure = format!(
            "If so, the poses {these} belong to a [[poses]] {with} (a file of their own, or the same file twice, with until_s and from_s where the \
             load changes{when}), or are left out."
        );
        (what, cure)
    }

    /// Of the change, after the first pose of the table; nothing where times are not known.
    fn seconds(self, session: &Session) -> Option<f64> {
        let time = |pose: usize| session.poses[pose].conditions.time;
        let first = session.poses.iter().position(|pose| pose.table == self.table)?;
        Some(time(self.from)? - time(first)?).filter(|seconds| *seconds > 0.0)
    }
}

/// Of the poses of each table that are said to carry the same, and of what a part of them may carry instead (no load, or one), the pose at which a change explains the readings best, with the cost of a start
/// there, and how many poses came into question. `start`: the cost without any change.
pub(in crate::joint) fn changed_loads(
    session: &Session,
    readings: &MeasurementSet,
    start: f64,
) -> Result<(Vec<(f64, ChangedLoad)>, usize), EstimateError> {
    let mut changes = Vec::new();
    let mut alike: BTreeMap<(usize, Option<usize>), Vec<usize>> = BTreeMap::new();
    for (place, pose) in session.poses.iter().enumerate() {
        alike.entry((pose.table, pose.load)).or_default().push(place);
    }
    for ((table, said), poses) in alike.into_iter().filter(|(_, poses)| poses.len() >= FEW) {
        let instead: Vec<Option<usize>> = match said {
            Some(_) => vec![None],
            None => (0..session.loads.len()).map(Some).collect(),
        };
        let poses: Arc<[usize]> = poses.into();
        let either = instead.into_iter().flat_map(|load| [true, false].map(|after| Change { after, load }));
        changes.extend(either.map(|change| (table, said, change, Arc::clone(&poses))));
    }
    let tried = changes.iter().map(|(.., poses)| poses.len() - 1).sum();
    let best = |(table, said, change, poses): (usize, Option<usize>, Change, Arc<[usize]>)| {
        let cost = |place: usize| {
            let changed = ChangedLoad { table, said, from: poses[place], change };
            Ok((start_cost(&changed.made(session), readings)?, changed))
        };
        lowest(poses.len(), WORTH_A_LOOK * start, cost)
    };
    Ok((in_parallel(changes, best).into_iter().collect::<Result<_, _>>()?, tried))
}

/// The lowest cost of places after the first, found in ever smaller steps as long as that is below `worth`.
fn lowest(
    places: usize,
    worth: f64,
    cost: impl Fn(usize) -> Result<(f64, ChangedLoad), EstimateError>,
) -> Result<(f64, ChangedLoad), EstimateError> {
    let mut step = (places / PARTS).max(1);
    let (mut at, mut best) = (1, cost(1)?);
    for place in (1 + step..places).step_by(step) {
        let next = cost(place)?;
        if next.0 < best.0 {
            (at, best) = (place, next);
        }
    }
    while step > 1 && best.0 < worth {
        step = step.div_ceil(2);
        for place in [at.saturating_sub(step).max(1), (at + step).min(places - 1)] {
            let next = cost(place)?;
            if next.0 < best.0 {
                (at, best) = (place, next);
            }
        }
    }
    Ok(best)
}
