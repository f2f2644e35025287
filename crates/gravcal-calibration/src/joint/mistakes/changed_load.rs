//! A table whose poses, or those before or from one of them on, are of an arm that carries something else than the table says: its label is wrong, or the load
//! was taken off or put on while it was recorded.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use gravcal_estimation::in_parallel;
use gravcal_recording::file_name;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use super::hypothesis::Hypothesis;
use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::starting::start::start_cost;
use crate::joint::variables::State;

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

impl Change {
    /// Of so many poses, those at which it may be: at the first it is of all of them, or of none.
    fn places(self, poses: usize) -> Range<usize> {
        usize::from(!self.after)..poses
    }
}

impl Hypothesis for ChangedLoad {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        let part = made.poses.iter_mut().enumerate().filter(|(pose, own)| {
            (own.table, own.load) == (self.table, self.said) && (*pose >= self.from) == self.change.after
        });
        part.for_each(|(_, pose)| pose.load = self.change.load);
        made
    }

    /// A start, which knows neither sensors nor masses, tells the pose of the change only roughly.
    fn placed(
        &self,
        session: &Session,
        readings: &MeasurementSet,
        found: &State,
    ) -> Result<Option<Arc<dyn Hypothesis>>, EstimateError> {
        let alike = |pose: &usize| (session.poses[*pose].table, session.poses[*pose].load) == (self.table, self.said);
        let poses: Vec<usize> = (0..session.poses.len()).filter(alike).collect();
        let cost = |place: usize| {
            let changed = ChangedLoad { from: poses[place], ..*self };
            let built = build_with_constraints(&changed.made(session), readings, found)?;
            Ok((built.problem.cost(&built.initial)?, changed))
        };
        Ok(Some(Arc::new(lowest(self.change.places(poses.len()), f64::INFINITY, cost)?.1)))
    }

    fn words(&self, session: &Session) -> (String, String) {
        let name = |load: usize| session.loads[load].name.as_str();
        if self.is_of_all(session) {
            return self.words_of_all(session);
        }
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
}

impl ChangedLoad {
    /// The change of which these are the poses: all that a table says to carry the same, or all from one on, or before one; nothing of others.
    pub(super) fn of_poses(session: &Session, poses: &[usize], carried: Option<usize>) -> Option<ChangedLoad> {
        let first = *poses.first()?;
        let (table, said) = (session.poses[first].table, session.poses[first].load);
        let alike = |pose: &usize| (session.poses[*pose].table, session.poses[*pose].load) == (table, said);
        let all: Vec<usize> = (0..session.poses.len()).filter(alike).collect();
        let change = |after: bool| Change { after, load: carried };
        if all.ends_with(poses) {
            return Some(ChangedLoad { table, said, from: first, change: change(true) });
        }
        let next = *all.get(poses.len())?;
        all.starts_with(poses).then(|| ChangedLoad { table, said, from: next, change: change(false) })
    }

    /// Whether it is of all poses of the table that are said to carry the same.
    fn is_of_all(&self, session: &Session) -> bool {
        let before = session.poses[..self.from].iter();
        self.change.after && !before.into_iter().any(|pose| (pose.table, pose.load) == (self.table, self.said))
    }

    fn words_of_all(&self, session: &Session) -> (String, String) {
        let name = |load: usize| session.loads[load].name.as_str();
        let file = file_name(&session.tables[self.table].path);
        match (self.said.map(name), self.change.load.map(name)) {
            (Some(said), Some(load)) => (
                format!("load {load} in {file}, which is said to be of load {said}"),
                format!("Say load = \"{load}\" in its [[poses]]."),
            ),
            (Some(said), None) => (
                format!("no load in {file}, which is said to be of load {said}"),
                format!("Take load = \"{said}\" out of its [[poses]]."),
            ),
            (None, load) => {
                let load = load.unwrap_or_default();
                (
                    format!("load {load} in {file}, which is said to be bare"),
                    format!("Say load = \"{load}\" in its [[poses]]."),
                )
            }
        }
    }

