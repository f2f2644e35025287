//! A covariance together with what its intervals are made of.

use super::bootstrap::Replicates;
use super::determined_by_blocks::DeterminedByBlocks;
use super::sandwich::Freedom;
use super::{Covariance, Quantile};

/// How far an estimate may be from the truth. Made by [`Uncertainty::from_noise`], [`Uncertainty::sandwich`],
/// [`Uncertainty::jackknife`] or [`Bootstrap::new`](super::Bootstrap::new); which of them is the caller's to tell.
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
    /// The same, with the number of blocks that tell the function.
    LeftOut(DeterminedByBlocks),
    /// Steps from the estimate to that of each replicate.
    Replicates(Replicates),
    /// That of whichever of two has the larger standard deviation of the function.
    Larger(Box<[Uncertainty; 2]>),
}

impl Uncertainty {
    pub(super) fn with_quantile(covariance: Covariance, quantile: Quantile) -> Uncertainty {
        Uncertainty { covariance, spread: Spread::Quantile(quantile) }
    }

    /// The covariance of the columns.
    pub fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    /// The same with the standard deviation of each column multiplied by its factor. Replicates stay as they are: they solve again, and
    /// do not rest on what is linear at the estimate.
    #[must_use]
    pub fn widened(self, factors: &[f64]) -> Uncertainty {
        match self.spread {
            Spread::Replicates(_) => self,
            spread => Uncertainty { covariance: self.covariance.widened(factors), spread },
        }
    }

    /// The same with the standard deviation of each column multiplied by its factor, columns that move together moving so still
    /// ([`Covariance::errors_of`]). Replicates stay as they are, as in [`Uncertainty::widened`].
    #[must_use]
    pub fn widened_together(self, factors: &[Option<f64>]) -> Uncertainty {
        match self.spread {
            Spread::Replicates(_) => self,
            spread => {
                let errors = self.covariance.errors_of(factors);
                Uncertainty { covariance: self.covariance.with_systematic(&errors), spread }
            }
        }
    }

    /// The same where errors move the columns by so much each that no solution contains, those of replicates as little as the estimate: their
    /// percentiles say nothing of it, and intervals are symmetric.
    #[must_use]
    pub fn with_systematic(self, moved: &[Vec<f64>]) -> Uncertainty {
        if moved.iter().flatten().all(|moved| *moved == 0.0) {
            return self;
        }
        let covariance = self.covariance.with_systematic(moved);
        let spread = match self.spread {
            Spread::Replicates(replicates) => Spread::Quantile(replicates.quantile()),
            spread => spread,
        };
        Uncertainty { covariance, spread }
    }

    /// This uncertainty with the standard deviation of every column at least that of another: correlations stay as they are here, and the
    /// quantile of a function is that of whichever of the two has the larger standard deviation of it.
    #[must_use]
    pub fn larger_of(self, other: Uncertainty) -> Uncertainty {
        let factors: Vec<f64> =
            other.covariance.ratios_to(&self.covariance).iter().map(|ratio| ratio.max(1.0)).collect();
        let covariance = self.covariance.widened(&factors);
        Uncertainty { covariance, spread: Spread::Larger(Box::new([self, other])) }
    }

    /// 95 % interval of a function with this value, linear near the estimate (see [`Covariance::linearized`]).
    pub fn interval(&self, value: f64, function: &[(usize, f64)]) -> [f64; 2] {
        match &self.spread {
            Spread::Replicates(replicates) => replicates.percentiles(function).map(|offset| value + offset),
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
            Spread::Quantile(quantile) => *quantile,
            Spread::Replicates(replicates) => replicates.quantile(),
            Spread::Blocks(freedom) => Quantile::student(freedom.of(function)),
            Spread::LeftOut(reported) => Quantile::student(reported.freedom(&self.covariance.shared(function))),
            Spread::Larger(both) => {
                let [a, b] = both.as_ref();
                let larger = if a.covariance.std_of(function) < b.covariance.std_of(function) { b } else { a };
                larger.quantile(function)
            }
        }
    }
}
