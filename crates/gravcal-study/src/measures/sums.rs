//! Running sums, taken in the order of the table.

use super::{Measure, QuantityMeasures, REASONS, Series};
use crate::batch::{Cell, Row};

/// Mean and variance of numbers that come one after the other (Welford's recurrence).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mean {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Mean {
    pub fn add(&mut self, number: f64) {
        self.count += 1;
        let before = number - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (number - self.mean);
    }

    pub fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Of the mean; NaN for fewer than two numbers.
    pub fn standard_error(&self) -> f64 {
        match self.count {
            0 | 1 => f64::NAN,
            count => (self.squares / (count - 1) as f64 / count as f64).sqrt(),
        }
    }
}

/// Those of one quantity.
#[derive(Clone, Debug, Default)]
struct QuantitySums {
    error: Mean,
    square: Mean,
    to_bound: Mean,
    to_std: Mean,
    bound: Mean,
    inside: u64,
}

impl QuantitySums {
    fn add(&mut self, cell: &Cell) {
        if !cell.bound.is_nan() {
            self.bound.add(cell.bound * cell.bound);
        }
        // What was handed in is no estimate.
        let Some(inside) = cell.inside.filter(|_| cell.std > 0.0) else { return };
        let square = cell.error * cell.error;
        self.error.add(cell.error);
        self.square.add(square);
        if !cell.bound.is_nan() {
            self.to_bound.add(square / (cell.bound * cell.bound));
        }
        self.to_std.add(square / (cell.std * cell.std));
        self.inside += u64::from(inside);
    }

    fn measures(&self) -> QuantityMeasures {
        QuantityMeasures {
            estimates: self.error.count,
            bias: Measure::of(&self.error),
            rms: Measure::root_of(&self.square),
            ratio: Measure::root_of(&self.to_bound),
            nees: Measure::of(&self.to_std),
            coverage: Measure::share(self.inside, self.error.count),
            bound: self.bound.mean().sqrt(),
        }
    }
}

/// Those of one estimator at one point with one solver.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    outcomes: [u64; 3],
    iterations: Mean,
    reasons: Vec<(String, u64)>,
    quantities: Vec<QuantitySums>,
}

impl Sums {
    pub fn new(quantities: usize) -> Sums {
        Sums {
            outcomes: [0; 3],
            iterations: Mean::default(),
            reasons: Vec::new(),
            quantities: vec![QuantitySums::default(); quantities],
        }
    }

    pub fn add(&mut self, row: &Row) {
        self.outcomes[row.outcome as usize] += 1;
        self.iterations.add(row.iterations as f64);
        self.quantities.iter_mut().zip(&row.cells).for_each(|(sums, cell)| sums.add(cell));
        if let Some(reason) = &row.reason {
            match self.reasons.iter().position(|(known, _)| known == reason) {
                Some(place) => self.reasons[place].1 += 1,
                None if self.reasons.len() < REASONS => self.reasons.push((reason.clone(), 1)),
                None => {}
            }
        }
    }

    pub fn series(mut self, point: usize, estimator: usize, solver: usize) -> Series {
        self.reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        Series {
            point,
            estimator,
            solver,
            trials: self.outcomes.iter().sum(),
            outcomes: self.outcomes,
            iterations: Measure::of(&self.iterations),
            reasons: self.reasons,
            quantities: self.quantities.iter().map(QuantitySums::measures).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_error_are_those_of_the_definition() {
        let mut mean = Mean::default();
        [1.0, 2.0, 4.0, 9.0].into_iter().for_each(|number| mean.add(number));
        assert_eq!(mean.mean(), 4.0);
        let variance: f64 = [9.0, 4.0, 0.0, 25.0].iter().sum::<f64>() / 3.0;
        assert!((mean.standard_error() - (variance / 4.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn measures_are_those_of_the_cells() {
        let mut sums = QuantitySums::default();
        for (error, inside) in [(1.0, true), (-3.0, false)] {
            sums.add(&Cell { error, std: 2.0, bound: 1.0, inside: Some(inside) });
        }
        sums.add(&Cell::EMPTY);
        sums.add(&Cell { error: 0.0, std: 0.0, bound: 1.0, inside: Some(true) });
        let measures = sums.measures();
        assert_eq!((measures.estimates, measures.bias.value, measures.coverage.value), (2, -1.0, 0.5));
        assert!((measures.rms.value - 5f64.sqrt()).abs() < 1e-15);
        assert!((measures.ratio.value - 5f64.sqrt()).abs() < 1e-15);
        assert!((measures.nees.value - 1.25).abs() < 1e-15);
    }
}
