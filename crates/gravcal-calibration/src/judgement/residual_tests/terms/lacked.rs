//! What every term tells of itself.

use crate::judgement::residual_tests::columns::Columns;
use crate::result::ResidualTestKind;

/// A term that a model may lack.
pub trait Lacked {
    /// Columns it is looked for by, one for each coefficient; a term of all channels has the same ones in each.
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>>;

    /// Columns as a model of it has them: what drifts was at the beginning what the parameter says.
    fn as_modelled(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        self.columns(of, channel)
    }

    /// What these coefficients come to.
    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found;

    /// Whether anything real has such coefficients.
    fn may_be(&self, _of: &Columns, _channel: usize, _coefficients: &[f64]) -> bool {
        true
    }

    /// Whether one coefficient of all joints is looked for, too: what acts on all of them, or in all of them about the same.
    fn is_alike_in_all_joints(&self, _of: &Columns) -> bool {
        false
    }
}

/// What is found of a term.
pub struct Found {
    pub kind: ResidualTestKind,
    /// In the unit.
    pub size: f64,
    pub unit: String,
}

impl Found {
    pub fn new(kind: ResidualTestKind, size: f64, unit: impl Into<String>) -> Found {
        Found { kind, size, unit: unit.into() }
    }
}

/// What is said of what a test names.
pub struct Words {
    pub what: String,
    /// What to do about it.
    pub cure: String,
    /// What else may be so, where it widens intervals.
    pub beside: Option<&'static str>,
}

impl Words {
    pub fn new(what: impl Into<String>, cure: impl Into<String>) -> Words {
        Words { what: what.into(), cure: cure.into(), beside: None }
    }

    pub fn beside(self, beside: Option<&'static str>) -> Words {
        Words { beside, ..self }
    }
}
