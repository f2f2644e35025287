//! Parameters of a ROS 2 node, for `ros2 run … --ros-args --params-file FILE`.
//!
//! Both directions of both sensors in one form:
//!
//! ```text
//!     raw = gain · true + bias          true = inverse_gain · raw + inverse_bias
//! ```
//!
//! For torque, `true` is what the joint exerts to carry gravity, in N·m (N where it slides); for position the joint's coordinate, in
//! rad (m). Angles are read in rad and lengths in m.

use super::corrections::{Corrections, JointCorrection};
use super::instruments::InstrumentCorrection;
use super::numbers::{float, quoted};
use super::{Export, ExportError, ExportFormat, Exported, head};

const CONVENTION: [&str; 5] = [
    "Convention, of torque and of position: raw = gain * true + bias, true = inverse_gain * raw + inverse_bias.",
    "The true torque is what the joint exerts to carry gravity; the true position is its coordinate.",
    "raw_unit and true_unit are the units of both: angles are read in rad and lengths in m, whatever unit the recording had.",
    "gravity_m_per_s2: the vector that points down, in the frame of the base.",
    "Take it with: ros2 run PACKAGE NODE --ros-args --params-file THIS_FILE",
];

/// Keys beside the joints' names.
const KEYS: [&str; 3] = ["joints", "instruments", "gravity_m_per_s2"];

const OF_INSTRUMENTS: [&str; 4] = [
    "Of an instrument: raw = gain * sensed + bias, sensed = inverse_gain * raw + inverse_bias, with matrices row by row.",
    "A wrist sensor senses the force and the moment that its link exerts on what hangs beyond it, in the",
    "sensor's frame and about its origin (at rest -mass * gravity and gravity x first moment); an accelerometer at rest",
    "senses -gravity.",
];

pub(super) fn export(export: &Export<'_>, corrections: &Corrections) -> Result<Exported, ExportError> {
    let joints = corrections.joints.iter().map(|joint| &joint.name);
    let instruments = corrections.instruments.iter().map(|instrument| &instrument.name);
    if let Some(name) = joints.clone().chain(instruments.clone()).find(|name| KEYS.contains(&name.as_str())) {
        return Err(ExportError::NameTaken { format: ExportFormat::Ros2, name: name.clone() });
    }
    let of_instruments = if corrections.instruments.is_empty() { &[] } else { &OF_INSTRUMENTS[..] };
    let convention = [&CONVENTION[..], of_instruments].concat();
    let head: String =
        head(export, &convention, &corrections.remarks).iter().map(|line| format!("# {line}\n")).collect();
    let gravity = corrections.gravity.map_or_else(String::new, |g| {
        let numbers = g.map(float).join(", ");
        format!("      gravity_m_per_s2: [{numbers}]\n")
    });
    let names = names("joints", joints) + &names("instruments", instruments);
    let joints: String = corrections.joints.iter().map(joint).collect();
    let instruments: String = corrections.instruments.iter().map(instrument).collect();
    Ok(Exported {
        text: format!("{head}/**:\n  ros__parameters:\n    gravcal:\n{names}{gravity}{joints}{instruments}"),
        remarks: corrections.remarks.clone(),
    })
}

/// Nothing of an empty list, whose kind a node could not tell.
fn names<'a>(key: &str, names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| quoted(name)).collect();
    if names.is_empty() { String::new() } else { format!("      {key}: [{}]\n", names.join(", ")) }
}

fn instrument(instrument: &InstrumentCorrection) -> String {
    let numbers = |numbers: &mut dyn Iterator<Item = f64>| numbers.map(float).collect::<Vec<_>>().join(", ");
    let texts = |texts: &mut dyn Iterator<Item = &str>| texts.map(quoted).collect::<Vec<_>>().join(", ");
    let matrix = |rows: &[Vec<f64>]| numbers(&mut rows.iter().flatten().copied());
    let lists = [
        ("axes", texts(&mut instrument.axes.iter().copied())),
        ("gain", matrix(&instrument.gain)),
        ("bias", numbers(&mut instrument.bias.iter().copied())),
        ("inverse_gain", matrix(&instrument.inverse_gain)),
        ("inverse_bias", numbers(&mut instrument.inverse_bias().into_iter())),
        ("raw_units", texts(&mut instrument.reading_units.iter().map(String::as_str))),
        ("true_units", texts(&mut instrument.units.iter().copied())),
    ];
    let lines: String = lists.into_iter().map(|(key, list)| format!("        {key}: [{list}]\n")).collect();
    format!("      {}:\n{lines}", quoted(&instrument.name))
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
