//! Evaluating the factors of a problem: residuals, cost, weights, and rows of the Jacobian.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::assembled::Problem;
use super::basis::Basis;
use super::structure::{Place, RowPlan, Shape, Structure};
use crate::batch::evaluate_batch;
use crate::noise::Weights;
use crate::reference::Pull;
use crate::{BlockId, EvaluateError, Factor, LANES, LocalValues, Loss, Noise, RowsMut, Values};

/// Factors evaluated by one task: fixed, so that the work is cut the same way on any number of threads.
const FACTORS_PER_BATCH: usize = 64;

impl Problem {
    /// Whitened residuals at `values`, one a row.
    ///
    /// # Errors
    /// Where a model has no value there, or gives one that is not finite.
    pub fn residuals(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        let mut out = vec![0.0; self.rows()];
        self.for_each_batch(values, &mut out, 1, |rows, mut factors, out| {
            let mut written = 0;
            while !factors.is_empty() {
                factors = &factors[rows.evaluate_some(factors)?..];
                out[written..][..rows.residual.len()].copy_from_slice(&rows.residual);
                written += rows.residual.len();
            }
            Ok(())
        })?;
        Ok(out)
    }

    /// Cost ½ Σ ρ of the whitened residuals, with ρ each factor's loss, and of the [reference](crate::Reference) if there is one.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn cost(&self, values: &Values) -> Result<f64, EvaluateError> {
        let of_factors = self.for_each_batch(values, &mut [], 0, |rows, mut factors, _| {
            let mut costs = Vec::with_capacity(factors.len());
            while !factors.is_empty() {
                let (some, rest) = factors.split_at(rows.evaluate_some(factors)?);
                costs.extend(rows.costs(some));
                factors = rest;
            }
            Ok(costs)
        })?;
        Ok(of_factors.iter().flatten().sum::<f64>() + Pull::of(self, values).cost())
    }

    /// Why the cost is zero, infinite or no number where it should be neither, in words: the factor that says most to it.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn costliest(&self, values: &Values) -> Result<String, EvaluateError> {
        let residuals = self.residuals(values)?;
        let size = |factor: usize| residuals[self.rows_of(factor)].iter().fold(0.0, |m: f64, r| m.max(r.abs()));
        let largest = (0..self.factors.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
        let at = self.reported_at(largest, values);
        Ok(format!("the largest residual, {:e} standard deviations, is of factor {largest} at {at}", size(largest)))
    }

    /// The values that a factor reads, by name.
    fn reported_at(&self, factor: usize, values: &Values) -> String {
        let reported = |id: &BlockId| format!("{} = {:?}", self.block(*id).name, values.get(*id));
        let at: Vec<String> = self.factors[factor].residual.blocks().iter().map(reported).collect();
        at.join(", ")
    }

    /// Weight ρ′ of every row: 1 where the reading counts fully, near 0 where its loss takes it for an outlier.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn weights(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        let residuals = self.residuals(values)?;
        let of_factor = |(index, factor): (usize, &Factor)| factor.weights(&residuals[self.rows_of(index)]);
        Ok(self.factors.iter().enumerate().flat_map(of_factor).collect())
    }

    /// Whitened `[J r]` by the tangent coordinates, before any loss: one row a residual, the residual last, row-major.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn augmented_jacobian(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        let width = self.columns.len() + 1;
        let mut out = vec![0.0; self.rows() * width];
        self.for_each_batch(values, &mut out, width, |rows, factors, mut out| {
            for factor in factors {
                rows.linearize(*factor, false)?;
                rows.check_jacobian(*factor)?;
                let (own, rest) = out.split_at_mut(self.rows_of(*factor).len() * width);
                own.chunks_exact_mut(width).enumerate().for_each(|(row, out)| rows.scatter(*factor, row, out));
                out = rest;
            }
            Ok(())
        })?;
        Ok(out)
    }

    /// What becomes of each whitened row `[J r]`, before any loss: `width` numbers that `make` writes, one row after another, and what it
    /// gives. It is handed column and entry where a row is not zero, and its residual. The rows themselves are kept nowhere.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub(crate) fn made_of_rows<T: Send>(
        &self,
        values: &Values,
        width: usize,
        make: impl Fn(&[(usize, f64)], f64, &mut [f64]) -> T + Sync,
    ) -> Result<(Vec<f64>, Vec<T>), EvaluateError> {
        let mut written = vec![0.0; self.rows() * width];
        let given = self.for_each_batch(values, &mut written, width, |rows, factors, mut out| {
            let (mut entries, mut given) = (Vec::new(), Vec::new());
            for factor in factors {
                rows.linearize(*factor, false)?;
                rows.check_jacobian(*factor)?;
                for row in 0..self.rows_of(*factor).len() {
                    let (own, rest) = out.split_at_mut(width);
                    entries.clear();
                    rows.for_columns(*factor, row, |column, entry| {
                        if entry != 0.0 {
                            entries.push((column, entry));
                        }
                    });
                    given.push(make(&entries, rows.residual(row), own));
                    out = rest;
                }
            }
            Ok(given)
        })?;
        Ok((written, given.into_iter().flatten().collect()))
    }

    /// `Jᵀ u` of the whitened Jacobian, before any loss, one entry a column; `u` has one a row.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn transposed_product(&self, values: &Values, u: &[f64]) -> Result<Vec<f64>, EvaluateError> {
        self.transposed_products(values, &[u]).map(|products| products.into_iter().flatten().collect())
    }

    /// The same of several `u`, for which the Jacobian is made once.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn transposed_products(&self, values: &Values, u: &[&[f64]]) -> Result<Vec<Vec<f64>>, EvaluateError> {
        // By column, as most columns of single poses are read by none of a batch.
        let of_batches = self.for_each_batch(values, &mut [], 0, |rows, factors, _| {
            let mut products = vec![BTreeMap::<usize, f64>::new(); u.len()];
            let mut stored = Vec::new();
            for factor in factors {
                rows.linearize(*factor, false)?;
                rows.check_jacobian(*factor)?;
                for (u, product) in u.iter().zip(&mut products) {
                    let own = &u[self.rows_of(*factor)];
                    if own.iter().any(|u| *u != 0.0) {
                        rows.sum(own, &mut stored);
                        rows.for_tangent(*factor, &stored, |column, entry| {
                            *product.entry(column).or_default() += entry;
                        });
                    }
                }
            }
            Ok(products)
        })?;
        let mut products = vec![vec![0.0; self.columns.len()]; u.len()];
        for of_batch in of_batches {
            for (sum, part) in products.iter_mut().zip(of_batch) {
                part.into_iter().for_each(|(column, part)| sum[column] += part);
            }
        }
        Ok(products)
    }

    /// Runs `task` on batches of factors in parallel, each writing only its own rows of `width` numbers; gives what they give, in order.
    fn for_each_batch<T: Send, F>(
        &self,
        values: &Values,
        out: &mut [f64],
        width: usize,
        task: F,
    ) -> Result<Vec<T>, EvaluateError>
    where
        F: Fn(&mut Rows<'_>, &[usize], &mut [f64]) -> Result<T, EvaluateError> + Sync,
    {
        let mut batches = Vec::new();
        let mut rest = out;
        for start in (0..self.factors.len()).step_by(FACTORS_PER_BATCH) {
            let end = (start + FACTORS_PER_BATCH).min(self.factors.len());
            let (batch, tail) = rest.split_at_mut((self.row_offsets[end] - self.row_offsets[start]) * width);
            batches.push((start..end, batch));
            rest = tail;
        }
        let run = |(factors, out): (Range<usize>, &mut [f64])| {
            task(&mut Rows::new(self, values), &factors.collect::<Vec<_>>(), out)
        };
        // The first error in the order of the factors, whichever task met its own first.
        let outcomes: Vec<Result<T, EvaluateError>> = if batches.len() < 4 {
            batches.into_iter().map(run).collect()
        } else {
            batches.into_par_iter().map(run).collect()
        };
        outcomes.into_iter().collect()
    }
}

