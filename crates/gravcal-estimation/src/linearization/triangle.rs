//! The triangular factor of a tall matrix that comes in rows: `R` of `[J r] = Q R`, in constant memory.

use faer::{Mat, MatRef};

use super::vector_registers::give_up_upper_halves;

/// Rows are factored together with the triangle when so many wait, as multiples of the width.
const PENDING: usize = 4;

/// Takes rows of `width` numbers and keeps the triangle of all so far.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    width: usize,
    /// Row-major, at most `width` of them once factored.
    rows: Vec<f64>,
}

impl Triangle {
    pub fn new(width: usize) -> Self {
        Triangle { width, rows: Vec::new() }
    }

    /// Adds rows, one after the other.
    pub fn push(&mut self, rows: &[f64]) {
        self.rows.extend_from_slice(rows);
        if self.rows.len() >= (1 + PENDING) * self.width * self.width.max(64) {
            self.factor();
        }
    }

    /// Replaces the rows by their triangle.
    pub fn factor(&mut self) {
        let count = self.rows.len() / self.width;
        let factored = MatRef::from_row_major_slice(&self.rows, count, self.width).qr();
        give_up_upper_halves();
        let r = factored.thin_R();
        self.rows.clear();
        for i in 0..r.nrows() {
            self.rows.extend((0..self.width).map(|j| if j < i { 0.0 } else { r[(i, j)] }));
        }
    }

    /// The rows as they are, of `width` numbers each.
    pub fn rows(&self) -> &[f64] {
        &self.rows
    }

    /// The rows as a matrix.
    pub fn matrix(&self) -> Mat<f64> {
        MatRef::from_row_major_slice(&self.rows, self.rows.len() / self.width, self.width).to_owned()
    }
}
