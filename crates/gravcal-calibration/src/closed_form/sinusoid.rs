//! One sweep: for a fixed position gain `s`, `y = a sin(s q) + c cos(s q) + e` is linear in `(a, c, e)`.
//! A search over `s` alone (variable projection) gives the rest.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

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

/// The position gain between a third and three times `nominal` at which the sweeps' sinusoids fit best, to some 1e-6 of it: where
/// a fit of all unknowns may start.
///
/// Gains of the other sign are never tried: that is the symmetric solution `(−s, π − φ)`.
pub(crate) fn search_position_gain(sweeps: &[Vec<(f64, f64)>], nominal: f64) -> Option<f64> {
    let (least, step) = (nominal / 3.0, (3.0 - 1.0 / 3.0) * nominal / STEPS as f64);
    let misfits = |from: f64, step: f64, count: usize| -> Vec<f64> {
        let mut sums = vec![0.0; count];
        sweeps.iter().for_each(|sweep| add_sums_of_squares(sweep, (from, step), &mut sums));
        sums
    };
    let coarse = misfits(least, step, STEPS + 1);
    let (best, lowest) = coarse.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let around = least + best.clamp(1, STEPS - 1) as f64 * step;
    let mut found = around + step * lowest_of_parabola(&coarse[best.clamp(1, STEPS - 1) - 1..]);
    for fine in [step / 10.0, step / 100.0] {
        found += fine * lowest_of_parabola(&misfits(found - fine, fine, 3));
    }
    lowest.is_finite().then_some(found)
}

/// Gains that are tried, evenly spaced: with equal steps of the gain no lobe of the misfit is narrower for one than for another.
const STEPS: usize = 120;

/// Where the parabola through three equally spaced values is lowest, in steps from the middle one; within a step of it.
fn lowest_of_parabola(values: &[f64]) -> f64 {
    let (slope, curvature) = (values[2] - values[0], values[0] - 2.0 * values[1] + values[2]);
    let place = -0.5 * slope / curvature;
    if curvature > 0.0 && place.is_finite() { place.clamp(-1.0, 1.0) } else { 0.0 }
}

/// Adds what [`fit_sinusoid`] leaves of a sweep, without a known bias, at the gains `from + k step`. Infinite where the readings do
/// not determine the fit.
///
/// ```text
///     Σ (y − ȳ)² − bᵀ A⁻¹ b,     A, b: of sin(s q) and cos(s q) about their means
/// ```
///
/// From one gain to the next the sinusoids follow by a rotation. The normal equations lose half of the digits, of which a search
/// needs few.
fn add_sums_of_squares(readings: &[(f64, f64)], (from, step): (f64, f64), sums: &mut [f64]) {
    let count = readings.len() as f64;
    let mean = readings.iter().map(|(_, y)| y).sum::<f64>() / count;
    let total: f64 = readings.iter().map(|(_, y)| (y - mean).powi(2)).sum();
    let mut waves: Vec<Wave> = readings.iter().map(|(q, y)| Wave::new(*q, y - mean, from, step)).collect();
    for sum in sums {
        let [mut s, mut c, mut ss, mut sc, mut sy, mut cy] = [0.0; 6];
        for wave in &mut waves {
            let (sin, cos) = wave.next();
            (s, c) = (s + sin, c + cos);
            (ss, sc) = (ss + sin * sin, sc + sin * cos);
            (sy, cy) = (sy + sin * wave.y, cy + cos * wave.y);
        }
        let (ss, sc, cc) = (ss - s * s / count, sc - s * c / count, count - ss - c * c / count);
        let determinant = ss * cc - sc * sc;
        let determined = ss + cc > DETERMINED * count && determinant > DETERMINED * (ss + cc).powi(2);
        let explained = (cc * sy * sy - 2.0 * sc * sy * cy + ss * cy * cy) / determinant;
        *sum += if readings.len() >= 4 && determined { total - explained } else { f64::INFINITY };
    }
}

/// Below this share of what they would be on a whole turn, sums of squares are rounding.
const DETERMINED: f64 = 1e-12;

/// Sine and cosine of one reading's angle, for one gain after the other.
struct Wave {
    y: f64,
    sin: f64,
    cos: f64,
    turn: (f64, f64),
}

impl Wave {
    fn new(q: f64, y: f64, from: f64, step: f64) -> Wave {
        let (sin, cos) = (from * q).sin_cos();
        Wave { y, sin, cos, turn: (step * q).sin_cos() }
    }

    /// Those at this gain; on to the next.
    fn next(&mut self) -> (f64, f64) {
        let (here, (sin, cos)) = ((self.sin, self.cos), self.turn);
        (self.sin, self.cos) = (here.0 * cos + here.1 * sin, here.1 * cos - here.0 * sin);
        here
    }
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
        let mut left = [0.0; 3];
        add_sums_of_squares(&sweep, (s - 0.01, 0.01), &mut left);
        assert!(left[1].abs() < 1e-8 && left[0] > 0.1 && left[2] > 0.1, "{left:?}");
        let about_bias = fit_sinusoid(&sweep, s, Some(e)).unwrap();
        assert!((about_bias.coefficients - fit.coefficients).amax() < 1e-9);
    }

    #[test]
    fn readings_at_one_place_determine_nothing() {
        let sweep = vec![(0.3, 1.0), (0.3, 1.1), (0.3, 0.9), (0.3, 1.0)];
        assert!(fit_sinusoid(&sweep, 1.0, None).is_none());
        assert!(search_position_gain(&[sweep], 1.0).is_none());
    }
}
