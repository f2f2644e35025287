//! What is known of a parameter beforehand.

/// What is known of one sensor parameter beforehand, in inside units.
///
/// The sign of `nominal` of a gain is the declared sign of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterPrior {
    /// Where the estimation starts.
    pub nominal: f64,
    /// How it is known.
    pub kind: PriorKind,
}

/// How a parameter is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PriorKind {
    /// Only as a start.
    Flat,
    /// As a prior with this standard deviation.
    Gaussian {
        /// In the parameter's unit.
        std: f64,
    },
    /// Exactly: held.
    Fixed,
}
