//! Normal random numbers.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

pub(super) fn normal(random: &mut impl Rng) -> f64 {
    random.sample(StandardNormal)
}
