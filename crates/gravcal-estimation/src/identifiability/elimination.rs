//! What the data say of some columns where all others are unknown.
//!
//! Near an estimate the cost is, up to a constant, `½ ‖W d + z‖²` of a step `d`, with `WᵀW = JᵀJ` and `Wᵀz` its gradient. Where the other
//! columns take what is best for the kept ones,
//!
//! ```text
//!     ½ ‖Q (W_k d_k + z)‖²,      d_o = −W_o⁺ (W_k d_k + z),      Q = 1 − W_o W_o⁺
//! ```
//!
//! the Schur complement, by orthogonal projection: other columns may themselves be undetermined.

use faer::{Mat, MatRef};

use super::RankAnalysis;
use crate::EvaluateError;

/// Singular values of the other columns below this share of the largest are rounding errors.
const RANK_TOLERANCE: f64 = 1e-9;

/// The cost as a function of some columns alone, all others being where they are best for these.
#[derive(Clone, Debug)]
pub struct Elimination {
    /// `½ dᵀ A d + bᵀ d`: A, row-major, over the kept columns in their units.
    pub information: Vec<f64>,
    /// b.
    pub slope: Vec<f64>,
    /// Places of the kept columns and of the others among all.
    kept: Vec<usize>,
    others: Vec<usize>,
    /// `d_o = follow d_k + lead`.
    follow: Mat<f64>,
    lead: Vec<f64>,
    columns: usize,
}

impl Elimination {
    /// A step by all columns of the problem: the kept ones by `step`, the others as is best. Columns that follow others by elimination stay.
    pub fn whole_step(&self, step: &[f64]) -> Vec<f64> {
        let mut whole = vec![0.0; self.columns];
        self.kept.iter().zip(step).for_each(|(column, by)| whole[*column] = *by);
        for (row, column) in self.others.iter().enumerate() {
            let followed: f64 = (0..step.len()).map(|j| self.follow[(row, j)] * step[j]).sum();
            whole[*column] = followed + self.lead[row];
        }
        whole
    }
}

impl RankAnalysis {
    /// The cost over the `kept` columns; `gradient` is its own by all columns where it was decomposed, zero at a minimum. Kept columns that
    /// follow others by elimination have no information of their own.
    ///
    /// # Errors
    /// Where the other columns have no singular value decomposition.
    pub fn eliminate_others(&self, kept: &[usize], gradient: &[f64]) -> Result<Elimination, EvaluateError> {
        let columns = self.column_scales.len();
        let shared: Vec<usize> = (0..columns).filter(|column| self.eliminated.shared(*column).is_some()).collect();
        let others: Vec<usize> = shared.into_iter().filter(|column| !kept.contains(column)).collect();
        let place = |column: &usize| self.eliminated.shared(*column);
        // Rows of W: singular value times direction, in scaled columns.
        let row = |k: usize| (self.singular_values[k], &self.directions[k]);
        let root = |of: &[usize]| {
            Mat::from_fn(self.rank, of.len(), |k, j| {
                let (value, direction) = row(k);
                place(&of[j]).map_or(0.0, |index| value * direction[index])
            })
        };
        let rest = Mat::from_fn(self.rank, 1, |k, _| {
            let (value, direction) = row(k);
            let along = |column: usize| {
                place(&column).map_or(0.0, |index| direction[index] * gradient[column] / self.column_scales[column])
            };
            (0..columns).map(along).sum::<f64>() / value
        });
        let (root_kept, root_others) = (root(kept), root(&others));
        let (range, inverse) = range_and_inverse(root_others.as_ref())?;
        let projected = |of: &Mat<f64>| of - &range * (range.transpose() * of);
        let (left, left_rest) = (projected(&root_kept), projected(&rest));
        let scale = |column: usize| self.column_scales[column];
        let (information, slope) = (left.transpose() * &left, left.transpose() * &left_rest);
        let (follow, lead) = (&inverse * &root_kept, &inverse * &rest);
        let entry = |i: usize, j: usize| information[(i, j)] * scale(kept[i]) * scale(kept[j]);
        Ok(Elimination {
            information: (0..kept.len())
                .flat_map(|i| (0..kept.len()).map(move |j| (i, j)))
                .map(|(i, j)| entry(i, j))
                .collect(),
            slope: (0..kept.len()).map(|i| slope[(i, 0)] * scale(kept[i])).collect(),
            follow: Mat::from_fn(others.len(), kept.len(), |i, j| -follow[(i, j)] * scale(kept[j]) / scale(others[i])),
            lead: (0..others.len()).map(|i| -lead[(i, 0)] / scale(others[i])).collect(),
            kept: kept.to_vec(),
            others,
            columns,
        })
    }
}