/// What factors of one shape that are evaluated in a batch read, and their Jacobians: zero outside of their patterns.
#[derive(Default)]
struct BatchInputs {
    /// Only the first, where they have no eliminated blocks.
    inputs: [Inputs; LANES],
    jacobian: Vec<[f64; LANES]>,
}

/// What the factors of one shape read: shared blocks are copied once, eliminated ones for each factor.
#[derive(Default)]
struct Inputs {
    shape: Option<usize>,
    values: Vec<f64>,
}

impl Inputs {
    fn load(&mut self, problem: &Problem, values: &Values, factor: usize) {
        let index = problem.structure.shape_of[factor];
        let shape = &problem.structure.shapes[index];
        let blocks = problem.factors[factor].residual.blocks();
        if self.shape.replace(index) == Some(index) {
            for place in &shape.eliminated_blocks {
                let own = values.get(blocks[*place]);
                self.values[shape.local_offsets[*place]..][..own.len()].copy_from_slice(own);
            }
        } else {
            self.values.clear();
            blocks.iter().for_each(|id| self.values.extend_from_slice(values.get(*id)));
        }
    }
}

/// The rows of one factor after another, or of some at once, in buffers that are used again.
pub(crate) struct Rows<'a> {
    problem: &'a Problem,
    values: &'a Values,
    local: Inputs,
    /// Local stored columns of the factors that are loaded.
    width: usize,
    /// Rows by local stored columns, row-major.
    jacobian: Vec<f64>,
    /// The same of factors that were evaluated in a batch, by shape.
    batch: Vec<BatchInputs>,
    /// The shape that was evaluated in a batch last.
    batch_shape: usize,
    /// How many factors' rows are loaded: one, in `jacobian`, or some, in `batch`.
    loaded_factors: usize,
    /// The shape for which `jacobian` is zero outside of its patterns.
    cleared: Option<usize>,
    /// Whitened residuals, of one factor after the other.
    residual: Vec<f64>,
    residual_lanes: Vec<[f64; LANES]>,
    /// Factors that are still to be applied to each row of the Jacobian and to its residual.
    scales: Vec<(f64, f64)>,
    /// Tangent basis of each shared block on a manifold.
    bases: Vec<Basis>,
    /// The same of the eliminated ones that the factor reads which was linearized last.
    eliminated_bases: Vec<Basis>,
    /// What a manifold writes to.
    basis_rows: Vec<f64>,
}

