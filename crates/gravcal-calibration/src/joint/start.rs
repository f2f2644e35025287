//! Where the joint problem starts.
//!
//! For given gravity, gains and offsets every torque reading is linear in the biases, the links' masses and moments
//! and the placements of the loads. So a candidate is a direction of gravity (with the nominal sensor values, or
//! those that the sequential estimator found), and its worth is the cost after that linear problem is solved. A few of the
//! best are followed a little further, and the one that comes lowest wins.

use gravcal_estimation::BlockId;

use super::problem::{PosingError, pose, pose_readings_alone};
use super::readings::Readings;
use super::unknowns::Unknowns;
use crate::parameter::Quantity;
use crate::session::{JointKnowledge, KnowledgeKind, LoadDistance, Session};
use crate::workbench::Workbench;

/// Directions tried in a hemisphere, besides the declared one.
const DIRECTIONS: usize = 48;
/// One direction of so many suffices to compare signs.
const FEW: usize = 6;
/// Poses that suffice to compare candidates.
const POSES: usize = 120;
/// Damping that leaves combinations without information where they are, and nothing else: column-relative.
const FAINT_DAMPING: f64 = 1e-14;
/// Candidates that are solved for briefly, the least angle between their directions, rad, and the iterations for each.
const CONTENDERS: usize = 4;
const APART: f64 = 0.3;
const BRIEF: usize = 30;
/// Nominal torque gains are taken for wrong where they are off by more than this factor, and by lengths only where that
/// lowers the cost by so much.
const FAR_SCALE: f64 = 1.5;
const WORTHWHILE: f64 = 10.0;
/// Angle by which the declared direction is left, rad: exactly along an axis, the moments that the axis would carry
/// have no effect, and nothing could be said of them.
const OFF_AXIS: f64 = 0.02;

