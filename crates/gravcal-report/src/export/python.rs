//! A Python module (3, no packages) with functions from a reading to what it truly says:
//!
//! ```text
//!     torque = (reading − torque_bias) / torque_gain          coordinate = position_gain · reading + position_offset
//! ```

use super::corrections::{Corrections, JointCorrection};
use super::numbers::{float, quoted};
use super::{Export, Exported, head};

const CONVENTION: [&str; 4] = [
    "Convention: reading = torque_gain * torque + torque_bias, coordinate = position_gain * reading + position_offset.",
    "Torque is what the joint exerts to carry gravity, in N m (N where it slides); the coordinate is in rad (m).",
    "An angle is read in rad, other readings in the unit that stands beside each joint. Numbers and NumPy arrays will do.",
    "GRAVITY points down, in the frame of the base, m/s^2.",
];

const FUNCTIONS: &str = "

def torque(joint, reading):
    \"\"\"True torque of a joint, N m or N, from its reading.\"\"\"
    sensor = JOINTS[joint]
    return (reading - sensor[\"torque_bias\"]) / sensor[\"torque_gain\"]


def coordinate(joint, reading):
    \"\"\"True coordinate of a joint, rad or m, from its reading.\"\"\"
    sensor = JOINTS[joint]
    return sensor[\"position_gain\"] * reading + sensor[\"position_offset\"]
";

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Exported {
    let head: String =
        head(export, &CONVENTION, &corrections.remarks).iter().map(|line| format!("# {line}\n")).collect();
    let joints: String = corrections.joints.iter().map(joint).collect();
    let gravity =
        corrections.gravity.map_or_else(String::new, |g| format!("\nGRAVITY = ({})\n", g.map(float).join(", ")));
    Exported {
        text: format!("{head}\nJOINTS = {{\n{joints}}}\n{gravity}{FUNCTIONS}"),
        remarks: corrections.remarks.clone(),
    }
}

fn joint(joint: &JointCorrection) -> String {
    let torque = joint.torque.as_ref().map_or_else(String::new, |torque| {
        let unit = quoted(&torque.reading_unit);
        let [gain, bias] = [torque.gain, torque.bias].map(float);
        format!(
            "        \"torque_gain\": {gain},\n        \"torque_bias\": {bias},\n        \"torque_unit\": {unit},\n"
        )
    });
    let position = &joint.position;
    let [gain, offset] = [position.gain, position.offset].map(float);
    format!(
        "    {}: {{\n{torque}        \"position_gain\": {gain},\n        \"position_offset\": {offset},\n        \
         \"position_unit\": {},\n    }},\n",
        quoted(&joint.name),
        quoted(&position.reading_unit)
    )
}
