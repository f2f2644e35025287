//! Derivatives of a term, held against differences of its values.

use thiserror::Error;

use super::term::{Moment, Partials, SensorTerm};
use crate::central_difference::contradicting_difference;

/// By how much the derivatives of models in use may differ, of the largest one: less than a mistake makes.
pub(crate) const TOLERANCE: f64 = 1e-3;

/// A derivative that differences of values contradict.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("the derivative by {by} is {reported}, but differences of values say {found}")]
pub struct WrongDerivative {
    /// By what.
    pub by: String,
    /// What the term says.
    pub reported: f64,
    /// What differences say.
    pub found: f64,
}

/// Holds the derivatives of a term against central differences: for the test of one that has them by hand. They may differ by `tolerance`
/// of the largest derivative.
///
/// # Errors
/// The first derivative that differs; also one by a torque or coordinate that the term says it does not read.
pub fn check_term_derivatives(
    term: &dyn SensorTerm,
    at: &Moment<'_>,
    x: &[f64],
    tolerance: f64,
) -> Result<(), WrongDerivative> {
    let joints = at.joints();
    let [mut by_parameter, mut by_torque, mut by_coordinate] = [x.len(), joints, joints].map(|count| vec![0.0; count]);
    let partials =
        Partials { by_parameter: &mut by_parameter, by_torque: &mut by_torque, by_coordinate: &mut by_coordinate };
    term.value(at, x, Some(partials));
    let all = by_parameter.iter().chain(&by_torque).chain(&by_coordinate);
    let tolerance = tolerance * all.fold(0.0, |largest: f64, derivative| largest.max(derivative.abs()));
    let (torques, coordinates) = at.unknowns();
    compare(("parameter", tolerance), &by_parameter, x, |x| term.value(at, x, None))?;
    compare(("torque", tolerance), &by_torque, torques, |torques| term.value(&at.with_torque(torques), x, None))?;
    let by_coordinates = |coordinates: &[f64]| term.value(&at.with_coordinate(coordinates), x, None);
    compare(("coordinate", tolerance), &by_coordinate, coordinates, by_coordinates)
}

fn compare(
    (what, tolerance): (&str, f64),
    reported: &[f64],
    values: &[f64],
    value: impl Fn(&[f64]) -> f64,
) -> Result<(), WrongDerivative> {
    for (place, reported) in reported.iter().enumerate() {
        if let Some(found) = contradicting_difference((*reported, tolerance), (values, place), &value) {
            return Err(WrongDerivative { by: format!("{what} {place}"), reported: *reported, found });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use gravcal_recording::Conditions;

    use super::*;
    use crate::sensors::Reads;

    /// `x τ₀ θ₁`, with a derivative by torque that is so many times too large.
    #[derive(Debug)]
    struct Product(f64);

    impl SensorTerm for Product {
        fn reads(&self) -> Reads {
            Reads::positions().torque(0).coordinate(1)
        }

        fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
            let (torque, coordinate) = (at.torque(0), at.coordinate(1));
            if let Some(partials) = partials {
                partials.by_parameter[0] = torque * coordinate;
                partials.by_torque[0] = self.0 * x[0] * coordinate;
                partials.by_coordinate[1] = x[0] * torque;
            }
            x[0] * torque * coordinate
        }
    }

    #[test]
    fn a_wrong_derivative_is_named() {
        let conditions = Conditions::default();
        let at = Moment::new(&[3.0, 4.0], &[0.5, 0.25], &[0.0; 2], &conditions);
        check_term_derivatives(&Product(1.0), &at, &[2.0], 1e-8).unwrap();
        let wrong = check_term_derivatives(&Product(1.1), &at, &[2.0], 1e-8).unwrap_err();
        assert!(wrong.to_string().starts_with("the derivative by torque 0 is 0.55"), "{wrong}");
        assert!(check_term_derivatives(&Product(f64::NAN), &at, &[2.0], 1e-8).is_err());
    }
}
