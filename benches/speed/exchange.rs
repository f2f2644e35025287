//! The problem as two plain tables in a temporary folder, for the peers.
//!
//! `constants.csv` has a name and its numbers in every line:
//!
//! ```text
//!     dh_a, dh_d (m), dh_cos_alpha, dh_sin_alpha     standard Denavit-Hartenberg rows, one number a joint
//!     torque_std                                     N·m, one a joint
//!     load_mass                                      kg
//!     gravity, torque_gain, torque_bias, position_gain, position_offset, inertia, placement, displacement
//!                                                    the start, inertia as (m, h_x, h_y, h_z) link after link
//! ```
//!
//! Lengths of `gravity` and `displacement`, and the first and last `position_offset`, are fixed. `poses.csv` has a line a
//! pose: 0 (bare), 1 (load at `placement`) or 2 (load at `placement` + `displacement`), position readings, torque readings.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use gravcal_dynamics::{Joint, Transform};
use gravcal_estimation::BlockId;
use gravcal_robot_model::parameter::SensorParameter;
use tempfile::TempDir;

use gravcal_benches::seven_joints::SevenJoints;

/// Writes both tables into a new folder, which is gone when the value is.
pub fn write(problem: &SevenJoints) -> Result<TempDir, String> {
    let folder = TempDir::new().map_err(|e| format!("no temporary folder: {e}"))?;
    let put = |name: &str, text: String| {
        let path: &Path = &folder.path().join(name);
        fs::write(path, text).map_err(|e| format!("cannot write {}: {e}", path.display()))
    };
    put("constants.csv", constants(problem)?)?;
    put("poses.csv", poses(problem))?;
    Ok(folder)
}

fn constants(problem: &SevenJoints) -> Result<String, String> {
    let joints = problem.session.robot.chain.joints();
    let rows = joints.iter().map(standard_row).collect::<Result<Vec<[f64; 4]>, String>>()?;
    let mut text = String::new();
    for (index, name) in ["dh_a", "dh_d", "dh_cos_alpha", "dh_sin_alpha"].into_iter().enumerate() {
        line(&mut text, name, rows.iter().map(|row| row[index]));
    }
    let std = problem.session.poses[0].torque.iter().map(|r| r.as_ref().and_then(|r| r.std).unwrap_or(f64::NAN));
    line(&mut text, "torque_std", std);
    line(&mut text, "load_mass", [problem.session.loads[0].mass]);
    start(problem, &mut text)?;
    Ok(text)
}

/// `[a, d, cos α, sin α]` of a joint that is a standard Denavit-Hartenberg row: `Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α)`.
fn standard_row(joint: &Joint) -> Result<[f64; 4], String> {
    let [[x, _, _], [_, cos, _], [_, sin, _]] = joint.after.rotation();
    let [a, side, d] = joint.after.translation();
    let standard = joint.before == Transform::identity() && joint.axis == [0.0, 0.0, 1.0] && x == 1.0 && side == 0.0;
    if standard { Ok([a, d, cos, sin]) } else { Err(format!("{} is no standard row without θ", joint.name)) }
}

fn start(problem: &SevenJoints, text: &mut String) -> Result<(), String> {
    let (variables, values) = (&problem.built.variables, &problem.built.initial);
    let numbers = |id: &BlockId| values.get(*id).to_vec();
    line(text, "gravity", numbers(&variables.gravity));
    for (quantity, name) in [
        (SensorParameter::TorqueGain, "torque_gain"),
        (SensorParameter::TorqueBias, "torque_bias"),
        (SensorParameter::PositionGain, "position_gain"),
        (SensorParameter::PositionOffset, "position_offset"),
    ] {
        line(text, name, variables.sensors.iter().map(|ids| values.scalar(ids[quantity as usize])));
    }
    line(text, "inertia", variables.inertia.iter().flat_map(numbers));
    let Some([placement, displacement]) = variables.loads.last().and_then(Option::as_deref) else {
        return Err("the second placement is not the first one and a displacement".into());
    };
    line(text, "placement", numbers(placement));
    line(text, "displacement", numbers(displacement));
    Ok(())
}

fn poses(problem: &SevenJoints) -> String {
    let mut text = String::new();
    for pose in &problem.session.poses {
        let torque = pose.torque.iter().map(|r| r.as_ref().map_or(f64::NAN, |r| r.value));
        let placement = pose.load.map_or(0, |load| load + 1);
        line(&mut text, &placement.to_string(), pose.position.iter().copied().chain(torque));
    }
    text
}

/// A name and its numbers, to the last digit.
fn line(text: &mut String, name: &str, numbers: impl IntoIterator<Item = f64>) {
    text.push_str(name);
    // Writing into a String cannot fail.
    numbers.into_iter().for_each(|number| _ = write!(text, ",{number:e}"));
    text.push('\n');
}
