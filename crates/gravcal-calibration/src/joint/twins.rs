//! Solutions that look alike, of which a start may have found the wrong one.
//!
//! - **Upside down.** Gravity the other way up, with masses, moments and placements negative, gives the same torques, unless a
//!   load of known mass hangs on known lengths. Where no hemisphere is declared both are solved for, the one that explains the
//!   readings better is taken, and the sign counts as known only if that is decisive.
//! - **Mirrored placements.** The vector between two placements of a known distance shows in its length and in what the
//!   joints carry of it; along the axis of the joint that carries it the latter may be little, and its sign a matter of
//!   where the start lay.

use super::hold::Holds;
use super::solve::{Solved, solve_from};
use super::start::{cost_nearby, thinned};
use super::{EstimateError, Unknowns};
use crate::session::Session;
use crate::workbench::Workbench;

/// Cost by which one of both must exceed the other to be ruled out: its likelihood is then less by e¹⁰.
pub(crate) const DECISIVE: f64 = 10.0;
/// A twin is followed where it lowers the cost by more than this share: less is where the same solution was found again.
const LOWER: f64 = 1e-6;

/// The solution, or a twin that explains the readings better; and whether gravity's sign is decided.
///
/// # Errors
/// As [`super::solve`].
pub(super) fn settled(session: &Session, solved: Solved, workbench: &Workbench<'_>) -> Result<Solved, EstimateError> {
    let solved = right_way_up(session, solved, workbench)?;
    unmirrored(session, solved, workbench)
}

fn right_way_up(session: &Session, solved: Solved, workbench: &Workbench<'_>) -> Result<Solved, EstimateError> {
    if session.gravity.hemisphere.is_some() {
        return Ok(solved);
    }
    workbench.tell("gravity the other way up");
    let nominal = Unknowns::nominal(session);
    let found = solved.unknowns(&nominal);
    let start = found.upside_down(session);
    let [here, there] = nearby(session, &solved, [&found, &start], workbench)?;
    if there > here + DECISIVE {
        return Ok(solved);
    }
    let other =
        Holds::at_start(session, &solved.readings, &start)?.solve(session, &solved.readings, &start, workbench)?;
    let [here, there] = [&solved, &other].map(|solution| solution.unknowns(&nominal).gravity);
    let opposite = here.iter().zip(there).map(|(a, b)| a * b).sum::<f64>() < 0.0;
    let gain = solved.estimate.cost - other.estimate.cost;
    let sign_known = !opposite || gain.abs() > DECISIVE;
    let lower = if opposite && gain > LOWER * solved.estimate.cost {
        solve_from(session, &solved.readings, other.unknowns(&nominal), workbench)?
    } else {
        solved
    };
    Ok(Solved { sign_known, ..lower })
}

fn unmirrored(session: &Session, solved: Solved, workbench: &Workbench<'_>) -> Result<Solved, EstimateError> {
    let found = solved.unknowns(&Unknowns::nominal(session));
    let Some(mirrored) = mirrored_placements(session, &found) else { return Ok(solved) };
    let [here, there] = nearby(session, &solved, [&found, &mirrored], workbench)?;
    if there >= here * (1.0 - LOWER) {
        return Ok(solved);
    }
    workbench.tell("placements the other way round");
    let other = solve_from(session, &solved.readings, mirrored, workbench)?;
    let lower = other.estimate.cost < solved.estimate.cost * (1.0 - LOWER);
    Ok(if lower { Solved { sign_known: solved.sign_known, ..other } } else { solved })
}

/// Costs to which a few iterations lead from two starts, with a part of the poses.
fn nearby(
    session: &Session,
    solved: &Solved,
    starts: [&Unknowns; 2],
    workbench: &Workbench<'_>,
) -> Result<[f64; 2], EstimateError> {
    let sample = thinned(&solved.readings);
    let [here, there] = starts.map(|start| cost_nearby(session, &sample, start, workbench));
    Ok([here?, there?])
}

/// The vector between two placements of a known distance reversed along the axis of the joint that carries them. Nothing where
/// there is no such pair.
fn mirrored_placements(session: &Session, values: &Unknowns) -> Option<Unknowns> {
    let [a, b] = session.pair_of_free_placements()?.between;
    let joint = &session.robot.chain.movers()[session.loads[a].link];
    let axis = nalgebra::Vector3::from(joint.after.inverse().rotate_vector(joint.axis));
    let [p, q] = [a, b].map(|load| nalgebra::Vector3::from(values.loads[load]));
    let along = axis * axis.dot(&(q - p));
    let mut mirrored = values.clone();
    mirrored.loads[a] = (p + along).into();
    mirrored.loads[b] = (q - along).into();
    Some(mirrored)
}
