//! A C header (C99, and C++) with functions from a reading to what it truly says:
//!
//! ```text
//!     torque = (reading − torque_bias) / torque_gain          coordinate = position_gain · reading + position_offset
//! ```

use super::corrections::{Corrections, JointCorrection};
use super::numbers::{float, quoted};
use super::{Export, Exported, head};

const CONVENTION: [&str; 5] = [
    "Convention: reading = torque_gain * torque + torque_bias, so torque = (reading - torque_bias) / torque_gain;",
    "coordinate = position_gain * reading + position_offset. Torque is what the joint exerts to carry gravity, in N m",
    "(N where it slides), the coordinate is in rad (m). An angle is read in rad; other readings in the unit that stands",
    "beside each joint. gravcal_gravity points down, in the frame of the base, m/s^2.",
    "A joint without a torque sensor, and an index that no joint has, give NAN.",
];

const FUNCTIONS: &str = "\
/* True torque of a joint, N m or N, from its reading. */
static inline double gravcal_torque(int joint, double reading) {
  if (joint < 0 || joint >= GRAVCAL_JOINT_COUNT || !gravcal_joints[joint].has_torque) return NAN;
  return (reading - gravcal_joints[joint].torque_bias) / gravcal_joints[joint].torque_gain;
}

/* True coordinate of a joint, rad or m, from its reading. */
static inline double gravcal_coordinate(int joint, double reading) {
  if (joint < 0 || joint >= GRAVCAL_JOINT_COUNT) return NAN;
  return gravcal_joints[joint].position_gain * reading + gravcal_joints[joint].position_offset;
}

#endif
";

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Exported {
    let head: Vec<String> = head(export, &CONVENTION, &corrections.remarks);
    let head: String = head.iter().map(|line| format!(" * {}\n", line.replace("*/", "* /"))).collect();
    let count = corrections.joints.len();
    let joints: String = corrections.joints.iter().map(joint).collect();
    let gravity = corrections.gravity.map_or_else(String::new, |g| {
        format!("static const double gravcal_gravity[3] = {{{}}};\n\n", g.map(float).join(", "))
    });
    let text = format!(
        "/*\n{head} */\n#ifndef GRAVCAL_CALIBRATION_H\n#define GRAVCAL_CALIBRATION_H\n\n#include <math.h>\n\n\
         #define GRAVCAL_JOINT_COUNT {count}\n\nstruct gravcal_joint {{\n  const char *name;\n  int has_torque;\n  double torque_gain;\n  \
         double torque_bias;\n  double position_gain;\n  double position_offset;\n}};\n\n\
         static const struct gravcal_joint gravcal_joints[GRAVCAL_JOINT_COUNT] = {{\n{joints}}};\n\n{gravity}{FUNCTIONS}"
    );
    Exported { text, remarks: corrections.remarks.clone() }
}

fn joint(joint: &JointCorrection) -> String {
    let position = &joint.position;
    let (has_torque, [gain, bias], unit) = match &joint.torque {
        Some(torque) => (1, [torque.gain, torque.bias], torque.reading_unit.as_str()),
        None => (0, [1.0, 0.0], "none"),
    };
    let numbers = [gain, bias, position.gain, position.offset].map(float).join(", ");
    let units = format!("torque read in {unit}, position in {}", position.reading_unit);
    format!("  {{{}, {has_torque}, {numbers}}}, /* {units} */\n", quoted(&joint.name))
}
