//! What exact rank says at the truth: which unknowns the readings determine, and how well at best.
//!
//! With the Jacobian `J` of the readings in units of their noise, its columns scaled to unit length by `D` (one of rounding errors alone to zero), and `J D⁻¹ = U S Vᵀ`:
//!
//! ```text
//!     share_i = ‖V_i,null‖                                 part of unknown i in directions with s < 1e-8 s₁, which change no reading
//!     bound_i = √(Σ_rank (V_ik / s_k)²) / D_i              Cramér-Rao bound of its standard deviation
//!     bound within reach: the same of J with a row 1/w_j for each unknown j, with w_j what it may be at most
//! ```
//!
//! The bound takes the readings to be linear in unknowns without end. Where an unknown would have to go beyond all reason for another to be
//! off by its bound, as an angle of many turns, the bound is none: readings are not linear that far. Within reach (van Trees' inequality with
//! a wide prior) an angle is known to about half a turn, a gain to its own size, a body to [`BODY`]. Rank is such, too: axes that are parallel but for the digits with
//! which a URDF writes π down let a gain of a hundred thousand pass for a tilt.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use faer::Mat;

use super::model::{State, jacobian, state};
use super::truth::Truth;

/// A singular value below this share of the largest is none.
const RANK: f64 = 1e-8;
/// A column shorter than this share of the longest is none: rounding.
const COLUMN: f64 = 1e-12;
/// An unknown with a larger share is not determined.
const SHARE: f64 = 1e-3;

/// Of a mass, kg, a first moment, kg·m, and a load's position, m: far more than those of any arm here.
const BODY: f64 = 30.0;

/// What the readings say of one unknown at best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Information {
    /// Of it that lies where no reading sees it, 0 to 1.
    pub share: f64,
    /// Of its standard deviation.
    pub bound: f64,
    /// The same where no unknown goes beyond reason.
    pub bound_within_reach: f64,
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
    let jacobian = jacobian(truth, &State { names: names.clone(), values: values.clone() });
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
    let reach: Vec<f64> = kept.iter().map(|index| reach(&names[*index], values[*index])).collect();
    let within_reach = within_reach(&scaled, &sizes, &reach)?;
    let rank = (0..kept.len()).filter(|k| s[*k] > RANK * s[0]).count();
    let of = |(index, column): (usize, &usize)| {
        let squares = |range: std::ops::Range<usize>, weight: &dyn Fn(usize) -> f64| -> f64 {
            range.map(|k| (v[(index, k)] * weight(k)).powi(2)).sum::<f64>().sqrt()
        };
        let share = squares(rank..kept.len(), &|_| 1.0);
        let bound = squares(0..rank, &|k| 1.0 / s[k]) / sizes[index];
        (names[*column].clone(), Information { share, bound, bound_within_reach: within_reach[index] })
    };
    Ok(kept.iter().enumerate().map(of).collect())
}

/// What an unknown of this true value may be at most, in its unit.
fn reach(name: &str, value: f64) -> f64 {
    match name.rsplit_once('.').map_or(name, |(_, what)| what) {
        what if what.starts_with("torque_bias") || what.starts_with("bias") => f64::INFINITY,
        what if what.contains("gain") => value.abs(),
        what if what.starts_with("position_offset") => PI,
        // Tangents of directions.
        what if what.parse::<u8>().is_ok() || what.starts_with("direction") => 1.0,
        _ => BODY,
    }
}

/// The bounds of all columns with knowledge of what each is at most; zero of a column of nothing of which nothing is known.
fn within_reach(scaled: &Mat<f64>, sizes: &[f64], reach: &[f64]) -> Result<Vec<f64>, String> {
    // A column of zeros counts in its own unit.
    let sizes: Vec<f64> = sizes.iter().map(|size| if size.is_finite() { *size } else { 1.0 }).collect();
    let rows = scaled.nrows();
    let with_reach = Mat::from_fn(rows + reach.len(), reach.len(), |row, column| match row.checked_sub(rows) {
        None => scaled[(row, column)],
        Some(known) => f64::from(known == column) / (reach[column] * sizes[column]),
    });
    let svd = with_reach.thin_svd().map_err(|error| format!("no singular values within reach: {error:?}"))?;
    let (s, v) = (svd.S().column_vector(), svd.V());
    let variance =
        |index: usize| (0..reach.len()).filter(|k| s[*k] > 0.0).map(|k| (v[(index, k)] / s[k]).powi(2)).sum::<f64>();
    Ok((0..reach.len()).map(|index| variance(index).sqrt() / sizes[index]).collect())
}

/// Lengths of columns; infinite where a column is none.
fn sizes(jacobian: &Mat<f64>, columns: &[usize]) -> Vec<f64> {
    let length = |column: &usize| (0..jacobian.nrows()).map(|row| jacobian[(row, *column)].powi(2)).sum::<f64>().sqrt();
    let lengths: Vec<f64> = columns.iter().map(length).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    lengths.into_iter().map(|length| if length < COLUMN * longest { f64::INFINITY } else { length }).collect()
}
