//! A covariance together with what its intervals are made of.

use super::sandwich::Freedom;
use super::{Covariance, Quantile, StatisticsError};
use crate::{BlockId, Problem, Spectrum, Values, named_combinations};

/// A solved problem, as the statistics need it.
#[derive(Clone, Copy, Debug)]
pub struct Solution<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Where its cost is smallest.
    pub values: &'a Values,
    /// What the data determine there.
    pub spectrum: &'a Spectrum,
}

impl Solution<'_> {
    /// # Errors
    /// Where the problem has local blocks, which the scatter of samples cannot tell apart.
    pub(super) fn without_local(&self) -> Result<(), StatisticsError> {
        let local = |id: &BlockId| self.problem.block(*id).local && !self.problem.columns_of(*id).is_empty();
        match self.problem.block_ids().find(local) {
            Some(id) => Err(StatisticsError::Local(self.problem.block(id).name.clone())),
            None => Ok(()),
        }
    }

    /// A step by all columns in words.
    pub(super) fn name_direction(&self, step: &[f64]) -> String {
        let columns: Vec<usize> = (0..step.len()).collect();
        let named =
            named_combinations(self.problem, self.values, &columns, &self.spectrum.sparse(&columns, &[step.to_vec()]));
        named.first().map_or_else(String::new, ToString::to_string)
    }
}

/// How far an estimate may be from the truth. Made by [`Uncertainty::from_noise`], [`Uncertainty::sandwich`] or
/// [`Bootstrap::new`](super::Bootstrap::new); which of them is the caller's to tell.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    pub(super) covariance: Covariance,
    pub(super) spread: Spread,
}

/// What makes an interval.
#[derive(Clone, Debug)]
pub(super) enum Spread {
    /// One quantile for everything.
    Quantile(Quantile),
    /// Student's quantile, with freedom that depends on the function.
    Blocks(Freedom),
    /// Steps from the estimate to that of each replicate, by the problem's columns, and the quantile for a cone.
    Replicates(Vec<Vec<f64>>, Quantile),
}

impl Uncertainty {
    pub(super) fn with_quantile(covariance: Covariance, quantile: Quantile) -> Uncertainty {
        Uncertainty { covariance, spread: Spread::Quantile(quantile) }
    }

    /// The covariance of the columns.
    pub fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    /// 95 % interval of a function with this value, linear near the estimate (see [`Covariance::linearized`]).
    pub fn interval(&self, value: f64, function: &[(usize, f64)]) -> [f64; 2] {
        match &self.spread {
            Spread::Replicates(steps, _) => percentiles(steps, function).map(|offset| value + offset),
            _ => self.quantile(function).interval(value, self.covariance.std_of(function)),
        }
    }

    /// Radius of the disc that holds two coordinates with 95 % probability, where `function` is the one of larger
    /// standard deviation.
    pub fn cone(&self, function: &[(usize, f64)]) -> f64 {
        self.quantile(function).cone(self.covariance.std_of(function))
    }

    fn quantile(&self, function: &[(usize, f64)]) -> Quantile {
        match &self.spread {
            Spread::Quantile(quantile) | Spread::Replicates(_, quantile) => *quantile,
            Spread::Blocks(freedom) => Quantile::student(freedom.of(function)),
        }
    }
}

/// 2.5 % and 97.5 % of a function's steps, between neighbouring ones in proportion: of `n` steps the k-th stands for
/// `k/(n + 1)` (Davison and Hinkley, *Bootstrap methods and their application*, 1997, section 5.2.1).
fn percentiles(steps: &[Vec<f64>], function: &[(usize, f64)]) -> [f64; 2] {
    let along = |step: &Vec<f64>| function.iter().map(|(column, c)| c * step[*column]).sum();
    let mut offsets: Vec<f64> = steps.iter().map(along).collect();
    offsets.sort_by(f64::total_cmp);
    [0.025, 0.975].map(|share| {
        let place = (share * (offsets.len() as f64 + 1.0) - 1.0).clamp(0.0, offsets.len() as f64 - 1.0);
        let (below, above) = (place.floor() as usize, place.ceil() as usize);
        offsets[below] + (place - place.floor()) * (offsets[above] - offsets[below])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_stand_between_their_neighbours() {
        let steps: Vec<Vec<f64>> = (1..40).rev().map(|k| vec![0.0, f64::from(k)]).collect();
        assert_eq!(percentiles(&steps, &[(1, 2.0)]), [2.0, 78.0]);
        assert_eq!(percentiles(&steps, &[]), [0.0, 0.0]);
    }
}
