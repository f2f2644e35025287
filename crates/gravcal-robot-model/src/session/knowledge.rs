//! What is known of a parameter beforehand.

/// What is known of one sensor parameter beforehand, in inside units.
///
/// The sign of `nominal` of a gain is the declared sign of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knowledge {
    /// Where the estimation starts.
    pub nominal: f64,
    /// How it is known.
    pub kind: KnowledgeKind,
}

/// How a parameter is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnowledgeKind {
    /// Only as a start.
    Start,
    /// As a prior with this standard deviation.
    Prior {
        /// In the parameter's unit.
        std: f64,
    },
    /// Exactly: held.
    Fixed,
}
