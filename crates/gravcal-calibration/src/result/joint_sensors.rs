//! The parameters of a joint's sensors, each by its name in the code.

use gravcal_robot_model::parameter::SensorParameter;

use super::parameter::ParameterResult;

/// What is told of the two sensors of one joint.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct JointSensors<'a> {
    /// The joint's name.
    pub joint: &'a str,
    /// `k` of `reading = k · torque + b`, in the reading's unit per N·m (N where the joint slides).
    pub torque_gain: &'a ParameterResult,
    /// `b` of the same, in the reading's unit.
    pub torque_bias: &'a ParameterResult,
    /// `s` of `coordinate = s · reading + o`, in rad (m where the joint slides) per unit of the reading.
    pub position_gain: &'a ParameterResult,
    /// `o` of the same, in rad or m.
    pub position_offset: &'a ParameterResult,
}

/// Those of every joint among the parameters, in their order.
pub(super) fn sensors_of_joints(parameters: &[ParameterResult]) -> impl Iterator<Item = JointSensors<'_>> {
    let suffix = SensorParameter::TorqueGain.name("");
    let joints = parameters.iter().filter_map(move |parameter| parameter.name.strip_suffix(&suffix));
    let of = |joint: &str, quantity: SensorParameter| {
        let name = quantity.name(joint);
        parameters.iter().find(|parameter| parameter.name == name)
    };
    joints.filter_map(move |joint| {
        Some(JointSensors {
            joint,
            torque_gain: of(joint, SensorParameter::TorqueGain)?,
            torque_bias: of(joint, SensorParameter::TorqueBias)?,
            position_gain: of(joint, SensorParameter::PositionGain)?,
            position_offset: of(joint, SensorParameter::PositionOffset)?,
        })
    })
}
