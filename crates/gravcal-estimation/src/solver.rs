//! What a method that minimises a problem offers.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

use crate::{Estimate, EvaluateError, IterationRecord, Problem, Values};

/// A method that minimises a [`Problem`] from a starting point.
pub trait Solver: Send + Sync {
    /// The name by which a user chooses it.
    fn name(&self) -> &'static str;

    /// Whether it can take this problem.
    ///
    /// # Errors
    /// Says in words why not.
    fn check(&self, problem: &Problem) -> Result<(), Unsupported>;

    /// Minimises from `initial`. Not converging is an answer ([`Estimate::termination`]), not an error.
    ///
    /// # Errors
    /// Where there is no answer at all: the problem is not for this method, or cannot be evaluated at the start.
    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError>;

    /// Other methods that take other ways down, with the same options: who doubts where this one ended asks the first, too, and the others
    /// where that does not suffice. Two that begin at the same place rarely end in the same wrong valley.
    fn companions(&self) -> Vec<Box<dyn Solver>> {
        Vec::new()
    }

    /// The method that looks how well an answer of this one is known, with the same options, where that is another: what is told must not
    /// depend on how the answer was found.
    fn judge(&self) -> Option<Box<dyn Solver>> {
        None
    }
}

/// A method cannot take a problem.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{solver} cannot take this problem: {reason}")]
pub struct Unsupported {
    /// The method's name.
    pub solver: &'static str,
    /// What it misses, in words.
    pub reason: String,
}

/// No answer at all.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SolveError {
    /// The method cannot take the problem.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// Every block is fixed.
    #[error("no unknowns: every block is fixed, there is nothing to solve for")]
    NoUnknowns,
    /// The start has other numbers than the problem.
    #[error("the start is of another problem: its blocks are not as long as this one's")]
    ForeignStart,
    /// An option that makes no sense.
    #[error("{solver}: {option} is {value}, and must be {expected}")]
    Option {
        /// The method's name.
        solver: &'static str,
        /// The option's name.
        option: &'static str,
        /// What it is.
        value: f64,
        /// What it must be, in words.
        expected: &'static str,
    },
    /// A residual has no value at the start.
    #[error("the start cannot be evaluated: {0}")]
    Evaluate(#[from] EvaluateError),
    /// The start breaks constraints.
    #[error("the start breaks {}; nearest to it, no constraint is broken by {}", .broken.join(", "), .nearest.join(", "))]
    StartOutside {
        /// Each constraint that it breaks, with its value and its limits.
        broken: Vec<String>,
        /// What its components would have to be.
        nearest: Vec<String>,
    },
    /// A constraint over blocks that are all held, and that they break.
    #[error("fixed values break {0}: fix them elsewhere, or drop the constraint")]
    HeldOutside(String),
    /// No values obey all constraints: the names of those that contradict each other.
    #[error("no values obey all constraints; these contradict each other: {}", .0.join(", "))]
    Contradiction(Vec<String>),
    /// The checkpoint is not one of this solve, or cannot be kept.
    #[error("the checkpoint {} {reason}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        reason: String,
    },
    /// The method failed inside.
    #[error("{solver} failed: {reason}")]
    Failed {
        /// The method's name.
        solver: &'static str,
        /// What it said.
        reason: String,
    },
}

/// Is told of every iteration.
pub trait Observer {
    /// Called after the start (iteration 0) and after every iteration.
    fn iteration(&mut self, record: &IterationRecord);
}

impl<F: FnMut(&IterationRecord)> Observer for F {
    fn iteration(&mut self, record: &IterationRecord) {
        self(record);
    }
}

/// What accompanies a solve: who watches, and who may stop it.
#[derive(Default)]
pub struct SolveContext<'a> {
    /// Told of every iteration.
    pub observer: Option<&'a mut dyn Observer>,
    /// Set from elsewhere to stop after the current iteration.
    pub stop: Option<&'a AtomicBool>,
    /// File in which the state is kept after every iteration, so that a solve that was interrupted goes on from there. A
    /// file that is there is gone on from, whatever the start; one that is not of this solve is an error.
    pub checkpoint: Option<&'a Path>,
}

impl SolveContext<'_> {
    /// Whether someone asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Tells the observer, if there is one.
    pub fn report(&mut self, record: &IterationRecord) {
        if let Some(observer) = self.observer.as_mut() {
            observer.iteration(record);
        }
    }
}
