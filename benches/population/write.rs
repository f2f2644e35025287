//! A session as files: what a user would write, and the truth beside it.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::arm::Urdf;
use super::draw::{NOMINAL_BIAS, NOMINAL_GAIN, WRIST_NOISE};
use super::independent::Information;
use super::model::{predicted, state};
use super::statics::Number;
use super::truth::{GRAVITY, PLACEMENTS, Truth, Wrist};

/// Writes `session.toml` and its tables into a folder.
///
/// # Errors
/// Says which file cannot be written.
pub fn write_session(truth: &Truth, folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let urdf = match &truth.arm.urdf {
        Urdf::File(path) => path.to_string_lossy().into_owned(),
        Urdf::Text(text) => {
            write(folder, "arm.urdf", text)?;
            "arm.urdf".to_owned()
        }
    };
    for (name, table) in tables(truth) {
        write(folder, &name, &table)?;
    }
    write(folder, "session.toml", &session(truth, &urdf))
}

/// Writes `truth.json`, and `information.json` with what exact rank says of every unknown.
///
/// # Errors
/// Says which file cannot be written.
pub fn write_truth(truth: &Truth, information: &BTreeMap<String, Information>, folder: &Path) -> Result<(), String> {
    let of: Value = information.iter().map(|(name, known)| (name.clone(), json!([known.share, known.bound]))).collect();
    write(folder, "truth.json", &format!("{:#}\n", true_values(truth)))?;
    write(folder, "information.json", &format!("{of:#}\n"))
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), String> {
    let path = folder.join(name);
    std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
}

fn session(truth: &Truth, urdf: &str) -> String {
    let Truth { arm, said, .. } = truth;
    let columns = |of: &str| list(arm.joints.iter().map(|joint| format!("{}_{of}", joint.name)));
    let mut lines = vec![
        format!("robot = {{ urdf = {}, base = \"{}\", tip = \"{}\" }}", json!(urdf), arm.base, arm.tip),
        "estimators = [\"joint\"]".to_owned(),
        "[gravity]".to_owned(),
        format!("magnitude_m_per_s2 = {GRAVITY}"),
    ];
    if said.hemisphere {
        let [x, y, z] = (truth.gravity / GRAVITY).map(|component| (10.0 * component).round() / 10.0).into();
        lines.push(format!("hemisphere = [{x:.1}, {y:.1}, {z:.1}]"));
    }
    let angle = if said.degrees { "deg" } else { "rad" };
    let unit = if said.counts { "count" } else { "N·m" };
    let std = if said.std { format!(", std = {:?}", &truth.noise[..arm.joint_count()]) } else { String::new() };
    lines.push("[readings]".to_owned());
    lines.push(format!("position = {{ columns = {}, unit = \"{angle}\" }}", columns("position")));
    lines.push(format!("torque = {{ columns = {}, unit = \"{unit}\"{std} }}", columns("torque")));
    if let Some(wrist) = &truth.wrist {
        lines.push(format!("[[force_torque_sensor]]\nname = \"{}\"", Wrist::NAME));
        lines.push(format!(
            "readings = {{ columns = {}, unit = [\"N\", \"N\", \"N\", \"N·m\", \"N·m\", \"N·m\"], std = {WRIST_NOISE:?} }}",
            list(Wrist::AXES.iter())
        ));
        if wrist.mass_said {
            lines.push(format!("tool_mass = {{ fixed = {}, unit = \"kg\" }}", wrist.tool[0]));
        }
    }
    if said.counts {
        lines.extend(arm.joints.iter().map(|joint| {
            format!(
                "[[joint]]\nname = \"{}\"\ntorque_gain = {{ nominal = {NOMINAL_GAIN}, unit = \"count/(N·m)\" }}\n\
                 torque_bias = {{ nominal = {NOMINAL_BIAS:.1}, unit = \"count\" }}",
                joint.name
            )
        }));
    }
    let placed = PLACEMENTS.iter().take(truth.placements.len());
    lines.extend(
        placed.map(|name| format!("[[load]]\nname = \"{name}\"\nmass_kg = {}\nlink = \"{}\"", truth.mass, arm.tip)),
    );
    if let [a, b] = truth.placements.as_slice() {
        let between = list(PLACEMENTS.iter());
        lines.push(format!("[[load_distance]]\nbetween = {between}\ndistance_m = {}", (a - b).norm()));
    }
    for table in &truth.tables {
        lines.push(format!("[[poses]]\nfile = \"{}\"", file_name(table.placement)));
        lines.extend(table.placement.map(|placement| format!("load = \"{}\"", PLACEMENTS[placement])));
    }
    lines.join("\n") + "\n"
}

