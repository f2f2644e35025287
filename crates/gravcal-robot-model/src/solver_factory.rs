//! Methods that minimise, by the names that sessions and `--solver` know them by.

use std::fmt::Debug;

use gravcal_estimation::Solver;

use crate::sensors::{Options, RefusedOption};

/// A method that minimises, from any crate.
///
/// [`Registry::with_solver`](crate::Registry::with_solver) makes its name known. gravcal's own methods have theirs in `gravcal-solvers`; one
/// of the same name counts in their place.
pub trait SolverFactory: Debug + Send + Sync {
    /// Its name in files, and behind `--solver`.
    fn name(&self) -> &str;

    /// What it is for, in a line.
    fn help(&self) -> &str;

    /// Keys of the options that it takes: `[solver]` of a session has them beside `name`.
    fn options(&self) -> &[&str] {
        &[]
    }

    /// The method.
    ///
    /// # Errors
    /// An option that it cannot do with.
    fn build(&self, options: &Options) -> Result<Box<dyn Solver>, RefusedOption>;
}