impl<'a> Rows<'a> {
    pub fn new(problem: &'a Problem, values: &'a Values) -> Self {
        let buffer = Vec::new;
        let bases = problem.structure.curved.iter().map(|id| Basis::of(problem.block(*id), values.get(*id)));
        Rows {
            problem,
            values,
            local: Inputs::default(),
            width: 0,
            jacobian: buffer(),
            batch: std::iter::repeat_with(BatchInputs::default).take(problem.structure.shapes.len()).collect(),
            batch_shape: 0,
            loaded_factors: 1,
            cleared: None,
            residual: buffer(),
            residual_lanes: Vec::new(),
            scales: Vec::new(),
            bases: bases.collect(),
            eliminated_bases: Vec::new(),
            basis_rows: Vec::new(),
        }
    }

    fn load_values(&mut self, factor: usize) {
        self.local.load(self.problem, self.values, factor);
        self.width = self.local.values.len();
        self.loaded_factors = 1;
        self.residual.clear();
        self.residual.resize(self.problem.factors[factor].residual.len(), 0.0);
    }

    /// Loads the whitened residuals of the first of these factors, or of the first few at once, and nothing else; gives how many they are.
    pub fn evaluate_some(&mut self, factors: &[usize]) -> Result<usize, EvaluateError> {
        if let Some(some) = factors.first_chunk()
            && self.load_batch(some, false)?
        {
            return Ok(LANES);
        }
        self.evaluate(factors[0])?;
        Ok(1)
    }

    /// Costs of the factors whose residuals are loaded.
    fn costs(&self, factors: &[usize]) -> impl Iterator<Item = f64> {
        let own = self.residual.chunks_exact((self.residual.len() / factors.len()).max(1));
        factors.iter().zip(own).map(|(factor, own)| self.problem.factors[*factor].cost(own))
    }

    /// Loads the bases of the eliminated blocks on manifolds that a factor reads.
    fn load_eliminated_bases(&mut self, factor: usize) {
        let (problem, values) = (self.problem, self.values);
        let places = &problem.shape_of(factor).eliminated_curved;
        self.eliminated_bases.resize_with(places.len().max(self.eliminated_bases.len()), Basis::default);
        for (basis, place) in self.eliminated_bases.iter_mut().zip(places) {
            let id = problem.factors[factor].residual.blocks()[*place];
            basis.load(problem.block(id), values.get(id), &mut self.basis_rows);
        }
    }

