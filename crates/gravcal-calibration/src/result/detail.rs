//! What pictures of a calibration need besides its numbers.

/// Details of an answer that no file holds.
#[derive(Clone, Debug, Default)]
pub struct Detail {
    /// Singular values of the Jacobian, whitened and its columns scaled to unit length, largest first.
    pub singular_values: Vec<f64>,
    /// Values of the result's `parameters`, in their order and units, after each iteration of its `trace`. Empty where the trace is,
    /// and where the estimate has failed.
    pub iterates: Vec<Vec<f64>>,
}
