//! One term of the cost.

use std::sync::Arc;

use crate::{Noise, Residual};

/// A residual and how far it is to be trusted.
#[derive(Clone, Debug)]
pub struct Factor {
    /// The model, in the unit of the reading.
    pub residual: Arc<dyn Residual>,
    /// Covariance of the reading's error.
    pub noise: Noise,
}

impl Factor {
    /// Puts a residual and its noise together.
    pub fn new(residual: impl Residual + 'static, noise: Noise) -> Self {
        Factor { residual: Arc::new(residual), noise }
    }
}
