//! A part of the poses: starts are compared and judged by one that is small, ends of starts are looked for with a larger one.
//!
//! Windows of an arm in motion overlap, and those that do are evaluated together: of them a part is made of runs of neighbours.

use std::borrow::Cow;
use std::collections::HashMap;

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::building::build::build_problem;
use crate::joint::error::BuildError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::order::Order;
use crate::joint::problem::JointProblem;
use crate::joint::starting::at_distances::FAINT_DAMPING;
use crate::joint::variables::State;

/// Poses that suffice to compare candidates.
pub(in crate::joint) const POSES: usize = 120;
/// Static poses, and windows of an arm in motion, that suffice to tell ends of starts apart; of more than twice as many a part is looked at.
const TELLING: usize = 1000;
const TELLING_WINDOWS: usize = 400;
/// Into about so many runs of neighbours a part of the windows falls, over all tables and loads.
const RUNS: usize = 30;
/// The multiples of this, less their whole parts, spread evenly and without a period (Weyl, *Mathematische Annalen* 77, 1916).
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;
/// Iterations from a start that tell how low it leads.
const BRIEF: usize = 30;
/// Iterations to a minimum: along a bent valley there are hundreds.
const LONG: usize = 300;
/// A solve that has not converged after so many, at so many times the cost that explains the readings, will not explain them.
const UNLIKELY: f64 = 5.0;
/// A cost for each reading below this explains them: noise alone makes it ½.
const EXPLAINED: f64 = 1.0;

/// The joint problem of a part of the poses.
pub(in crate::joint) struct Sample {
    pub readings: MeasurementSet,
    built: JointProblem,
}

/// Where some iterations lead.
pub(in crate::joint) struct Nearby {
    /// The cost there; infinite where the solver takes no such problem.
    pub cost: f64,
    pub end: State,
}

/// What the readings of a sample cost where a start leads.
pub(in crate::joint) struct RoughMinimum {
    /// Infinite where the solver takes no such problem.
    pub cost: f64,
    /// Whether it is no lower at the end of the way: the solver has converged, or creeps where nothing explains the readings.
    pub reached: bool,
}

/// Where one step leads.
pub(in crate::joint) struct OneStep {
    /// The cost there.
    pub cost: f64,
    pub end: State,
}

impl Sample {
    /// Of these readings, to start from anywhere.
    ///
    /// # Errors
    /// Where no problem can be built.
    pub fn new(session: &Session, readings: &MeasurementSet) -> Result<Sample, BuildError> {
        let readings = thinned(session, readings, POSES);
        let built = build_problem(session, &readings, &State::nominal(session))?;
        Ok(Sample { readings, built })
    }

    /// The same with the noise of these readings, which are those that it is part of.
    ///
    /// # Errors
    /// As [`Sample::new`].
    pub fn with_noise_of(self, session: &Session, readings: &MeasurementSet) -> Result<Sample, BuildError> {
        let alike = self.readings.noise == readings.noise && self.readings.unexplained == readings.unexplained;
        if alike { Ok(self) } else { Sample::new(session, readings) }
    }

    /// Its problem, started from here.
    pub fn built_at(&self, session: &Session, start: &State) -> JointProblem {
        self.built.starting_at(session, start)
    }

    /// How many unknowns its poses share: those of one pose, such as how far a joint is from where its sensor says, are nearly known beforehand.
    pub fn shared_columns(&self) -> usize {
        let problem = &self.built.problem;
        problem.columns().iter().filter(|column| !problem.block(column.block).eliminated).count()
    }

    /// A cost that explains its readings.
    pub fn explained(&self) -> f64 {
        EXPLAINED * self.readings.count() as f64
    }

    /// Where a few iterations from `start` lead, or fewer where the cost is no higher than `enough` before.
    pub fn nearby(&self, session: &Session, start: &State, enough: f64, environment: &SolveEnvironment<'_>) -> Nearby {
        let built = self.built_at(session, start);
        match environment.solve_briefly(&built.problem, &built.initial, BRIEF, enough) {
            Ok(estimate) => Nearby { cost: estimate.cost, end: built.variables.state(&estimate.values, start) },
            Err(_) => Nearby { cost: f64::INFINITY, end: start.clone() },
        }
    }

    /// The cost of the readings alone where `start` leads, as far as it was followed: what unknowns rest on does not count.
    pub fn rough_minimum(&self, session: &Session, start: &State, environment: &SolveEnvironment<'_>) -> RoughMinimum {
        let built = self.built_at(session, start);
        let nowhere = RoughMinimum { cost: f64::INFINITY, reached: true };
        let Ok(end) = environment.within(LONG).solve(&built.problem, &built.initial) else { return nowhere };
        let cost = built.problem.without_reference().cost(&end.values).unwrap_or(f64::INFINITY);
        RoughMinimum { cost, reached: end.termination.converged() || cost > UNLIKELY * self.explained() }
    }

    /// The step to the minimum of the linear model; nothing if the cost is no lower where it leads.
    pub fn one_step(&self, session: &Session, start: &State) -> Option<OneStep> {
        let JointProblem { problem, initial, variables, .. } = &self.built_at(session, start);
        let mut linearization = problem.linearize(initial).ok()?;
        let mut step = vec![0.0; problem.columns().len()];
        linearization.damped_step(FAINT_DAMPING, &linearization.column_scales(), &mut step);
        let there = problem.retract(initial, &step);
        let cost = problem.cost(&there).ok().filter(|cost| *cost < linearization.cost())?;
        let end = variables.state(&there, start);
        Some(OneStep { cost, end })
    }
}

