//! Ends of several starts, compared by their likelihood.
//!
//! ```text
//!     − ln L = ½ χ² + Σ ln σ_i      over the readings, but for what all ends share
//! ```
//!
//! A minimum may be a local one, and noise that was found at a minimum excuses it; so ends are compared with the noise that each of them
//! found. An end takes another's place only where it is likelier beyond doubt ([`DECISIVE`]), or where the other did not converge; what ends
//! elsewhere and is as plausible is kept, as it may be the true one.

use gravcal_estimation::{Values, in_parallel};

use crate::fit::FIRST_ITERATIONS;
use crate::nearby::IMPLAUSIBLE;
use crate::workbench::Workbench;

/// − ln of the likelihood by which one of two must exceed the other to be ruled out: it is then less likely by e¹⁰.
pub const DECISIVE: f64 = 10.0;

/// Where a start led.
#[derive(Clone, Debug)]
pub struct End<S> {
    /// All of it.
    pub solution: S,
    /// − ln of its likelihood.
    pub height: f64,
    /// Whether it is a minimum.
    pub converged: bool,
    /// The unknowns there.
    pub values: Values,
}

/// The likeliest end so far.
#[derive(Debug)]
pub struct Likeliest<S> {
    /// It.
    pub best: End<S>,
    /// Whether it is another than the first.
    pub is_another: bool,
    /// − ln of the likelihood and unknowns of all others that converged.
    pub ends: Vec<(f64, Values)>,
}

impl<S: Send + Sync> Likeliest<S> {
    /// The first.
    pub fn first(end: End<S>) -> Likeliest<S> {
        Likeliest { best: end, is_another: false, ends: Vec::new() }
    }

    /// Or a likelier one from one of these starts. `follow` leads from a start to its end, `on` starts where an end is. What still creeps
    /// after some iterations is followed on only where that may matter.
    pub fn or_from<Start: Send, E: Send>(
        &mut self,
        starts: Vec<Start>,
        follow: impl Fn(Start, &Workbench<'_>) -> Result<End<S>, E> + Sync,
        on: impl Fn(&S) -> Start + Sync,
        workbench: &Workbench<'_>,
    ) {
        let followed = |start: Start| {
            let there = follow(start, &workbench.within(FIRST_ITERATIONS))?;
            if there.converged || there.height - self.best.height > IMPLAUSIBLE {
                return Ok(there);
            }
            follow(on(&there.solution), workbench)
        };
        let ends: Vec<Result<End<S>, E>> = in_parallel(starts, followed);
        // A start that leads nowhere says nothing of the others.
        for other in ends.into_iter().flatten() {
            let gain = self.best.height - other.height;
            if other.converged {
                self.ends.push((other.height, other.values.clone()));
            }
            if gain > DECISIVE || gain > 0.0 && other.converged && !self.best.converged {
                (self.best, self.is_another) = (other, true);
            }
        }
    }
}
