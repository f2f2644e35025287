//! Single poses that carry something else than their table says: a load that was taken off for a few poses, or rows of another table among these.
//!
//! A solution of which most poses are right tells them apart: with the values that were found, each pose is explained by what it is said to carry, or by far
//! better by something else. Where these are all poses of a table, or all from one on or before one, they are told as `changed_load.rs` tells them.

use std::collections::BTreeMap;
use std::sync::Arc;

use gravcal_robot_model::session::Session;

use super::changed_load::ChangedLoad;
use super::hypothesis::Hypothesis;
use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// What a pose carries otherwise must leave so small a share of its residuals.
const BETTER: f64 = 0.2;
/// And explain so many times as much as is left of half of the poses: else noise decides.
const MUCH: f64 = 10.0;
/// Of a load that fewer poses are said to carry the solution knows nothing.
const FEW: usize = 3;
/// Times what is left of half of the poses that a pose with what it carries may have left: more, and something else is wrong with it.
const LEFT: f64 = 30.0;
/// More poses than this share of those that are said to carry the same are a mistake of another kind.
const MOST: f64 = 0.5;
/// Lines that are listed.
const LISTED: usize = 8;

/// Poses that carry the same instead of what they are said to carry.
#[derive(Clone, Debug)]
struct MislabelledPoses {
    said: Option<usize>,
    carried: Option<usize>,
    poses: Vec<usize>,
}

/// The poses that what they carry instead explains best, with the values of a solution; nothing where each is best explained by what it is said to carry.
///
/// # Errors
/// Where no problem can be built.
pub(super) fn all(
    session: &Session,
    readings: &MeasurementSet,
    solved: &Solved,
) -> Result<Option<Arc<dyn Hypothesis>>, EstimateError> {
    let found = found(session, readings, &solved.state(&State::nominal(session)))?;
    Ok(found.map(|found| Arc::new(found) as Arc<dyn Hypothesis>))
}

impl Hypothesis for MislabelledPoses {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        self.poses.iter().for_each(|pose| made.poses[*pose].load = self.carried);
        made
    }

    /// With the values that it leads to other poses may turn out to be among them, or not to be: one of which much is left has another error, a spike that
    /// the load happens to explain in part. None may be left: then the session stays as it is.
    fn placed(
        &self,
        session: &Session,
        readings: &MeasurementSet,
        found_with: &State,
    ) -> Result<Option<Arc<dyn Hypothesis>>, EstimateError> {
        let read = squares(&self.made(session), readings, found_with)?;
        let most = LEFT * median(read.values().copied());
        let is_one = |pose: &usize| read.get(pose).is_none_or(|square| *square <= most);
        let mut poses: Vec<usize> = self.poses.iter().copied().filter(is_one).collect();
        if let Some(now) = found(session, readings, found_with)?
            && (now.said, now.carried) == (self.said, self.carried)
        {
            let otherwise = squares(&now.made(session), readings, found_with)?;
            poses.extend(now.poses.iter().filter(|pose| otherwise.get(pose).is_some_and(|square| *square <= most)));
        }
        poses.sort_unstable();
        poses.dedup();
        Ok((poses != self.poses).then(|| Arc::new(MislabelledPoses { poses, ..self.clone() }) as Arc<dyn Hypothesis>))
    }

    /// Any so many poses with any load.
    fn alternatives(&self, session: &Session) -> f64 {
        (session.poses.len() * (session.loads.len() + 1)) as f64
            * (session.poses.len() as f64).powi(self.poses.len() as i32 - 1)
    }

    fn words(&self, session: &Session) -> (String, String) {
        if let Some(changed) = ChangedLoad::of_poses(session, &self.poses, self.carried) {
            return changed.words(session);
        }
        let name = |load: usize| session.loads[load].name.as_str();
        let lines = self.lines(session);
        let what = match (self.said.map(name), self.carried.map(name)) {
            (Some(said), Some(carried)) => format!("load {carried} in {lines}, said to be of load {said}"),
            (Some(said), None) => format!("no load in {lines}, said to be of load {said}"),
            (None, carried) => format!("load {} in {lines}, said to be bare", carried.unwrap_or_default()),
        };
        let with = self.carried.map_or_else(|| "without load".to_owned(), |load| format!("with load {}", name(load)));
        let cure = format!("If so, put these poses into a file of their own, a [[poses]] {with}, or leave them out.");
        (what, cure)
    }
}

impl MislabelledPoses {
    /// `lines 12, 13 and 14 of bare.csv`, file by file.
    fn lines(&self, session: &Session) -> String {
        let mut of_file: BTreeMap<String, Vec<u64>> = BTreeMap::new();
        for pose in &self.poses {
            let (file, line) = session.row_of(*pose);
            of_file.entry(file).or_default().push(line);
        }
        let told = |(file, lines): (&String, &Vec<u64>)| {
            let listed: Vec<String> = lines.iter().take(LISTED).map(u64::to_string).collect();
            match (lines.len(), listed.split_last()) {
                (1, _) => format!("line {} of {file}", listed[0]),
                (2..=LISTED, Some((last, others))) => format!("lines {} and {last} of {file}", others.join(", ")),
                (count, _) => format!("{count} lines of {file} ({}, …)", listed.join(", ")),
            }
        };
        of_file.iter().map(told).collect::<Vec<_>>().join(", ")
    }
}