    /// Of the change, after the first pose of the table; nothing where times are not known.
    fn seconds(self, session: &Session) -> Option<f64> {
        let time = |pose: usize| session.poses[pose].conditions.time;
        let first = session.poses.iter().position(|pose| pose.table == self.table)?;
        Some(time(self.from)? - time(first)?).filter(|seconds| *seconds > 0.0)
    }
}

/// Of the poses of each table that are said to carry the same, and of what they or a part of them may carry instead, the pose at which a change explains the readings best, with the cost of a start
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
        let poses: Arc<[usize]> = poses.into();
        for load in std::iter::once(None).chain((0..session.loads.len()).map(Some)).filter(|load| *load != said) {
            // One load is seldom exchanged for another on the way: there only the label of all poses may be wrong.
            let exchanged = load.is_some() && said.is_some();
            for change in
                [true, false].map(|after| Change { after, load }).into_iter().take(if exchanged { 1 } else { 2 })
            {
                let places = if exchanged { 0..1 } else { change.places(poses.len()) };
                changes.push((table, said, change, Arc::clone(&poses), places));
            }
        }
    }
    let tried = changes.iter().map(|(.., places)| places.len()).sum();
    let best = |(table, said, change, poses, places): (usize, Option<usize>, Change, Arc<[usize]>, Range<usize>)| {
        let cost = |place: usize| {
            let changed = ChangedLoad { table, said, from: poses[place], change };
            Ok((start_cost(&changed.made(session), readings)?, changed))
        };
        lowest(places, WORTH_A_LOOK * start, cost)
    };
    Ok((in_parallel(changes, best).into_iter().collect::<Result<_, _>>()?, tried))
}