    fn evaluate(&mut self, factor: usize) -> Result<(), EvaluateError> {
        self.load_values(factor);
        let Factor { residual: model, noise, .. } = &self.problem.factors[factor];
        let local = LocalValues::new(&self.local.values, &self.problem.shape_of(factor).local_offsets);
        model.evaluate(local, &mut self.residual, None)?;
        self.check_residual(factor, 0)?;
        noise.whiten(&mut self.residual, 1);
        Ok(())
    }

    /// Loads the whitened rows `[J r]` of a factor, with its loss if `with_loss`, and gives its cost.
    pub fn linearize(&mut self, factor: usize, with_loss: bool) -> Result<f64, EvaluateError> {
        self.load_values(factor);
        self.load_eliminated_bases(factor);
        let Factor { residual: model, noise, .. } = &self.problem.factors[factor];
        let offsets = &self.problem.shape_of(factor).local_offsets;
        let width = offsets[offsets.len() - 1];
        let shape = self.problem.structure.shape_of[factor];
        if self.cleared != Some(shape) {
            self.jacobian.clear();
            self.jacobian.resize(model.len() * width, 0.0);
            self.cleared = self.problem.structure.shapes[shape].patterned.then_some(shape);
        }
        let rows = RowsMut::new(&mut self.jacobian, width);
        model.evaluate(LocalValues::new(&self.local.values, offsets), &mut self.residual, Some(rows))?;
        self.check_residual(factor, 0)?;
        noise.whiten(&mut self.residual, 1);
        let cost = self.problem.factors[factor].cost(&self.residual);
        self.scales.clear();
        self.scale(factor, width, with_loss);
        Ok(cost)
    }

    /// The same with the loss of the first of these factors, or of the first few at once; gives how many they are, and their cost.
    pub fn linearize_some(&mut self, factors: &[usize]) -> Result<(usize, f64), EvaluateError> {
        let some = match factors.first_chunk() {
            Some(some) if self.load_batch(some, true)? => some,
            _ => return Ok((1, self.linearize(factors[0], true)?)),
        };
        self.scales.clear();
        let cost = self.costs(some).sum();
        some.iter().for_each(|factor| self.scale(*factor, self.width, true));
        Ok((LANES, cost))
    }

    /// Loads the whitened residuals of these factors and their Jacobians, if they can be evaluated in a batch.
    fn load_batch(&mut self, factors: &[usize; LANES], with_jacobian: bool) -> Result<bool, EvaluateError> {
        let Structure { shapes, shape_of, .. } = &*self.problem.structure;
        let index = shape_of[factors[0]];
        let shape = &shapes[index];
        if shape.correlated || factors.iter().any(|factor| shape_of[*factor] != index) {
            return Ok(false);
        }
        let (problem, values) = (self.problem, self.values);
        self.batch_shape = index;
        let BatchInputs { inputs, jacobian } = &mut self.batch[index];
        let x = if shape.eliminated_blocks.is_empty() {
            inputs[0].load(problem, values, factors[0]);
            [inputs[0].values.as_slice(); LANES]
        } else {
            inputs.iter_mut().zip(factors).for_each(|(own, factor)| own.load(problem, values, *factor));
            inputs.each_ref().map(|own| own.values.as_slice())
        };
        self.width = x[0].len();
        let all = factors.map(|factor| &*self.problem.factors[factor].residual);
        jacobian.resize(shape.rows.len() * self.width, [0.0; LANES]);
        self.residual_lanes.resize(shape.rows.len(), [0.0; LANES]);
        let x = x.map(|x| LocalValues::new(x, &shape.local_offsets));
        let jacobian = with_jacobian.then_some(&mut jacobian[..]);
        if !evaluate_batch(all, x, &mut self.residual_lanes, jacobian) {
            return Ok(false);
        }
        self.loaded_factors = LANES;
        self.residual.clear();
        for (lane, factor) in factors.iter().enumerate() {
            let start = self.residual.len();
            self.residual.extend(self.residual_lanes.iter().map(|lanes| lanes[lane]));
            self.check_residual(*factor, start)?;
            self.problem.factors[*factor].noise.whiten(&mut self.residual[start..], 1);
        }
        Ok(true)
    }

