//! A C header (C99, and C++) with functions from a reading to what it truly says:
//!
//! ```text
//!     torque = (reading − torque_bias) / torque_gain          coordinate = position_gain · reading + position_offset
//! ```

use super::corrections::{Corrections, JointCorrection};
use super::instruments::InstrumentCorrection;
use super::numbers::{float, quoted};
use super::{Export, Exported, head};

const CONVENTION: [&str; 5] = [
    "Convention: reading = torque_gain * torque + torque_bias, so torque = (reading - torque_bias) / torque_gain;",
    "coordinate = position_gain * reading + position_offset. Torque is what the joint exerts to carry gravity, in N m",
    "(N where it slides), the coordinate is in rad (m). Readings are in the unit that stands beside each joint: angles in",
    "rad and lengths in m, whatever unit the recording had. gravcal_gravity() points down, in the frame of the base, m/s^2.",
    "A joint without a torque sensor, and an index that no joint has, give NAN.",
];

const OF_JOINTS: &str = "\
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

";

const CONVENTION_OF_INSTRUMENTS: [&str; 4] = [
    "Of an instrument: readings = gain * sensed + bias, so sensed = inverse_gain * (readings - bias), matrices row by row. A wrist",
    "sensor senses the force and the moment that its link exerts on what hangs beyond it, N and N m, in the sensor's frame and",
    "about its origin (at rest -mass * gravity and gravity x first moment); an accelerometer at rest senses -gravity, m/s^2.",
    "Readings are in the units that stand beside each instrument, axis by axis; an index that none has gives 0 axes.",
];

const OF_INSTRUMENTS: &str = "\
/* What an instrument truly senses along its axes, from their readings; gives the number of axes. */
static inline int gravcal_sensed(int instrument, const double *readings, double *sensed) {
  if (instrument < 0 || instrument >= GRAVCAL_INSTRUMENT_COUNT) return 0;
  const struct gravcal_instrument *own = &gravcal_instruments[instrument];
  for (int i = 0; i < own->axes; ++i) {
    sensed[i] = 0.0;
    for (int j = 0; j < own->axes; ++j) sensed[i] += own->inverse_gain[i * own->axes + j] * (readings[j] - own->bias[j]);
  }
  return own->axes;
}

";

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Exported {
    let Corrections { joints, instruments, gravity, remarks } = corrections;
    let of_instruments = if instruments.is_empty() { &[] } else { &CONVENTION_OF_INSTRUMENTS[..] };
    let head: Vec<String> = head(export, &[&CONVENTION[..], of_instruments].concat(), remarks);
    let head: String = head.iter().map(|line| format!(" * {}\n", line.replace("*/", "* /"))).collect();
    let gravity = gravity.map_or_else(String::new, |g| {
        let numbers = g.map(float).join(", ");
        format!(
            "/* Three numbers, m/s^2. */\nstatic inline const double *gravcal_gravity(void) {{\n  static const double gravity[3] = \
             {{{numbers}}};\n  return gravity;\n}}\n\n"
        )
    });
    let (joints, of_joints) = joints_and_functions(joints);
    let (instruments, of_instruments) = instruments_and_functions(instruments);
    let text = format!(
        "/*\n{head} */\n#ifndef GRAVCAL_CALIBRATION_H\n#define GRAVCAL_CALIBRATION_H\n\n#include <math.h>\n\n\
         {joints}{instruments}{gravity}{of_joints}{of_instruments}#endif\n"
    );
    Exported { text, remarks: remarks.clone() }
}

/// Nothing where there are none: C has no array of no elements.
fn joints_and_functions(joints: &[JointCorrection]) -> (String, &'static str) {
    if joints.is_empty() {
        return (String::new(), "");
    }
    let (count, joints) = (joints.len(), joints.iter().map(joint).collect::<String>());
    let declared = format!(
        "#define GRAVCAL_JOINT_COUNT {count}\n\nstruct gravcal_joint {{\n  const char *name;\n  int has_torque;\n  double torque_gain;\n  \
         double torque_bias;\n  double position_gain;\n  double position_offset;\n}};\n\n\
         static const struct gravcal_joint gravcal_joints[GRAVCAL_JOINT_COUNT] = {{\n{joints}}};\n\n"
    );
    (declared, OF_JOINTS)
}

/// The same of instruments.
fn instruments_and_functions(instruments: &[InstrumentCorrection]) -> (String, &'static str) {
    if instruments.is_empty() {
        return (String::new(), "");
    }
    let (count, instruments) = (instruments.len(), instruments.iter().map(instrument).collect::<String>());
    let declared = format!(
        "#define GRAVCAL_INSTRUMENT_COUNT {count}\n\nstruct gravcal_instrument {{\n  const char *name;\n  int axes;\n  \
         double inverse_gain[36];\n  double bias[6];\n}};\n\n\
         static const struct gravcal_instrument gravcal_instruments[GRAVCAL_INSTRUMENT_COUNT] = {{\n{instruments}}};\n\n"
    );
    (declared, OF_INSTRUMENTS)
}

fn instrument(instrument: &InstrumentCorrection) -> String {
    let numbers = |numbers: &mut dyn Iterator<Item = f64>| numbers.map(float).collect::<Vec<_>>().join(", ");
    let inverse = numbers(&mut instrument.inverse_gain.iter().flatten().copied());
    let bias = numbers(&mut instrument.bias.iter().copied());
    let axes = instrument.axes.iter().zip(&instrument.reading_units);
    let axes: Vec<String> = axes.map(|(axis, unit)| format!("{axis} in {unit}")).collect();
    let (name, count, axes) = (quoted(&instrument.name), axes.len(), axes.join(", ").replace("*/", "* /"));
    format!("  {{{name}, {count}, {{{inverse}}}, {{{bias}}}}}, /* {axes} */\n")
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
