//! The linear blocks of a problem: their optimum for given nonlinear ones.
//!
//! With the nonlinear blocks fixed the residual is affine, so one full step leads to the optimum, and the cost there is
//! known beforehand. Where the cost found is another, and the residual halfway is not the mean of both ends', a block is marked as linear in which
//! the residuals are not affine. The cost alone may be another where the step is ill conditioned.

use gravcal_estimation::{BlockId, Column, Problem, Unsupported, Values};

use crate::{Point, Trial};

/// Share of the residual by which a foretold one may be wrong; rounding in a badly conditioned linear problem is less.
const WRONG_RESIDUAL: f64 = 1e-8;
/// Share of the linear terms by which it may be wrong: a residual is small after terms far larger have cancelled.
const WRONG_TERMS: f64 = 1e-12;

/// The problem with everything held but its linear blocks.
#[derive(Debug)]
pub(crate) struct LinearPart {
    problem: Problem,
    /// The linear blocks, with their first columns in the whole problem.
    blocks: Vec<(BlockId, usize)>,
}

impl LinearPart {
    pub fn new(whole: &Problem) -> Self {
        let (linear, nonlinear): (Vec<BlockId>, Vec<BlockId>) = whole.block_ids().partition(|id| is_linear(whole, *id));
        let blocks = linear.into_iter().map(|id| (id, whole.columns_of(id).start)).collect();
        LinearPart { problem: whole.with_fixed(&nonlinear, "given while the linear blocks are solved for"), blocks }
    }

    /// Whether there is nothing else.
    pub fn is_all_of(&self, whole: &Problem) -> bool {
        self.problem.columns().len() == whole.columns().len()
    }

    /// Columns of the whole problem that are linear.
    pub fn columns(&self) -> impl Iterator<Item = usize> {
        self.blocks.iter().flat_map(|(id, first)| *first..first + self.problem.block(*id).len())
    }

    /// Where a step of the nonlinear blocks (zero for the others) leads when the linear ones follow to their optimum: the values, and the whole
    /// step in place of the one given. Nothing where the model has no value there. Combinations of linear blocks without
    /// effect stay where they are.
    ///
    /// # Errors
    /// Where the residuals are not affine in a block marked as linear, with its name.
    pub fn follow(
        &self,
        from: &Point<'_>,
        step: &mut [f64],
        solver: &'static str,
    ) -> Result<Option<Values>, Unsupported> {
        let Some(best) = self.optimum(from.problem.retract(&from.values, step), solver)? else { return Ok(None) };
        for (id, first) in &self.blocks {
            let pairs = from.values.get(*id).iter().zip(best.get(*id));
            step[*first..].iter_mut().zip(pairs).for_each(|(entry, (from, to))| *entry = to - from);
        }
        Ok(Some(best))
    }

    /// The given values with the linear blocks at their optimum. Nothing where the model has no value.
    ///
    /// # Errors
    /// As [`LinearPart::follow`].
    pub fn optimum(&self, values: Values, solver: &'static str) -> Result<Option<Values>, Unsupported> {
        let Ok(here) = Point::new(&self.problem, values, Vec::new()) else { return Ok(None) };
        let mut here = here.for_cost_alone();
        let (step, predicted) = here.full_step();
        let there = here.attempt(&step, predicted);
        match there.actual.is_finite() {
            false => Ok(None),
            true if as_foretold(&here, &there) || self.is_straight(&here, &step, &there.values) => {
                Ok(Some(there.values))
            }
            true => Err(Unsupported { solver, reason: not_affine(self.culprit(&here, &step)) }),
        }
    }

    /// Whether the residual halfway along a step is the mean of those at both ends, but for rounding.
    fn is_straight(&self, here: &Point<'_>, step: &[f64], there: &Values) -> bool {
        let half: Vec<f64> = step.iter().map(|entry| 0.5 * entry).collect();
        let halfway = self.problem.retract(&here.values, &half);
        let residuals = |values: &Values| self.problem.residuals(values).ok();
        let [Some(start), Some(middle), Some(end)] = [&here.values, &halfway, there].map(residuals) else {
            return false;
        };
        let norm = |of: &dyn Fn(usize) -> f64| (0..start.len()).map(|row| of(row).powi(2)).sum::<f64>().sqrt();
        let bent = norm(&|row| middle[row] - 0.5 * (start[row] + end[row]));
        bent <= WRONG_RESIDUAL * norm(&|row| end[row] - start[row]) + WRONG_TERMS * terms(here, there)
    }

    /// The block with which, moved one after the other, the cost is no longer the one foretold.
    fn culprit(&self, here: &Point<'_>, step: &[f64]) -> &str {
        let mut part = vec![0.0; step.len()];
        let mut name = "";
        for (id, _) in &self.blocks {
            name = &self.problem.block(*id).name;
            let columns = self.problem.columns_of(*id);
            part[columns.clone()].copy_from_slice(&step[columns]);
            if !as_foretold(here, &here.attempt(&part, here.predicted(&part))) {
                break;
            }
        }
        name
    }
}

/// Whether a block is solved for linearly.
pub(crate) fn is_linear(problem: &Problem, id: BlockId) -> bool {
    let block = problem.block(id);
    block.linear && block.fixed.is_none()
}

/// Whether the cost fell as an affine residual's does, but for rounding.
fn as_foretold(here: &Point<'_>, there: &Trial<'_>) -> bool {
    let residual = (2.0 * here.cost()).sqrt();
    let wrong = WRONG_RESIDUAL * residual + WRONG_TERMS * terms(here, &there.values);
    (there.actual - there.predicted).abs() <= wrong * (residual + wrong)
}

/// Sum of the linear terms, the larger of both points'.
fn terms(here: &Point<'_>, there: &Values) -> f64 {
    let of_column = |(column, scale): (&Column, &f64)| {
        let size = |values: &Values| values.get(column.block)[column.index].abs();
        scale * size(&here.values).max(size(there))
    };
    here.problem.columns().iter().zip(&here.scaling).map(of_column).sum()
}

fn not_affine(name: &str) -> String {
    format!("the residuals are not affine in `{name}`, which is marked as linear: remove the mark")
}