    /// Finds what is still to be applied to each of a factor's rows; correlated rows are whitened and corrected right away.
    fn scale(&mut self, factor: usize, width: usize, with_loss: bool) {
        let Factor { noise, loss, .. } = &self.problem.factors[factor];
        match noise {
            Noise::Independent(Weights(weights)) if with_loss && *loss != Loss::None => {
                // Those of the factors before have theirs.
                let residual = &self.residual[self.scales.len()..];
                self.scales.extend(weights.iter().zip(residual).map(|(weight, r)| {
                    let (residual, jacobian) = loss.at(r * r).correction(r * r);
                    (weight * jacobian, residual)
                }));
            }
            Noise::Independent(Weights(weights)) => self.scales.extend(weights.iter().map(|weight| (*weight, 1.0))),
            // Never batched: such rows have no patterns.
            Noise::Correlated(_) => {
                noise.whiten(&mut self.jacobian, width.max(1));
                if with_loss {
                    loss.correct_together(&mut self.jacobian, &mut self.residual);
                }
                self.scales.resize(self.residual.len(), (1.0, 1.0));
            }
        }
    }

    fn local_row(&self, row: usize) -> &[f64] {
        &self.jacobian[row * self.width..(row + 1) * self.width]
    }

    /// Local stored columns of a row of batched factors, still without their scales.
    pub fn local_row_lanes(&self, row: usize) -> &[[f64; LANES]] {
        &self.batch[self.batch_shape].jacobian[row * self.width..(row + 1) * self.width]
    }

    /// What is still to be applied to a row of the Jacobian, of each factor of the batch.
    pub fn scale_lanes(&self, row: usize) -> [f64; LANES] {
        let rows = self.residual_lanes.len();
        std::array::from_fn(|lane| self.scales[lane * rows + row].0)
    }

    /// Residuals of a row of batched factors, with everything applied.
    pub fn residual_lanes(&self, row: usize) -> [f64; LANES] {
        let rows = self.residual_lanes.len();
        std::array::from_fn(|lane| self.residual(lane * rows + row))
    }

    /// The tangent basis of a shared block on a manifold, by its place among [`Structure::curved`].
    pub fn basis(&self, curved: usize) -> &Basis {
        &self.bases[curved]
    }

