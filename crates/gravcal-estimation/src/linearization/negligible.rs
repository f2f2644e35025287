//! Columns that are zero but for rounding errors.

use crate::{Column, Problem, Values};

/// Columns smaller than this share of the largest are rounding errors: see [`negligible`]. Units differ by far less (1e6 between a count
/// and a metre), rounding by more (1e-16).
const NEGLIGIBLE: f64 = 1e-12;

/// Columns that are zero but for rounding errors, so that nothing walks along them or takes them for information: the gain
/// of a joint whose axis is vertical to the last digit.
///
/// A column is negligible if it is small beside the largest both as it stands and times the size of its block: next to a factor
/// of 1e-20 any other parameter's column looks negligible, though both do the same to the residuals. A block at zero has no
/// size that could tell, and is held only against columns of its own unit, where it states one.
pub(super) fn negligible(problem: &Problem, values: &Values, norms: &[f64]) -> Vec<usize> {
    let length = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let sizes: Vec<f64> = problem.columns().iter().map(|column| length(values.get(column.block))).collect();
    let limit = |norms: &mut dyn Iterator<Item = f64>| NEGLIGIBLE * norms.fold(0.0, f64::max);
    let plain = limit(&mut norms.iter().copied());
    let sized = limit(&mut norms.iter().zip(&sizes).map(|(norm, size)| norm * size));
    let unit = |column: usize| {
        let Column { block, index } = problem.columns()[column];
        problem.block(block).units[index].as_str()
    };
    let of_its_unit = |column: usize| {
        let alike = |other: &usize| !unit(column).is_empty() && unit(*other) == unit(column);
        limit(&mut (0..norms.len()).filter(alike).map(|other| norms[other]))
    };
    let is_negligible = |column: &usize| {
        let (norm, size) = (norms[*column], sizes[*column]);
        norm <= plain && if size > 0.0 { norm * size <= sized } else { norm <= of_its_unit(*column) }
    };
    (0..norms.len()).filter(is_negligible).collect()
}
