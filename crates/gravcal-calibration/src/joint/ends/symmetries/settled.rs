//! The symmetries of an arm, in the order in which they are tried.

use gravcal_identification::{SolveEnvironment, Symmetry, settle};
use gravcal_robot_model::session::Session;

use super::axes::TurnedAxes;
use super::hemisphere::InHemisphere;
use super::mirrored::MirroredPlacements;
use super::upside_down::UpsideDown;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::starting::sample::Sample;

/// The solution, or an image that explains the readings better or is as declared; and whether gravity's sign is decided. `sample`: a part of the
/// readings, with the noise of the solution.
///
/// # Errors
/// As [`solve_from`](crate::joint::solving::solve_from::solve_from).
pub(in crate::joint) fn settled(
    session: &Session,
    solved: Solved,
    sample: &Sample,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let upside_down = UpsideDown { session, sample };
    let in_hemisphere = InHemisphere { session };
    let mirrored = MirroredPlacements { session, sample };
    let axes = TurnedAxes { session };
    // Each of them solves again, and may end anywhere: the declared hemisphere has the last word.
    let settled = settle(solved, &[&upside_down, &in_hemisphere, &mirrored, &axes, &in_hemisphere], environment)?;
    let open = settled.undecided.contains(&upside_down.name());
    Ok(Solved { sign_known: settled.solution.sign_known && !open, ..settled.solution })
}