fn list<T: ToString>(items: impl Iterator<Item = T>) -> String {
    json!(items.map(|item| item.to_string()).collect::<Vec<_>>()).to_string()
}

fn file_name(placement: Option<usize>) -> String {
    format!("{}.csv", placement.map_or("bare", |placement| PLACEMENTS[placement]))
}

/// Readings with their errors, in the order of the model.
pub fn readings(truth: &Truth) -> Vec<f64> {
    let values: Vec<Number> = state(truth).values.into_iter().map(Number::from).collect();
    let noise = truth.noise.iter().cycle();
    let errors = truth.errors.iter().zip(noise).map(|(error, noise)| error * noise);
    predicted(truth, &values).iter().zip(errors).map(|(exact, error)| exact.re + error).collect()
}

/// Names and texts of the tables.
fn tables(truth: &Truth) -> Vec<(String, String)> {
    let joints = || truth.arm.joints.iter().map(|joint| joint.name.as_str());
    let header =
        joints().map(|joint| format!("{joint}_position")).chain(joints().map(|joint| format!("{joint}_torque")));
    let wrist = Wrist::AXES.iter().take(truth.channels() - truth.arm.joint_count()).map(ToString::to_string);
    let header = header.chain(wrist).collect::<Vec<_>>().join(",");
    let torques = readings(truth);
    let mut torques = torques.chunks(truth.channels());
    let unit = if truth.said.degrees { 1f64.to_degrees() } else { 1.0 };
    let text = |table: &super::truth::Table| {
        let mut text = format!("{header}\n");
        for angles in &table.angles {
            let positions = truth.position_readings(angles).into_iter().map(|angle| unit * angle);
            let torques = torques.next().unwrap_or_default().iter().copied();
            let numbers: Vec<String> = positions.chain(torques).map(|number| number.to_string()).collect();
            let _ = writeln!(text, "{}", numbers.join(","));
        }
        text
    };
    truth.tables.iter().map(|table| file_name(table.placement)).zip(truth.tables.iter().map(text)).collect()
}

fn true_values(truth: &Truth) -> Value {
    let sensors = &truth.sensors;
    let mut values = json!({
        "g": truth.gravity.as_slice(),
        "counts": truth.said.counts,
        "degrees": truth.said.degrees,
        "mass": truth.mass,
        "k": sensors.torque_gain,
        "b": sensors.torque_bias,
        "s": sensors.position_gain,
        "o": sensors.position_offset,
        "sigma": truth.noise,
        "wrist": truth.wrist.as_ref().map(|wrist| json!({ "gain": wrist.gain, "bias": wrist.bias, "tool": wrist.tool })),
        "joints": truth.arm.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>(),
        "bodies": truth.arm.joints.iter().map(|joint| joint.body).collect::<Vec<_>>(),
        "tables": truth.tables.iter().map(|table| json!({ "load": table.placement.map(|k| PLACEMENTS[k]), "angles": table.angles })).collect::<Vec<_>>(),
    });
    for (name, placement) in PLACEMENTS.iter().zip(&truth.placements) {
        values[name] = json!(placement.as_slice());
    }
    values
}
