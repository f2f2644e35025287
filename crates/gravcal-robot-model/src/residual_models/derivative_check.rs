//! Derivatives of a residual, held against differences of its values.

use super::scene::{Scene, only_seen};
use super::term::{ResidualTerm, Slopes, Tie};
use crate::central_difference::contradicting_difference;
use crate::sensors::WrongDerivative;

/// Holds the derivatives of a row against central differences: for the test of a term that has them by hand. They may differ by `tolerance`
/// of the largest derivative.
///
/// # Errors
/// The first derivative that differs; also one by a coordinate or by gravity that the term says it does not see.
pub fn check_residual_derivatives(
    term: &dyn ResidualTerm,
    (tie, at): (&Tie, &[Scene<'_>]),
    x: &[f64],
    tolerance: f64,
) -> Result<(), WrongDerivative> {
    let sees = term.sees();
    let gravity = at.first().filter(|_| sees.gravity).map_or([f64::NAN; 3], |scene| scene.plain().1);
    let joints = at.first().map_or(0, |scene| scene.plain().0.len());
    let mut coordinates: Vec<f64> = at.iter().flat_map(|scene| scene.plain().0).copied().collect();
    coordinates.chunks_mut(joints.max(1)).for_each(|of_pose| only_seen(&sees, of_pose));
    let given: Vec<f64> = x.iter().chain(&gravity).chain(&coordinates).copied().collect();
    let value = |all: &[f64], slopes: Option<Slopes<'_>>| {
        let (x, rest) = all.split_at(x.len());
        let (gravity, coordinates) = rest.split_at(3);
        let gravity = [gravity[0], gravity[1], gravity[2]];
        let coordinates = coordinates.chunks(joints.max(1));
        let scenes: Vec<Scene<'_>> =
            at.iter().zip(coordinates).map(|(scene, coordinates)| scene.moved(coordinates, gravity)).collect();
        term.value(tie, &scenes, x, slopes)
    };
    let (mut by_parameter, mut by_gravity) = (vec![0.0; x.len()], [0.0; 3]);
    let mut by_coordinate = vec![0.0; coordinates.len()];
    let slopes =
        Slopes { by_parameter: &mut by_parameter, by_gravity: &mut by_gravity, by_coordinate: &mut by_coordinate };
    value(&given, Some(slopes));
    let reported: Vec<f64> = by_parameter.iter().chain(&by_gravity).chain(&by_coordinate).copied().collect();
    let tolerance = tolerance * reported.iter().fold(0.0, |largest: f64, slope| largest.max(slope.abs()));
    for (place, reported) in reported.iter().enumerate() {
        // What is not seen has no number, and no slope.
        let found = match given[place].is_nan() {
            true => (*reported != 0.0).then_some(0.0),
            false => contradicting_difference((*reported, tolerance), (&given, place), |all| value(all, None)),
        };
        if let Some(found) = found {
            let by = match place.checked_sub(x.len()) {
                None => format!("parameter {place}"),
                Some(axis @ 0..3) => format!("component {axis} of gravity"),
                Some(rest) => {
                    format!("the coordinate of joint {} in pose {}", (rest - 3) % joints, (rest - 3) / joints)
                }
            };
            return Err(WrongDerivative { by, reported: *reported, found });
        }
    }
    Ok(())
}