/// With these values, the poses that carry the same instead of what they are said to carry: of all such exchanges the one that explains most.
fn found(
    session: &Session,
    readings: &MeasurementSet,
    found_with: &State,
) -> Result<Option<MislabelledPoses>, EstimateError> {
    let said = squares(session, readings, found_with)?;
    let usual = MUCH * median(said.values().copied());
    let mut best: Option<(f64, MislabelledPoses)> = None;
    for carried in carried(session) {
        let mut made = session.clone();
        made.poses.iter_mut().for_each(|pose| pose.load = carried);
        let otherwise = squares(&made, readings, found_with)?;
        let mut gains: BTreeMap<Option<usize>, (f64, Vec<usize>)> = BTreeMap::new();
        for (pose, said_square) in &said {
            let Some(square) = otherwise.get(pose).filter(|_| session.poses[*pose].load != carried) else { continue };
            if *square < BETTER * said_square && said_square - square > usual {
                let (gain, poses) = gains.entry(session.poses[*pose].load).or_default();
                *gain += said_square - square;
                poses.push(*pose);
            }
        }
        for (said, (gain, poses)) in gains {
            if is_part(session, said, &poses) && best.as_ref().is_none_or(|(most, _)| gain > *most) {
                best = Some((gain, MislabelledPoses { said, carried, poses }));
            }
        }
    }
    Ok(best.map(|(_, found)| found))
}

/// Whether most poses that are said to carry this do.
fn is_part(session: &Session, said: Option<usize>, poses: &[usize]) -> bool {
    let all = session.poses.iter().filter(|pose| pose.load == said).count();
    (poses.len() as f64) < MOST * all as f64
}

/// What poses may carry: nothing, and each load that enough poses are said to carry.
fn carried(session: &Session) -> Vec<Option<usize>> {
    let loads = std::iter::once(None).chain((0..session.loads.len()).map(Some));
    loads.filter(|load| session.poses.iter().filter(|pose| pose.load == *load).count() >= FEW).collect()
}

/// Squares of the residuals of each pose with these values, in standard deviations.
fn squares(
    session: &Session,
    readings: &MeasurementSet,
    found_with: &State,
) -> Result<BTreeMap<usize, f64>, EstimateError> {
    let built = build_with_constraints(session, readings, found_with)?;
    let mut squares = BTreeMap::new();
    for (id, residual) in built.rows.iter().zip(built.problem.residuals(&built.initial)?) {
        *squares.entry(id.pose).or_insert(0.0) += residual * residual;
    }
    Ok(squares)
}

fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::session::Session;

    use crate::result::Verdict;
    use crate::testing::sensor_models::{estimate, shoulder};

    /// The reference protocol with some poses of one table among those of another, as if they were like these; and the lines that they have there.
    fn among(from: usize, into: usize, places: &[usize]) -> (Session, Vec<String>) {
        let mut session = shoulder().session(0);
        let poses: Vec<usize> = (0..session.poses.len()).filter(|pose| session.poses[*pose].table == from).collect();
        let of_table = session.poses.iter().find(|pose| pose.table == into).cloned().unwrap();
        let mut lines = Vec::new();
        for (place, line) in places.iter().zip(10_u64..) {
            let pose = &mut session.poses[poses[*place]];
            (pose.table, pose.load, pose.line) = (into, of_table.load, 2 * line);
            lines.push(pose.line.to_string());
        }
        // They stand in the middle of that table.
        session.poses.sort_by_key(|pose| (pose.table, pose.line));
        (session, lines)
    }

    fn named(session: &Session) -> (String, String) {
        let result = estimate(session);
        assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
        (result.termination, result.notes[0].clone())
    }

    /// Table 4 is bare, table 5 of the first plate.
    #[test]
    fn poses_that_carry_something_else_are_named_by_their_lines() {
        let (session, lines) = among(5, 4, &[3, 20, 33]);
        let (what, advice) = named(&session);
        assert_eq!(
            what,
            format!(
                "load plate-a in lines {}, {} and {} of sweep-4.csv, said to be bare",
                lines[0], lines[1], lines[2]
            )
        );
        assert!(advice.contains("file of their own, a [[poses]] with load plate-a"), "{advice}");
        let (session, lines) = among(4, 5, &[5, 12]);
        let (what, advice) = named(&session);
        assert_eq!(
            what,
            format!("no load in lines {} and {} of sweep-5.csv, said to be of load plate-a", lines[0], lines[1])
        );
        assert!(advice.contains("file of their own, a [[poses]] without load"), "{advice}");
    }

    /// A reading that something disturbed is told as such, though the weight of a load would explain a part of it.
    #[test]
    fn a_spike_is_no_load() {
        for by in [-40.0, -15.0, 15.0, 40.0] {
            let mut session = shoulder().session(0);
            let pose = session.poses.iter_mut().filter(|pose| pose.table == 4).nth(12).unwrap();
            pose.torque[1].iter_mut().for_each(|reading| reading.value += by);
            let result = estimate(&session);
            assert!(!result.termination.contains("plate"), "{by}: {}", result.termination);
            assert!(result.notes.iter().any(|note| note.contains("contradict")), "{by}: {:?}", result.notes);
        }
    }

    /// A small table of its own is no part of another.
    #[test]
    fn a_small_table_that_carries_something_else_is_named_as_a_whole() {
        let mut session = shoulder().session(0);
        let own = session.poses.iter().rposition(|pose| pose.table == 5).unwrap();
        let table = session.tables.len();
        session.tables.push(session.tables[5].clone());
        session.tables[table].path = "afterwards.csv".into();
        session.poses[own - 2..=own].iter_mut().for_each(|pose| (pose.table, pose.load) = (table, None));
        assert_eq!(named(&session).0, "load plate-a in afterwards.csv, which is said to be bare");
    }
}
