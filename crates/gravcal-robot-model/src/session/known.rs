//! What is known beforehand of gravity, links, loads and sensors.

use gravcal_recording::{PositionUnit, TorqueUnit};

use super::parameter_prior::ParameterPrior;
use crate::parameter::SensorParameter;

/// What is known of gravity beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityPrior {
    /// ‖g‖, m/s².
    pub magnitude: f64,
    /// Standard deviation of the magnitude, m/s²; `None` where it is taken as exact (gravity on the sphere).
    pub magnitude_std: Option<f64>,
    /// Rough direction of gravity in base coordinates, of unit length: settles the sign. `None`: it is sought everywhere.
    pub hemisphere: Option<[f64; 3]>,
}

impl GravityPrior {
    /// Gravity as it is assumed before anything is estimated: along the declared direction, or that of an upright base.
    pub fn assumed(&self) -> [f64; 3] {
        self.hemisphere.unwrap_or([0.0, 0.0, -1.0]).map(|component| self.magnitude * component)
    }

    /// The same with the opposite hemisphere, where one is declared.
    pub fn other_hemisphere(&self) -> GravityPrior {
        GravityPrior { hemisphere: self.hemisphere.map(|pole| pole.map(|component| -component)), ..*self }
    }
}

/// What is known of the links' masses and first moments.
#[derive(Clone, Debug, PartialEq)]
pub enum InertiaPrior {
    /// Nothing: the robot's values are only a start.
    Unknown,
    /// The robot's values of some links, as a prior.
    Model {
        /// Standard deviation relative to each value, by link, for example 0.1; `None`: nothing is known of the link.
        relative_std: Vec<Option<f64>>,
    },
    /// Nothing, and lengths are not used either: what hangs beyond each joint has a moment of its own in each sweep.
    Sweep,
}

/// A load at one placement.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Nominal, kg; no number (NaN) where it is to be found, see [`Load::is_unknown`]. See [`Session::load_mass`](super::Session::load_mass) for
    /// one that was weighed with an error.
    pub mass: f64,
    /// Index of the link that carries it.
    pub link: usize,
    /// Its centre of mass in the link's frame, m, where known.
    pub position: Option<[f64; 3]>,
    /// Standard deviation of each component of `position`, m; `None` with a position: exact.
    pub position_std: Option<f64>,
}

impl Load {
    /// Whether nothing is known of it but the link that carries it: a payload, whose mass, centre of mass and, in motion, tensor are answers.
    /// The link with it is then another body than the link without, and the payload the difference.
    pub fn is_unknown(&self) -> bool {
        self.mass.is_nan()
    }
}

/// A known distance between the centres of mass of two placements.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadDistance {
    /// Indices of the loads; both on one link.
    pub between: [usize; 2],
    /// m.
    pub distance: f64,
    /// Standard deviation, m; `None`: exact.
    pub std: Option<f64>,
}

/// What is known of one joint's sensors beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPriors {
    /// Unit of the torque reading; `None` where the joint has no torque sensor.
    pub torque_unit: Option<TorqueUnit>,
    /// Whether the session says which way the torque sensor reads; where not, it is looked for.
    pub torque_sign_declared: bool,
    /// Unit of the position reading.
    pub position_unit: PositionUnit,
    /// Knowledge of each parameter, in the order of [`SensorParameter::ALL`].
    pub parameters: [ParameterPrior; 4],
}

impl JointPriors {
    /// What is known of one parameter of the joint.
    pub fn of(&self, quantity: SensorParameter) -> ParameterPrior {
        self.parameters[quantity as usize]
    }
}
