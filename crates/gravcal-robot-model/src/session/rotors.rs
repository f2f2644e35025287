//! Inertias of the joints' rotors as parameters of a session.
//!
//! ```text
//!     reading = torque_gain * (torque + rotor_inertia * acceleration) + …
//! ```
//!
//! What a motor turns before its gear, felt at the joint: the inertia of its rotor times the ratio squared. It belongs where a torque is the
//! motor's own, as its current tells; a sensor behind the gear does not feel it.

use gravcal_dynamics::{Joint, JointKind};

use super::contents::Session;
use super::parameter_prior::{ParameterPrior, PriorKind};
use super::parameters::GIVEN;
use super::pose::Pose;
use crate::parameter::{Limit, Parameter, ParameterId, SensorParameter};

/// The unit of a joint's rotor inertia.
pub fn rotor_inertia_unit(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "kg·m²",
        JointKind::Prismatic => "kg",
    }
}

/// The rotor inertia of the joint of this index, of which so much is known (kg·m², kg where it slides).
pub fn rotor_inertia_parameter(index: usize, joint: &Joint, prior: ParameterPrior) -> Parameter {
    Parameter {
        owner: joint.name.clone(),
        quantity: "rotor_inertia".into(),
        unit: rotor_inertia_unit(joint.kind).into(),
        convention: "reading = torque_gain * (torque + rotor_inertia * acceleration) + torque_bias".into(),
        prior,
        fixed: (prior.kind == PriorKind::Fixed).then_some(GIVEN),
        limit: Limit::HalfSpread { channel: index },
        cure: "move the joint with other accelerations while the joints before it move, too; a first joint's cannot be told from its link's \
               inertia: state it"
            .into(),
        linear: true,
        same_as: None,
    }
}

impl Session {
    /// Says what is known of the rotor inertia of one joint, kg·m² (kg where it slides), behind all further parameters.
    pub fn set_rotor_inertia(&mut self, joint: usize, prior: ParameterPrior) {
        self.rotors.resize(self.joints.len(), None);
        self.rotors[joint] = Some(self.further.len());
        self.further.push(rotor_inertia_parameter(joint, &self.robot.chain.joints()[joint], prior));
    }

    /// The joint whose rotor inertia a further parameter is.
    pub fn rotor_of(&self, further: usize) -> Option<usize> {
        self.rotors.iter().position(|place| *place == Some(further))
    }

    /// By how much, at most, a unit of a joint's rotor inertia changes its reading; 1 where it never accelerates.
    pub(super) fn lever_of_rotor(&self, joint: usize) -> f64 {
        let gain = self.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
        let acceleration = |pose: &Pose| pose.conditions.acceleration.get(joint).map_or(0.0, |a| gain * a.abs());
        let largest = self.poses.iter().map(acceleration).filter(|a| a.is_finite()).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }
}
