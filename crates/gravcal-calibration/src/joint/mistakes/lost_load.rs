//! A load that fell off or was taken off while a table was recorded: from some pose on its readings are those of the bare arm.

use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::starting::start::start_cost;

/// Fewer poses of a table tell nothing of a change.
const FEW: usize = 6;
/// Into so many parts a table is cut at first.
const PARTS: usize = 8;

/// Where the load of a table is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::joint) struct LostLoad {
    table: usize,
    /// Index of the first pose without it.
    from: usize,
}

impl LostLoad {
    /// The session as it would be right.
    pub fn made(self, session: &Session) -> Session {
        let mut made = session.clone();
        let gone = made.poses.iter_mut().skip(self.from).filter(|pose| pose.table == self.table);
        gone.for_each(|pose| pose.load = None);
        made
    }

    /// What happened, and what to do about it.
    pub fn report(self, session: &Session) -> (String, String) {
        let load = session.tables[self.table].load.map_or("", |load| session.loads[load].name.as_str());
        let (file, line) = session.row_of(self.from);
        (
            format!("load {load} gone from about line {line} of {file} on"),
            "If it fell off or was taken off there, the poses from there on belong to a [[poses]] without load (a file of their own, or the \
             same file with from_s, and until_s where the load ends), or are left out."
                .to_owned(),
        )
    }
}

/// Of each table with a load the pose from which on readings are explained best without it, with the cost of a start there, and how many
/// poses came into question.
pub(in crate::joint) fn lost_loads(
    session: &Session,
    readings: &MeasurementSet,
) -> Result<(Vec<(f64, LostLoad)>, usize), EstimateError> {
    let mut found = Vec::new();
    let mut tried = 0;
    for table in 0..session.tables.len() {
        let loaded = |pose: &usize| session.poses[*pose].table == table && session.poses[*pose].load.is_some();
        let poses: Vec<usize> = (0..session.poses.len()).filter(loaded).collect();
        if poses.len() >= FEW {
            tried += poses.len() - 1;
            let cost = |place: usize| {
                let lost = LostLoad { table, from: poses[place] };
                Ok((start_cost(&lost.made(session), readings)?, lost))
            };
            found.push(lowest(poses.len(), cost)?);
        }
    }
    Ok((found, tried))
}

/// The lowest cost of places after the first, found in ever smaller steps.
fn lowest(
    places: usize,
    cost: impl Fn(usize) -> Result<(f64, LostLoad), EstimateError>,
) -> Result<(f64, LostLoad), EstimateError> {
    let mut step = (places / PARTS).max(1);
    let (mut at, mut best) = (1, cost(1)?);
    for place in (1 + step..places).step_by(step) {
        let next = cost(place)?;
        if next.0 < best.0 {
            (at, best) = (place, next);
        }
    }
    while step > 1 {
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