/// The best of `known` (if any) and the nominal values under directions spread over the declared hemisphere, or over the
/// sphere where none is declared.
///
/// The candidates that are left the lowest cost, and differ in direction, are solved for briefly with a part of the poses:
/// the best of them then is where the estimate starts.
pub(super) fn best_start(
    session: &Session,
    readings: &Readings,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<Unknowns, PosingError> {
    let sample = thinned(readings);
    let nominal = Unknowns::nominal(session);
    let directed =
        |direction: [f64; 3]| Unknowns { gravity: direction.map(|c| session.gravity.magnitude * c), ..nominal.clone() };
    let candidates = known.cloned().into_iter().chain(directions(session.gravity.hemisphere).map(directed));
    let mut solved: Vec<(f64, Unknowns)> =
        candidates.map(|values| solve_linear_part_to_scale(session, &sample, &values)).collect::<Result<_, _>>()?;
    solved.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut best: Option<(f64, Unknowns)> = None;
    for mut start in contenders(solved) {
        respect_distances(session, &mut start);
        let cost = cost_nearby(session, &sample, &start, workbench)?;
        if best.as_ref().is_none_or(|(lowest, _)| cost < *lowest) {
            best = Some((cost, start));
        }
    }
    Ok(best.map_or(nominal, |(_, start)| start))
}

/// Of candidates in the order of their cost the first few that are apart from those before.
fn contenders(sorted: Vec<(f64, Unknowns)>) -> Vec<Unknowns> {
    let mut contenders: Vec<Unknowns> = Vec::new();
    for (_, candidate) in sorted {
        if contenders.len() < CONTENDERS
            && contenders.iter().all(|other| angle(&other.gravity, &candidate.gravity) > APART)
        {
            contenders.push(candidate);
        }
    }
    contenders
}

fn angle(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    nalgebra::Vector3::from(*a).angle(&nalgebra::Vector3::from(*b))
}

/// The cost, with a part of the poses, to which a few iterations lead; infinite where the solver takes no such problem.
///
/// # Errors
/// Where no problem can be posed.
pub(super) fn cost_nearby(
    session: &Session,
    sample: &Readings,
    start: &Unknowns,
    workbench: &Workbench<'_>,
) -> Result<f64, PosingError> {
    let posed = pose(session, sample, start)?;
    Ok(workbench.solve_briefly(&posed.problem, &posed.initial, BRIEF).map_or(f64::INFINITY, |estimate| estimate.cost))
}

/// The linear problem solved, with torque gains of the size that the loads tell where the nominal ones are far from it.
fn solve_linear_part_to_scale(
    session: &Session,
    sample: &Readings,
    values: &Unknowns,
) -> Result<(f64, Unknowns), PosingError> {
    let (cost, solved) = solve_linear_part(session, sample, values)?;
    match gain_scale(session, sample, cost, &solved)? {
        scale if (1.0 / FAR_SCALE..FAR_SCALE).contains(&scale) => Ok((cost, solved)),
        scale => solve_linear_part(session, sample, &with_gains_times(scale, values)),
    }
}

/// By what all torque gains are to be multiplied, where none is known beforehand. `one`: the cost left without that.
///
/// With the gains times κ, and masses, moments and placements divided by κ, only what the loads' known masses do on known
/// lengths changes, linearly in κ. So the cost that the linear problem leaves is a parabola in κ, and three points give its
/// minimum. Where it is flat (no lengths), the known distance of two placements is the measure: the linear problem, which
/// does not know it, puts them κ times as far apart.
fn gain_scale(session: &Session, sample: &Readings, one: f64, start: &Unknowns) -> Result<f64, PosingError> {
    let free = |joint: &JointKnowledge| joint.of(Quantity::TorqueGain).kind == KnowledgeKind::Start;
    if session.loads.is_empty() || !session.joints.iter().all(free) {
        return Ok(1.0);
    }
    let solved = |scale: f64| solve_linear_part(session, sample, &with_gains_times(scale, start));
    let [(half, _), (two, _)] = [solved(0.5)?, solved(2.0)?];
    let slopes = [2.0 * (one - half), two - one];
    let curvature = (slopes[1] - slopes[0]) / 1.5;
    let scale = 1.5 / 2.0 - slopes[0] / (2.0 * curvature);
    let drop = curvature * (scale - 1.0).powi(2);
    if scale > 0.0 && drop > WORTHWHILE {
        return Ok(scale);
    }
    let apart = |known: &LoadDistance| {
        let [p, q] = known.between.map(|load| nalgebra::Vector3::from(start.loads[load]));
        (q - p).norm() / known.distance
    };
    let told = session.load_distances.iter().find(|known| known.between.iter().all(|load| is_free(session, *load)));
    Ok(told.map(apart).filter(|scale| *scale > 0.0).unwrap_or(1.0))
}

fn with_gains_times(scale: f64, values: &Unknowns) -> Unknowns {
    let mut scaled = values.clone();
    scaled.sensors.iter_mut().for_each(|sensor| sensor[Quantity::TorqueGain as usize] *= scale);
    scaled
}

fn is_free(session: &Session, load: usize) -> bool {
    session.loads[load].position.is_none()
}

/// What the best of the nominal values under some directions of gravity costs, for comparing sessions that differ in signs.
pub(super) fn start_cost(session: &Session, readings: &Readings) -> Result<f64, PosingError> {
    let sample = thinned(readings);
    let mut lowest = f64::INFINITY;
    for direction in directions(session.gravity.hemisphere).step_by(FEW) {
        let gravity = direction.map(|c| session.gravity.magnitude * c);
        let candidate = Unknowns { gravity, ..Unknowns::nominal(session) };
        lowest = lowest.min(solve_linear_part(session, &sample, &candidate)?.0);
    }
    Ok(lowest)
}

/// Masses, moments and placements that suit given gravity and sensors, which stay as they are.
pub(crate) fn start_around(session: &Session, readings: &Readings, known: &Unknowns) -> Result<Unknowns, PosingError> {
    let (_, solved) = solve_linear_part(session, &thinned(readings), known)?;
    let mut start =
        Unknowns { gravity: known.gravity, sensors: known.sensors.clone(), further: known.further.clone(), ..solved };
    respect_distances(session, &mut start);
    Ok(start)
}

/// Puts placements of a known distance that far apart: the linear problem does not know of distances, and a solver
/// that starts off a nearly exact distance must creep along its sphere.
fn respect_distances(session: &Session, start: &mut Unknowns) {
    for known in &session.load_distances {
        let [a, b] = known.between;
        let [p, q] = known.between.map(|load| nalgebra::Vector3::from(start.loads[load]));
        let Some(direction) = (q - p).try_normalize(f64::MIN_POSITIVE) else { continue };
        let excess = known.distance - (q - p).norm();
        let free = known.between.map(|load| is_free(session, load));
        let shares = match free {
            [true, true] => [0.5, 0.5],
            [true, false] => [1.0, 0.0],
            [false, _] => [0.0, 1.0],
        };
        start.loads[a] = (p - shares[0] * excess * direction).into();
        start.loads[b] = (q + shares[1] * excess * direction).into();
    }
}

/// Biases, masses, moments and placements by linear least squares, everything else as it stands; and the cost left.
fn solve_linear_part(
    session: &Session,
    readings: &Readings,
    candidate: &Unknowns,
) -> Result<(f64, Unknowns), PosingError> {
    let posed = pose_readings_alone(session, readings, candidate)?;
    let nonlinear: Vec<BlockId> = posed.problem.block_ids().filter(|id| !posed.problem.block(*id).linear).collect();
    let linear = posed.problem.holding(&nonlinear, "given by the candidate");
    let Ok(mut linearization) = linear.linearize(&posed.initial) else {
        return Ok((f64::INFINITY, candidate.clone()));
    };
    let scaling = linearization.column_scales();
    let mut step = vec![0.0; scaling.len()];
    let gain = linearization.damped_step(FAINT_DAMPING, &scaling, &mut step).predicted_reduction;
    let solved = linear.retract(&posed.initial, &step);
    Ok((linearization.cost() - gain, Unknowns::of(&solved, &posed.layout, candidate)))
}

/// Every so many poses of the readings, so that about [`POSES`] are left.
pub(super) fn thinned(readings: &Readings) -> Readings {
    let stride = readings.used.iter().filter(|used| !used.is_empty()).count().div_ceil(POSES).max(1);
    let mut thinned = readings.clone();
    thinned.used.iter_mut().enumerate().filter(|(i, _)| i % stride != 0).for_each(|(_, used)| used.clear());
    thinned
}

/// A direction [`OFF_AXIS`] away from the given one, towards no special side.
fn off_axis(direction: [f64; 3]) -> [f64; 3] {
    let direction = nalgebra::Vector3::from(direction);
    let side = direction.cross(&nalgebra::Vector3::new(0.36, 0.48, 0.8)).normalize();
    (OFF_AXIS.cos() * direction + OFF_AXIS.sin() * side).into()
}

/// The declared direction, and directions spread over the half of the sphere about it; over all of it where none is
/// declared.
fn directions(declared: Option<[f64; 3]>) -> impl Iterator<Item = [f64; 3]> {
    let in_hemisphere = move |direction: &[f64; 3]| {
        declared.is_none_or(|pole| direction.iter().zip(pole).map(|(a, b)| a * b).sum::<f64>() > 0.0)
    };
    declared.map(off_axis).into_iter().chain(lattice().filter(in_hemisphere))
}

/// Directions spread evenly (Fibonacci lattice) over the sphere.
fn lattice() -> impl Iterator<Item = [f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..2 * DIRECTIONS).map(move |k| {
        let z = 1.0 - (k as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    })
}
