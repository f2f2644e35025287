//! Directions over the sphere, among which gravity's is sought.

use std::f64::consts::PI;

use nalgebra::Vector3;

/// Directions tried in a hemisphere, besides the declared one.
const DIRECTIONS: usize = 48;
/// Angle by which the declared direction is left, rad: exactly along an axis, the moments that the axis would carry
/// have no effect, and nothing could be said of them.
const OFF_AXIS: f64 = 0.02;

/// The declared direction, and directions spread over the half of the sphere about it; over all of it where none is
/// declared.
pub(in crate::joint) fn directions(declared: Option<[f64; 3]>) -> impl Iterator<Item = [f64; 3]> {
    let in_hemisphere = move |direction: &[f64; 3]| {
        declared.is_none_or(|pole| direction.iter().zip(pole).map(|(a, b)| a * b).sum::<f64>() > 0.0)
    };
    declared.map(off_axis).into_iter().chain(lattice(2 * DIRECTIONS).filter(in_hemisphere))
}

/// So many directions spread evenly (Fibonacci lattice) over the sphere.
pub(in crate::joint) fn lattice(count: usize) -> impl Iterator<Item = [f64; 3]> {
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cos, across * sin, z]
    })
}

/// A direction turned four ways.
pub(in crate::joint) fn turned(direction: [f64; 3], angle: f64) -> [[f64; 3]; 4] {
    let direction = Vector3::from(direction);
    let first = direction.cross(&Vector3::ith(direction.iamin(), 1.0)).normalize();
    let second = direction.cross(&first);
    [first, -first, second, -second].map(|side| (angle.cos() * direction + angle.sin() * side).into())
}

/// A direction [`OFF_AXIS`] away from the given one, towards no special side.
fn off_axis(direction: [f64; 3]) -> [f64; 3] {
    let direction = Vector3::from(direction);
    let side = direction.cross(&Vector3::new(0.36, 0.48, 0.8)).normalize();
    (OFF_AXIS.cos() * direction + OFF_AXIS.sin() * side).into()
}
