//! What a method must say: how it gets from one point to the next. Everything else is [`minimise`](crate::minimise).

use gravcal_estimation::{SolveError, Solver, Termination};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::{Point, StoppingRules, Trial};

/// A method that goes from point to point, each of lower cost.
pub trait Descent: Solver {
    /// What it remembers from one iteration to the next: a damping, a radius. It stands in the checkpoint, so it must come
    /// back to the same bits.
    type Memory: Default + Serialize + DeserializeOwned;

    /// When it ends.
    fn stopping(&self) -> &StoppingRules;

    /// One iteration.
    ///
    /// # Errors
    /// Where the problem turns out not to be for this method.
    fn iterate<'p>(&self, memory: &mut Self::Memory, here: &mut Point<'p>) -> Result<Move<'p>, SolveError>;
}

/// What one iteration comes to.
pub enum Move<'p> {
    /// To a better point.
    To {
        /// The step that leads there.
        trial: Trial<'p>,
        /// Its damping; 0 for methods without.
        damping: f64,
        /// Why the method ends there, if it does.
        end: Option<Termination>,
    },
    /// Nowhere.
    Stay(Termination),
}
