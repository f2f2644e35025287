//! Several calibrations of one robot beside each other: which sensor moved.

mod json;
mod text;

use std::fmt;

use gravcal_calibration::comparison::Comparison;
use gravcal_recording::EarlierInput;

use crate::json::JsonError;

/// A comparison with the names of what is compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonReport<'a> {
    /// The files, in the order in which they were compared.
    pub files: &'a [String],
    /// Recordings and calibrations that several of them were made from: see [`shared_inputs`].
    pub shared: &'a [String],
    /// What the comparison comes to.
    pub comparison: &'a Comparison,
    /// Whether the values of sensors that have not moved are told, too.
    pub verbose: bool,
}

impl ComparisonReport<'_> {
    /// The same as JSON.
    ///
    /// # Errors
    /// Where a number is not finite.
    pub fn to_json(&self) -> Result<String, JsonError> {
        json::json(self)
    }
}

impl fmt::Display for ComparisonReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text::text(self))
    }
}

/// What makes calibrations depend on each other: a recording that several read, or one that is another's knowledge. `own`: each
/// calibration's hash; `inputs`: what each was made from. Robots and sessions may well be the same.
pub fn shared_inputs(own: &[String], inputs: &[Vec<EarlierInput>]) -> Vec<String> {
    let description = |path: &str| {
        let end = path.rsplit_once('.').map_or("", |(_, end)| end).to_ascii_lowercase();
        ["toml", "urdf", "xml", "xacro", "json"].contains(&end.as_str())
    };
    let mut shared = Vec::new();
    for (index, all) in inputs.iter().enumerate() {
        for input in all {
            let earlier = inputs[..index].iter().flatten().any(|other| other.sha256 == input.sha256);
            if own.contains(&input.sha256) || (earlier && !description(&input.path)) {
                shared.push(input.path.clone());
            }
        }
    }
    shared.sort();
    shared.dedup();
    shared
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::comparison::{ComparedParameter, HomogeneityTest, SensorComparison};

    use super::*;

    fn input(path: &str, hash: &str) -> EarlierInput {
        EarlierInput { path: path.into(), sha256: hash.into() }
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

    fn comparison() -> Comparison {
        let parameter = |name: &str, unit: &str, values: [f64; 2], std: f64| ComparedParameter {
            name: name.into(),
            unit: unit.into(),
            values: values.to_vec(),
            stds: vec![std; 2],
        };
        let test = |chi_squared, p_value, moved| HomogeneityTest {
            chi_squared,
            degrees_of_freedom: 2,
            p_value,
            corrected_p_value: 2.0 * p_value,
            moved,
            largest_step: (0, chi_squared),
        };
        let torque = SensorComparison {
            name: "joint2 torque".into(),
            parameters: vec![
                parameter("joint2.torque_gain", "count/(N·m)", [7.124, 7.56], 0.022),
                parameter("joint2.torque_bias", "count", [2074.9, 2074.8], 0.12),
            ],
            left_out: vec![],
            test: Some(test(196.4, 2.1e-43, true)),
        };
        let position = SensorComparison {
            name: "joint1 position".into(),
            parameters: vec![parameter("joint1.position_gain", "rad/rad", [0.988, 0.9881], 0.0005)],
            left_out: vec!["joint1.position_offset is held in calibration 1 (it defines the base frame)".into()],
            test: Some(test(1.2, 0.55, false)),
        };
        Comparison { sensors: vec![torque, position] }
    }

    fn report<'a>(comparison: &'a Comparison, files: &'a [String], shared: &'a [String]) -> ComparisonReport<'a> {
        ComparisonReport { files, shared, comparison, verbose: false }
    }

    #[test]
    fn the_verdict_stands_first_and_lines_fit() {
        let (comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        let text = report(&comparison, &files, &["poses.csv".to_owned()]).to_string();
        assert!(text.starts_with("Moved: joint2 torque\n"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.contains("  joint2 torque    196    2  < 0.001  < 0.001  moved\n"), "{text}");
        assert!(text.contains("joint2.torque_gain  count/(N·m)  1     7.124 ± 0.022\n"), "{text}");
        assert!(text.contains("were made from the same poses.csv"), "{text}");
        let nothing = Comparison { sensors: comparison.sensors[1..].to_vec() };
        let text = report(&nothing, &files, &[]).to_string();
        assert!(text.starts_with("Nothing moved, as far as these calibrations tell\n"), "{text}");
    }

    #[test]
    fn json_has_all_numbers() {
        let (comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        let json: serde_json::Value =
            serde_json::from_str(&report(&comparison, &files, &[]).to_json().unwrap()).unwrap();
        assert_eq!(json["moved"][0], "joint2 torque");
        assert_eq!(json["sensors"][0]["test"]["degrees_of_freedom"], 2);
        assert_eq!(json["sensors"][1]["parameters"][0]["values"][1], 0.9881);
    }
}
