//! What exact rank says at the truth: which unknowns the readings determine, and how well at best.
//!
//! With the Jacobian `J` of the readings in units of their noise, its columns scaled to unit length by `D` (one of rounding errors alone to zero), and `J D⁻¹ = U S Vᵀ`:
//!
//! ```text
//!     share_i = ‖V_i,null‖                                 part of unknown i in directions with s < 1e-8 s₁, which change no reading
//!     bound_i = √(Σ_rank (V_ik / s_k)²) / D_i              Cramér-Rao bound of its standard deviation
//! ```

use std::collections::BTreeMap;

use faer::Mat;

use super::model::{State, jacobian, state};
use super::truth::Truth;

/// A singular value below this share of the largest is none.
const RANK: f64 = 1e-8;
/// A column shorter than this share of the longest is none: rounding.
const COLUMN: f64 = 1e-12;
/// An unknown with a larger share is not determined.
const SHARE: f64 = 1e-3;

/// What the readings say of one unknown at best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Information {
    /// Of it that lies where no reading sees it, 0 to 1.
    pub share: f64,
    /// Of its standard deviation.
    pub bound: f64,
}

impl Information {
    /// Whether exact rank leaves it its value.
    pub fn determined(&self) -> bool {
        self.share <= SHARE
    }
}

/// What the readings say of every unknown by name.
///
/// # Errors
/// Where the decomposition fails.
pub fn information(truth: &Truth) -> Result<BTreeMap<String, Information>, String> {
    let State { names, values } = state(truth);
    let jacobian = jacobian(truth, &State { names: names.clone(), values });
    let kept: Vec<usize> = (0..names.len()).filter(|index| !truth.knows(&names[*index])).collect();
    let sizes = sizes(&jacobian, &kept);
    // At least as many rows as columns, so that the right singular vectors are a whole basis.
    let rows = jacobian.nrows().max(kept.len());
    let scaled = Mat::from_fn(rows, kept.len(), |row, column| match row < jacobian.nrows() {
        true => jacobian[(row, kept[column])] / sizes[column],
        false => 0.0,
    });
    let svd = scaled.thin_svd().map_err(|error| format!("no singular values: {error:?}"))?;
    let (s, v) = (svd.S().column_vector(), svd.V());
    let rank = (0..kept.len()).filter(|k| s[*k] > RANK * s[0]).count();
    let of = |(index, column): (usize, &usize)| {
        let squares = |range: std::ops::Range<usize>, weight: &dyn Fn(usize) -> f64| -> f64 {
            range.map(|k| (v[(index, k)] * weight(k)).powi(2)).sum::<f64>().sqrt()
        };
        let share = squares(rank..kept.len(), &|_| 1.0);
        let bound = squares(0..rank, &|k| 1.0 / s[k]) / sizes[index];
        (names[*column].clone(), Information { share, bound })
    };
    Ok(kept.iter().enumerate().map(of).collect())
}

/// Lengths of columns; infinite where a column is none.
fn sizes(jacobian: &Mat<f64>, columns: &[usize]) -> Vec<f64> {
    let length = |column: &usize| (0..jacobian.nrows()).map(|row| jacobian[(row, *column)].powi(2)).sum::<f64>().sqrt();
    let lengths: Vec<f64> = columns.iter().map(length).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    lengths.into_iter().map(|length| if length < COLUMN * longest { f64::INFINITY } else { length }).collect()
}
