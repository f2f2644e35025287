//! Differences of values that derivatives are held against.

/// Relative step: near the cube root of the rounding error.
const STEP: f64 = 6e-6;

/// The central difference of `value` by the entry of `values` at this place.
pub(crate) fn central_difference(values: &[f64], place: usize, value: impl Fn(&[f64]) -> f64) -> f64 {
    let step = STEP * values[place].abs().max(1.0);
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
        let slope = central_difference(&[0.5, 200.0], 1, |x| x[0] * x[1].powi(3));
        assert!((slope / (1.5 * 200.0_f64.powi(2)) - 1.0).abs() < 1e-9, "{slope}");
    }
}