/// Orthonormal basis of a matrix's columns, and its pseudo-inverse.
fn range_and_inverse(matrix: MatRef<'_, f64>) -> Result<(Mat<f64>, Mat<f64>), EvaluateError> {
    if matrix.ncols() == 0 || matrix.nrows() == 0 {
        return Ok((Mat::zeros(matrix.nrows(), 0), Mat::zeros(matrix.ncols(), matrix.nrows())));
    }
    let svd =
        matrix.thin_svd().map_err(|_| EvaluateError("the Jacobian has no singular value decomposition".into()))?;
    let values = svd.S().column_vector();
    let rank = (0..values.nrows()).filter(|k| values[*k] > RANK_TOLERANCE * values[0]).count();
    let range = svd.U().get(.., ..rank).to_owned();
    let scaled = Mat::from_fn(matrix.ncols(), rank, |i, k| svd.V()[(i, k)] / values[k]);
    let inverse = &scaled * range.transpose();
    Ok((range, inverse))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Line, add};
    use crate::{Block, Problem, ProblemBuilder, Values};

    /// `a + b t + c t² + (d + e) sin t`: of d and e the sum alone shows.
    fn curve() -> (Problem, Values) {
        let mut builder = ProblemBuilder::new();
        let blocks = ["a", "b", "c", "d", "e"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.3]));
        for k in 0..50 {
            let t = 0.1 * f64::from(k) - 1.0;
            let slopes = [1.0, t, t * t, t.sin(), t.sin()];
            add(&mut builder, Line::new(&blocks, &slopes, (3.0 * t).cos()));
        }
        builder.build().unwrap()
    }

    #[test]
    fn the_others_take_what_is_best() {
        let (problem, values) = curve();
        let gradient = problem.transposed_product(&values, &problem.residuals(&values).unwrap()).unwrap();
        let kept = [0, 3];
        let left = RankAnalysis::new(&problem, &values).unwrap().eliminate_others(&kept, &gradient).unwrap();
        let cost = |step: &[f64]| problem.cost(&problem.retract(&values, step)).unwrap();
        let predicted = |d: [f64; 2]| {
            let a = &left.information;
            0.5 * (a[0] * d[0] * d[0] + 2.0 * a[1] * d[0] * d[1] + a[3] * d[1] * d[1])
                + left.slope[0] * d[0]
                + left.slope[1] * d[1]
        };
        let origin = cost(&left.whole_step(&[0.0, 0.0]));
        for d in [[0.7, -0.2], [-1.0, 0.5]] {
            let whole = left.whole_step(&d);
            assert_eq!([whole[0], whole[3]], d);
            assert!((cost(&whole) - origin - predicted(d)).abs() < 1e-9, "{} {}", cost(&whole) - origin, predicted(d));
            // No step of another column lowers it.
            for other in [1, 2, 4] {
                for by in [-1e-3, 1e-3] {
                    let mut off = whole.clone();
                    off[other] += by;
                    assert!(cost(&off) >= cost(&whole) - 1e-12, "{other}");
                }
            }
        }
        // e makes up for d: nothing is said of d by itself.
        assert!(left.information[3].abs() < 1e-9 && left.information[0] > 1.0, "{:?}", left.information);
    }
}
