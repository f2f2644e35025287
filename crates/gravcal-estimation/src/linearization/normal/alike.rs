//! Passes over the components that are eliminated by reweighing their mixed rows (see [`super::group`]).
//!
//! Nothing of a component is kept from one pass to the next: to evaluate some at once again takes less time than to write and read what
//! couples them with the shared columns, and no memory.

use rayon::prelude::*;

use super::group::Group;
use super::products::Products;
use super::sums::Sums;
use crate::problem::{Chunk, Component, Kind, Rows};
use crate::{EvaluateError, LANES, Problem, Values};

/// Where such components are looked at.
#[derive(Clone, Copy)]
pub(crate) struct Alike<'p, 'v> {
    pub problem: &'p Problem,
    pub values: &'v Values,
    /// Columns that count as zeros.
    pub left_out: &'v [usize],
}

/// What their eliminated columns come to.
#[derive(Default)]
pub(super) struct EliminatedSums {
    /// `Jᵀr` and square of the norm of each eliminated column, component after component.
    pub columns: Vec<[f64; 2]>,
    /// The same of the shared columns.
    pub shared: Vec<[f64; 2]>,
    pub cost: f64,
}

/// Those among some components of a problem, one kind after another.
pub(super) fn runs_among<'p>(
    components: &'p [Component],
    problem: &'p Problem,
) -> impl Iterator<Item = &'p [Component]> + use<'p> {
    let kinds = &problem.structure().kinds;
    components.chunk_by(|a, b| a.kind == b.kind).filter(|run| kinds[run[0].kind].reweighed)
}

impl EliminatedSums {
    pub fn add(&mut self, other: EliminatedSums) {
        self.cost += other.cost;
        self.columns.extend(other.columns);
        for (sum, part) in self.shared.iter_mut().zip(&other.shared) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
    }
}

