//! Singular values and right singular vectors of the whitened Jacobian, columns scaled to unit length.
//!
//! They are had from an orthogonal factorization, which loses no digit. A problem that is not small is looked at through its normal
//! equations first, which cost a third of that or less, after elimination:
//!
//! ```text
//!     D⁻¹ JᵀJ D⁻¹ = V Σ² Vᵀ
//! ```
//!
//! They serve where every eigenvalue is either well above rounding, so that the singular value and its vector keep ten digits, or
//! as good as zero with a vector that J itself maps to zero.

use std::borrow::Cow;

use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::{RANK_TOLERANCE, SHADOW_TOLERANCE};
use crate::eliminated_columns::EliminatedColumns;
use crate::linearization::{Alike, Normal, Orthogonal, column_scales};
use crate::problem::{Chunk, Rows};
use crate::{EvaluateError, Linearization, NormalEquations, Problem, Values};

/// Eigenvalues of the scaled `JᵀJ` above this keep ten digits.
const PLAIN: f64 = 1e-6;
/// Those below this are zero but for rounding, or too small to be told from it.
const ROUNDING: f64 = 1e-12;

/// Directions along which J is applied at once: their sums stay in registers.
const TOGETHER: usize = 8;

/// What is decomposed are the shared columns, after elimination.
pub(super) struct Decomposition {
    /// Scale of every column of J, see [`Linearization::column_scales`].
    pub column_scales: Vec<f64>,
    pub eliminated: EliminatedColumns,
    /// Columns of zeros, as indices among the shared ones. They are directions without information by themselves: decomposed along
    /// with the others they would mix with theirs.
    pub zero_columns: Vec<usize>,
    /// Largest first.
    pub singular_values: Vec<f64>,
    /// Right singular vectors over all shared columns, one a row.
    pub directions: Vec<Vec<f64>>,
}

