//! The estimate of a built problem with its readings in their order: see [`super::groups`].

use std::collections::BTreeSet;

use gravcal_estimation::passing_on::{condensed, linearized, selected};
use gravcal_estimation::{
    BlockId, Covariance, Estimate, Factor, IterationRecord, Problem, RankAnalysis, Termination, Values,
};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::ReadingId;

use crate::joint::error::{BuildError, EstimateError};
use crate::joint::order::Order;
use crate::joint::problem::JointProblem;
use crate::joint::solving::groups::{NOT_YET, first_of};
use crate::joint::solving::robust::solve_with_loss;

/// An unknown in which readings are not linear stays where it is in a step of whose readings, and those before, it follows so
/// many times worse than from all: where a standing joint trembles, its gain and offset seem to be known a little.
const HARDLY_KNOWN: f64 = 10.0;
/// Iterations that bring a step that others follow near enough to its end: where it ends is no more than where its readings are
/// condensed.
const BRIEF: usize = 30;
/// A start is far where the residuals of all steps' readings are, root mean square, so many standard deviations. From there a step
/// leads what it leaves open anywhere, and those that follow back in thousands of iterations.
const FAR: f64 = 10.0;
/// Why.
const STEP_SAYS_LITTLE: &str = "the steps so far say hardly anything of it";

/// Estimates the unknowns of a problem.
pub(in crate::joint) fn estimate_in_order(
    built: &JointProblem,
    environment: &SolveEnvironment<'_>,
) -> Result<(JointProblem, Estimate), EstimateError> {
    let updated = match &built.readings().order {
        Order::Together => return solve_with_loss(built, built.readings().loss, environment),
        Order::StepByStep(steps) => step_by_step(built, steps, environment)?,
        Order::PoseByPose { from } => pose_by_pose(built, *from, environment)?,
    };
    Ok((built.clone(), updated.estimate(&built.problem)?))
}

/// Each step from where the one before ended, with what those before determine. A start that is [`FAR`] is first brought near on
/// the readings of all steps: a start is where readings are condensed, and no knowledge.
fn step_by_step(
    built: &JointProblem,
    steps: &[BTreeSet<ReadingId>],
    environment: &SolveEnvironment<'_>,
) -> Result<Updated, EstimateError> {
    let whole = &built.problem;
    let (mut updated, mut last) = (Updated::from(&built.initial), None);
    if is_far(whole, &built.initial)? {
        updated.go_to(environment.solve_briefly(whole, &built.initial, BRIEF, 0.0)?);
    }
    let in_the_end = RankAnalysis::new(whole, &updated.values)?.covariance();
    let mut known = first_of(built, 0);
    for step in steps {
        let rows: Vec<usize> = (0..built.rows.len()).filter(|row| step.contains(&built.rows[*row])).collect();
        if rows.is_empty() {
            continue; // held out of a second fit
        }
        let factors = known.iter().cloned().chain([selected(whole, &rows)]).collect();
        let problem = whole.with_only(factors, NOT_YET).map_err(BuildError::from)?;
        let open = Open::of(&problem, &updated.values, (whole, &in_the_end))?;
        // First what is open stays where it is, as the step would only wander along it; then it may follow.
        for fixed in [open.open_or_hardly_known, open.hardly_known] {
            let problem = problem.with_fixed(&fixed, STEP_SAYS_LITTLE);
            updated.go_to(environment.solve_briefly(&problem, &updated.values, BRIEF, 0.0)?);
        }
        known.extend(condensed(whole, &rows, &updated.values)?);
        last = Some(problem);
    }
    if let Some(last) = last {
        updated.take(environment.solve(&last, &updated.values)?);
    }
    Ok(updated)
}

fn is_far(whole: &Problem, start: &Values) -> Result<bool, EstimateError> {
    Ok(2.0 * whole.cost(start)? > FAR * FAR * whole.rows() as f64)
}

/// Blocks in which the residuals are not linear, and which the readings up to a step do not fix.
struct Open {
    /// What they say hardly anything of.
    hardly_known: Vec<BlockId>,
    /// The same, and what takes part in a direction that is open.
    open_or_hardly_known: Vec<BlockId>,
}

impl Open {
    fn of(
        step: &Problem,
        values: &Values,
        (whole, in_the_end): (&Problem, &Covariance),
    ) -> Result<Self, EstimateError> {
        let analysis = RankAnalysis::new(step, values)?;
        let now = analysis.covariance();
        let is_hardly_known = |id: &BlockId| {
            let mut columns = step.columns_of(*id).zip(whole.columns_of(*id));
            columns.any(|(own, all)| now.std(own) > HARDLY_KNOWN * in_the_end.std(all))
        };
        let is_open = |id: &BlockId| {
            let columns: Vec<usize> = step.columns_of(*id).collect();
            !analysis.null_space_within(&columns).is_empty()
        };
        let not_linear = || step.block_ids().filter(|id| !step.block(*id).linear);
        Ok(Open {
            hardly_known: not_linear().filter(is_hardly_known).collect(),
            open_or_hardly_known: not_linear().filter(|id| is_open(id) || is_hardly_known(id)).collect(),
        })
    }
}

/// The poses before `from` together, then each with all before it as an information matrix.
fn pose_by_pose(
    built: &JointProblem,
    from: usize,
    environment: &SolveEnvironment<'_>,
) -> Result<Updated, EstimateError> {
    let whole = &built.problem;
    let poses: BTreeSet<usize> = built.rows.iter().map(|id| id.pose).collect();
    let together = poses.range(..from).count();
    let mut problem = whole.with_only(first_of(built, together), NOT_YET).map_err(BuildError::from)?;
    let mut updated = Updated::from(&built.initial);
    updated.take(environment.solve(&problem, &updated.values)?);
    for pose in &whole.factors()[together..built.poses] {
        if updated.stopped() {
            break;
        }
        let factors: Vec<Factor> = vec![linearized(&problem, &updated.values)?, pose.clone()];
        problem = whole.with_only(factors, NOT_YET).map_err(BuildError::from)?;
        updated.take(environment.solve(&problem, &updated.values)?);
    }
    Ok(updated)
}

/// Values after some updates.
struct Updated {
    values: Values,
    /// Of the first update that did not converge, else of the last.
    termination: Termination,
    iterations: Vec<IterationRecord>,
}

impl Updated {
    fn from(values: &Values) -> Self {
        Updated { values: values.clone(), termination: Termination::AsGiven, iterations: Vec::new() }
    }

    fn stopped(&self) -> bool {
        self.termination == Termination::Stopped
    }

    fn take(&mut self, estimate: Estimate) {
        if self.termination == Termination::AsGiven || self.termination.converged() {
            self.termination = estimate.termination;
        }
        self.go_to(estimate);
    }

    fn go_to(&mut self, estimate: Estimate) {
        self.values = estimate.values;
        // The start of an update is the end of the one before.
        let own = estimate.iterations.into_iter().skip(usize::from(!self.iterations.is_empty()));
        for record in own {
            self.iterations.push(IterationRecord { iteration: self.iterations.len(), ..record });
        }
    }

    fn estimate(self, whole: &Problem) -> Result<Estimate, EstimateError> {
        Ok(Estimate {
            cost: whole.cost(&self.values)?,
            values: self.values,
            termination: self.termination,
            iterations: self.iterations,
            iterates: Vec::new(),
            active: Vec::new(),
            without_effect: Vec::new(),
            normal_equations: None,
        })
    }
}
