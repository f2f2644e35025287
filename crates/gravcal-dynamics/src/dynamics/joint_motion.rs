//! How joints move.

/// How the joints that have a coordinate of their own move: one sample, or several at once. n numbers each.
#[derive(Clone, Copy, Debug)]
pub struct JointMotion<'a, L = f64> {
    /// rad or m.
    pub coordinates: &'a [L],
    /// rad/s or m/s.
    pub velocities: &'a [L],
    /// rad/s² or m/s².
    pub accelerations: &'a [L],
}
