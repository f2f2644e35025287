//! The problem along the constraints on which a solution leans.
//!
//! Nothing moves an estimate off a constraint that holds it, to first order: there it has no error. Judged without that, the
//! uncertainty across the constraint is what the readings alone would leave, and the scores of a sandwich do not sum to zero.
//! So what an active constraint holds becomes an all but exact reading,
//!
//! ```text
//!     f(x) = f(x₀),     f affine
//! ```
//!
//! which takes the direction across the constraint from what the readings leave open. **Assumption:** with other readings of
//! the same noise the same constraints would hold. So only those count whose lean,
//!
//! ```text
//!     λ σ      λ: multiplier,  σ: standard deviation of f by the readings alone
//! ```
//!
//! the distance by which the readings would like to pass the constraint, in standard deviations, is at least [`DECIDED`]. What leans by less
//! might as well not hold with other readings, and what holds a direction without information leans by nothing: both leave open what
//! they hold.

use crate::{
    ActiveConstraint, Affine, BlockId, Estimate, EvaluateError, Factor, LocalValues, Noise, Problem, RankAnalysis,
    Residual, RowsMut, Values,
};

use super::StatisticsError;

/// How much stiffer an active function is than the data make the unknowns it reads: enough to stand for exact, and little
/// enough to leave weak directions to be told from empty ones.
const STIFFNESS: f64 = 1e3;
/// A constraint that leans by less, in standard deviations, leaves open what it holds.
pub const DECIDED: f64 = 3.0;
/// Part of a function's slope, in scaled coordinates, along directions without information beyond which these touch it.
const TOUCHED: f64 = 1e-6;
/// A function whose slope is but for this share that of others follows from them.
const DEPENDENT: f64 = 1e-6;

/// The problem with what the active constraints of an estimate hold as all but exact readings, after all other factors;
/// nothing where none is active. `analysis` is that of the problem at the estimate.
///
/// # Errors
/// Where a constraint reads nothing that is free, or a value that is not finite.
pub fn along_constraints(
    problem: &Problem,
    estimate: &Estimate,
    analysis: &RankAnalysis,
) -> Result<Option<Problem>, StatisticsError> {
    let leans = leans(problem, estimate, analysis);
    let decided = estimate.active.iter().zip(leans).filter(|(_, lean)| *lean >= DECIDED);
    let decided: Vec<ActiveConstraint> = decided.map(|(active, _)| active.clone()).collect();
    if decided.is_empty() {
        return Ok(None);
    }
    let mut factors = problem.factors().to_vec();
    for (function, norm) in independent(problem, &decided, analysis) {
        let noise = Noise::independent(&[norm / STIFFNESS])?;
        factors.push(Factor::new(ActiveFunction::new(function, &estimate.values), noise));
    }
    Ok(Some(problem.with_factors(factors)?))
}

/// By how many standard deviations the readings would like to pass each active constraint of an estimate; 0 where a constraint holds what the
/// readings say nothing of. `analysis` is that of the problem at the estimate, without its constraints.
pub fn leans(problem: &Problem, estimate: &Estimate, analysis: &RankAnalysis) -> Vec<f64> {
    if estimate.active.is_empty() {
        return Vec::new();
    }
    let covariance = analysis.covariance();
    let std = |function: &Affine| {
        let column = |(id, component, c): &(BlockId, usize, f64)| Some((problem.columns_of(*id).nth(*component)?, *c));
        let slope: Vec<(usize, f64)> = function.terms.iter().filter_map(column).collect();
        let scaled = |(column, c): &(usize, f64)| c / analysis.column_scale(*column);
        let length = slope.iter().map(|term| scaled(term).powi(2)).sum::<f64>().sqrt();
        let open = slope.iter().any(|term| scaled(term).abs() * analysis.null_share(term.0) > TOUCHED * length);
        if open { 0.0 } else { covariance.std_of(&slope) }
    };
    let lean = |active: &ActiveConstraint| {
        active.multiplier.abs() * active.holds.iter().map(std).fold(f64::INFINITY, f64::min)
    };
    estimate.active.iter().map(lean).collect()
}

