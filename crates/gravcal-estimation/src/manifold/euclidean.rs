//! All of ℝⁿ: the manifold of blocks that are on no other.

use super::Manifold;

/// Stored and tangent coordinates are the same.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Euclidean;

impl Manifold for Euclidean {
    fn name(&self) -> &str {
        "Euclidean space"
    }

    fn tangent_dimension(&self, stored: usize) -> usize {
        stored
    }

    fn retract(&self, x: &mut [f64], step: &[f64]) {
        x.iter_mut().zip(step).for_each(|(x, d)| *x += d);
    }

    fn basis(&self, x: &[f64], basis: &mut [f64]) {
        basis.iter_mut().enumerate().for_each(|(k, entry)| *entry = f64::from(k % (x.len() + 1) == 0));
    }

    fn check(&self, _x: &[f64]) -> Result<(), String> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_manifold;

    #[test]
    fn a_step_is_added() {
        check_manifold(&Euclidean, &[3.0, -0.5, 20.0], 1e-9).unwrap();
    }
}
