//! Masses, moments and placements in the combinations that the data determine (base parameters).
//!
//! Any masses and moments that reproduce these combinations predict the same gravity torques.

use gravcal_estimation::{BlockId, Covariance, Problem, Spectrum, Values, sparse_basis};

use crate::joint::Layout;
use crate::result::MomentResult;

/// The combinations with value and standard deviation.
pub(crate) fn determined_moments(
    problem: &Problem,
    values: &Values,
    layout: &Layout,
    spectrum: &Spectrum,
    covariance: &Covariance,
) -> Vec<MomentResult> {
    let blocks: Vec<BlockId> = layout.inertia.iter().copied().chain(layout.loads.iter().flatten().copied()).collect();
    // These blocks are Euclidean: a column is a stored coordinate.
    let coordinates: Vec<(usize, BlockId, usize)> = blocks
        .iter()
        .flat_map(|id| problem.columns_of(*id).enumerate().map(|(component, column)| (column, *id, component)))
        .collect();
    let columns: Vec<usize> = coordinates.iter().map(|(column, _, _)| *column).collect();
    sparse_basis(&spectrum.determined_within(&columns), 1e-7)
        .iter()
        .map(|coefficients| {
            let used = || coordinates.iter().zip(coefficients).filter(|(_, c)| **c != 0.0);
            let by_column: Vec<(usize, f64)> = used().map(|((column, _, _), c)| (*column, *c)).collect();
            MomentResult {
                terms: used().map(|((_, id, i), c)| (problem.block(*id).component_name(*i), *c)).collect(),
                value: used().map(|((_, id, i), c)| c * values.get(*id)[*i]).sum(),
                std: covariance.std_of(&by_column),
            }
        })
        .collect()
}
