//! Parameters of a ROS 2 node, for `ros2 run … --ros-args --params-file FILE`.
//!
//! Both directions of both sensors in one form:
//!
//! ```text
//!     raw = gain · true + bias          true = inverse_gain · raw + inverse_bias
//! ```
//!
//! For torque, `true` is what the joint exerts to carry gravity, in N·m (N where it slides); for position the joint's coordinate, in
//! rad (m). An angle is read in rad.

use super::corrections::{Corrections, JointCorrection};
use super::numbers::{float, quoted};
use super::{Export, Exported, head};

const CONVENTION: [&str; 5] = [
    "Convention, of torque and of position: raw = gain * true + bias, true = inverse_gain * raw + inverse_bias.",
    "The true torque is what the joint exerts to carry gravity; the true position is its coordinate.",
    "raw_unit and true_unit are the units of both; an angle is read in rad, whatever the sensor's table says.",
    "gravity_m_per_s2: the vector that points down, in the frame of the base.",
    "Take it with: ros2 run PACKAGE NODE --ros-args --params-file THIS_FILE",
];

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Exported {
    let head: String =
        head(export, &CONVENTION, &corrections.remarks).iter().map(|line| format!("# {line}\n")).collect();
    let names: Vec<String> = corrections.joints.iter().map(|joint| quoted(&joint.name)).collect();
    let gravity = corrections.gravity.map_or_else(String::new, |g| {
        let numbers = g.map(float).join(", ");
        format!("      gravity_m_per_s2: [{numbers}]\n")
    });
    let joints: String = corrections.joints.iter().map(joint).collect();
    let names = names.join(", ");
    Exported {
        text: format!("{head}/**:\n  ros__parameters:\n    gravcal:\n      joints: [{names}]\n{gravity}{joints}"),
        remarks: corrections.remarks.clone(),
    }
}

fn joint(joint: &JointCorrection) -> String {
    let mut text = format!("      {}:\n", quoted(&joint.name));
    if let Some(torque) = &joint.torque {
        text += &sensor("torque", [torque.gain, torque.bias], [&torque.reading_unit, &torque.unit]);
    }
    let position = &joint.position;
    let forward = [1.0 / position.gain, -position.offset / position.gain];
    let inverse = [position.gain, position.offset];
    text + &directions("position", forward, inverse, [&position.reading_unit, &position.unit])
}

fn sensor(what: &str, [gain, bias]: [f64; 2], units: [&str; 2]) -> String {
    directions(what, [gain, bias], [1.0 / gain, -bias / gain], units)
}

fn directions(what: &str, forward: [f64; 2], inverse: [f64; 2], [raw, truth]: [&str; 2]) -> String {
    let [gain, bias] = forward.map(float);
    let [inverse_gain, inverse_bias] = inverse.map(float);
    format!(
        "        {what}:\n          gain: {gain}\n          bias: {bias}\n          inverse_gain: {inverse_gain}\n          \
         inverse_bias: {inverse_bias}\n          raw_unit: {}\n          true_unit: {}\n",
        quoted(raw),
        quoted(truth)
    )
}
