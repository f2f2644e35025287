//! A data set's residuals.

use super::models::Model;
use crate::Number;

/// Observations and the model of their responses.
#[derive(Clone, Debug)]
pub(crate) struct Regression {
    pub(super) model: Model,
    /// One an observation.
    pub(super) responses: Vec<f64>,
    /// Observation by observation.
    pub(super) predictors: Vec<f64>,
}

impl Regression {
    /// Prediction minus response, one row an observation.
    pub(crate) fn evaluate<N: Number>(&self, b: &[N], residual: &mut [N]) {
        let predictors = self.predictors.chunks_exact(self.model.predictors());
        for ((row, response), x) in residual.iter_mut().zip(&self.responses).zip(predictors) {
            *row = self.model.predict(b, x) - *response;
        }
    }
}
