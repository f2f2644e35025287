//! Differences of values that derivatives are held against.

/// Relative step: near the cube root of the rounding error.
const STEP: f64 = 6e-6;

/// A finer step, by whose difference it is seen whether differences tell a slope at all.
const FINER: f64 = STEP / 16.0;

/// What differences say of a derivative by the entry of `values` at this place, where that is not what is reported, to within `tolerance`. Differences
/// that hang on their step, as at a kink or by rounding, contradict nothing.
pub(crate) fn contradicting_difference(
    (reported, tolerance): (f64, f64),
    (values, place): (&[f64], usize),
    value: impl Fn(&[f64]) -> f64,
) -> Option<f64> {
    let found = central_difference(STEP, (values, place), &value);
    let apart = (reported - found).abs();
    let rounding = 4.0 * f64::EPSILON * value(values).abs() / (STEP * values[place].abs().max(1.0));
    // Nor does what is not a number agree.
    let agrees = apart <= tolerance.max(rounding);
    let hangs_on_step = || {
        let finer = central_difference(FINER, (values, place), &value);
        (finer - found).abs() > tolerance.max(0.25 * apart.min(found.abs().max(finer.abs())))
    };
    (!agrees && !hangs_on_step()).then_some(found)
}

fn central_difference(step: f64, (values, place): (&[f64], usize), value: impl Fn(&[f64]) -> f64) -> f64 {
    let step = step * values[place].abs().max(1.0);
    let at = |step: f64| {
        let mut moved = values.to_vec();
        moved[place] += step;
        value(&moved)
    };
    (at(step) - at(-step)) / (2.0 * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_has_its_slope() {
        let slope = central_difference(STEP, (&[0.5, 200.0], 1), |x| x[0] * x[1].powi(3));
        assert!((slope / (1.5 * 200.0_f64.powi(2)) - 1.0).abs() < 1e-9, "{slope}");
    }

    #[test]
    fn only_a_slope_contradicts() {
        let of = |reported: f64, at: f64, value: fn(&[f64]) -> f64| {
            contradicting_difference((reported, 1e-6), (&[at], 0), value)
        };
        assert!(of(1.0, 0.5, |x| x[0] * x[0]).is_none() && of(2.0, 0.5, |x| x[0] * x[0]).is_some());
        // A kink a little aside, a slope over so short a way that steps go beyond it, and one that rounding hides.
        assert!(of(1.0, 2e-6, |x| x[0].abs()).is_none());
        assert!(of(1e8, 0.0, |x| (1e8 * x[0]).tanh()).is_none());
        assert!(of(1.0, 0.0, |x| x[0] + 1e12).is_none());
        assert!(of(f64::NAN, 0.0, |x| x[0]).is_some());
    }
}
