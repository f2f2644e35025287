//! Least squares over named blocks whose residuals are functions in Python: what `gravcal.estimation` says, solved and judged.

mod residual;
mod said;
mod solve;

pub use residual::Raised;
pub use solve::{Estimated, estimate};
