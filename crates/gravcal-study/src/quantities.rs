//! The numbers whose errors a study measures.

use gravcal_calibration::joint::{Solved, State};
use gravcal_robot_model::Session;
use gravcal_robot_model::parameter::SensorParameter;

/// One number: a component of gravity, or a sensor parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// Component of gravity in base coordinates, m/s².
    Gravity(usize),
    /// Sensor parameter of a joint.
    Sensor(usize, SensorParameter),
}

/// Everything that the joint estimator estimates of sensors and gravity.
pub fn measured_quantities(session: &Session) -> Vec<Measured> {
    let sensors = (0..session.joints.len()).flat_map(|joint| SensorParameter::ALL.map(|q| Measured::Sensor(joint, q)));
    let free = sensors.filter(|m| match m {
        Measured::Sensor(joint, quantity) => session.fixed_reason(*joint, *quantity).is_none(),
        Measured::Gravity(_) => true,
    });
    (0..3).map(Measured::Gravity).chain(free).collect()
}

impl Measured {
    /// `gravity.x`, `joint1.torque_gain`.
    pub fn name(self, session: &Session) -> String {
        match self {
            Measured::Gravity(axis) => format!("gravity.{}", ["x", "y", "z"][axis]),
            Measured::Sensor(joint, quantity) => quantity.name(&session.robot.chain.joints()[joint].name),
        }
    }

    /// Unit inside the program.
    pub fn unit(self, session: &Session) -> String {
        match self {
            Measured::Gravity(_) => "m/s²".into(),
            Measured::Sensor(joint, quantity) => session.parameter_unit(joint, quantity),
        }
    }

    /// Its value among all unknowns.
    pub fn of(self, state: &State) -> f64 {
        match self {
            Measured::Gravity(axis) => state.gravity[axis],
            Measured::Sensor(joint, quantity) => state.sensors[joint][quantity as usize],
        }
    }

    /// Its standard deviation in a judged joint problem.
    pub fn std(self, solved: &Solved) -> f64 {
        match self {
            Measured::Gravity(axis) => solved.gravity_covariance()[4 * axis].max(0.0).sqrt(),
            Measured::Sensor(joint, quantity) => solved.sensor_std(joint, quantity),
        }
    }
}