impl Decomposition {
    /// `known`: the normal equations there, if they were summed before.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn new(problem: &Problem, values: &Values, known: Option<&NormalEquations>) -> Result<Self, EvaluateError> {
        match Self::by_normal_equations(problem, values, known)? {
            Some(plain) => Ok(plain),
            None => Self::orthogonally(problem, values),
        }
    }

    fn by_normal_equations(
        problem: &Problem,
        values: &Values,
        known: Option<&NormalEquations>,
    ) -> Result<Option<Self>, EvaluateError> {
        let summed = match known.filter(|known| known.are_of(problem)) {
            Some(known) => Some(Cow::Borrowed(known)),
            None if !problem.is_small() => Normal::new(problem, values)?.normal_equations().map(Cow::Owned),
            None => None,
        };
        let Some(normal) = summed else { return Ok(None) };
        let (active, zero_columns) = nonzero_and_zero(problem, normal.column_norms());
        let Some((eigen, plain)) = clear_cut(&normal, &active) else { return Ok(None) };
        let value = |k: usize| eigen.S()[active.len() - 1 - k];
        let vector = |k: usize| spread(&active, problem, |j| eigen.U()[(j, active.len() - 1 - k)]);
        let decomposition = Decomposition {
            column_scales: column_scales(normal.column_norms()),
            eliminated: EliminatedColumns::new(problem, values, normal.column_norms()),
            zero_columns,
            singular_values: (0..active.len()).map(|k| if k < plain { value(k).sqrt() } else { 0.0 }).collect(),
            directions: (0..active.len()).map(vector).collect(),
        };
        let none = decomposition.maps_to_zero(problem, values, plain)?;
        Ok(none.then_some(decomposition))
    }

    /// Whether J itself maps the directions from `first` on to zero.
    fn maps_to_zero(&self, problem: &Problem, values: &Values, first: usize) -> Result<bool, EvaluateError> {
        let null = &self.directions[first..];
        if null.is_empty() {
            return Ok(true);
        }
        let of_chunk = |chunk: &Chunk| self.image_of_chunk(problem, values, null, chunk);
        let parts: Vec<Result<Vec<_>, _>> = problem.structure().chunks.par_iter().map(of_chunk).collect();
        let mut squares = vec![[0.0; TOGETHER]; null.len().div_ceil(TOGETHER)];
        for part in parts {
            squares.as_flattened_mut().iter_mut().zip(part?.as_flattened()).for_each(|(sum, part)| *sum += part);
        }
        let Some(of_components) = self.image_of_components(problem, values, null) else { return Ok(false) };
        let squares = squares.as_flattened().iter().zip(of_components.iter().chain(std::iter::repeat(&0.0)));
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        Ok(squares.into_iter().all(|(free, components)| (free + components).sqrt() <= RANK_TOLERANCE * largest))
    }

    /// What J makes of some directions in those rows of a chunk that belong to no component: the squares of the lengths.
    fn image_of_chunk(
        &self,
        problem: &Problem,
        values: &Values,
        directions: &[Vec<f64>],
        chunk: &Chunk,
    ) -> Result<Vec<[f64; TOGETHER]>, EvaluateError> {
        let structure = problem.structure();
        let mut squares = vec![[0.0; TOGETHER]; directions.len().div_ceil(TOGETHER)];
        let mut rows = Rows::new(problem, values);
        let mut entries = Vec::new();
        // By list of columns, the steps along some directions at a time, column by column.
        let mut steps: Vec<Vec<Vec<[f64; TOGETHER]>>> = Vec::new();
        let mut shape = None;
        let mut left = structure.free_factors(chunk);
        while let Some(factor) = left.first().copied() {
            let (count, _) = rows.linearize_some(left)?;
            left = &left[count..];
            if shape.replace(structure.shape_of[factor]) != shape {
                let of_list = |list: &Vec<usize>| {
                    directions.chunks(TOGETHER).map(|some| self.steps(some, &structure.shared, list)).collect()
                };
                steps = problem.column_lists(factor).iter().map(of_list).collect();
            }
            for (row, plan) in problem.plans(factor).iter().enumerate() {
                let width = plan.columns.len() + 1;
                entries.resize(count * width, 0.0);
                rows.gather(plan, row, &mut entries);
                for entries in entries.chunks_exact(width) {
                    for (squares, steps) in squares.iter_mut().zip(&steps[plan.place]) {
                        let mut along = [0.0; TOGETHER];
                        for (entry, step) in entries.iter().zip(steps) {
                            along.iter_mut().zip(step).for_each(|(sum, step)| *sum += entry * step);
                        }
                        squares.iter_mut().zip(&along).for_each(|(sum, along)| *sum += along * along);
                    }
                }
            }
        }
        Ok(squares)
    }

    /// What J makes of some directions in the rows of components, after elimination: the squares of the lengths. `None` where that would
    /// lose too many digits.
    fn image_of_components(&self, problem: &Problem, values: &Values, directions: &[Vec<f64>]) -> Option<Vec<f64>> {
        if problem.structure().components.is_empty() {
            return Some(vec![0.0; directions.len()]);
        }
        let shared = &problem.structure().shared;
        let step = |direction: &Vec<f64>| {
            direction.iter().zip(shared).map(|(entry, column)| entry / self.column_scales[*column]).collect()
        };
        let steps: Vec<Vec<f64>> = directions.iter().map(step).collect();
        Alike { problem, values, left_out: &[] }.reduced_image_norms_squared(&steps)
    }

    /// Steps along some directions by some of the shared columns, in their units; zero for directions that there are not.
    fn steps(&self, directions: &[Vec<f64>], shared: &[usize], columns: &[usize]) -> Vec<[f64; TOGETHER]> {
        let by_column = |column: &usize| {
            let scale = self.column_scales[shared[*column]];
            std::array::from_fn(|k| directions.get(k).map_or(0.0, |d| d[*column] / scale))
        };
        columns.iter().map(by_column).collect()
    }

    fn orthogonally(problem: &Problem, values: &Values) -> Result<Self, EvaluateError> {
        let linearization = Orthogonal::new(&problem.without_reference(), values)?;
        let (active, zero_columns) = nonzero_and_zero(problem, linearization.column_norms());
        let (triangle, norms) = (linearization.triangle(), linearization.column_norms());
        let shared = &problem.structure().shared;
        // At least as many rows as columns, so that the whole null space comes out.
        let scaled = Mat::from_fn(triangle.nrows().max(active.len()), active.len(), |i, j| {
            if i < triangle.nrows() { triangle[(i, active[j])] / norms[shared[active[j]]] } else { 0.0 }
        });
        let svd =
            scaled.thin_svd().map_err(|_| EvaluateError("the Jacobian has no singular value decomposition".into()))?;
        linearization.check_eliminated_columns(problem)?;
        Ok(Decomposition {
            column_scales: linearization.column_scales(),
            eliminated: EliminatedColumns::new(problem, values, norms),
            zero_columns,
            singular_values: (0..active.len()).map(|k| svd.S()[k]).collect(),
            directions: (0..active.len()).map(|k| spread(&active, problem, |j| svd.V()[(j, k)])).collect(),
        })
    }
}

/// Eigenvectors of the scaled normal equations over the active columns, smallest first, and how many are well above rounding, where all
/// others may be zero.
fn clear_cut(normal: &NormalEquations, active: &[usize]) -> Option<(SelfAdjointEigen<f64>, usize)> {
    let eigen = normal.scaled(active).self_adjoint_eigen(Side::Lower).ok()?;
    let null = (0..active.len()).take_while(|k| eigen.S()[*k] <= ROUNDING).count();
    (null == active.len() || eigen.S()[null] > PLAIN).then(|| (eigen, active.len() - null))
}

impl NormalEquations {
    /// Whether they show that each of these columns is determined: none takes part in a direction that may be without information.
    /// `false` shows nothing: ask a [`RankAnalysis`](crate::RankAnalysis).
    pub fn determine(&self, columns: &[usize]) -> bool {
        let (norms, shared) = (self.column_norms(), self.shared());
        let active: Vec<usize> = (0..shared.len()).filter(|j| norms[shared[*j]] > 0.0).collect();
        let Some((eigen, plain)) = clear_cut(self, &active) else { return false };
        let takes_part = |at: usize| (0..active.len() - plain).any(|k| eigen.U()[(at, k)].abs() > SHADOW_TOLERANCE);
        let is_determined = |column: &usize| {
            let index = shared.binary_search(column).ok()?;
            Some(!takes_part(active.binary_search(&index).ok()?))
        };
        columns.iter().all(|column| is_determined(column) == Some(true))
    }
}

