//! What pictures of a calibration need besides its numbers.

/// Details of an answer that no file holds.
#[derive(Clone, Debug, Default)]
pub struct Detail {
    /// Every reading that entered, by poses; empty where nothing could be fitted.
    pub predictions: Vec<Prediction>,
    /// Singular values of the Jacobian, whitened and its columns scaled to unit length, largest first.
    pub singular_values: Vec<f64>,
    /// Values of the result's `parameters`, in their order and units, after each iteration of its `trace`. Empty where the trace is,
    /// and where the estimate has failed.
    pub way: Vec<Vec<f64>>,
}

/// A reading beside what an estimate says that it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Index of the pose in the session.
    pub pose: usize,
    /// Joint, or axis of an instrument: see [`Session::channel_count`](crate::Session::channel_count).
    pub channel: usize,
    /// What was read, in the unit of the reading.
    pub reading: f64,
    /// What the estimate predicts, in that unit.
    pub predicted: f64,
    /// Standard deviation that the fit assumed, in that unit.
    pub std: f64,
}

impl Prediction {
    /// Prediction less reading, in the unit of the reading.
    pub fn residual(&self) -> f64 {
        self.predicted - self.reading
    }
}
