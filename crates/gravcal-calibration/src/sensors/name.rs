//! The sensor models that a session may name.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A model of a joint's torque or position sensor, beyond the affine one that every sensor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorModelName {
    /// The torque bias drifts linearly in time.
    TorqueBiasInTime,
    /// The torque bias drifts linearly with temperature.
    TorqueBiasWithTemperature,
    /// The torque gain depends on the torque.
    TorqueGainPolynomial,
    /// The torque reading depends on the side from which the joint came.
    CoulombFriction,
    /// The torque reading depends on the joint's velocity.
    ViscousFriction,
    /// The torque reading depends on other joints' torques.
    TorqueCrosstalk,
    /// The position reading runs unevenly: eccentricity, ripple.
    PositionHarmonics,
}

/// A condition of the poses that a model reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// When the pose was read.
    Time,
    /// How warm the sensor was.
    Temperature,
    /// How fast the joint moved.
    Velocity,
    /// From which side the joint came; its velocity tells, too.
    Direction,
}

impl SensorModelName {
    /// Every model.
    pub const ALL: [SensorModelName; 7] = [
        SensorModelName::TorqueBiasInTime,
        SensorModelName::TorqueBiasWithTemperature,
        SensorModelName::TorqueGainPolynomial,
        SensorModelName::CoulombFriction,
        SensorModelName::ViscousFriction,
        SensorModelName::TorqueCrosstalk,
        SensorModelName::PositionHarmonics,
    ];

    /// The name in files.
    pub fn as_str(self) -> &'static str {
        match self {
            SensorModelName::TorqueBiasInTime => "torque-bias-in-time",
            SensorModelName::TorqueBiasWithTemperature => "torque-bias-with-temperature",
            SensorModelName::TorqueGainPolynomial => "torque-gain-polynomial",
            SensorModelName::CoulombFriction => "coulomb-friction",
            SensorModelName::ViscousFriction => "viscous-friction",
            SensorModelName::TorqueCrosstalk => "torque-crosstalk",
            SensorModelName::PositionHarmonics => "position-harmonics",
        }
    }

    /// What the poses must say for it.
    pub fn need(self) -> Option<Need> {
        match self {
            SensorModelName::TorqueBiasInTime => Some(Need::Time),
            SensorModelName::TorqueBiasWithTemperature => Some(Need::Temperature),
            SensorModelName::CoulombFriction => Some(Need::Direction),
            SensorModelName::ViscousFriction => Some(Need::Velocity),
            SensorModelName::TorqueGainPolynomial
            | SensorModelName::TorqueCrosstalk
            | SensorModelName::PositionHarmonics => None,
        }
    }

    /// Whether it is a position sensor's; otherwise a torque sensor's.
    pub fn is_of_position(self) -> bool {
        self == SensorModelName::PositionHarmonics
    }

    /// Keys of the options that it takes.
    pub(crate) fn options(self) -> &'static [&'static str] {
        match self {
            SensorModelName::TorqueBiasWithTemperature => &["reference_degC"],
            SensorModelName::TorqueGainPolynomial => &["degree"],
            SensorModelName::TorqueCrosstalk => &["from"],
            SensorModelName::PositionHarmonics => &["orders"],
            SensorModelName::TorqueBiasInTime | SensorModelName::CoulombFriction | SensorModelName::ViscousFriction => {
                &[]
            }
        }
    }
}

impl fmt::Display for SensorModelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No sensor model has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("there is no sensor model `{name}`; known: {known}")]
pub struct UnknownSensorModel {
    name: String,
    known: String,
}

impl FromStr for SensorModelName {
    type Err = UnknownSensorModel;

    fn from_str(name: &str) -> Result<Self, UnknownSensorModel> {
        SensorModelName::ALL.into_iter().find(|model| model.as_str() == name).ok_or_else(|| UnknownSensorModel {
            name: name.to_owned(),
            known: SensorModelName::ALL.map(SensorModelName::as_str).join(", "),
        })
    }
}