/// What suffices to tell ends of starts apart: of many readings a part, where they enter together.
pub(in crate::joint) fn telling_part<'a>(session: &Session, readings: &'a MeasurementSet) -> Cow<'a, MeasurementSet> {
    let enough = if session.has_windows() { TELLING_WINDOWS } else { TELLING };
    match readings.order == Order::Together && readings.poses() > 2 * enough {
        true => Cow::Owned(thinned(session, readings, enough)),
        false => Cow::Borrowed(readings),
    }
}

/// About so many `poses` of the readings, spread evenly over each table and load. Which they are has no period: every so many of
/// them could be those that were approached from one side.
pub(in crate::joint) fn thinned(session: &Session, readings: &MeasurementSet, poses: usize) -> MeasurementSet {
    let share = poses as f64 / readings.poses() as f64;
    if share >= 1.0 {
        return readings.clone();
    }
    let run = (poses / RUNS).max(1);
    let mut seen: HashMap<(usize, Option<usize>, bool), usize> = HashMap::new();
    let kept = session.poses.iter().zip(&readings.used).map(|(pose, used)| {
        let in_motion = pose.course.is_some();
        let place = seen.entry((pose.table, pose.load, in_motion)).or_default();
        *place += usize::from(!used.is_empty());
        let place = if in_motion { place.div_ceil(run) } else { *place };
        (place as f64 * GOLDEN_SECTION).fract() < share
    });
    let kept: Vec<bool> = kept.collect();
    readings.only(|id| kept[id.pose])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gravcal_recording::Course;

    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::sarcos_shoulder;

    /// The reference protocol so many times over, in three tables of which one carries loads.
    fn many(times: usize) -> Session {
        let mut session = sarcos_shoulder().session(0);
        session.poses.iter_mut().for_each(|pose| pose.table %= 3);
        session.poses = std::iter::repeat_n(session.poses, times).flatten().collect();
        session
    }

    /// The same of an arm in motion: how it moved does not matter here.
    fn in_motion(times: usize) -> Session {
        let mut session = many(times);
        let course = Arc::new(Course::of(&[]));
        session.poses.iter_mut().for_each(|pose| pose.course = Some(Arc::clone(&course)));
        session
    }

    /// By table and load, which of the poses one after the other are in the part.
    fn kept(session: &Session) -> Vec<Vec<bool>> {
        let readings = select(session, Signals::All);
        let part = telling_part(session, &readings);
        let mut apart: HashMap<(usize, Option<usize>), Vec<bool>> = HashMap::new();
        for (pose, used) in session.poses.iter().zip(&part.used) {
            apart.entry((pose.table, pose.load)).or_default().push(!used.is_empty());
        }
        apart.into_values().collect()
    }

    fn share(kept: impl Iterator<Item = bool>) -> f64 {
        let all: Vec<bool> = kept.collect();
        all.iter().filter(|kept| **kept).count() as f64 / all.len() as f64
    }

    #[test]
    fn all_readings_are_looked_at_unless_they_are_many_and_enter_together() {
        // 407 poses each time; of windows fewer are enough.
        let is_all =
            |session: &Session, readings: &MeasurementSet| matches!(telling_part(session, readings), Cow::Borrowed(_));
        let of = |session: Session| is_all(&session, &select(&session, Signals::All));
        assert_eq!([of(many(4)), of(many(5))], [true, false]);
        assert_eq!([of(in_motion(1)), of(in_motion(2))], [true, false]);
        let session = many(5);
        let one_by_one = MeasurementSet { order: Order::PoseByPose { from: 100 }, ..select(&session, Signals::All) };
        assert!(is_all(&session, &one_by_one));
    }

    /// Of each table and load its share, to one pose, and as many of those that come from one side as of the others.
    #[test]
    fn of_many_poses_a_part_is_spread_evenly() {
        let (session, expected) = (many(8), 1000.0 / (8.0 * 407.0));
        for kept in kept(&session) {
            let poses = kept.len() as f64;
            assert!((poses * (share(kept.iter().copied()) - expected)).abs() < 2.0, "{}", share(kept.into_iter()));
            for period in [2, 3, 37] {
                let one_in = share(kept.iter().copied().step_by(period));
                assert!((one_in / expected - 1.0).abs() < 0.3, "{period}: {one_in} {expected}");
            }
        }
    }

    /// A 30th of 400 windows one after the other each time, but at the ends of a table.
    #[test]
    fn of_many_windows_a_part_is_made_of_runs_of_neighbours() {
        let (session, mut runs) = (in_motion(8), 0);
        for kept in kept(&session) {
            let own: Vec<&[bool]> = kept.chunk_by(|one, next| one == next).filter(|run| run[0]).collect();
            assert!(own.len() > 1 && own[..own.len() - 1].iter().all(|run| run.len() == 13), "{own:?}");
            assert!(own[own.len() - 1].len() <= 13);
            runs += own.len();
        }
        assert!((RUNS - 6..RUNS + 7).contains(&runs), "{runs}");
    }
}
