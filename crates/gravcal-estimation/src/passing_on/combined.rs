//! `Qᵀ r(x)`: linear combinations of the whitened residuals of some factors.

use std::collections::BTreeMap;

use faer::MatRef;

use crate::{BlockId, EvaluateError, Factor, LocalValues, Problem, Residual, RowsMut};

/// One row a combination.
#[derive(Clone, Debug)]
pub(super) struct Combined {
    blocks: Vec<BlockId>,
    parts: Vec<Part>,
    rows: usize,
}

/// What one factor contributes.
#[derive(Clone, Debug)]
struct Part {
    factor: Factor,
    /// First column of each of its blocks among its own columns, and their number.
    starts: Vec<usize>,
    /// Column of the combination for each of its own.
    columns: Vec<usize>,
    /// Row of the factor, row of the combination, coefficient.
    terms: Vec<(usize, usize, f64)>,
}

impl Combined {
    /// Some rows of a problem as they are.
    pub fn selected(problem: &Problem, rows: &[usize]) -> Self {
        Combined::of(problem, rows.iter().enumerate().map(|(to, row)| (*row, to, 1.0)), rows.len())
    }

    /// `combinations`: one row for each of `rows`, one column a combination.
    pub fn new(problem: &Problem, rows: &[usize], combinations: MatRef<'_, f64>) -> Self {
        let terms = rows
            .iter()
            .enumerate()
            .flat_map(|(index, row)| (0..combinations.ncols()).map(move |to| (*row, to, combinations[(index, to)])));
        Combined::of(problem, terms, combinations.ncols())
    }

    /// `terms`: row of the problem, row of the combination, coefficient.
    fn of(problem: &Problem, terms: impl Iterator<Item = (usize, usize, f64)>, rows: usize) -> Self {
        let mut by_factor: BTreeMap<usize, Vec<(usize, usize, f64)>> = BTreeMap::new();
        for (row, to, coefficient) in terms {
            let factor = problem.factor_of(row);
            let own = row - problem.rows_of(factor).start;
            by_factor.entry(factor).or_default().push((own, to, coefficient));
        }
        let mut blocks: Vec<BlockId> =
            by_factor.keys().flat_map(|factor| problem.factors()[*factor].residual.blocks()).copied().collect();
        blocks.sort_unstable();
        blocks.dedup();
        let starts = starts(problem, &blocks);
        let part = |(factor, terms): (usize, Vec<(usize, usize, f64)>)| {
            let factor = problem.factors()[factor].clone();
            let own = factor.residual.blocks();
            let first = |id: &BlockId| starts[blocks.partition_point(|other| other < id)];
            let columns = own.iter().flat_map(|id| first(id)..first(id) + problem.block(*id).len()).collect();
            Part { starts: self::starts(problem, own), columns, terms, factor }
        };
        Combined { parts: by_factor.into_iter().map(part).collect(), blocks, rows }
    }
}

/// First column of each block, and the number of columns.
fn starts(problem: &Problem, blocks: &[BlockId]) -> Vec<usize> {
    let mut starts = vec![0];
    blocks.iter().for_each(|id| starts.push(starts[starts.len() - 1] + problem.block(*id).len()));
    starts
}

impl Part {
    fn add(&self, x: &[f64], residual: &mut [f64], jacobian: Option<&mut RowsMut<'_>>) -> Result<(), EvaluateError> {
        let Factor { residual: model, noise, .. } = &self.factor;
        let own: Vec<f64> = self.columns.iter().map(|column| x[*column]).collect();
        let (own, width) = (LocalValues::new(&own, &self.starts), self.columns.len());
        let mut values = vec![0.0; model.len()];
        let mut entries = vec![0.0; if jacobian.is_some() { model.len() * width } else { 0 }];
        let rows = jacobian.is_some().then(|| RowsMut::new(&mut entries, width));
        model.evaluate(own, &mut values, rows)?;
        noise.whiten(&mut values, 1);
        self.terms.iter().for_each(|(row, to, coefficient)| residual[*to] += coefficient * values[*row]);
        let Some(jacobian) = jacobian else { return Ok(()) };
        noise.whiten(&mut entries, width);
        for (row, to, coefficient) in &self.terms {
            let out = jacobian.row(*to);
            let entries = &entries[row * width..(row + 1) * width];
            self.columns.iter().zip(entries).for_each(|(column, entry)| out[*column] += coefficient * entry);
        }
        Ok(())
    }
}

impl Residual for Combined {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        residual.fill(0.0);
        self.parts.iter().try_for_each(|part| part.add(x.as_slice(), residual, jacobian.as_mut()))
    }
}