/// The lowest cost of some places, found in ever smaller steps as long as that is below `worth`.
fn lowest(
    places: Range<usize>,
    worth: f64,
    cost: impl Fn(usize) -> Result<(f64, ChangedLoad), EstimateError>,
) -> Result<(f64, ChangedLoad), EstimateError> {
    let mut step = (places.end / PARTS).max(1);
    let (mut at, mut best) = (places.start, cost(places.start)?);
    for place in (places.start + step..places.end).step_by(step) {
        let next = cost(place)?;
        if next.0 < best.0 {
            (at, best) = (place, next);
        }
    }
    while step > 1 && best.0 < worth {
        step = step.div_ceil(2);
        for place in [at.saturating_sub(step).max(places.start), (at + step).min(places.end - 1)] {
            let next = cost(place)?;
            if next.0 < best.0 {
                (at, best) = (place, next);
            }
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::joint::mistakes::search::contradicting_mistake;
    use crate::joint::{Signals, select, solve};
    use crate::result::Verdict;
    use crate::testing::sensor_models::{estimate, shoulder};
    use crate::testing::with_environment;

    /// The reference protocol, ten seconds from pose to pose, with two of its tables one after the other in one.
    fn in_one([first, second]: [usize; 2]) -> Session {
        let mut session = shoulder().session(0);
        let of = |table: usize| session.poses.iter().filter(move |pose| pose.table == table);
        let others = session.poses.iter().filter(|pose| ![first, second].contains(&pose.table));
        session.poses = others.chain(of(first)).chain(of(second)).cloned().collect();
        let in_one = session.poses.iter_mut().filter(|pose| [first, second].contains(&pose.table));
        for (pose, row) in in_one.zip(0_u32..) {
            (pose.table, pose.line) = (first, u64::from(row) + 2);
            pose.conditions.time = Some(5000.0 + 10.0 * f64::from(row));
        }
        session
    }

    /// The first table is without a load and the second with one. Each has 37 poses.
    const TABLES: [usize; 2] = [4, 5];

    #[test]
    fn a_load_that_changes_within_a_table_is_named_with_the_line_and_the_time() {
        let named = |[first, second]: [usize; 2], said: Option<usize>| {
            let mut session = in_one([first, second]);
            session.poses.iter_mut().filter(|pose| pose.table == first).for_each(|pose| pose.load = said);
            let result = estimate(&session);
            let advice = result.notes[0].clone();
            assert_eq!(result.verdict, Verdict::Failed, "{advice}");
            assert!(advice.contains("from_s where the load changes, about 370 s), or are left out."), "{advice}");
            (result.termination, advice)
        };
        let [bare, loaded] = TABLES;
        let (what, advice) = named([bare, loaded], None);
        assert_eq!(what, "load plate-a there from about line 39 of sweep-4.csv on");
        assert!(advice.contains("the poses from there on belong to a [[poses]] with that load"), "{advice}");
        let (what, advice) = named([bare, loaded], Some(0));
        assert_eq!(what, "load plate-a not there before about line 39 of sweep-4.csv");
        assert!(advice.contains("the poses before belong to a [[poses]] without load"), "{advice}");
        let (what, _) = named([loaded, bare], Some(0));
        assert_eq!(what, "load plate-a gone from about line 39 of sweep-5.csv on");
        let (what, _) = named([loaded, bare], None);
        assert_eq!(what, "load plate-a still there before about line 39 of sweep-5.csv");
    }

    /// A wrong label of a whole table is no change at one of its edges.
    #[test]
    fn a_table_that_is_said_to_carry_another_load_is_named_with_it() {
        let named = |table: usize, said: Option<usize>| {
            let mut session = shoulder().session(0);
            session.poses.iter_mut().filter(|pose| pose.table == table).for_each(|pose| pose.load = said);
            let result = estimate(&session);
            assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
            (result.termination.clone(), result.notes[0].contains("in its [[poses]]."))
        };
        let [bare, loaded] = TABLES;
        assert_eq!(
            named(bare, Some(0)),
            ("no load in sweep-4.csv, which is said to be of load plate-a".to_owned(), false)
        );
        assert_eq!(named(loaded, None), ("load plate-a in sweep-5.csv, which is said to be bare".to_owned(), true));
        let exchanged = ("load plate-a in sweep-5.csv, which is said to be of load plate-b".to_owned(), true);
        assert_eq!(named(loaded, Some(1)), exchanged);
    }

    #[test]
    fn loads_that_are_where_they_are_said_to_be_are_not_named() {
        let [bare, loaded] = TABLES;
        for session in [shoulder().session(0), in_one([bare, loaded]), in_one([loaded, bare])] {
            let readings = select(&session, Signals::All);
            let mistake = with_environment(|environment| {
                let solved = solve(&session, &readings, None, environment)?;
                contradicting_mistake(&session, &solved, environment)
            });
            assert!(mistake.as_ref().is_ok_and(Option::is_none), "{mistake:?}");
            assert_eq!(estimate(&session).verdict, Verdict::Determined);
        }
    }

    /// Of a change that makes nothing better no closer look is taken.
    #[test]
    fn the_place_of_a_change_is_found_in_few_steps_where_it_is_worth_them() {
        let change = Change { after: true, load: None };
        let looked = |worth: f64| {
            let tried = Cell::new(0);
            let cost = |from: usize| {
                tried.set(tried.get() + 1);
                Ok((10.0 + from.abs_diff(237) as f64, ChangedLoad { table: 0, said: Some(0), from, change }))
            };
            let (lowest, found) = lowest(1..400, worth, cost).unwrap();
            (lowest, found.from, tried.get())
        };
        let (lowest, from, tried) = looked(50.0);
        assert!((lowest, from) == (10.0, 237) && tried < 25, "{lowest} {from} {tried}");
        let (_, from, tried) = looked(20.0);
        assert!(from == 251 && tried == PARTS, "{from} {tried}");
    }
}
