//! The sensor parameters of a joint: names, units and conventions, in one place.

use std::fmt;

/// One of the four parameters of a joint's affine sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// `k` of `reading = k · torque + b` (paper, eq. (8)).
    TorqueGain = 0,
    /// `b` of the same.
    TorqueBias = 1,
    /// `s` of `coordinate = s · reading + o` (paper, eq. (3)).
    PositionGain = 2,
    /// `o` of the same.
    PositionOffset = 3,
}

impl Quantity {
    /// All four, in the order in which a joint's parameters are stored.
    pub const ALL: [Quantity; 4] =
        [Quantity::TorqueGain, Quantity::TorqueBias, Quantity::PositionGain, Quantity::PositionOffset];

    /// The name in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Quantity::TorqueGain => "torque_gain",
            Quantity::TorqueBias => "torque_bias",
            Quantity::PositionGain => "position_gain",
            Quantity::PositionOffset => "position_offset",
        }
    }

    /// The equation in which the parameter stands.
    pub fn convention(self) -> &'static str {
        match self {
            Quantity::TorqueGain | Quantity::TorqueBias => "reading = torque_gain * torque + torque_bias",
            Quantity::PositionGain | Quantity::PositionOffset => {
                "coordinate = position_gain * reading + position_offset"
            }
        }
    }

    /// `joint1.torque_gain`.
    pub fn name(self, joint: &str) -> String {
        format!("{joint}.{}", self.as_str())
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
