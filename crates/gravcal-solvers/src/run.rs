//! Runs a [`Descent`] as an argmin [`Solver`](argmin::core::Solver): linearization, stopping rules, records, observer, stop
//! flag and checkpoint are the same for every method.

use std::cell::RefCell;

use argmin::core::{
    Error, Executor, IterState, KV, Problem as Counted, Solver as ArgminSolver, State, TerminationReason,
};
use gravcal_estimation::{
    Estimate, EvaluateError, IterationRecord, Problem, SolveContext, SolveError, Termination, Values,
};

use crate::checkpoint::{CheckpointFile, other_cost};
use crate::{Descent, Move, Point, Trial};

pub(crate) type IterationState = IterState<Vec<f64>, (), (), (), (), f64>;

/// Minimises `problem` from `initial`, or from where the checkpoint of `context` left it.
///
/// The checkpoint is removed when the solve has ended by itself. It stays where the solve was stopped from outside or had
/// no iterations left, so that another one, perhaps with more of them, goes on.
///
/// # Errors
/// Where there is no answer at all: the problem is not for this method, it cannot be evaluated at the start, or the
/// checkpoint is not one of this solve.
pub fn minimise<D: Descent>(
    method: &D,
    problem: &Problem,
    initial: &Values,
    context: &mut SolveContext<'_>,
) -> Result<Estimate, SolveError> {
    method.check(problem)?;
    method.stopping().check(method.name())?;
    check_start(problem, initial)?;
    let checkpoint = context.checkpoint.map(|path| CheckpointFile::new(path, method.name(), problem, initial));
    let lent = Lend { method, problem, initial, context: RefCell::new(context) };
    let state = IterationState::new().max_iters(u64::MAX);
    let mut executor = Executor::new(lent, Run::default()).configure(|_| state).ctrlc(false).timer(false);
    if let Some(file) = &checkpoint {
        executor = executor.checkpointing(file.clone());
    }
    let estimate =
        executor.run().and_then(|result| result.solver.into_estimate()).map_err(|error| reported(method, error))?;
    let unfinished = matches!(estimate.termination, Termination::Stopped | Termination::IterationLimit { .. });
    match checkpoint {
        Some(file) if !unfinished => file.remove()?,
        _ => {}
    }
    Ok(estimate)
}

/// # Errors
/// Where nothing is unknown, or a start is of another problem.
pub(crate) fn check_start(problem: &Problem, initial: &Values) -> Result<(), SolveError> {
    match (problem.columns().is_empty(), problem.fits(initial)) {
        (true, _) => Err(SolveError::NoUnknowns),
        (_, false) => Err(SolveError::ForeignStart),
        _ => Ok(()),
    }
}

/// argmin's error as ours.
fn reported(method: &dyn gravcal_estimation::Solver, error: Error) -> SolveError {
    match error.downcast::<SolveError>() {
        Ok(error) => error,
        Err(other) => SolveError::Failed { solver: method.name(), reason: other.to_string() },
    }
}

/// argmin owns its problem; ours is lent to it together with what accompanies the solve.
struct Lend<'p, 'c, 'o, D> {
    method: &'c D,
    problem: &'p Problem,
    initial: &'p Values,
    context: RefCell<&'c mut SolveContext<'o>>,
}

/// A method at work.
pub(crate) struct Run<'p, M> {
    /// What the method remembers.
    pub memory: M,
    /// The way so far, the start first.
    pub records: Vec<IterationRecord>,
    /// Where it came by, as far as it was not before a checkpoint.
    pub iterates: Vec<Values>,
    /// Where a checkpoint left it: values and scaling, to be linearized.
    pub restored: Option<(Values, Vec<f64>)>,
    /// Where it is; nowhere before the start.
    pub point: Option<Point<'p>>,
    /// Why it ended; told only once it has.
    pub termination: Termination,
}

impl<M: Default> Default for Run<'_, M> {
    fn default() -> Self {
        Run {
            memory: M::default(),
            records: Vec::new(),
            iterates: Vec::new(),
            restored: None,
            point: None,
            termination: Termination::NoProgress,
        }
    }
}

impl<'p, M> Run<'p, M> {
    fn into_estimate(self) -> Result<Estimate, Error> {
        let mut point = self.point.ok_or_else(nowhere)?;
        Ok(Estimate {
            active: point.active(),
            without_effect: point.without_effect(),
            normal_equations: point.linearization.normal_equations(),
            cost: point.cost(),
            values: point.values,
            termination: self.termination,
            iterations: self.records,
            iterates: self.iterates,
        })
    }