    /// One stored column of a row of the one factor that is loaded.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.scales[row].0 * self.jacobian[row * self.width + column]
    }

    /// Residual of a row, with everything applied.
    pub fn residual(&self, row: usize) -> f64 {
        self.scales[row].1 * self.residual[row]
    }

    /// Writes the shared columns of a row of each loaded factor, compact, and its residual last.
    pub fn gather(&self, plan: &RowPlan, row: usize, out: &mut [f64]) {
        match self.loaded_factors {
            1 => self.gather_one(plan, row, out),
            _ => self.gather_lanes(plan, row, out),
        }
    }

    fn gather_lanes(&self, plan: &RowPlan, row: usize, out: &mut [f64]) {
        let (local, scales) = (self.local_row_lanes(row), self.scale_lanes(row));
        let mut out = out.chunks_exact_mut(plan.columns.len() + 1);
        let mut out: [&mut [f64]; LANES] = std::array::from_fn(|_| out.next().unwrap_or_default());
        let mut at = 0;
        for piece in &plan.pieces {
            let stored = &local[piece.from..];
            match piece.curved {
                None => spread_lanes(&stored[..piece.length], &scales, at, &mut out),
                Some(curved) => (0..piece.length).for_each(|index| {
                    spread_lanes(&[self.bases[curved].along_lanes(index, stored)], &scales, at + index, &mut out);
                }),
            }
            at += piece.length;
        }
        out.into_iter().zip(self.residual_lanes(row)).for_each(|(out, residual)| out[at] = residual);
    }

    fn gather_one(&self, plan: &RowPlan, row: usize, mut out: &mut [f64]) {
        let (scale, local) = (self.scales[row].0, self.local_row(row));
        for piece in &plan.pieces {
            let (own, rest) = out.split_at_mut(piece.length);
            let stored = &local[piece.from..];
            match piece.curved {
                None => own.iter_mut().zip(stored).for_each(|(out, v)| *out = scale * v),
                Some(curved) => own
                    .iter_mut()
                    .enumerate()
                    .for_each(|(index, out)| *out = scale * self.bases[curved].along(index, stored)),
            }
            out = rest;
        }
        out[0] = self.residual(row);
    }

    /// Calls `found(index, entry)` for the entries of a row in the columns of a component.
    pub fn for_component(&self, factor: usize, row: usize, mut found: impl FnMut(usize, f64)) {
        self.for_columns(factor, row, |column, entry| {
            if let Place::Component { index, .. } = self.problem.structure.places[column] {
                found(index, entry);
            }
        });
    }

    /// Writes a row over all columns, the residual last.
    fn scatter(&self, factor: usize, row: usize, out: &mut [f64]) {
        self.for_columns(factor, row, |column, entry| out[column] = entry);
        out[out.len() - 1] = self.residual(row);
    }

    /// The stored columns of a factor's rows, each row so many times, in one; without residuals.
    fn sum(&self, times: &[f64], stored: &mut Vec<f64>) {
        stored.clear();
        stored.resize(self.width, 0.0);
        for (row, times) in times.iter().enumerate() {
            let times = times * self.scales[row].0;
            stored.iter_mut().zip(self.local_row(row)).for_each(|(sum, entry)| *sum += times * entry);
        }
    }

    /// Calls `found(column, entry)` for the entries of a row in the tangent columns of the factor's free blocks.
    pub fn for_columns(&self, factor: usize, row: usize, mut found: impl FnMut(usize, f64)) {
        let scale = self.scales[row].0;
        self.for_tangent(factor, self.local_row(row), |column, entry| found(column, scale * entry));
    }

    /// Calls `found(column, entry)` for what numbers over a factor's stored columns are over the tangent columns of its free blocks.
    fn for_tangent(&self, factor: usize, local: &[f64], mut found: impl FnMut(usize, f64)) {
        let problem = self.problem;
        let shape = problem.shape_of(factor);
        let blocks = problem.factors[factor].residual.blocks();
        for (place, (id, from)) in blocks.iter().zip(&shape.local_offsets).enumerate() {
            let columns = problem.columns_of(*id);
            let stored = &local[*from..];
            if problem.block(*id).is_euclidean() {
                columns.zip(stored).for_each(|(column, entry)| found(column, *entry));
            } else {
                let basis = self.basis_of(shape, place, *id);
                columns.enumerate().for_each(|(index, column)| found(column, basis.along(index, stored)));
            }
        }
    }

    /// The tangent basis of a block on a manifold that the factor reads, in this place, which was linearized last.
    fn basis_of(&self, shape: &Shape, place: usize, id: BlockId) -> &Basis {
        match shape.eliminated_curved.binary_search(&place) {
            Ok(eliminated) => &self.eliminated_bases[eliminated],
            Err(_) => &self.bases[self.problem.structure.curved.partition_point(|curved| *curved < id)],
        }
    }

    /// Of the residuals from `start` on.
    fn check_residual(&self, factor: usize, start: usize) -> Result<(), EvaluateError> {
        let own = &self.residual[start..];
        match own.iter().position(|r| !r.is_finite()) {
            Some(row) => Err(self.not_finite(factor, format!("row {row} gives {}", own[row]))),
            None => Ok(()),
        }
    }

    /// Fails where an entry of the Jacobian that was loaded last is not finite.
    pub fn check_jacobian(&self, factor: usize) -> Result<(), EvaluateError> {
        let width = self.width.max(1);
        match self.jacobian.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(self.not_finite(factor, format!("the derivative of row {} is not finite", at / width))),
            None => Ok(()),
        }
    }

    fn not_finite(&self, factor: usize, what: String) -> EvaluateError {
        EvaluateError(format!("factor {factor}: {what} at {}", self.problem.reported_at(factor, self.values)))
    }
}

/// Writes each lane, times its scale, to its own row from `at` on.
#[inline]
fn spread_lanes(lanes: &[[f64; LANES]], scales: &[f64; LANES], at: usize, out: &mut [&mut [f64]; LANES]) {
    let range = at..at + lanes.len();
    let [a, b, c, d] = out;
    let (a, b, c, d) = (&mut a[range.clone()], &mut b[range.clone()], &mut c[range.clone()], &mut d[range]);
    for (k, lanes) in lanes.iter().enumerate() {
        a[k] = scales[0] * lanes[0];
        b[k] = scales[1] * lanes[1];
        c[k] = scales[2] * lanes[2];
        d[k] = scales[3] * lanes[3];
    }
}
