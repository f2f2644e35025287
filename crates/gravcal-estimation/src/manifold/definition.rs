//! What a manifold is to an estimator.

use std::fmt::Debug;

/// The set that a block's values belong to, where that is not all of ℝⁿ.
///
/// A block is *stored* as `n` numbers; a step lives in the *tangent* space, which may have fewer dimensions `m`. Methods solve for the
/// step `d` and move by `x ⊞ d` ([`Manifold::retract`]); they never see the stored numbers. A manifold needs these two and the slope
/// between them, with
///
/// ```text
///     x ⊞ 0 = x,     B(x) = ∂(x ⊞ d)/∂d at d = 0,  n × m, of rank m
/// ```
///
/// (Hertzberg, Wagner, Frese and Schröder, *Integrating generic sensor fusion algorithms with sound state representations through
/// encapsulation of manifolds*, Information Fusion 14, 2013.) Standard deviations are those of the step, in its unit, and of
/// the stored numbers by way of `B`. [`check_manifold`](crate::check_manifold) compares `B` with differences of `⊞`.
///
/// A block is put on a manifold by [`Block::on`](crate::Block::on); without, it is Euclidean: `x ⊞ d = x + d`, and `B` is the identity.
pub trait Manifold: Debug + Send + Sync {
    /// What it is called in messages, such as `sphere`.
    fn name(&self) -> &str;

    /// Dimension `m` of the tangent space of a block stored in `stored` numbers.
    fn tangent_dimension(&self, stored: usize) -> usize;

    /// Moves `x`, `n` numbers in the unit of the block, by the tangent step `step`, `m` numbers; the result lies on the manifold.
    fn retract(&self, x: &mut [f64], step: &[f64]);

    /// Writes `∂x/∂step` at step zero to `basis`: `n × m`, row-major.
    fn basis(&self, x: &[f64], basis: &mut [f64]);

    /// Whether `x` lies on it.
    ///
    /// # Errors
    /// What is wrong with `x` or with the manifold itself, in words that follow *the value of the block*: `has no length`.
    fn check(&self, x: &[f64]) -> Result<(), String>;

    /// How long a step is that turns by one radian, in the unit of the step; `None` where steps turn nothing. Nobody can be farther off
    /// than a few of them.
    fn radian(&self) -> Option<f64> {
        None
    }
}
