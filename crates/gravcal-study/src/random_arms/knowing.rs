//! What a session of a random arm says beforehand.

/// What the session says beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowing {
    /// Nominal sensors, and gravity's direction within 60°.
    Nominal,
    /// Nothing: torque gains start at 1 count/(N·m), biases at zero, and gravity may point anywhere.
    Nothing,
}
