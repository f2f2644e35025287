//! By how much an estimate is off where readings have errors of a known shape.
//!
//! Errors `e` of the readings, in their standard deviations, move the estimate by `(JᵀJ)⁻¹ Jᵀ e` along what the data determine: to first
//! order, and with whatever unknowns of single samples there are following. A term of the model that is missing, and of which the residuals
//! tell the size ([`super::ResidualMaker`]), is such an error. **Assumptions.** No loss together with eliminated blocks.

use super::projected::{Projected, back};
use super::{Solution, StatisticsError};
use crate::Loss;

/// By how much each column of the problem is off, of each of some errors (one entry a row of the problem, in standard deviations); columns of
/// eliminated blocks are left at zero.
///
/// # Errors
/// Where a residual cannot be evaluated, or the problem has eliminated blocks together with losses.
pub fn moved_by(solution: &Solution<'_>, errors: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, StatisticsError> {
    if errors.is_empty() {
        return Ok(Vec::new());
    }
    let Solution { problem, values, analysis } = *solution;
    if problem.factors().iter().any(|factor| factor.loss != Loss::None) {
        solution.without_eliminated()?;
    }
    // With `T` the determined directions, along which `J T` is orthonormal, `(JᵀJ)⁻¹ = T Tᵀ`.
    let directions = analysis.determined_directions();
    let errors: Vec<&[f64]> = errors.iter().map(Vec::as_slice).collect();
    let moved = |product: Vec<f64>| {
        let product: Vec<(usize, f64)> = product.into_iter().enumerate().collect();
        let mut moved = back(&directions, &Projected::of_function(&directions, &product));
        moved.resize(problem.columns().len(), 0.0);
        moved
    };
    Ok(analysis.on_shared(&problem.transposed_products(values, &errors)?).into_iter().map(moved).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{fit, line};

    /// A line through readings to which something is added: it is off by the line through what was added.
    #[test]
    fn it_is_the_difference_of_two_fits() {
        let added = [0.0, 0.3, -0.2, 0.5, 0.9, 0.1];
        let y = [0.1, 1.3, 1.8, 3.4, 3.9, 5.6];
        let with: Vec<f64> = y.iter().zip(added).map(|(y, added)| y + added).collect();
        let [solved, other] = [&y[..], &with].map(|y| fit(line(y)));
        let moved = moved_by(&solved.solution(), &[vec![0.0; 6], added.to_vec()]).unwrap();
        assert!(moved[0].iter().all(|moved| *moved == 0.0));
        let ids: Vec<_> = solved.problem.block_ids().collect();
        let difference: Vec<f64> = ids
            .iter()
            .flat_map(|id| {
                other.values.get(*id).iter().zip(solved.values.get(*id)).map(|(a, b)| a - b).collect::<Vec<_>>()
            })
            .collect();
        for (moved, difference) in moved[1].iter().zip(&difference) {
            assert!((moved - difference).abs() < 1e-6, "{moved} {difference}");
        }
    }
}
