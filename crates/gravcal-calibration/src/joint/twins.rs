//! Solutions that look alike, of which a start may have found the wrong one.
//!
//! - **Upside down.** Gravity the other way up, with masses, moments and placements negative, gives the same torques, unless a
//!   load of known mass hangs on known lengths. Where no hemisphere is declared both are solved for, the one that explains the
//!   readings better is taken, and the sign counts as known only if that is decisive. What unknowns rest on decides nothing, but gains
//!   keep their sign ([`with_gains_known`]). Where a hemisphere is declared the end must lie in it.
//! - **Mirrored placements.** The vector between two placements of a known distance shows in its length and in what the
//!   joints carry of it; along the axis of the joint that carries it the latter may be little, and its sign a matter of
//!   where the start lay.
//! - **Another displacement.** Only its length is known of the vector between two placements. Each joint carries a part of it, times a gain that
//!   may be any: where few joints move, two directions explain the readings, with gains that are many times apart between joints
//!   ([`gains_disagree`]). Which of such is right nothing tells: both are kept ([`otherwise_displaced`]).
//! - **Axes the other way round**: see `signs.rs`.

use gravcal_identification::{DECISIVE, Workbench, median};
use gravcal_robot_model::parameter::{Limit, ParameterId, Quantity};
use gravcal_robot_model::session::{Knowledge, KnowledgeKind, Session};
use nalgebra::Vector3;

use super::error::EstimateError;
use super::posing::pose_with_constraints;
use super::sample::Sample;
use super::signs::axes_as_declared;
use super::solve::{solve_from, solve_posed};
use super::solved::Solved;
use super::unknowns::Unknowns;

/// Standard deviation of a gain where gravity is told from its opposite, as a share of it.
const GAIN_KNOWN: f64 = 0.3;
/// Iterations at most in which the rest follows gravity on the border of its hemisphere.
const AT_BORDER: usize = 300;
/// Torque gains, each by its nominal value, that are so many times apart are no scatter of sensors.
const DISAGREES: f64 = 3.0;
/// A twin is followed where it lowers the cost by more than this share: less is where the same solution was found again.
const LOWER: f64 = 1e-6;

/// The solution, or a twin that explains the readings better; and whether gravity's sign is decided.
///
/// # Errors
/// As [`super::solve`].
pub(super) fn settled(
    session: &Session,
    solved: Solved,
    sample: &Sample,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    let solved = right_way_up(session, solved, sample, workbench)?;
    let solved = unmirrored(session, solved, sample, workbench)?;
    let solved = axes_as_declared(session, solved, workbench)?;
    // Each of these solved again, and may have ended anywhere.
    in_hemisphere(session, solved, workbench)
}

