//! What instruments sense of gravity: one file a quantity.

use std::fmt::Debug;

use gravcal_estimation::BlockId;
use nalgebra::Vector3;

/// What an instrument senses of gravity in its frame.
pub trait SensedQuantity: Debug + Send + Sync {
    /// How many components it has: axes of the instrument.
    fn axes(&self) -> usize;

    /// Blocks of the unknowns that are its own, in the order of their columns.
    fn blocks(&self) -> Vec<BlockId>;

    /// `u`, with its derivatives. `gravity`: v, m/s²; `own`: the values of its blocks.
    fn sense(&self, gravity: &Vector3<f64>, own: &[f64]) -> Sensed;
}

/// Value and derivatives of a [`SensedQuantity`], one entry an axis.
#[derive(Clone, Debug)]
pub struct Sensed {
    /// `u`.
    pub value: Vec<f64>,
    /// By gravity in the instrument's frame.
    pub by_gravity: Vec<Vector3<f64>>,
    /// By its own unknowns.
    pub by_own: Vec<Vec<f64>>,
}
