//! Covariance of tangent coordinates, and of what depends on them.
//!
//! With `Σ` the covariance of the columns and `F` the slopes of some functions of them, the functions have the
//! covariance `F Σ Fᵀ`: exactly where they are linear, to first order elsewhere (the delta method).
//!
//! Along directions that the data do not determine `Σ` holds nothing (zero): ask [`RankAnalysis`](crate::RankAnalysis) which
//! those are before a number is shown.

use std::sync::Arc;

use crate::eliminated_columns::EliminatedColumns;
use crate::{BlockId, EvaluateError, Problem, Values};

/// Step of the differences, relative to the block's size or its standard deviation: rounding 1e-13, error of the
/// extrapolation 1e-12.
const DIFFERENCE: f64 = 1e-3;

/// A linear function of the columns: column and coefficient. What is not named has the coefficient zero.
pub type LinearFunction = Vec<(usize, f64)>;

/// Covariance of the free blocks in tangent coordinates.
#[derive(Clone, Debug)]
pub struct Covariance {
    /// Square, row-major, in the order of the problem's shared columns (all of them, without eliminated blocks).
    tangent: Vec<f64>,
    size: usize,
    /// Where the problem has eliminated blocks: what their columns are made of, and a factor of their own variances.
    eliminated: Option<(Arc<EliminatedColumns>, f64)>,
    /// Factor of each column's standard deviation; nothing where all are 1.
    widening: Option<Arc<[f64]>>,
    /// What errors that no reading shows add: by how much each moves the columns, one standard deviation of it.
    systematic: Vec<Arc<[f64]>>,
}

/// Correlation from which on two columns move together.
const TOGETHER: f64 = 0.9;