/// The active functions that do not follow from those before them, each with the norm of its slope by columns that count
/// in what one standard deviation of the data makes of them.
fn independent<'a>(
    problem: &Problem,
    active: &'a [ActiveConstraint],
    analysis: &RankAnalysis,
) -> Vec<(&'a Affine, f64)> {
    let mut found: Vec<(&Affine, f64)> = Vec::new();
    let mut directions: Vec<Vec<f64>> = Vec::new();
    for function in active.iter().flat_map(|constraint| &constraint.holds) {
        let mut slope = vec![0.0; problem.columns().len()];
        for (id, component, c) in &function.terms {
            if let Some(column) = problem.columns_of(*id).nth(*component) {
                slope[column] += c / analysis.column_scale(column);
            }
        }
        let norm = dot(&slope, &slope).sqrt();
        for other in &directions {
            let along = dot(other, &slope);
            slope.iter_mut().zip(other).for_each(|(s, o)| *s -= along * o);
        }
        let left = dot(&slope, &slope).sqrt();
        if left > DEPENDENT * norm {
            directions.push(slope.iter().map(|s| s / left).collect());
            found.push((function, norm));
        }
    }
    found
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The deviation of the function from its value, in its unit.
#[derive(Clone, Debug)]
struct ActiveFunction {
    blocks: Vec<BlockId>,
    /// Position among `blocks`, component, coefficient.
    terms: Vec<(usize, usize, f64)>,
    /// The value less the constant part.
    value: f64,
}

impl ActiveFunction {
    /// Held where it is at `values`.
    fn new(function: &Affine, values: &Values) -> Self {
        let mut blocks: Vec<BlockId> = function.terms.iter().map(|(id, ..)| *id).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let place = |id: &BlockId| blocks.partition_point(|other| other < id);
        let terms = function.terms.iter().map(|(id, component, c)| (place(id), *component, *c)).collect();
        ActiveFunction { terms, value: function.at(values) - function.constant, blocks }
    }
}

impl Residual for ActiveFunction {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        residual[0] = self.terms.iter().map(|(block, i, c)| c * x.block(*block)[*i]).sum::<f64>() - self.value;
        if let Some(mut rows) = jacobian {
            self.terms.iter().for_each(|(block, i, c)| rows.row(0)[x.column(*block) + i] += c);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{NoiseScale, SampleBlocks, Solution, Uncertainty};
    use crate::testing::Line;
    use crate::{Block, ProblemBuilder, Termination, check_derivatives};

    #[test]
    fn a_held_function_is_zero_where_it_is_held_and_has_the_slopes_it_says() {
        let mut builder = ProblemBuilder::new();
        let a = builder.add_block(Block::vector("a", "", &["x", "y"]), &[1.0, 2.0]);
        let b = builder.add_block(Block::vector("b", "", &["x", "y", "z"]), &[3.0, 4.0, 5.0]);
        let function = Affine::constant(7.0).plus(b, 2, 0.5).plus(a, 1, -2.0).plus(b, 2, 1.0);
        let residual = ActiveFunction::new(&function, &builder.initial());
        check_derivatives(&residual, &[2, 3], &[0.3; 5], 1e-9).unwrap();
        let mut r = [1.0];
        let values = builder.initial();
        residual.evaluate(LocalValues::new(values.as_slice(), &[0, 2, 5]), &mut r, None).unwrap();
        assert_eq!(r, [0.0]);
    }

    /// 120 readings of x + y and as many of x, x held at a bound of 1 that they would like to pass: by hand
    /// var y = 1 / 120 instead of 2 / 120.
    #[test]
    fn an_active_bound_has_no_error_and_spares_others_theirs() {
        let mut builder = ProblemBuilder::new();
        let blocks = [("x", 1.0), ("y", 2.0)].map(|(name, value)| builder.add_block(Block::scalar(name, ""), &[value]));
        for k in 0..240 {
            let error = f64::from(k * 37 % 11) / 5.0 - 1.0;
            let (slopes, reading) = if k % 2 == 0 { ([1.0, 1.0], 3.0) } else { ([1.0, 0.0], 1.5) };
            let line = Line::new(&blocks, &slopes, reading + error);
            builder.add_factor(Factor::new(line, Noise::independent(&[1.0]).unwrap()));
        }
        let (problem, values) = builder.build().unwrap();
        let holds = vec![Affine::component(blocks[0], 0)];
        let estimate = Estimate {
            cost: problem.cost(&values).unwrap(),
            values,
            termination: Termination::Gradient { cosine: 0.0 },
            iterations: Vec::new(),
            iterates: Vec::new(),
            active: vec![ActiveConstraint { name: "x is at most 1".into(), multiplier: 60.0, holds }],
            without_effect: Vec::new(),
            normal_equations: None,
        };
        let analysis = RankAnalysis::new(&problem, &estimate.values).unwrap();
        let along = along_constraints(&problem, &estimate, &analysis).unwrap().unwrap();
        let std = |problem: &Problem, of: fn(&Solution<'_>) -> Uncertainty| {
            let analysis = RankAnalysis::new(problem, &estimate.values).unwrap();
            let uncertainty = of(&Solution { problem, values: &estimate.values, analysis: &analysis });
            [0, 1].map(|column| uncertainty.covariance().std(column))
        };
        let plain = |solution: &Solution<'_>| Uncertainty::from_noise(solution, NoiseScale::Stated).unwrap();
        let [free_x, free_y] = std(&problem, plain);
        assert!((free_x - 120f64.recip().sqrt()).abs() < 1e-12 && (free_y - 60f64.recip().sqrt()).abs() < 1e-12);
        let [x, y] = std(&along, plain);
        assert!(x < 2e-3 * free_x && (y / 120f64.recip().sqrt() - 1.0).abs() < 1e-5, "{x} {y}");
        let by_blocks =
            |solution: &Solution<'_>| Uncertainty::sandwich(solution, &SampleBlocks::new(0..240, 6).unwrap()).unwrap();
        assert!(std(&along, by_blocks)[0] < 2e-3 * std(&problem, by_blocks)[0]);
        let inside = Estimate { active: Vec::new(), ..estimate.clone() };
        assert!(along_constraints(&problem, &inside, &analysis).unwrap().is_none());
    }
}
