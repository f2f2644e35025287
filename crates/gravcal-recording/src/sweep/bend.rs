//! How readings bend over the joint's position, which the straight line of a bin does not follow.
//!
//! With `u` the way from the centre `x₀` of a bin, a reading is `y + y′ u + ½ y″ u²`. Of points whose mean place is `x̄` and whose mean
//! squared distance from it is `v`, the line of least squares says at the centre
//!
//! ```text
//!     y + ½ y″ (v − (x₀ − x̄)²)
//! ```
//!
//! but for the third moment of the points' places. Gravity's torque is a sinusoid of the joint's angle, `y″ = −τ`, and `v` a twelfth of the
//! square of a bin's width: of bins of 2°, a 20,000th of the torque, which is more than the noise of the means of a slow sweep. `y″` is that of
//! the parabola of least squares through a bin and its neighbours, whose noise hardly counts: of seven bins, a hundredth of that of one.

use nalgebra::{DMatrix, DVector};

/// Neighbours to either side, in bins.
const NEIGHBOURS: i64 = 3;
/// Fewest bins that tell a bend from their noise.
const LEAST: usize = 4;

/// Second derivatives of values over the numbers of their bins, which are in order, in units of a bin; zero where there are too few neighbours.
pub(super) fn bends(values: &[(i64, f64)]) -> Vec<f64> {
    values.iter().map(|(index, _)| bend(values, *index)).collect()
}

fn bend(values: &[(i64, f64)], index: i64) -> f64 {
    let near: Vec<(f64, f64)> = values
        .iter()
        .filter(|(other, _)| (other - index).abs() <= NEIGHBOURS)
        .map(|(other, value)| ((other - index) as f64, *value))
        .collect();
    if near.len() < LEAST {
        return 0.0;
    }
    let powers = DMatrix::from_fn(near.len(), 3, |row, power| near[row].0.powi(power as i32));
    let right = DVector::from_iterator(near.len(), near.iter().map(|(_, value)| *value));
    let parabola = (powers.transpose() * &powers).cholesky().map(|factor| factor.solve(&(powers.transpose() * right)));
    parabola.map_or(0.0, |parabola| 2.0 * parabola[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_bends_alike_everywhere_and_a_line_nowhere() {
        let values: Vec<(i64, f64)> =
            (-5..6).filter(|k| *k != 0).map(|k| (k, 3.0 - k as f64 + (k * k) as f64)).collect();
        assert!(bends(&values).iter().all(|bend| (bend - 2.0).abs() < 1e-9), "{:?}", bends(&values));
        let line: Vec<(i64, f64)> = (0..9).map(|k| (k, 1e6 + 0.3 * k as f64)).collect();
        assert!(bends(&line).iter().all(|bend| bend.abs() < 1e-8), "{:?}", bends(&line));
    }

    #[test]
    fn few_neighbours_tell_no_bend() {
        let apart = [(0, 1.0), (1, 5.0), (2, 1.0), (90, 5.0), (91, 1.0)];
        assert_eq!(bends(&apart), [0.0; 5]);
    }
}