    /// Takes a point as the current one, with the length and the damping of the step to it, and tells the observer.
    fn arrive<D>(&mut self, lent: &Lend<'p, '_, '_, D>, mut point: Point<'p>, step: f64, damping: f64) {
        let record = IterationRecord {
            iteration: self.records.len(),
            cost: point.cost(),
            cosine: point.cosine(),
            step,
            damping,
        };
        self.iterates.push(point.values.clone());
        self.point = Some(point);
        lent.context.borrow_mut().report(&record);
        self.records.push(record);
    }

    fn start<D>(&mut self, lent: &Lend<'p, '_, '_, D>) -> Result<(), SolveError> {
        let point = Point::new(lent.problem, lent.initial.clone(), Vec::new())?;
        let (cost, problem) = (point.cost(), lent.problem);
        let underflows = cost == 0.0 && problem.residuals(lent.initial)?.iter().any(|r| *r != 0.0);
        if !cost.is_finite() || underflows {
            let reported = format!("the cost is {cost}, as squares of residuals leave the range of numbers");
            return Err(EvaluateError(format!("{reported}: {}", problem.costliest(lent.initial)?)).into());
        }
        self.arrive(lent, point, 0.0, 0.0);
        Ok(())
    }

    /// Where a checkpoint left the run.
    fn restore<D>(&mut self, lent: &Lend<'p, '_, '_, D>) -> Result<(), SolveError> {
        let Some((values, scaling)) = self.restored.take() else { return Ok(()) };
        let point = Point::new(lent.problem, values, scaling)?;
        let path = lent.context.borrow().checkpoint;
        let (here, then) = (point.cost(), self.records.last().map_or(f64::NAN, |record| record.cost));
        match path {
            Some(path) if !same(here, then) => Err(other_cost(path, here, then)),
            _ => {
                self.point = Some(point);
                Ok(())
            }
        }
    }

    /// One iteration. `None` while there is reason to go on.
    fn advance<D>(&mut self, lent: &Lend<'p, '_, '_, D>) -> Result<Option<Termination>, SolveError>
    where
        D: Descent<Memory = M>,
    {
        self.restore(lent)?;
        let rules = lent.method.stopping();
        let Some(here) = self.point.as_mut() else { return Ok(Some(Termination::NoProgress)) };
        if let Some(end) = here.stationary(rules) {
            return Ok(Some(end));
        }
        if lent.context.borrow().stopped() {
            return Ok(Some(Termination::Stopped));
        }
        if self.records.len() > rules.max_iterations {
            return Ok(Some(Termination::IterationLimit { limit: rules.max_iterations }));
        }
        match lent.method.iterate(&mut self.memory, here)? {
            Move::Stay(Termination::NoProgress) => Ok(Some(here.at_rest())),
            Move::Stay(end) => Ok(Some(end)),
            Move::To { trial, damping, end } => {
                let Trial { values, length, there, .. } = *trial;
                let linearize = || here.next(values);
                let no_derivative = |EvaluateError(why)| SolveError::Failed {
                    solver: lent.method.name(),
                    reason: format!("there is a cost but no derivative at a point on the way: {why}"),
                };
                let point = there.map_or_else(linearize, Ok).map_err(no_derivative)?;
                self.arrive(lent, point, length, damping);
                Ok(end)
            }
        }
    }
}

/// The same cost, but for the last digits of another machine.
fn same(here: f64, then: f64) -> bool {
    (here - then).abs() <= 1e-9 * then.abs()
}

fn nowhere() -> Error {
    Error::msg("no current point")
}

impl<'p, D: Descent> ArgminSolver<Lend<'p, '_, '_, D>, IterationState> for Run<'p, D::Memory> {
    fn name(&self) -> &str {
        "descent" // for observers of argmin, of which there are none
    }

    fn init(
        &mut self,
        problem: &mut Counted<Lend<'p, '_, '_, D>>,
        state: IterationState,
    ) -> Result<(IterationState, Option<KV>), Error> {
        problem.problem("start", |lent| Ok(self.start(lent)?))?;
        Ok((state.cost(self.records[0].cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Counted<Lend<'p, '_, '_, D>>,
        state: IterationState,
    ) -> Result<(IterationState, Option<KV>), Error> {
        let end = problem.problem("iterations", |lent| Ok(self.advance(lent)?))?;
        let point = self.point.as_ref().ok_or_else(nowhere)?;
        let mut state = state.cost(point.cost());
        if let Some(termination) = end {
            self.termination = termination;
            state = state.terminate_with(match termination.converged() {
                true => TerminationReason::SolverConverged,
                false => TerminationReason::SolverExit(termination.to_string()),
            });
        }
        Ok((state, None))
    }
}