/// Shared columns with some effect, and without any.
fn nonzero_and_zero(problem: &Problem, norms: &[f64]) -> (Vec<usize>, Vec<usize>) {
    let shared = &problem.structure().shared;
    (0..shared.len()).partition(|index| norms[shared[*index]] > 0.0)
}

/// A vector over the active columns as one over all shared ones.
fn spread(active: &[usize], problem: &Problem, entry: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut vector = vec![0.0; problem.structure().shared.len()];
    active.iter().enumerate().for_each(|(j, column)| vector[*column] = entry(j));
    vector
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Line, add};
    use crate::{Block, ProblemBuilder};

    /// `a + b t + c t² + (1 + unlike) d t²` at a hundred times, `unlike` at every other one: of c and d only the sum shows if it is zero.
    fn alike(unlike: f64) -> (Problem, Values) {
        let mut builder = ProblemBuilder::new();
        let blocks = ["a", "b", "c", "d"].map(|name| builder.add_block(Block::scalar(name, ""), &[1.0]));
        for k in 0..100 {
            let t = 0.01 * f64::from(k) - 0.3;
            let share = 1.0 + unlike * f64::from(k % 2);
            add(&mut builder, Line::new(&blocks, &[1.0, t, t * t, share * t * t], t));
        }
        builder.build().unwrap()
    }

    #[test]
    fn normal_equations_tell_the_same_as_the_orthogonal_factorization() {
        let (problem, values) = alike(0.0);
        let plain = Decomposition::by_normal_equations(&problem, &values, None).unwrap().unwrap();
        let careful = Decomposition::orthogonally(&problem, &values).unwrap();
        for (a, b) in plain.singular_values.iter().zip(&careful.singular_values) {
            assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
        let along: f64 = plain.directions[3].iter().zip(&careful.directions[3]).map(|(a, b)| a * b).sum();
        assert!((along.abs() - 1.0).abs() < 1e-12, "{along}");
    }

    #[test]
    fn with_blocks_eliminated_normal_equations_tell_the_same() {
        let (problem, values) = crate::linearization::tests::problem(40, true);
        let plain = Decomposition::by_normal_equations(&problem, &values, None).unwrap().unwrap();
        let careful = Decomposition::orthogonally(&problem, &values).unwrap();
        assert_eq!(plain.singular_values.len(), careful.singular_values.len());
        for (a, b) in plain.singular_values.iter().zip(&careful.singular_values) {
            assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
    }

    /// `a t + (1 + unlike) b t` with a local error in each reading: of a and b only the sum shows, or hardly more.
    #[test]
    fn a_faint_direction_beside_eliminated_blocks_is_left_to_the_orthogonal_factorization() {
        let with_unlike = |unlike: f64| {
            let mut builder = ProblemBuilder::new();
            let [a, b] = ["a", "b"].map(|name| builder.add_block(Block::scalar(name, ""), &[1.0]));
            for k in 0..40 {
                let t = 1.0 + 0.1 * f64::from(k);
                let error = builder.add_block(Block::scalar(format!("error{k}"), "").eliminated(), &[0.0]);
                let slopes = [t, t + unlike * f64::from(k % 2), 0.5];
                add(&mut builder, Line::new(&[a, b, error], &slopes, t));
                add(&mut builder, Line::new(&[error], &[1.0], 0.0));
            }
            let (problem, values) = builder.build().unwrap();
            Decomposition::by_normal_equations(&problem, &values, None).unwrap().map(|found| found.singular_values[1])
        };
        assert_eq!(with_unlike(0.0), Some(0.0));
        assert_eq!(with_unlike(1e-4), None);
        assert!(with_unlike(1.0).unwrap() > 0.01);
    }

    #[test]
    fn normal_equations_do_not_serve_where_a_direction_is_faint_but_not_without_information() {
        for faint in [1e-4, 1e-6, 1e-8] {
            let (problem, values) = alike(faint);
            assert!(Decomposition::by_normal_equations(&problem, &values, None).unwrap().is_none(), "{faint}");
            assert!(Decomposition::new(&problem, &values, None).unwrap().singular_values[3] > 1e-10, "{faint}");
        }
    }

    #[test]
    fn normal_equations_show_what_no_open_direction_touches() {
        let determined = |unlike: f64, columns: &[usize]| {
            let (problem, values) = alike(unlike);
            Normal::new(&problem, &values).unwrap().normal_equations().unwrap().determine(columns)
        };
        assert!(determined(0.0, &[0, 1]) && determined(1e-8, &[0, 1]) && determined(0.1, &[0, 1, 2, 3]));
        assert!(!determined(0.0, &[0, 2]) && !determined(0.0, &[3]) && !determined(1e-8, &[2]));
    }
}
