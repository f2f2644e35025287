//! What stands between a comparison and what it seems to say: common recordings, other robots, other models.

use gravcal_calibration::comparison::{Comparison, SensorComparison};
use gravcal_recording::{EarlierInput, InputRole};

/// Lines that warn.
pub(super) fn warnings(comparison: &Comparison, shared: &[String], robots: &[String]) -> Vec<String> {
    let mut warnings = Vec::new();
    if !shared.is_empty() {
        warnings.push(format!(
            "some of these were made from the same {}. The test takes them to be independent: what they share counts as \
             agreement, and a sensor that moved may go unnoticed.",
            shared.join(", ")
        ));
    }
    if !robots.is_empty() {
        warnings.push(format!(
            "their descriptions of the robot differ: {}. What differs there can pass for a sensor that moved, or hide one.",
            robots.join(", ")
        ));
    }
    let lacking: Vec<&str> =
        comparison.sensors.iter().filter(|sensor| !sensor.in_all).map(|sensor| sensor.name.as_str()).collect();
    if !lacking.is_empty() {
        warnings.push(format!("not in all of these: {}. Are they of one robot?", lacking.join(", ")));
    }
    warnings.extend(comparison.sensors.iter().filter_map(other_model));
    warnings
}

fn other_model(sensor: &SensorComparison) -> Option<String> {
    let SensorComparison { name, models_differ_in, .. } = sensor;
    let reported = format!(
        "{name} has different models: {} is not in all of these. Its other parameters may differ though it has not moved.",
        models_differ_in.join(", ")
    );
    (!models_differ_in.is_empty()).then_some(reported)
}

/// What makes calibrations depend on each other: a recording that several read, or one that is another's knowledge. `own`: each
/// calibration's hash; `inputs`: what each was made from. Robots and sessions may well be the same.
pub fn shared_inputs(own: &[String], inputs: &[Vec<EarlierInput>]) -> Vec<String> {
    let mut shared = Vec::new();
    for (index, all) in inputs.iter().enumerate() {
        for input in all {
            let earlier = inputs[..index].iter().flatten().any(|other| other.sha256 == input.sha256);
            if own.contains(&input.sha256) || (earlier && input.role == InputRole::Recording) {
                shared.push(input.path.clone());
            }
        }
    }
    shared.sort();
    shared.dedup();
    shared
}

/// Files that describe the robot, each with the first calibration made from it; none where that is one for all. `inputs`: what each
/// was made from.
pub fn different_robots(inputs: &[Vec<EarlierInput>]) -> Vec<String> {
    let mut robots: Vec<(usize, &EarlierInput)> = Vec::new();
    for (index, inputs) in inputs.iter().enumerate() {
        let known = |robot: &EarlierInput| robots.iter().any(|(_, other)| other.sha256 == robot.sha256);
        if let Some(robot) = inputs.iter().find(|input| input.role == InputRole::Robot && !known(input)) {
            robots.push((index, robot));
        }
    }
    match robots.len() {
        0 | 1 => Vec::new(),
        _ => robots.iter().map(|(index, robot)| format!("{} (calibration {})", robot.path, index + 1)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(path: &str, hash: &str) -> EarlierInput {
        let role = match path.rsplit_once('.') {
            _ if path == "session.toml" => InputRole::Session,
            Some((_, "urdf")) => InputRole::Robot,
            Some((_, "json")) => InputRole::Calibration,
            _ => InputRole::Recording,
        };
        EarlierInput { path: path.into(), sha256: hash.into(), role }
    }

    #[test]
    fn shared_recordings_and_priors_are_found() {
        let a = vec![input("session.toml", "s"), input("arm.urdf", "r"), input("monday.csv", "1")];
        let b = vec![input("session.toml", "s"), input("arm.urdf", "r"), input("tuesday.csv", "2")];
        let own = ["a".to_owned(), "b".to_owned()];
        assert_eq!(shared_inputs(&own, &[a.clone(), b.clone()]), Vec::<String>::new());
        let mut again = b.clone();
        again.push(input("copy-of-monday.csv", "1"));
        again.push(input("last-week/calibration.json", "a"));
        assert_eq!(shared_inputs(&own, &[a, again]), ["copy-of-monday.csv", "last-week/calibration.json"]);
    }

    #[test]
    fn another_robot_is_found_and_the_same_one_is_not() {
        let made_from = |hash: &str| vec![input("session.toml", "s"), input("arm.urdf", hash), input("a.csv", "1")];
        assert_eq!(different_robots(&[made_from("r"), made_from("r"), vec![]]), Vec::<String>::new());
        let found = different_robots(&[made_from("r"), made_from("r"), made_from("q")]);
        assert_eq!(found, ["arm.urdf (calibration 1)", "arm.urdf (calibration 3)"]);
        // A sensor by itself has no robot, whatever was recorded of it.
        let by_itself = |hash: &str| vec![input("session.toml", "s"), input("a.csv", hash)];
        assert_eq!(different_robots(&[by_itself("1"), by_itself("2")]), Vec::<String>::new());
    }
}
