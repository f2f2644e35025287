//! Methods that minimise a [`gravcal_estimation::Problem`], one file each.
//!
//! | name | for |
//! |---|---|
//! | `levenberg-marquardt` | everything without constraints; the default |
//! | `gauss-newton` | small residuals, starts that are near; as fast as Levenberg-Marquardt |
//! | `dogleg` | as Levenberg-Marquardt, and as fast: where that creeps along a bent valley it may go through |
//! | `variable-projection` | problems with blocks marked as linear of which nobody has a start: an iteration takes several times as long |
//! | `clarabel` | problems with constraints: bounds, cones, vectors of known length |
//!
//! Each goes from point to point, each of lower cost ([`Descent`]); what they have in common is in files of its own:
//! when to end (`stopping.rs`), what a step comes to ([`Point`]), the run with records, observer, stop flag and
//! checkpoint ([`minimise`]). [Solving](solving) goes from readings to intervals; [Adding a solver](adding_a_solver) shows the whole of a small one; the
//! shared suites of published problems (`tests/`) run every method with a name by themselves.

mod checkpoint;
mod clarabel;
mod damping;
mod descent;
mod dogleg;
mod gauss_newton;
mod levenberg_marquardt;
mod linear_part;
mod point;
mod refusal;
mod run;
mod stopping;
#[cfg(test)]
mod testing;
mod variable_projection;

#[doc = include_str!("../SOLVING.md")]
pub mod solving {}

#[doc = include_str!("../ADDING_A_SOLVER.md")]
pub mod adding_a_solver {}

use std::fmt;
use std::str::FromStr;

use gravcal_estimation::Solver;
use serde::de::{Deserialize, DeserializeSeed, Deserializer};
use thiserror::Error;

pub use crate::clarabel::Clarabel;
pub use descent::{Descent, Move};
pub use dogleg::Dogleg;
pub use gauss_newton::GaussNewton;
pub use levenberg_marquardt::LevenbergMarquardt;
pub use point::{Decision, Point, Trial};
pub use refusal::refuse_constraints;
pub use run::minimise;
pub use stopping::StoppingRules;
pub use variable_projection::VariableProjection;

/// The methods that a user can choose by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverName {
    /// [`LevenbergMarquardt`].
    LevenbergMarquardt,
    /// [`GaussNewton`].
    GaussNewton,
    /// [`Dogleg`].
    Dogleg,
    /// [`VariableProjection`].
    VariableProjection,
    /// [`Clarabel`].
    Clarabel,
}

impl SolverName {
    /// Every method.
    pub const ALL: [SolverName; 5] = [
        SolverName::LevenbergMarquardt,
        SolverName::GaussNewton,
        SolverName::Dogleg,
        SolverName::VariableProjection,
        SolverName::Clarabel,
    ];

    /// The name in files and on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            SolverName::LevenbergMarquardt => levenberg_marquardt::NAME,
            SolverName::GaussNewton => gauss_newton::NAME,
            SolverName::Dogleg => dogleg::NAME,
            SolverName::VariableProjection => variable_projection::NAME,
            SolverName::Clarabel => crate::clarabel::NAME,
        }
    }

    /// The method with its default options.
    pub fn build(self) -> Box<dyn Solver> {
        match self {
            SolverName::LevenbergMarquardt => Box::new(LevenbergMarquardt::default()),
            SolverName::GaussNewton => Box::new(GaussNewton::default()),
            SolverName::Dogleg => Box::new(Dogleg::default()),
            SolverName::VariableProjection => Box::new(VariableProjection::default()),
            SolverName::Clarabel => Box::new(Clarabel::default()),
        }
    }

    /// The method with options from a file; what is not said has its default.
    ///
    /// # Errors
    /// An option that the method has not, or a value that makes no sense.
    pub fn with_options<'de, D: Deserializer<'de>>(self, options: D) -> Result<Box<dyn Solver>, D::Error> {
        match self {
            SolverName::LevenbergMarquardt => boxed::<LevenbergMarquardt, D>(options),
            SolverName::GaussNewton => boxed::<GaussNewton, D>(options),
            SolverName::Dogleg => boxed::<Dogleg, D>(options),
            SolverName::VariableProjection => boxed::<VariableProjection, D>(options),
            SolverName::Clarabel => boxed::<Clarabel, D>(options),
        }
    }
}

fn boxed<'de, S, D>(options: D) -> Result<Box<dyn Solver>, D::Error>
where
    S: Solver + Deserialize<'de> + 'static,
    D: Deserializer<'de>,
{
    Ok(Box::new(S::deserialize(options)?))
}

/// [`SolverName::with_options`], where serde wants a value.
impl<'de> DeserializeSeed<'de> for SolverName {
    type Value = Box<dyn Solver>;

    fn deserialize<D: Deserializer<'de>>(self, options: D) -> Result<Box<dyn Solver>, D::Error> {
        self.with_options(options)
    }
}

impl fmt::Display for SolverName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No method has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown solver `{name}`; there is: {known}")]
pub struct UnknownSolver {
    name: String,
    known: String,
}

impl FromStr for SolverName {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, UnknownSolver> {
        SolverName::ALL.into_iter().find(|s| s.as_str() == name).ok_or_else(|| UnknownSolver {
            name: name.to_owned(),
            known: SolverName::ALL.map(SolverName::as_str).join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_their_methods_and_back() {
        for name in SolverName::ALL {
            assert_eq!(name.build().name(), name.as_str());
            assert_eq!(name.as_str().parse(), Ok(name));
        }
        let unknown = "simplex".parse::<SolverName>().unwrap_err().to_string();
        assert!(unknown.starts_with("unknown solver `simplex`; there is: levenberg-marquardt, gauss-newton,"));
    }

    #[test]
    fn every_method_takes_options_and_refuses_unknown_ones() {
        for name in SolverName::ALL {
            let read = |text: &str| name.with_options(&mut serde_json::Deserializer::from_str(text));
            assert_eq!(read("{}").unwrap().name(), name.as_str());
            assert_eq!(read(r#"{ "max_iterations": 50 }"#).unwrap().name(), name.as_str());
            let error = read(r#"{ "colour": 1 }"#).err().unwrap().to_string();
            assert!(error.contains("unknown field `colour`, expected one of `max_iterations`"), "{name}: {error}");
        }
    }
}