fn right_way_up(
    session: &Session,
    solved: Solved,
    sample: &Sample,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    if session.gravity.hemisphere.is_some() {
        return in_hemisphere(session, solved, workbench);
    }
    workbench.tell("gravity the other way up");
    let nominal = Unknowns::nominal(session);
    let found = solved.unknowns(&nominal);
    let start = found.upside_down(session);
    let known = with_gains_known(session);
    let sample = Sample::new(&known, &sample.readings)?;
    let [here, there] = [&found, &start].map(|start| sample.rough_minimum(&known, start, workbench));
    if there.reached && there.cost > here.cost + DECISIVE {
        return Ok(solved);
    }
    let posed = pose_with_constraints(session, &solved.readings, &start)?.with_loss(solved.posed.loss)?;
    let other = solve_posed(solved.readings.clone(), posed, workbench)?;
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

/// The session with gains known but for a share of them: gravity the other way up is explained by sensors that are all reversed, too, and
/// the sign of a sensor is as declared.
pub(crate) fn with_gains_known(session: &Session) -> Session {
    let mut known = session.clone();
    for id in session.parameters() {
        let parameter = session.parameter(id);
        if let (Limit::ShareOfNominal(_), Knowledge { nominal, kind: KnowledgeKind::Start }) =
            (parameter.limit, parameter.knowledge)
        {
            known.knowledge_mut(id).kind = KnowledgeKind::Prior { std: GAIN_KNOWN * nominal.abs() };
        }
    }
    known
}

/// The solution, or, where it lies in the other hemisphere than the declared one, an image of it that does not: gravity, masses, moments and
/// placements negative; or gravity negative and a joint across it half a turn on, which is as good where those before it carry nothing.
/// Without such an image the readings contradict the declaration, or say hardly anything of gravity. Whoever solves anew asks this last.
///
/// # Errors
/// As [`super::solve`].
pub(super) fn in_hemisphere(
    session: &Session,
    solved: Solved,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    let Some(pole) = session.gravity.hemisphere else { return Ok(solved) };
    let nominal = Unknowns::nominal(session);
    let found = solved.unknowns(&nominal);
    let lies_within = |values: &Unknowns| Vector3::from(values.gravity).dot(&Vector3::from(pole)) >= 0.0;
    let known = solved.hemisphere_contradicted || !solved.estimate.termination.converged();
    if known || lies_within(&found) {
        return Ok(solved);
    }
    workbench.tell("gravity in the declared hemisphere");
    let free = |joint: &usize| session.held_reason(*joint, Quantity::PositionOffset).is_none();
    let turned = (0..session.joints.len()).find(free).map(|joint| half_a_turn_on(session, &found, joint));
    let mut best: Option<Solved> = None;
    for image in std::iter::once(found.upside_down(session)).chain(turned) {
        let Ok(other) = solve_from(session, &solved.readings, image, workbench) else { continue };
        let lower = best.as_ref().is_none_or(|best| other.estimate.cost < best.estimate.cost);
        if other.estimate.termination.converged() && lies_within(&other.unknowns(&nominal)) && lower {
            best = Some(other);
        }
    }
    match best.filter(|best| best.estimate.cost < solved.estimate.cost + DECISIVE) {
        Some(within) => Ok(within),
        None if explained_at_border(&solved, pole, workbench)? => Ok(Solved { sign_known: false, ..solved }),
        None => Ok(Solved { hemisphere_contradicted: true, ..solved }),
    }
}

/// Whether the readings are hardly explained worse with gravity on the border of its hemisphere: then they say too little of it to contradict
/// anything.
fn explained_at_border(solved: &Solved, pole: [f64; 3], workbench: &Workbench<'_>) -> Result<bool, EstimateError> {
    let (problem, gravity) = (&solved.posed.problem, solved.posed.layout.gravity);
    let found = Vector3::from_column_slice(solved.estimate.values.get(gravity));
    let pole = Vector3::from(pole).normalize();
    let Some(border) = (found - pole * pole.dot(&found)).try_normalize(f64::MIN_POSITIVE) else { return Ok(false) };
    let mut start = solved.estimate.values.clone();
    start.set(gravity, (border * found.norm()).as_slice());
    let held = problem.holding(&[gravity], "on the border of its hemisphere");
    // What cannot be solved there explains nothing.
    let Ok(there) = workbench.within(AT_BORDER).solve(&held, &start) else { return Ok(false) };
    Ok(held.without_reference().cost(&there.values)? < solved.estimate.cost + DECISIVE)
}

/// Gravity negative, and the offset of a joint half a turn towards its nominal value.
fn half_a_turn_on(session: &Session, found: &Unknowns, joint: usize) -> Unknowns {
    let id = ParameterId::Sensor(joint, Quantity::PositionOffset);
    let mut image = Unknowns { gravity: found.gravity.map(|component| -component), ..found.clone() };
    let towards = (session.nominal(id) - found.value(id)).signum();
    *image.value_mut(id) += towards * std::f64::consts::PI;
    image
}

/// Whether some torque gain is many times farther from its nominal value than most are, as where the vector between two placements of a known
/// distance came out in another direction.
pub(super) fn gains_disagree(session: &Session, solved: &Solved) -> bool {
    if session.pair_of_free_placements().is_none() {
        return false;
    }
    let found = solved.unknowns(&Unknowns::nominal(session));
    let gains = (0..session.joints.len()).map(|joint| ParameterId::Sensor(joint, Quantity::TorqueGain));
    let free = gains.filter(|id| session.knowledge(*id).kind == KnowledgeKind::Start && session.held(*id).is_none());
    let mut ratios: Vec<f64> = free.map(|id| (found.value(id) / session.nominal(id)).abs()).collect();
    let Some(middle) = median(&mut ratios) else { return false };
    ratios.iter().any(|ratio| ratio * DISAGREES < middle || *ratio > DISAGREES * middle)
}

/// The same with the vector between two placements of a known distance reversed along some of the link's axes.
pub(super) fn otherwise_displaced(session: &Session, values: &Unknowns) -> Vec<Unknowns> {
    let Some(known) = session.pair_of_free_placements() else { return Vec::new() };
    let [p, q] = known.between.map(|load| Vector3::from(values.loads[load]));
    let (middle, half) = ((p + q) / 2.0, (q - p) / 2.0);
    let displaced = |signs: usize| {
        let reversed = Vector3::from_fn(|axis, _| if signs >> axis & 1 == 1 { -half[axis] } else { half[axis] });
        let mut other = values.clone();
        let [a, b] = known.between;
        (other.loads[a], other.loads[b]) = ((middle - reversed).into(), (middle + reversed).into());
        other
    };
    (1..8).map(displaced).collect()
}

fn unmirrored(
    session: &Session,
    solved: Solved,
    sample: &Sample,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    let found = solved.unknowns(&Unknowns::nominal(session));
    let Some(along) = along_axis(session, &found) else { return Ok(solved) };
    let mirrored = mirrored_placements(&found, along);
    let is_back = |end: &Unknowns| along_axis(session, end).is_some_and(|end| end.vector.dot(&along.vector) > 0.0);
    // Where the readings tell the sign well, one step leads back; else it is the first of some.
    let step = sample.one_step(session, &mirrored).map(|step| step.end);
    if step.as_ref().is_some_and(is_back) {
        return Ok(solved);
    }
    let there = sample.nearby(session, step.as_ref().unwrap_or(&mirrored), 0.0, workbench);
    if is_back(&there.end) || there.cost > sample.nearby(session, &found, 0.0, workbench).cost + DECISIVE {
        return Ok(solved);
    }
    workbench.tell("placements the other way round");
    let other = solve_from(session, &solved.readings, mirrored, workbench)?;
    let lower = other.estimate.cost < solved.estimate.cost * (1.0 - LOWER);
    Ok(if lower { Solved { sign_known: solved.sign_known, ..other } } else { solved })
}

/// Of the vector between two placements, the part along the axis of the joint that carries them.
#[derive(Clone, Copy)]
struct AlongAxis {
    loads: [usize; 2],
    vector: Vector3<f64>,
}

/// That of the placements of a known distance. Nothing where there is no such pair, or no joint.
fn along_axis(session: &Session, values: &Unknowns) -> Option<AlongAxis> {
    if session.joints.is_empty() {
        return None;
    }
    let loads = session.pair_of_free_placements()?.between;
    let joint = &session.robot.chain.movers()[session.loads[loads[0]].link];
    let axis = Vector3::from(joint.after.inverse().rotate_vector(joint.axis));
    let [p, q] = loads.map(|load| Vector3::from(values.loads[load]));
    Some(AlongAxis { loads, vector: axis * axis.dot(&(q - p)) })
}

/// The vector between two placements reversed along the axis.
fn mirrored_placements(values: &Unknowns, along: AlongAxis) -> Unknowns {
    let [a, b] = along.loads;
    let mut mirrored = values.clone();
    mirrored.loads[a] = (Vector3::from(values.loads[a]) + along.vector).into();
    mirrored.loads[b] = (Vector3::from(values.loads[b]) - along.vector).into();
    mirrored
}

#[cfg(test)]
mod tests {
    use gravcal_session::simulation::Disturbance;

    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::{sarcos_shoulder, with_workbench};

    use super::super::solve::solve;

    /// An upright arm with the joint across gravity half a turn on, and gravity negative, reads the same.
    #[test]
    fn an_end_in_the_other_hemisphere_is_led_back() {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [0.0, 0.0, -9.8];
        simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let nominal = Unknowns::nominal(&session);
        let free = |joint: &usize| session.held_reason(*joint, Quantity::PositionOffset).is_none();
        let first_free = (0..session.joints.len()).find(free).unwrap();
        let (above, back) = with_workbench(|w| {
            let found = solve(&session, &readings, None, w)?.unknowns(&nominal);
            let above = solve_from(&session, &readings, half_a_turn_on(&session, &found, first_free), w)?;
            let (height, cost) = (above.unknowns(&nominal).gravity[2], above.estimate.cost);
            assert!(height > 9.0, "{height}");
            Ok::<_, EstimateError>((cost, in_hemisphere(&session, above, w)?))
        })
        .unwrap();
        assert!(back.unknowns(&nominal).gravity[2] < -9.0 && !back.hemisphere_contradicted);
        assert!((back.estimate.cost - above).abs() < DECISIVE);
    }

    /// Whether readings with noise of so many counts are explained as well with gravity on a border 30° away from it.
    fn explained_on_a_border(noise: f64) -> bool {
        let mut simulation = sarcos_shoulder();
        simulation.disturbance = Disturbance::noise(vec![noise; 3]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_workbench(|w| solve(&session, &readings, None, w)).unwrap();
        let gravity = Vector3::from(solved.unknowns(&Unknowns::nominal(&session)).gravity).normalize();
        let across = gravity.cross(&Vector3::x()).normalize();
        let pole = 3f64.sqrt() / 2.0 * across - 0.5 * gravity;
        with_workbench(|w| explained_at_border(&solved, pole.into(), w)).unwrap()
    }

    #[test]
    fn readings_contradict_a_hemisphere_only_where_they_say_something_of_gravity() {
        assert!(!explained_on_a_border(0.8));
        // The noise is many times what gravity does.
        assert!(explained_on_a_border(1e3) && explained_on_a_border(3e3));
    }
}