impl<'p> Alike<'p, '_> {
    /// Whether there are any.
    pub fn any(&self) -> bool {
        self.problem.structure().kinds.iter().any(|kind| kind.reweighed)
    }

    /// Those of a chunk, one kind after another.
    fn runs(&self, chunk: &Chunk) -> impl Iterator<Item = &'p [Component]> + use<'p> {
        runs_among(&self.problem.structure().components[chunk.components.clone()], self.problem)
    }

    /// Calls `found` with group after group of one kind, their rows loaded, and the groups' costs.
    fn for_groups(
        &self,
        rows: &mut Rows<'_>,
        run: &'p [Component],
        mut found: impl FnMut(&mut Group<'p>, &'p [Component], f64) -> Option<()>,
    ) -> Result<Option<()>, EvaluateError> {
        let mut group = Group::new(self.problem, self.kind(run));
        for components in run.chunks(LANES) {
            let cost = group.load(rows, components, self.left_out)?;
            if found(&mut group, components, cost).is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    fn kind(&self, run: &[Component]) -> &'p Kind {
        &self.problem.structure().kinds[run[0].kind]
    }

    /// What one pass over each chunk gives, in order; `None` where one of them gives up or cannot be evaluated.
    fn by_chunk<T: Send>(&self, pass: impl Fn(&mut Rows<'_>, &Chunk) -> Option<T> + Sync) -> Option<Vec<T>> {
        let run = |chunk: &Chunk| pass(&mut Rows::new(self.problem, self.values), chunk);
        let chunks = self.problem.structure().chunks.par_iter();
        let parts: Vec<Option<T>> = chunks.filter(|chunk| !chunk.components.is_empty()).map(run).collect();
        parts.into_iter().collect()
    }

    /// Sums over one chunk.
    pub(super) fn sum(&self, rows: &mut Rows<'_>, chunk: &Chunk) -> Result<EliminatedSums, EvaluateError> {
        let shared = vec![[0.0; 2]; self.problem.structure().shared.len()];
        let mut sums = EliminatedSums { shared, ..EliminatedSums::default() };
        for run in self.runs(chunk) {
            let columns = &self.kind(run).columns;
            let [mut gradient, mut squares] = [(); 2].map(|()| vec![[0.0; LANES]; columns.len()]);
            self.for_groups(rows, run, |group, _, cost| {
                sums.cost += cost;
                sums.columns.extend(group.eliminated_sums());
                group.add_shared(&mut gradient, &mut squares);
                Some(())
            })?;
            for (index, (slope, square)) in columns.iter().zip(gradient.iter().zip(&squares)) {
                sums.shared[*index][0] += slope.iter().sum::<f64>();
                sums.shared[*index][1] += square.iter().sum::<f64>();
            }
        }
        Ok(sums)
    }

    /// What reweighed rows add to the shared normal equations, by chunk. `None` where that would lose too many digits.
    pub(super) fn eliminate(&self, damping: &[f64]) -> Option<Vec<Sums>> {
        self.by_chunk(|rows, chunk| {
            let mut sums = Sums::new(self.problem.structure().shared.len());
            for run in self.runs(chunk) {
                let mut products = Products::new(self.kind(run));
                let done = self.for_groups(rows, run, |group, components, _| {
                    group.reweigh(components, damping)?;
                    products.take(group);
                    Some(())
                });
                done.ok()??;
                products.scatter(&mut sums);
            }
            Some(sums)
        })
    }

    /// What undamped elimination leaves of the components' rows, `‖J v‖²` for each of some vectors `v` over the shared columns. `None` where
    /// that would lose too many digits.
    pub fn reduced_image_norms_squared(&self, vectors: &[Vec<f64>]) -> Option<Vec<f64>> {
        let undamped = vec![0.0; self.problem.columns().len()];
        let parts = self.by_chunk(|rows, chunk| {
            let mut squares = vec![0.0; vectors.len()];
            for run in self.runs(chunk) {
                let done = self.for_groups(rows, run, |group, components, _| {
                    group.reweigh(components, &undamped)?;
                    for row in group.reweighed() {
                        let sums = squares.iter_mut().zip(vectors);
                        sums.for_each(|(sum, v)| *sum += row.image_norm_squared(&group.kind.columns, v));
                    }
                    Some(())
                });
                done.ok()??;
            }
            Some(squares)
        })?;
        Some((0..vectors.len()).map(|k| parts.iter().map(|part| part[k]).sum()).collect())
    }

    /// Writes the eliminated steps that follow from a shared one, and gives `‖J δ‖²` of the components' rows. `None` where that would lose too
    /// many digits.
    pub fn substitute(&self, damping: &[f64], shared: &[f64], step: &mut [f64]) -> Option<f64> {
        let parts = self.by_chunk(|rows, chunk| {
            let (mut steps, mut image) = (Vec::new(), 0.0);
            for run in self.runs(chunk) {
                let done = self.for_groups(rows, run, |group, components, _| {
                    group.substitute(components, damping, shared)?;
                    steps.extend(group.steps());
                    image += group.image_norm_squared();
                    Some(())
                });
                done.ok()??;
            }
            Some((steps, image))
        })?;
        let components = runs_among(&self.problem.structure().components, self.problem).flatten();
        let columns = components.flat_map(|component| &component.columns);
        let steps = parts.iter().flat_map(|(steps, _)| steps);
        columns.zip(steps).for_each(|(column, own)| step[*column] = *own);
        Some(parts.iter().map(|(_, image)| image).sum())
    }

    /// `‖J v‖²` of the components' rows; `shared`: the shared part of `v`.
    pub fn image_norm_squared(&self, v: &[f64], shared: &[f64]) -> f64 {
        let parts = self.by_chunk(|rows, chunk| {
            let mut image = 0.0;
            for run in self.runs(chunk) {
                let done = self.for_groups(rows, run, |group, components, _| {
                    group.set_step(components, v, shared);
                    image += group.image_norm_squared();
                    Some(())
                });
                done.ok()??;
            }
            Some(image)
        });
        // They were evaluated there before.
        parts.map_or(f64::NAN, |parts| parts.iter().sum())
    }

    /// Calls `found` with the entries of `JᵀJ` that the components' rows make.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub fn for_hessian(&self, mut found: impl FnMut(usize, usize, f64)) -> Result<(), EvaluateError> {
        let mut rows = Rows::new(self.problem, self.values);
        for run in self.problem.structure().chunks.iter().flat_map(|chunk| self.runs(chunk)) {
            self.for_groups(&mut rows, run, |group, components, _| {
                group.for_hessian(components, &mut found);
                Some(())
            })?;
        }
        Ok(())
    }
}
