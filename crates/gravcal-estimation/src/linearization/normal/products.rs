//! Products of reweighed rows: rows of one length wait in batches, each of which makes one small matrix product.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, NullaryFnOnce};

use super::group::{Group, Reweighed};
use super::lanes::{Lanes, lanes};
use super::sums::Sums;
use crate::LANES;
use crate::linearization::vector_registers::give_up_upper_halves;
use crate::problem::Kind;

/// Groups of rows that are multiplied at once.
const BATCH: usize = 16;
/// Room of a column: a little more than a batch, so that not all columns compete for the same lines of the cache.
const STRIDE: usize = BATCH + 1;

/// Products of the rows of one kind. As each row has some of the kind's first columns, all are summed in one matrix.
pub(super) struct Products<'p> {
    kind: &'p Kind,
    instructions: Arch,
    /// One for each length of rows, in ascending order, and the batch of each row.
    batches: Vec<Batch>,
    batch_of: Vec<usize>,
    /// Lower triangle, column-major: the residual is the first column.
    product: Vec<f64>,
}

/// Rows that wait.
struct Batch {
    /// Number of columns, the residual included.
    width: usize,
    waiting: usize,
    /// Column-major.
    rows: Vec<Lanes>,
}

impl<'p> Products<'p> {
    pub fn new(kind: &'p Kind) -> Self {
        let mut widths: Vec<usize> = kind.widths.iter().map(|columns| columns + 1).collect();
        widths.dedup();
        let batch_of = kind.widths.iter().map(|columns| widths.partition_point(|width| *width <= *columns)).collect();
        let batch = |width: usize| Batch { width, waiting: 0, rows: vec![[0.0; LANES]; width * STRIDE] };
        let all = kind.columns.len() + 1;
        Products {
            kind,
            instructions: Arch::new(),
            batches: widths.into_iter().map(batch).collect(),
            batch_of,
            product: vec![0.0; all * all],
        }
    }

    /// Takes the rows of a group; components that are not there have rows of zeros.
    pub fn take(&mut self, group: &Group<'p>) {
        for (row, batch) in group.reweighed().zip(&self.batch_of) {
            let batch = &mut self.batches[*batch];
            if batch.waiting == BATCH {
                batch.multiply(&mut self.product, self.kind.columns.len() + 1);
            }
            self.instructions.dispatch(Push { batch, row });
        }
    }

    /// Adds the sum of products to its places.
    pub fn scatter(mut self, sums: &mut Sums) {
        let all = self.kind.columns.len() + 1;
        self.batches.iter_mut().for_each(|batch| batch.multiply(&mut self.product, all));
        let mut of_columns = self.product.chunks_exact(all);
        let slopes = of_columns.next().into_iter().flat_map(|first| &first[1..]);
        self.kind.columns.iter().zip(slopes).for_each(|(column, slope)| sums.gradient[*column] += slope);
        for (j, (column, product)) in self.kind.columns.iter().zip(of_columns).enumerate() {
            for (row, entry) in self.kind.columns[j..].iter().zip(&product[j + 1..]) {
                sums.hessian[(*row.max(column), *row.min(column))] += entry;
            }
        }
    }
}

struct Push<'a> {
    batch: &'a mut Batch,
    row: Reweighed<'a>,
}

impl NullaryFnOnce for Push<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.batch.push(&self.row);
    }
}

impl Batch {
    #[inline(always)]
    fn push(&mut self, row: &Reweighed<'_>) {
        let scaled = |entry: &Lanes| lanes(|lane| row.scale[lane] * entry[lane]);
        let entries = std::iter::once(row.residual).chain(row.entries);
        let out = self.rows[self.waiting..].iter_mut().step_by(STRIDE);
        out.zip(entries).for_each(|(out, entry)| *out = scaled(entry));
        self.waiting += 1;
    }

    /// Adds the product of the waiting rows to that of all columns, of which there are so many.
    fn multiply(&mut self, product: &mut [f64], all: usize) {
        let (rows, stride) = (self.waiting * LANES, STRIDE * LANES);
        let rows = MatRef::from_column_major_slice_with_stride(self.rows.as_flattened(), rows, self.width, stride);
        let product = MatMut::from_column_major_slice_mut(product, all, all);
        let product = product.submatrix_mut(0, 0, self.width, self.width);
        let (lower, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        matmul(product, lower, Accum::Add, rows.transpose(), full, rows, full, 1.0, Par::Seq);
        give_up_upper_halves();
        self.waiting = 0;
    }
}
