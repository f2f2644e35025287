//! What a method needs of the Jacobian, without seeing how it is stored.
//!
//! Two forms: [`normal`] (normal equations, fast) and [`orthogonal`] (orthogonal factorization, no digit lost). Both
//! eliminate blocks component by component, so that cost and memory grow linearly with their number. Damping comes
//! before elimination, and another damping reuses what was summed over the factors.

mod finite;
mod form;
mod negligible;
mod normal;
mod normal_equations;
mod orthogonal;
mod triangle;
mod vector_registers;

use crate::{EvaluateError, Problem, Values};

pub(crate) use form::column_scales;
pub use form::{Linearization, StepInfo};
pub(crate) use normal::{Alike, Normal};
pub use normal_equations::NormalEquations;
pub(crate) use orthogonal::{Orthogonal, factor_component};

impl Problem {
    /// Linearizes at `values`, in the form that suits the problem's size and structure: by an orthogonal factorization
    /// where that is cheap, else by normal equations after elimination, which turn to the orthogonal
    /// factorization by themselves where they would lose digits.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn linearize<'p>(&'p self, values: &Values) -> Result<Box<dyn Linearization + 'p>, EvaluateError> {
        if self.is_small() {
            Ok(Box::new(Orthogonal::new(self, values)?))
        } else {
            Ok(Box::new(Normal::new(self, values)?))
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
