//! Compliances of the joints as parameters of a session.

use std::ops::Range;

use gravcal_dynamics::{Joint, JointKind};

use super::contents::Session;
use super::parameter_prior::{ParameterPrior, PriorKind};
use super::parameters::GIVEN;
use crate::parameter::{Limit, Parameter};

/// A compliance is told where its standard deviation is at most this share of what it was before any reading.
const OBSERVABLE: f64 = 0.5;

/// One compliance for each joint, zero give or take `std`, rad/(N·m); exactly zero where that is zero, and for joints that
/// slide.
pub fn compliance_parameters(joints: &[Joint], std: &[f64]) -> Vec<Parameter> {
    joints.iter().zip(std).map(|(joint, std)| compliance(joint, *std)).collect()
}

fn compliance(joint: &Joint, std: f64) -> Parameter {
    let stiff = std == 0.0 || joint.kind == JointKind::Prismatic;
    Parameter {
        owner: joint.name.clone(),
        quantity: "compliance".into(),
        unit: if joint.kind == JointKind::Revolute { "rad/(N·m)" } else { "m/N" }.into(),
        convention: "coordinate = position_gain * reading + position_offset + compliance * torque".into(),
        prior: ParameterPrior {
            nominal: 0.0,
            kind: if stiff { PriorKind::Fixed } else { PriorKind::Gaussian { std } },
        },
        fixed: stiff.then_some(GIVEN),
        limit: Limit::Absolute(if stiff { 1.0 } else { OBSERVABLE * std }),
        cure:
            "hold the joint under torques that differ more, with and without a load; or leave it as it was known before"
                .into(),
        linear: false,
        same_as: None,
    }
}

impl Session {
    /// Lets every joint give way under the torque of gravity that it carries: one compliance each, known to be zero
    /// within `std`, rad/(N·m). They come last among the further parameters.
    pub fn let_joints_give_way(&mut self, std: &[f64]) {
        self.deflection.compliance = Some(self.further.len());
        self.further.extend(compliance_parameters(self.robot.chain.joints(), std));
    }

    /// The compliances among the further parameters, one for each joint; nothing where no joint gives way.
    pub fn compliances(&self) -> Range<usize> {
        self.deflection.compliance.map_or(0..0, |first| first..first + self.joints.len())
    }
}
