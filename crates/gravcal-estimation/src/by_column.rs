//! Directions of a problem's columns, for products of sparse rows with all of them at once.

use pulp::{Arch, NullaryFnOnce};

/// Sums that a processor adds to at once.
const SUMS: usize = 8;

/// Directions, the entries of all of them at one column side by side.
pub(crate) struct ByColumn {
    count: usize,
    entries: Vec<f64>,
    instructions: Arch,
}

impl ByColumn {
    /// `directions`: each over so many columns.
    pub fn of(directions: &[Vec<f64>], columns: usize) -> ByColumn {
        let at = |column: usize| directions.iter().map(move |direction| direction[column]);
        let entries = (0..columns).flat_map(at).collect();
        ByColumn { count: directions.len(), entries, instructions: Arch::new() }
    }

    /// How many directions there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The product of a row, of which column and entry are given where it is not zero, with each of them. The square of its length is returned.
    pub fn along(&self, row: impl IntoIterator<Item = (usize, f64)>, out: &mut [f64]) -> f64 {
        self.instructions.dispatch(Along { directions: self, row, out })
    }
}

struct Along<'a, I> {
    directions: &'a ByColumn,
    row: I,
    out: &'a mut [f64],
}

impl<I: IntoIterator<Item = (usize, f64)>> NullaryFnOnce for Along<'_, I> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Along { directions: ByColumn { count, entries, .. }, row, out } = self;
        out.fill(0.0);
        for (column, entry) in row {
            let directions = &entries[count * column..count * (column + 1)];
            out.iter_mut().zip(directions).for_each(|(sum, direction)| *sum += entry * direction);
        }
        let (chunks, rest) = out.as_chunks::<SUMS>();
        let mut sums = [0.0; SUMS];
        for chunk in chunks {
            sums.iter_mut().zip(chunk).for_each(|(sum, along)| *sum += along * along);
        }
        sums.iter().sum::<f64>() + rest.iter().map(|along| along * along).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sparse_row_is_multiplied_with_each_direction() {
        let directions: Vec<Vec<f64>> = (0..19).map(|k| vec![f64::from(k), 2.0, -f64::from(k)]).collect();
        let mut along = vec![7.0; 19];
        let square = ByColumn::of(&directions, 3).along([(0, 3.0), (2, 1.0)], &mut along);
        assert!((0..19_u32).zip(&along).all(|(k, along)| *along == 2.0 * f64::from(k)), "{along:?}");
        assert_eq!(square, (0..19).map(|k| f64::from(4 * k * k)).sum::<f64>());
    }
}
