//! Which way gravity points where no hemisphere is declared.
//!
//! Gravity the other way up, with masses, moments and placements negative, gives the same torques, unless a load of known
//! mass hangs on known lengths. So both are solved for, and the readings decide if they can.

use super::hold::Holds;
use super::solve::{Solved, solve_from};
use super::{EstimateError, Unknowns};
use crate::session::Session;
use crate::workbench::Workbench;

/// Cost by which one of both must exceed the other to be ruled out: its likelihood is then less by e¹⁰.
const DECISIVE: f64 = 10.0;

/// The solution, or the one the other way up if that explains the readings better; and whether the readings decide.
///
/// # Errors
/// As [`super::solve`].
pub(super) fn settled(session: &Session, solved: Solved, workbench: &Workbench<'_>) -> Result<Solved, EstimateError> {
    if session.gravity.hemisphere.is_some() {
        return Ok(solved);
    }
    workbench.tell("gravity the other way up");
    let nominal = Unknowns::nominal(session);
    let start = solved.unknowns(&nominal).upside_down();
    let other =
        Holds::at_start(session, &solved.readings, &start)?.solve(session, &solved.readings, &start, workbench)?;
    let [here, there] = [&solved, &other].map(|solution| solution.unknowns(&nominal).gravity);
    let opposite = here.iter().zip(there).map(|(a, b)| a * b).sum::<f64>() < 0.0;
    let gain = solved.estimate.cost - other.estimate.cost;
    if opposite && gain > DECISIVE {
        return solve_from(session, &solved.readings, other.unknowns(&nominal), workbench);
    }
    Ok(Solved { sign_known: !opposite || gain < -DECISIVE, ..solved })
}