/// The column of the largest factor above 1.
fn largest(factors: &[Option<f64>]) -> Option<(usize, f64)> {
    let factors = factors.iter().enumerate().filter_map(|(column, factor)| Some((column, (*factor)?)));
    factors.filter(|(_, factor)| *factor > 1.0).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// What is added to a standard deviation of 1 that is multiplied by a factor, as squares add up.
fn beyond(factor: f64) -> f64 {
    ((factor - 1.0).max(0.0)).sqrt() * (factor + 1.0).sqrt()
}

impl Covariance {
    /// `tangent`: `size` rows, one after the other.
    pub(crate) fn new(tangent: Vec<f64>, size: usize) -> Self {
        Covariance { tangent, size, eliminated: None, widening: None, systematic: Vec::new() }
    }

    /// The same of a problem with eliminated blocks, of whose shared columns `tangent` is.
    pub(crate) fn with_eliminated(self, eliminated: Arc<EliminatedColumns>) -> Self {
        Covariance { eliminated: Some((eliminated, 1.0)), ..self }
    }

    /// Number of the problem's columns.
    pub(super) fn columns(&self) -> usize {
        self.eliminated.as_ref().map_or(self.size, |(eliminated, _)| eliminated.columns())
    }

    /// A linear function of the problem's columns as one of the shared columns.
    pub(super) fn shared(&self, function: &[(usize, f64)]) -> LinearFunction {
        match &self.eliminated {
            Some((eliminated, _)) => eliminated.reduce(function.iter().copied()).shared,
            None => function.to_vec(),
        }
    }

    /// Covariance between two columns.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.between(&[(row, 1.0)], &[(column, 1.0)])
    }

    /// Standard deviation of one column.
    pub fn std(&self, column: usize) -> f64 {
        self.at(column, column).max(0.0).sqrt()
    }

    /// Standard deviation of each column in units of that of another covariance; 1 where that has none.
    pub(super) fn ratios_to(&self, other: &Covariance) -> Vec<f64> {
        let ratio = |column: usize| match other.std(column) {
            std if std > 0.0 => self.std(column) / std,
            _ => 1.0,
        };
        (0..self.columns()).map(ratio).collect()
    }

    /// Correlation between two columns, from −1 to 1; 0 where one of them has no variance.
    pub fn correlation(&self, row: usize, column: usize) -> f64 {
        correlation(self.at(row, column), self.at(row, row), self.at(column, column))
    }

    /// The same with every variance and covariance multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Covariance {
        let eliminated = self.eliminated.as_ref().map(|(eliminated, own)| (Arc::clone(eliminated), factor * own));
        let tangent = self.tangent.iter().map(|v| factor * v).collect();
        let systematic = self.systematic.iter().map(|moved| moved.iter().map(|moved| factor.sqrt() * moved).collect());
        let (widening, systematic) = (self.widening.clone(), systematic.collect());
        Covariance { tangent, size: self.size, eliminated, widening, systematic }
    }

    /// The same with the standard deviation of each of the problem's columns multiplied by its factor, and correlations as they are.
    pub fn widened(&self, factors: &[f64]) -> Covariance {
        let before = |column: usize| self.widening.as_ref().map_or(1.0, |before| before[column]);
        let all = factors.iter().enumerate().map(|(column, factor)| factor * before(column));
        let moved = |moved: &Arc<[f64]>| moved.iter().zip(factors).map(|(moved, factor)| factor * moved).collect();
        let systematic = self.systematic.iter().map(moved).collect();
        Covariance { widening: Some(all.collect()), systematic, ..self.clone() }
    }

    /// The same with errors beside it, `Σ + Σ_k Δ_k Δ_kᵀ`: by `Δ_k` each moves the columns. What is known well of a combination stays so as far as
    /// errors do not move it.
    pub fn with_systematic(&self, moved: &[Vec<f64>]) -> Covariance {
        let systematic = self.systematic.iter().cloned().chain(moved.iter().map(|moved| moved.as_slice().into()));
        Covariance { systematic: systematic.collect(), ..self.clone() }
    }

    /// The errors beside it that multiply the standard deviation of each column by its factor: one of each group of columns that move together, in the
    /// direction in which they do. Columns without a factor move with those that they are hardly known apart from.
    pub fn errors_of(&self, factors: &[Option<f64>]) -> Vec<Vec<f64>> {
        let mut left: Vec<Option<f64>> = factors.to_vec();
        let mut errors = Vec::new();
        while let Some((leader, factor)) = largest(&left) {
            let std = self.std(leader);
            let mut moved = vec![0.0; left.len()];
            for (column, left) in left.iter_mut().enumerate() {
                let (own, with_leader) = (self.std(column), self.at(column, leader) / std);
                if own > 0.0 && with_leader.abs() > TOGETHER * own {
                    let size = left.map_or(beyond(factor) * with_leader.abs(), |factor| beyond(factor) * own);
                    moved[column] = size.copysign(with_leader);
                    *left = left.map(|_| 1.0);
                }
            }
            left[leader] = Some(1.0);
            errors.push(moved);
        }
        errors
    }

    /// Standard deviation of the linear function `Σ coefficient · column`.
    pub fn std_of(&self, function: &[(usize, f64)]) -> f64 {
        self.between(function, function).max(0.0).sqrt()
    }

    /// Covariance of linear functions, row-major.
    pub fn of(&self, functions: &[LinearFunction]) -> Vec<f64> {
        let count = functions.len();
        let mut all = vec![0.0; count * count];
        // Each once: what rounding leaves differs with the order of sums.
        for (i, a) in functions.iter().enumerate() {
            for (j, b) in functions[..=i].iter().enumerate() {
                let both = self.between(a, b);
                (all[i * count + j], all[j * count + i]) = (both, both);
            }
        }
        all
    }

    fn between(&self, a: &[(usize, f64)], b: &[(usize, f64)]) -> f64 {
        let moved = |moved: &[f64], function: &[(usize, f64)]| function.iter().map(|(i, c)| c * moved[*i]).sum::<f64>();
        let systematic: f64 = self.systematic.iter().map(|error| moved(error, a) * moved(error, b)).sum();
        let Some(factors) = &self.widening else { return self.between_narrow(a, b) + systematic };
        let wide =
            |function: &[(usize, f64)]| function.iter().map(|(i, c)| (*i, c * factors[*i])).collect::<LinearFunction>();
        self.between_narrow(&wide(a), &wide(b)) + systematic
    }

    fn between_narrow(&self, a: &[(usize, f64)], b: &[(usize, f64)]) -> f64 {
        let Some((eliminated, own)) = &self.eliminated else { return self.between_shared(a, b) };
        let (a, b) = (eliminated.reduce(a.iter().copied()), eliminated.reduce(b.iter().copied()));
        self.between_shared(&a.shared, &b.shared) + own * a.own_covariance(&b)
    }

    fn between_shared(&self, a: &[(usize, f64)], b: &[(usize, f64)]) -> f64 {
        let entry = |i: usize, j: usize| self.tangent[i * self.size + j];
        a.iter().map(|(i, a)| b.iter().map(|(j, b)| a * b * entry(*i, *j)).sum::<f64>()).sum()
    }

    /// Covariance of the stored coordinates of a list of blocks, row-major; zero where a block is fixed.
    ///
    /// It is `B Σ Bᵀ` with `B` the tangent basis of each block, so that a vector on a sphere has a singular one.
    pub fn stored(&self, problem: &Problem, values: &Values, blocks: &[BlockId]) -> Vec<f64> {
        self.of(&stored_coordinates(problem, values, blocks))
    }

    /// Correlations of the stored coordinates of a list of blocks, row-major; 0 where one has no variance, 1 of each
    /// with itself.
    pub fn stored_correlations(&self, problem: &Problem, values: &Values, blocks: &[BlockId]) -> Vec<f64> {
        let covariance = self.stored(problem, values, blocks);
        let size = (covariance.len() as f64).sqrt().round() as usize;
        let variance = |i: usize| covariance[i * (size + 1)];
        let entry = |k: usize| match (k / size, k % size) {
            (i, j) if i == j => 1.0,
            (i, j) => correlation(covariance[k], variance(i), variance(j)),
        };
        (0..covariance.len()).map(entry).collect()
    }

    /// Covariance of `function` of the stored coordinates of some blocks (one block after the other), row-major.
    ///
    /// # Errors
    /// As [`Covariance::linearized`].
    pub fn of_function(
        &self,
        (problem, values): (&Problem, &Values),
        blocks: &[BlockId],
        function: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Result<Vec<f64>, EvaluateError> {
        Ok(self.of(&self.linearized((problem, values), blocks, function)?))
    }

    /// The slopes of `function` of the stored coordinates of some blocks, one linear function an entry: Richardson's
    /// extrapolation of central differences along the blocks' manifolds (error of fourth order).
    ///
    /// # Errors
    /// Where the function has a value near `values` that is not finite, or not as many values everywhere.
    pub fn linearized(
        &self,
        (problem, values): (&Problem, &Values),
        blocks: &[BlockId],
        function: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Result<Vec<LinearFunction>, EvaluateError> {
        let stored = |at: &Values| blocks.iter().flat_map(|id| at.get(*id).to_vec()).collect::<Vec<f64>>();
        let entries = function(&stored(values)).len();
        let evaluate = |column: usize, by: f64| {
            let mut step = vec![0.0; problem.columns().len()];
            step[column] = by;
            let at = stored(&problem.retract(values, &step));
            let value = function(&at);
            let sound = value.len() == entries && value.iter().all(|v| v.is_finite());
            if sound { Ok(value) } else { Err(EvaluateError(format!("the function gives {value:?} at {at:?}"))) }
        };
        let mut slopes = vec![LinearFunction::new(); entries];
        for id in blocks {
            let size = values.get(*id).iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for column in problem.columns_of(*id) {
                let largest = size.max(self.std(column));
                let step = DIFFERENCE * if largest > 0.0 { largest } else { 1.0 };
                let slope = |h: f64| -> Result<Vec<f64>, EvaluateError> {
                    let (up, down) = (evaluate(column, h)?, evaluate(column, -h)?);
                    Ok(up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * h)).collect())
                };
                let (wide, narrow) = (slope(step)?, slope(0.5 * step)?);
                for (entry, (wide, narrow)) in slopes.iter_mut().zip(wide.iter().zip(narrow)) {
                    entry.push((column, (4.0 * narrow - wide) / 3.0));
                }
            }
        }
        Ok(slopes)
    }
}

