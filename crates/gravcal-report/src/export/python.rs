//! A Python module (3, no packages) with functions from a reading to what it truly says:
//!
//! ```text
//!     torque = (reading − torque_bias) / torque_gain          coordinate = position_gain · reading + position_offset
//! ```

use super::corrections::{Corrections, JointCorrection};
use super::instruments::InstrumentCorrection;
use super::numbers::{float, quoted};
use super::{Export, Exported, head};

const CONVENTION: [&str; 5] = [
    "Convention: reading = torque_gain * torque + torque_bias, coordinate = position_gain * reading + position_offset.",
    "Torque is what the joint exerts to carry gravity, in N m (N where it slides); the coordinate is in rad (m).",
    "Readings are in the unit that stands beside each joint: angles in rad and lengths in m, whatever unit the recording had.",
    "Numbers and NumPy arrays will do.",
    "GRAVITY points down, in the frame of the base, m/s^2.",
];

const OF_JOINTS: &str = "

def torque(joint, reading):
    \"\"\"True torque of a joint, N m or N, from its reading.\"\"\"
    sensor = JOINTS[joint]
    return (reading - sensor[\"torque_bias\"]) / sensor[\"torque_gain\"]


def coordinate(joint, reading):
    \"\"\"True coordinate of a joint, rad or m, from its reading.\"\"\"
    sensor = JOINTS[joint]
    return sensor[\"position_gain\"] * reading + sensor[\"position_offset\"]
";

const OF_INSTRUMENTS: &str = "

def sensed(instrument, readings):
    \"\"\"What an instrument truly senses along its axes, from their readings.\"\"\"
    sensor = INSTRUMENTS[instrument]
    left = [reading - bias for reading, bias in zip(readings, sensor[\"bias\"])]
    return [sum(gain * part for gain, part in zip(row, left)) for row in sensor[\"inverse_gain\"]]
";

const CONVENTION_OF_INSTRUMENTS: [&str; 4] = [
    "Of an instrument: readings = gain * sensed + bias, so sensed = inverse_gain * (readings - bias). A wrist sensor senses the",
    "force and the moment that its link exerts on what hangs beyond it, N and N m, in the sensor's frame and about its origin",
    "(at rest -mass * gravity and gravity x first moment); an accelerometer at rest senses -gravity, m/s^2. Readings are in the",
    "units that stand beside the axes.",
];

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Exported {
    let Corrections { joints, instruments, gravity, remarks } = corrections;
    let of_instruments = if instruments.is_empty() { &[] } else { &CONVENTION_OF_INSTRUMENTS[..] };
    let convention = [&CONVENTION[..], of_instruments].concat();
    let head: String = head(export, &convention, remarks).iter().map(|line| format!("# {line}\n")).collect();
    let joints: String = joints.iter().map(joint).collect();
    let instruments: String = instruments.iter().map(instrument).collect();
    let gravity = gravity.map_or_else(String::new, |g| format!("\nGRAVITY = ({})\n", g.map(float).join(", ")));
    let mut text = format!("{head}\nJOINTS = {{\n{joints}}}\n");
    if !instruments.is_empty() {
        text += &format!("\nINSTRUMENTS = {{\n{instruments}}}\n");
    }
    text += &gravity;
    text += OF_JOINTS;
    if !instruments.is_empty() {
        text += OF_INSTRUMENTS;
    }
    Exported { text, remarks: remarks.clone() }
}

fn instrument(instrument: &InstrumentCorrection) -> String {
    // With a comma behind each, a tuple of one is one, too.
    let tuple =
        |items: Vec<String>| format!("({})", items.into_iter().map(|item| item + ", ").collect::<String>().trim_end());
    let texts = |texts: &[&str]| tuple(texts.iter().map(|text| quoted(text)).collect());
    let numbers = |numbers: &[f64]| tuple(numbers.iter().map(|number| float(*number)).collect());
    let matrix = |rows: &[Vec<f64>]| tuple(rows.iter().map(|row| numbers(row)).collect());
    let units: Vec<&str> = instrument.reading_units.iter().map(String::as_str).collect();
    format!(
        "    {}: {{\n        \"axes\": {},\n        \"units\": {},\n        \"gain\": {},\n        \"inverse_gain\": {},\n        \
         \"bias\": {},\n    }},\n",
        quoted(&instrument.name),
        texts(&instrument.axes),
        texts(&units),
        matrix(&instrument.gain),
        matrix(&instrument.inverse_gain),
        numbers(&instrument.bias)
    )
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
