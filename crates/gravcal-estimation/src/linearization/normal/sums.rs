//! Sums over the factors: rows of one shape that touch the same columns wait in batches, each of which makes one small matrix product.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::super::vector_registers::give_up_upper_halves;
use super::alike::{Alike, EliminatedSums};
use super::components::ComponentSums;
use crate::problem::{Chunk, Rows};
use crate::{EvaluateError, Problem, Values};

/// Rows of the same columns that are multiplied at once.
const BATCH: usize = 64;

/// Sums over the factors of one chunk.
pub(super) struct Sums {
    pub cost: f64,
    /// Lower triangle over the shared columns.
    pub hessian: Mat<f64>,
    pub gradient: Vec<f64>,
    /// Of those components that are not alike.
    pub components: Vec<ComponentSums>,
    /// Of all others, whose rows are in none of the above.
    pub alike: EliminatedSums,
}

impl Sums {
    pub fn new(shared: usize) -> Self {
        Sums {
            cost: 0.0,
            hessian: Mat::zeros(shared, shared),
            gradient: vec![0.0; shared],
            components: Vec::new(),
            alike: EliminatedSums { shared: vec![[0.0; 2]; shared], ..EliminatedSums::default() },
        }
    }

    pub fn add(&mut self, other: Sums) {
        self.cost += other.cost;
        self.hessian += &other.hessian;
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(sum, part)| *sum += part);
        self.components.extend(other.components);
        self.alike.add(other.alike);
    }
}

/// Compact rows of one shape and place that wait for their product, and the sum of the products so far.
struct Batch<'p> {
    columns: &'p [usize],
    waiting: usize,
    multiplied: bool,
    memory: Memory,
}

/// Room that one batch after another uses.
#[derive(Default)]
struct Memory {
    /// Rows one after another, each its columns and the residual; what lies beyond those that wait is old.
    rows: Vec<f64>,
    /// Lower triangle of the sum, column-major.
    product: Vec<f64>,
}

impl<'p> Batch<'p> {
    fn new(columns: &'p [usize], mut memory: Memory) -> Self {
        let width = columns.len() + 1;
        grow(&mut memory.rows, BATCH * width);
        grow(&mut memory.product, width * width);
        Batch { columns, waiting: 0, multiplied: false, memory }
    }

    fn width(&self) -> usize {
        self.columns.len() + 1
    }

    /// Room for some more rows.
    fn next_rows(&mut self, count: usize) -> &mut [f64] {
        if self.waiting + count > BATCH {
            self.multiply();
        }
        let width = self.width();
        let start = self.waiting * width;
        self.waiting += count;
        &mut self.memory.rows[start..start + count * width]
    }

    /// Adds the product of the waiting rows, the residual their last column.
    fn multiply(&mut self) {
        let width = self.width();
        let rows = MatRef::from_column_major_slice(&self.memory.rows[..self.waiting * width], width, self.waiting);
        let product = MatMut::from_column_major_slice_mut(&mut self.memory.product[..width * width], width, width);
        let (lower, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        let accumulate = if self.multiplied { Accum::Add } else { Accum::Replace };
        matmul(product, lower, accumulate, rows, full, rows.transpose(), full, 1.0, Par::Seq);
        give_up_upper_halves();
        self.waiting = 0;
        self.multiplied = true;
    }

    /// Adds the sum of products to its places, and gives its room back.
    fn scatter(mut self, sums: &mut Sums) -> Memory {
        self.multiply();
        for (j, (column, product)) in
            self.columns.iter().zip(self.memory.product.chunks_exact(self.width())).enumerate()
        {
            let sum = sums.hessian.col_as_slice_mut(*column);
            self.columns[j..].iter().zip(&product[j..]).for_each(|(row, entry)| sum[*row] += entry);
            sums.gradient[*column] += product[self.columns.len()];
        }
        self.memory
    }
}

/// Room for so many numbers, whatever they are.
fn grow(room: &mut Vec<f64>, length: usize) {
    if room.len() < length {
        *room = vec![0.0; length];
    }
}

/// Sums one chunk of factors.
pub(super) fn sum_chunk(problem: &Problem, values: &Values, chunk: &Chunk) -> Result<Sums, EvaluateError> {
    let structure = problem.structure();
    // The step before was found by faer, too.
    give_up_upper_halves();
    let mut rows = Rows::new(problem, values);
    let mut sums = Sums::new(structure.shared.len());
    let mut batches: Vec<Vec<Batch<'_>>> = structure.shapes.iter().map(|_| Vec::new()).collect();
    let components = &structure.components[chunk.components.clone()];
    let mut shape = None;
    let mut spare = Vec::new();
    let mut free = structure.free_factors(chunk);
    while let Some(factor) = free.first() {
        let (count, cost) = rows.linearize_some(free)?;
        sums.cost += cost;
        // One shape after another, so that few batches are alive and stay in cache.
        let before = shape.replace(structure.shape_of[*factor]);
        if let Some(before) = before.filter(|before| Some(*before) != shape) {
            spare.extend(batches[before].drain(..).map(|batch| batch.scatter(&mut sums)));
        }
        collect(problem, &rows, *factor, count, &mut batches, &mut spare);
        free = &free[count..];
    }
    let mut position = vec![0; structure.shared.len()];
    for component in components.iter().filter(|component| !structure.kinds[component.kind].reweighed) {
        component.shared.iter().enumerate().for_each(|(at, index)| position[*index] = at);
        let mut own = ComponentSums::new(component);
        for factor in &structure.order[component.factors.clone()] {
            sums.cost += rows.linearize(*factor, true)?;
            own.add(problem, &rows, *factor, &position);
            collect(problem, &rows, *factor, 1, &mut batches, &mut spare);
        }
        sums.components.push(own);
    }
    batches.into_iter().flatten().for_each(|batch| drop(batch.scatter(&mut sums)));
    if components.iter().any(|component| structure.kinds[component.kind].reweighed) {
        sums.alike = Alike { problem, values, left_out: &[] }.sum(&mut rows, chunk)?;
    }
    Ok(sums)
}

/// Puts the rows of a factor, or of so many of which it is the first, into the batches of their shape.
fn collect<'p>(
    problem: &'p Problem,
    rows: &Rows<'_>,
    factor: usize,
    count: usize,
    batches: &mut [Vec<Batch<'p>>],
    spare: &mut Vec<Memory>,
) {
    let own = &mut batches[problem.structure().shape_of[factor]];
    if own.is_empty() {
        let lists = problem.column_lists(factor).iter();
        own.extend(lists.map(|columns| Batch::new(columns, spare.pop().unwrap_or_default())));
    }
    for (row, plan) in problem.plans(factor).iter().enumerate() {
        rows.gather(plan, row, own[plan.place].next_rows(count));
    }
}
