//! One sweep: for a fixed position gain `s`, `y = a sin(s q) + c cos(s q) + e` is linear in `(a, c, e)`.
//! A search over `s` alone (variable projection) gives the rest.

use nalgebra::{DMatrix, DVector, Dyn, Matrix3, OMatrix, U4, Vector3};

/// `(a, c, e)` of one sweep at a fixed position gain.
#[derive(Clone, Debug)]
pub(crate) struct LinearSinusoid {
    /// `(a, c, e)` in the unit of the torque reading.
    pub coefficients: Vector3<f64>,
    /// Covariance of the coefficients for readings of unit variance.
    pub unit_covariance: Matrix3<f64>,
}

/// Fits `(a, c, e)` to `(q, y)` pairs, `e` held at `bias` where that is known. `None` where the pairs do not
/// determine them.
pub(crate) fn fit_sinusoid(readings: &[(f64, f64)], position_gain: f64, bias: Option<f64>) -> Option<LinearSinusoid> {
    let unknowns = if bias.is_some() { 2 } else { 3 };
    if readings.len() < unknowns {
        return None;
    }
    let design = DMatrix::from_fn(readings.len(), unknowns, |row, column| {
        let angle = position_gain * readings[row].0;
        [angle.sin(), angle.cos(), 1.0][column]
    });
    let measured = DVector::from_iterator(readings.len(), readings.iter().map(|r| r.1 - bias.unwrap_or(0.0)));
    let factored = design.qr();
    let triangle = factored.r();
    let diagonal = triangle.diagonal().abs();
    if diagonal.min() <= 1e-12 * diagonal.max() {
        return None;
    }
    let inverse = triangle.try_inverse()?;
    let found = &inverse * factored.q().tr_mul(&measured);
    let covariance = &inverse * inverse.transpose();
    let at = |i: usize, j: usize| if i.max(j) < unknowns { covariance[(i, j)] } else { 0.0 };
    Some(LinearSinusoid {
        coefficients: Vector3::new(found[0], found[1], bias.unwrap_or_else(|| found[2])),
        unit_covariance: Matrix3::from_fn(at),
    })
}

/// The position gain between a third and three times `nominal` at which the sweeps' sinusoids fit best.
///
/// Gains of the other sign are never tried: that is the twin `(−s, π − φ)`.
pub(crate) fn search_position_gain(sweeps: &[Vec<(f64, f64)>], nominal: f64) -> Option<f64> {
    const STEPS: i32 = 60;
    let misfit = |gain: f64| -> f64 { sweeps.iter().map(|sweep| sum_of_squares(sweep, gain)).sum() };
    let candidate = |step: i32| nominal * 3f64.powf(f64::from(step) / f64::from(STEPS));
    let tried = (-STEPS..=STEPS).map(|step| (step, misfit(candidate(step))));
    let (best, _) = tried.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let found = golden_section(misfit, candidate(best - 1), candidate(best + 1));
    misfit(found).is_finite().then_some(found)
}

/// What [`fit_sinusoid`] leaves of a sweep, without a known bias: the last pivot of `[sin, cos, 1, y]`. Infinite where the
/// readings do not determine the fit.
fn sum_of_squares(readings: &[(f64, f64)], position_gain: f64) -> f64 {
    if readings.len() < 4 {
        return f64::INFINITY;
    }
    let columns = OMatrix::<f64, Dyn, U4>::from_fn(readings.len(), |row, column| match column {
        0 => (position_gain * readings[row].0).sin(),
        1 => (position_gain * readings[row].0).cos(),
        2 => 1.0,
        _ => readings[row].1,
    });
    let triangle = columns.qr().r();
    let pivots = [0, 1, 2].map(|place| triangle[(place, place)].abs());
    let [least, most] = [f64::min, f64::max].map(|of| pivots.into_iter().fold(pivots[0], of));
    if least <= 1e-12 * most { f64::INFINITY } else { triangle[(3, 3)].powi(2) }
}

/// Minimum of a function that falls and rises once between two points, to about 1e-8 of their distance.
fn golden_section(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (from, to);
    let at = |x: f64| (x, f(x));
    let (mut left, mut right) = (at(high - ratio * (high - low)), at(low + ratio * (high - low)));
    for _ in 0..40 {
        if left.1 <= right.1 {
            (high, right) = (right.0, left);
            left = at(high - ratio * (high - low));
        } else {
            (low, left) = (left.0, right);
            right = at(low + ratio * (high - low));
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_sweep_gives_its_own_gain_and_coefficients() {
        let (s, a, c, e) = (0.988, 30.0, -12.0, 2075.0);
        let sweep: Vec<(f64, f64)> = (0..37)
            .map(|k| {
                let q = (f64::from(k) * 5.0 - 90.0).to_radians();
                (q, a * (s * q).sin() + c * (s * q).cos() + e)
            })
            .collect();
        let found = search_position_gain(std::slice::from_ref(&sweep), 1.1).unwrap();
        assert!((found - s).abs() < 1e-6, "{found}");
        let fit = fit_sinusoid(&sweep, s, None).unwrap();
        assert!((fit.coefficients - Vector3::new(a, c, e)).amax() < 1e-9);
        assert!(sum_of_squares(&sweep, s) < 1e-15);
        let about_bias = fit_sinusoid(&sweep, s, Some(e)).unwrap();
        assert!((about_bias.coefficients - fit.coefficients).amax() < 1e-9);
    }

    #[test]
    fn readings_at_one_place_determine_nothing() {
        assert!(fit_sinusoid(&[(0.3, 1.0), (0.3, 1.1), (0.3, 0.9), (0.3, 1.0)], 1.0, None).is_none());
    }
}
