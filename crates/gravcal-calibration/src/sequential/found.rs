//! What a step of the sequential procedure leaves behind for the next.

use crate::result::Undetermined;

/// A value with its standard deviation, as one step found it: given what the steps before it froze.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frozen {
    /// In inside units.
    pub value: f64,
    /// Conditional on the frozen results of the steps before.
    pub std: f64,
}

/// Why a step gave nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// Why.
    pub why: String,
    /// What would help.
    pub cure: String,
}

impl Missing {
    pub(super) fn new(why: impl Into<String>, cure: impl Into<String>) -> Self {
        Missing { why: why.into(), cure: cure.into() }
    }

    /// The same as an entry of a result.
    pub(super) fn report(&self, parameters: Vec<String>) -> Undetermined {
        Undetermined { combination: parameters.join(", "), parameters, why: self.why.clone(), cure: self.cure.clone() }
    }
}

/// A step's outcome for one parameter.
pub type Found = Result<Frozen, Missing>;
