//! Where the joint problem starts.
//!
//! For given gravity, gains and offsets every torque reading is linear in the biases, the links' masses and moments
//! and the placements of the loads. So a candidate is a direction of gravity (with the nominal sensor values, or
//! those that the sequential estimator found), its worth is the cost after that linear problem is solved, and the
//! best candidate wins.

use gravcal_estimation::BlockId;

use super::problem::{PosingError, Readings, pose_readings_alone};
use super::unknowns::Unknowns;
use crate::session::Session;

/// Directions tried in a hemisphere, besides the declared one.
const DIRECTIONS: usize = 48;
/// Poses that suffice to compare candidates.
const POSES: usize = 120;
/// Damping that leaves combinations without information where they are, and nothing else: column-relative.
const FAINT_DAMPING: f64 = 1e-14;
/// Angle by which the declared direction is left, rad: exactly along an axis, the moments that the axis would carry
/// have no effect, and nothing could be said of them.
const OFF_AXIS: f64 = 0.02;

/// The best of `known` (if any) and the nominal values under directions spread over the declared hemisphere, or over the
/// sphere where none is declared.
pub(super) fn best_start(
    session: &Session,
    readings: &Readings,
    known: Option<&Unknowns>,
) -> Result<Unknowns, PosingError> {
    let sample = thinned(readings);
    let nominal = Unknowns::nominal(session);
    let directed =
        |direction: [f64; 3]| Unknowns { gravity: direction.map(|c| session.gravity.magnitude * c), ..nominal.clone() };
    let candidates = known.cloned().into_iter().chain(directions(session.gravity.hemisphere).map(directed));
    let mut best: Option<(f64, Unknowns)> = None;
    for candidate in candidates {
        let (cost, solved) = solve_linear_part(session, &sample, &candidate)?;
        if best.as_ref().is_none_or(|(lowest, _)| cost < *lowest) {
            best = Some((cost, solved));
        }
    }
    let mut start = best.map_or(nominal, |(_, start)| start);
    respect_distances(session, &mut start);
    Ok(start)
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
        let free = known.between.map(|load| session.loads[load].position.is_none());
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
fn thinned(readings: &Readings) -> Readings {
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
