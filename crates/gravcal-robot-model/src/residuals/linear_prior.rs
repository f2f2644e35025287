//! Quantities known together: those of an earlier calibration.
//!
//! ```text
//!     a_i Σ_j c_ij x_j = v_i        for all i, with a common covariance
//! ```
//!
//! `a_i` is 1, or a torque gain: readings tell masses and moments times that, far better than either by itself.
//! `x_j` are stored numbers of any blocks. A vector on a sphere has two rows, along its tangent plane at the known value.

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// One quantity: block, which of its numbers, and coefficient of each term; and its known value.
#[derive(Clone, Debug)]
pub struct KnownCombination {
    /// In the unit of `value` a unit of the number.
    pub terms: Vec<(BlockId, usize, f64)>,
    /// `a`: a number of one block; `None`: 1.
    pub times: Option<(BlockId, usize)>,
    /// `v`.
    pub value: f64,
}

/// Known values of linear functions of some blocks.
#[derive(Clone, Debug)]
pub struct LinearPrior {
    blocks: Vec<BlockId>,
    rows: Vec<Row>,
}

#[derive(Clone, Debug)]
struct Row {
    /// Block (by its place among the blocks), number in it and coefficient of each term.
    terms: Vec<(usize, usize, f64)>,
    times: Option<(usize, usize)>,
    value: f64,
}

impl LinearPrior {
    /// One row a quantity.
    pub fn new(quantities: Vec<KnownCombination>) -> Self {
        let read = |q: &KnownCombination| {
            q.terms.iter().map(|(id, ..)| *id).chain(q.times.map(|(id, _)| id)).collect::<Vec<BlockId>>()
        };
        let mut blocks: Vec<BlockId> = quantities.iter().flat_map(read).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let place = |id: BlockId| blocks.partition_point(|other| *other < id);
        let row = |q: KnownCombination| {
            let terms = q.terms.into_iter().map(|(id, component, c)| (place(id), component, c)).collect();
            Row { terms, times: q.times.map(|(id, component)| (place(id), component)), value: q.value }
        };
        let rows = quantities.into_iter().map(row).collect();
        LinearPrior { blocks, rows }
    }
}

impl Residual for LinearPrior {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        for (index, Row { terms, times, value }) in self.rows.iter().enumerate() {
            let sum: f64 = terms.iter().map(|(block, i, c)| c * x.block(*block)[*i]).sum();
            let factor = times.map_or(1.0, |(block, i)| x.block(block)[i]);
            residual[index] = factor * sum - value;
            if let Some(rows) = jacobian.as_mut() {
                let row = rows.row(index);
                terms.iter().for_each(|(block, i, c)| row[x.column(*block) + i] += factor * c);
                times.iter().for_each(|(block, i)| row[x.column(*block) + i] += sum);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    #[test]
    fn derivatives() {
        let ids = ids(&[3, 1, 2]);
        let terms = vec![(ids[2], 1, 0.5), (ids[0], 2, -2.0), (ids[0], 0, 1.0)];
        let along = KnownCombination { terms: terms.clone(), times: None, value: 3.0 };
        let alone = KnownCombination { terms: vec![(ids[1], 0, 1.0)], times: None, value: -1.0 };
        let product = KnownCombination { terms, times: Some((ids[1], 0)), value: 3.0 };
        let residual = LinearPrior::new(vec![along, alone, product]);
        assert_eq!(residual.blocks(), ids);
        check_at_random_points(&residual, &[3, 1, 2], &[0.0; 6]);
        let mut r = [0.0; 3];
        let x = LocalValues::new(&[1.0, 0.0, 2.0, 4.0, 0.0, 8.0], &[0, 3, 4, 6]);
        residual.evaluate(x, &mut r, None).unwrap();
        assert_eq!(r, [4.0 - 4.0 + 1.0 - 3.0, 5.0, 4.0 * (4.0 - 4.0 + 1.0) - 3.0]);
    }
}
