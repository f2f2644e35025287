//! Compares a manifold's basis with differences of its steps.

use thiserror::Error;

use super::Manifold;

/// Step of the differences, by that which changes the value by its own size.
const DIFFERENCE: f64 = 1e-3;
/// The same of the step that must stay on the manifold.
const FAR: f64 = 0.5;

/// What a manifold says that its own steps contradict.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ManifoldMismatch {
    /// A value that does not lie on it: the one that was given, or one that a step leads to.
    #[error("{value:?} {reason}")]
    Off {
        /// The value.
        value: Vec<f64>,
        /// What is wrong with it.
        reason: String,
    },
    /// A step of length zero that moves.
    #[error("a step of length zero moves {from:?} to {to:?}")]
    Moved {
        /// Where it was.
        from: Vec<f64>,
        /// Where it is.
        to: Vec<f64>,
    },
    /// An entry of the basis that is not the slope.
    #[error("∂x[{stored}]/∂step[{tangent}] is {stated:e}, differences give {numeric:e}")]
    Entry {
        /// Stored number.
        stored: usize,
        /// Tangent coordinate.
        tangent: usize,
        /// What the manifold says.
        stated: f64,
        /// What extrapolated central differences say.
        numeric: f64,
    },
}

/// Checks at `x` that a step of length zero moves nothing, that steps stay on the manifold, and that the basis is their slope.
///
/// The reference is Richardson's extrapolation of central differences at two steps (error of fourth order). An entry passes when it agrees
/// within `tolerance` times the largest entry of the basis, or 1 where that is smaller.
///
/// # Errors
/// The first thing that is wrong.
pub fn check_manifold(manifold: &dyn Manifold, x: &[f64], tolerance: f64) -> Result<(), ManifoldMismatch> {
    let on_it =
        |value: &[f64]| manifold.check(value).map_err(|reason| ManifoldMismatch::Off { value: value.to_vec(), reason });
    on_it(x)?;
    let tangent = manifold.tangent_dimension(x.len());
    let moved = |index: usize, by: f64| {
        let (mut at, mut step) = (x.to_vec(), vec![0.0; tangent]);
        step[index] = by;
        manifold.retract(&mut at, &step);
        at
    };
    let mut basis = vec![0.0; x.len() * tangent];
    manifold.basis(x, &mut basis);
    let largest = |of: &[f64]| of.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let (size, slope) = (largest(x), largest(&basis));
    let whole = if size > 0.0 { size } else { 1.0 } / if slope > 0.0 { slope } else { 1.0 };
    let (step, allowed) = (DIFFERENCE * whole, tolerance * slope.max(1.0));
    for index in 0..tangent {
        let still = moved(index, 0.0);
        if still.iter().zip(x).any(|(a, b)| (a - b).abs() > tolerance * size) {
            return Err(ManifoldMismatch::Moved { from: x.to_vec(), to: still });
        }
        on_it(&moved(index, FAR * whole))?;
        let [wide, narrow] = [step, 0.5 * step].map(|h| {
            let (up, down) = (moved(index, h), moved(index, -h));
            up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * h)).collect::<Vec<f64>>()
        });
        for (stored, (wide, narrow)) in wide.iter().zip(narrow).enumerate() {
            let (stated, numeric) = (basis[stored * tangent + index], (4.0 * narrow - wide) / 3.0);
            let apart = (stated - numeric).abs();
            // What is no number agrees with nothing.
            if apart.is_nan() || apart > allowed {
                return Err(ManifoldMismatch::Entry { stored, tangent: index, stated, numeric });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sphere;

    /// A positive number; each variant has one fault.
    #[derive(Debug)]
    enum Positive {
        Sound,
        WrongSlope,
        Drifting,
        Leaving,
    }

    impl Manifold for Positive {
        fn name(&self) -> &str {
            "positive number"
        }

        fn tangent_dimension(&self, _stored: usize) -> usize {
            1
        }

        fn retract(&self, x: &mut [f64], step: &[f64]) {
            match self {
                Positive::Drifting => x[0] *= step[0].exp() + 0.1,
                Positive::Leaving => x[0] *= 1.0 - 10.0 * step[0],
                _ => x[0] *= step[0].exp(),
            }
        }

        fn basis(&self, x: &[f64], basis: &mut [f64]) {
            basis[0] = if matches!(self, Positive::WrongSlope) { 1.0 } else { x[0] };
        }

        fn check(&self, x: &[f64]) -> Result<(), String> {
            if x[0] > 0.0 { Ok(()) } else { Err("is not positive".into()) }
        }
    }

    #[test]
    fn faults_are_found() {
        let fault = |of: Positive| check_manifold(&of, &[2.0], 1e-9).map_err(|mismatch| mismatch.to_string());
        assert_eq!(fault(Positive::Sound), Ok(()));
        assert!(fault(Positive::WrongSlope).unwrap_err().starts_with("∂x[0]/∂step[0] is 1e0, differences give "));
        assert!(fault(Positive::Drifting).unwrap_err().starts_with("a step of length zero moves [2.0] to [2.2]"));
        assert!(fault(Positive::Leaving).unwrap_err().ends_with("is not positive"));
        let off = check_manifold(&Sphere { radius: 2.0 }, &[1.0, 0.0, 0.0], 1e-9).unwrap_err();
        assert_eq!(off.to_string(), "[1.0, 0.0, 0.0] does not have the length of its sphere");
    }
}
