//! How many blocks tell a function of the parameters, by what each of them tells of the determined directions.

use super::projected::Projected;

/// What tells how many blocks tell a function of the parameters.
#[derive(Clone, Debug)]
pub(super) struct DeterminedByBlocks {
    directions: Vec<Vec<f64>>,
    /// Whitened rows of each block along these.
    rows: Vec<Vec<Vec<f64>>>,
}

impl DeterminedByBlocks {
    pub fn new(directions: Vec<Vec<f64>>, rows: Vec<Vec<Vec<f64>>>) -> DeterminedByBlocks {
        DeterminedByBlocks { directions, rows }
    }

    /// Degrees of freedom of a linear function of the shared columns: `G* − 1` (of `jackknife.rs`), at least 1; infinite where blocks tell nothing of it.
    pub fn freedom(&self, function: &[(usize, f64)]) -> f64 {
        let c = Projected::of_function(&self.directions, function);
        let along = |row: &Vec<f64>| row.iter().zip(&c).map(|(z, c)| z * c).sum::<f64>();
        let reported = |rows: &Vec<Vec<f64>>| rows.iter().map(|row| along(row).powi(2)).sum::<f64>();
        let squares: f64 = self.rows.iter().map(|rows| reported(rows).powi(2)).sum();
        let total: f64 = c.iter().map(|c| c * c).sum();
        if squares > 0.0 { (total * total / squares - 1.0).max(1.0) } else { f64::INFINITY }
    }
}