/// Each stored coordinate of some blocks as a linear function of the columns; none of a fixed block.
pub fn stored_coordinates(problem: &Problem, values: &Values, blocks: &[BlockId]) -> Vec<LinearFunction> {
    let of_block = |id: &BlockId| {
        let columns = problem.columns_of(*id);
        let basis = problem.tangent_basis(values, *id);
        let tangent = columns.len();
        let row = |stored: usize| columns.clone().zip(basis[stored * tangent..].iter().copied()).collect();
        (0..problem.block(*id).len()).map(row).collect::<Vec<LinearFunction>>()
    };
    blocks.iter().flat_map(of_block).collect()
}

fn correlation(covariance: f64, variance: f64, other: f64) -> f64 {
    let product = variance.max(0.0).sqrt() * other.max(0.0).sqrt();
    if product > 0.0 { (covariance / product).clamp(-1.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Line;
    use crate::{Block, Factor, Noise, ProblemBuilder, Sphere};

    /// A vector on a sphere of radius 5 and a number, measured directly.
    fn sphere_and_number() -> (Problem, Values, [BlockId; 2]) {
        let mut builder = ProblemBuilder::new();
        let vector = Block::vector("g", "m/s²", &["x", "y", "z"]).on(Sphere { radius: 5.0 });
        let g = builder.add_block(vector, &[3.0, 0.0, 4.0]);
        let a = builder.add_block(Block::scalar("a", ""), &[2.0]);
        for (id, component) in [(g, 0), (g, 1), (a, 0)] {
            let noise = Noise::independent(&[0.1]).unwrap();
            builder.add_factor(Factor::new(Line::component(id, component), noise));
        }
        let (problem, values) = builder.build().unwrap();
        (problem, values, [g, a])
    }

    #[test]
    fn a_function_has_the_covariance_of_its_slopes() {
        let (problem, values, blocks) = sphere_and_number();
        let covariance = Covariance::new(vec![0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.25], 3);
        let of = |f: fn(&[f64]) -> Vec<f64>| covariance.of_function((&problem, &values), &blocks, f).unwrap();
        // The length never changes on a sphere; a linear function is its own slope.
        let length = of(|x| vec![(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt()]);
        assert!(length[0].abs() < 1e-18, "{length:?}");
        let same = of(|x| x.to_vec());
        let stored = covariance.stored(&problem, &values, &blocks);
        assert!(same.iter().zip(&stored).all(|(a, b)| (a - b).abs() < 1e-12), "{same:?} {stored:?}");
        // d(a³) = 3 a² da at a = 2.
        let cube = of(|x| vec![x[3].powi(3)]);
        assert!((cube[0] / (144.0 * 0.25) - 1.0).abs() < 1e-9, "{cube:?}");
    }

    #[test]
    fn a_wider_column_keeps_its_correlations() {
        let narrow = Covariance::new(vec![0.04, 0.01, 0.01, 0.09], 2);
        let wide = narrow.widened(&[3.0, 1.0]).widened(&[1.0, 2.0]);
        assert!((wide.std(0) - 0.6).abs() < 1e-12 && (wide.std(1) - 0.6).abs() < 1e-12);
        assert!((wide.correlation(0, 1) - narrow.correlation(0, 1)).abs() < 1e-12);
    }

    /// Two numbers whose product is known to a thousandth stay so where each is uncertain by more.
    #[test]
    fn errors_of_what_moves_together_leave_the_rest_as_well_known() {
        let narrow = Covariance::new(vec![1.0, -1.0, 0.1, -1.0, 1.000_001, 0.0, 0.1, 0.0, 1.0], 3);
        let errors = narrow.errors_of(&[Some(2.0), None, Some(3.0)]);
        let wide = narrow.with_systematic(&errors);
        assert_eq!(errors.len(), 2);
        let close = |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 1e-5, "{value} {expected}");
        close(wide.std(0), 2.0);
        close(wide.std(1), 2.0);
        close(wide.std(2), 3.0);
        close(wide.std_of(&[(0, 1.0), (1, 1.0)]), narrow.std_of(&[(0, 1.0), (1, 1.0)]));
        close(wide.widened(&[2.0; 3]).std(0), 4.0);
        close(wide.scaled(4.0).std(0), 4.0);
    }

    #[test]
    fn a_function_without_a_value_is_reported() {
        let (problem, values, blocks) = sphere_and_number();
        let covariance = Covariance::new(vec![0.0; 9], 3);
        let error = covariance.of_function((&problem, &values), &blocks, |x| vec![(x[3] - 2.0).sqrt()]).unwrap_err();
        assert!(error.to_string().contains("NaN"), "{error}");
    }

    #[test]
    fn correlations_are_covariances_without_units() {
        let (problem, values, blocks) = sphere_and_number();
        let covariance = Covariance::new(vec![0.04, 0.03, 0.0, 0.03, 0.09, 0.0, 0.0, 0.0, 0.0], 3);
        assert!((covariance.correlation(0, 1) - 0.5).abs() < 1e-15);
        assert_eq!(covariance.correlation(0, 2), 0.0);
        let stored = covariance.stored_correlations(&problem, &values, &blocks);
        assert_eq!([stored[0], stored[5], stored[10], stored[15]], [1.0; 4]);
        // x and z of a sphere move together: along the tangent, against each other.
        assert!((stored[2] + 1.0).abs() < 1e-12, "{stored:?}");
    }
}
