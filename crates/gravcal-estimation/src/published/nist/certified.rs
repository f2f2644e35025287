//! What NIST certifies.

/// The certified values of a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct Certified {
    /// b1, b2, …
    pub parameters: Vec<f64>,
    /// One a parameter.
    pub standard_deviations: Vec<f64>,
    /// Σ r².
    pub sum_of_squares: f64,
    /// √(Σ r² / degrees of freedom).
    pub residual_standard_deviation: f64,
    /// Observations less parameters.
    pub degrees_of_freedom: f64,
}
