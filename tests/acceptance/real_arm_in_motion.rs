//! Three recordings of a real arm that never stands still: what two runs of one trajectory agree on.

use std::fs;
use std::path::Path;

use crate::answer::Estimator;
use crate::experiments::{say, shared_data};
use crate::program::{Calibration, gravcal_in};
use crate::tree;

/// The experiment's session on one recording; `None` where the recordings are absent.
fn session(recording: u32) -> Option<String> {
    let experiment = tree::experiment("kuka-lwr4");
    let data = shared_data(&experiment);
    if !data.is_dir() {
        say(&format!("SKIPPED: a real arm in motion: there is no folder {}", data.display()));
        return None;
    }
    let text = fs::read_to_string(experiment.join("session.toml")).unwrap();
    let text = text.replace("${GRAVCAL_SHARED_DATA:-../../../shared/data}", &data.to_string_lossy());
    assert!(text.contains("${RECORDING:-1}"));
    Some(text.replace("${RECORDING:-1}", &recording.to_string()))
}

fn in_folder(session: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("session.toml"), session).unwrap();
    folder
}

fn estimate(session: &str) -> Estimator {
    Calibration::of(&in_folder(session).path().join("session.toml")).estimator("joint")
}

/// Name, value and standard deviation of all that was estimated.
fn estimated(joint: &Estimator) -> Vec<(String, f64, f64)> {
    let gravity = joint.gravity.as_ref().unwrap();
    let axes = (0..3).map(|k| (format!("gravity[{k}]"), gravity.vector_m_per_s2[k], gravity.std_m_per_s2[k]));
    let sensors = joint.estimated().map(|found| (found.name.clone(), found.value.unwrap(), found.std.unwrap()));
    axes.chain(sensors).collect()
}

#[test]
fn two_runs_of_one_trajectory_agree_within_their_robust_intervals() {
    let (Some(first), Some(second)) = (session(1), session(2)) else { return };
    let [first, second] = [first, second].map(|session| estimate(&session));
    for joint in [&first, &second] {
        assert!(joint.undetermined.is_empty(), "{:?}", joint.undetermined);
    }
    let [first, second] = [&first, &second].map(estimated);
    assert_eq!(first.len(), 24);
    let differences = first.iter().zip(&second).map(|((name, a, std_a), (other, b, std_b))| {
        assert_eq!(name, other);
        (a - b) / std_a.hypot(*std_b)
    });
    let differences: Vec<f64> = differences.collect();
    let rms = (differences.iter().map(|z| z * z).sum::<f64>() / 24.0).sqrt();
    assert!(rms < 1.0 && differences.iter().all(|z| z.abs() < 3.0), "{rms} {differences:?}");
}

/// Nothing but the robot's masses can tell the scale of the torques, and no load was attached.
#[test]
fn check_names_what_gains_the_rows_cannot_tell() {
    let Some(session) = session(1) else { return };
    let folder = in_folder(&session.replace("torque_gain = { fixed", "torque_gain = { nominal"));
    let reported = reported_by_check(folder.path());
    assert!(reported.contains("readings.select): lwr_0_joint 4459 of 5027, lwr_1_joint 4359 of 5027"), "{reported}");
    assert!(reported.contains("gravity is parallel to the axis of lwr_0_joint"), "{reported}");
    assert!(reported.contains("with a load of known mass (1 kg) on the last link"), "{reported}");
}

/// Without its velocity columns the speeds are slopes of the positions: nearly the same rows are left.
#[test]
fn speeds_may_be_slopes_of_positions() {
    let Some(session) = session(1) else { return };
    let columns = session.lines().find(|line| line.starts_with("velocity = ")).unwrap();
    let folder = in_folder(&session.replace(columns, "velocity = { slope_over_s = 0.05 }"));
    let reported = reported_by_check(folder.path());
    let left = reported.split("readings.select): lwr_0_joint ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    let left: i32 = left.parse().unwrap();
    assert!((left - 4459).abs() < 200, "{left}");
}

/// What a fit of the first part of a bag predicts of the rest: no joint's rms is more than this share of its torques' range. And gravity of an
/// arm that stands upright lies along its base's axis within the interval.
fn predicts_the_rest(name: &str, most: f64) {
    let experiment = tree::experiment(name);
    if !shared_data(&experiment).is_dir() {
        say(&format!("SKIPPED: {name}: there is no folder {}", shared_data(&experiment).display()));
        return;
    }
    let calibration = Calibration::of(&experiment.join("session.toml"));
    let joint = calibration.estimator("joint");
    let predicted = joint.fit.as_ref().and_then(|fit| fit.held_out.as_ref()).unwrap();
    let gains = joint.parameters.iter().filter(|parameter| parameter.name.ends_with("torque_gain"));
    assert_eq!(predicted.joints.len(), gains.count(), "{name}");
    for own in &predicted.joints {
        assert!(own.rms / own.range < most, "{name}: {} {} of {}", own.joint, own.rms, own.range);
    }
    let gravity = joint.gravity.as_ref().unwrap();
    let [x, y, _] = gravity.vector_m_per_s2;
    let [std_x, std_y, _] = gravity.std_m_per_s2;
    assert!((x / std_x).abs() < 3.0 && (y / std_y).abs() < 3.0, "{name}: {gravity:?}");
}

#[test]
fn bags_of_arms_in_motion_predict_what_was_not_fitted() {
    predicts_the_rest("ur10-in-motion", 0.035);
    predicts_the_rest("panda-in-motion", 0.11);
}

fn reported_by_check(folder: &Path) -> String {
    gravcal_in(folder, ["check", "--full", "session.toml"]).stdout.split_whitespace().collect::<Vec<_>>().join(" ")
}
