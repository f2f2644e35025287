//! The named parameters of a session: those of the joints' sensors, and those of everything else that reads gravity.
//!
//! Every joint has the four of its affine sensors ([`SensorParameter`]). Whatever else has parameters (a term of a sensor's
//! model, an instrument that belongs to no joint) appends to [`Session::further`](crate::Session) what it calls them, in
//! which unit and equation, what is known of them, and when a number would be of use. From there on all are treated
//! alike: [`ParameterId`] names one of either kind.

use std::borrow::Cow;
use std::fmt;

use crate::session::ParameterPrior;

/// One of the four parameters of a joint's affine sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SensorParameter {
    /// `k` of `reading = k · torque + b` (paper, eq. (8)).
    TorqueGain = 0,
    /// `b` of the same.
    TorqueBias = 1,
    /// `s` of `coordinate = s · reading + o` (paper, eq. (3)).
    PositionGain = 2,
    /// `o` of the same.
    PositionOffset = 3,
}

impl SensorParameter {
    /// All four, in the order in which a joint's parameters are stored.
    pub const ALL: [SensorParameter; 4] = [
        SensorParameter::TorqueGain,
        SensorParameter::TorqueBias,
        SensorParameter::PositionGain,
        SensorParameter::PositionOffset,
    ];

    /// The name in files.
    pub fn as_str(self) -> &'static str {
        match self {
            SensorParameter::TorqueGain => "torque_gain",
            SensorParameter::TorqueBias => "torque_bias",
            SensorParameter::PositionGain => "position_gain",
            SensorParameter::PositionOffset => "position_offset",
        }
    }

    /// The equation in which the parameter stands.
    pub fn convention(self) -> &'static str {
        match self {
            SensorParameter::TorqueGain | SensorParameter::TorqueBias => "reading = torque_gain * torque + torque_bias",
            SensorParameter::PositionGain | SensorParameter::PositionOffset => {
                "coordinate = position_gain * reading + position_offset"
            }
        }
    }

    /// `joint1.torque_gain`.
    pub fn name(self, joint: &str) -> String {
        format!("{joint}.{}", self.as_str())
    }
}

impl fmt::Display for SensorParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Why a parameter of an axis that no column gives is fixed.
pub const UNREAD: &str = "the axis is not read";

/// A parameter of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ParameterId {
    /// Of a joint's affine sensors, by the joint's index.
    Sensor(usize, SensorParameter),
    /// By its place in [`Session::further`](crate::Session).
    Further(usize),
}

/// A parameter with everything that is said of it beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The joint or instrument that has it; tables gather parameters by it.
    pub owner: String,
    /// What it is, such as `torque_gain`.
    pub quantity: String,
    /// Unit inside the program.
    pub unit: String,
    /// The equation in which it stands.
    pub convention: Cow<'static, str>,
    /// What is known of it.
    pub prior: ParameterPrior,
    /// Why it is fixed and not estimated, if it is.
    pub fixed: Option<&'static str>,
    /// Standard deviation beyond which a number would mislead.
    pub limit: Limit,
    /// What would determine it where the data do not.
    pub cure: Cow<'static, str>,
    /// Whether readings are affine in it, together with all other linear unknowns: see
    /// [`Block::linear`](gravcal_estimation::Block::linear).
    pub linear: bool,
    /// The place in [`Session::further`](crate::Session) of the parameter that this one is the same as, where several sensors share it: only
    /// that one is told.
    pub same_as: Option<usize>,
}

impl Parameter {
    /// The same, held where nothing reads it.
    #[must_use]
    pub fn unread_unless(self, read: bool) -> Parameter {
        if read { self } else { Parameter { fixed: Some(UNREAD), ..self } }
    }

    /// `joint1.torque_gain`.
    pub fn name(&self) -> String {
        format!("{}.{}", self.owner, self.quantity)
    }
}

/// The place in `known` of a parameter that is the same as another one: of the same owner, by the same name.
///
/// # Errors
/// They are not said to be the same kind of number; in words.
pub fn same_in(known: &[Parameter], parameter: &Parameter) -> Result<Option<usize>, String> {
    let same = |other: &Parameter| other.owner == parameter.owner && other.quantity == parameter.quantity;
    let Some(place) = known.iter().position(same) else { return Ok(None) };
    let (first, name) = (&known[place], parameter.name());
    if first.unit != parameter.unit {
        return Err(format!(
            "{name} is shared, and in {} where it stands first: expected that unit, not {}",
            first.unit, parameter.unit
        ));
    }
    if first.limit != parameter.limit {
        return Err(format!("{name} is shared, and its limit is another where it stands first: give it the same"));
    }
    Ok(Some(first.same_as.unwrap_or(place)))
}

/// How uncertain a parameter may be for its number still to be of use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// This share of its nominal value.
    ShareOfNominal(f64),
    /// This much, in its unit.
    Absolute(f64),
    /// As much as changes the readings of a channel by half their spread.
    HalfSpread {
        /// See [`Session::channel_count`](crate::Session::channel_count).
        channel: usize,
    },
    /// As much as changes a joint's torque gain `k` by a tenth where its reading is half the spread `S` of the readings from
    /// its bias: `0.1 k / (S / 2k)ᵖ`.
    GainChange {
        /// Index of the joint.
        joint: usize,
        /// p.
        power: i32,
    },
}
