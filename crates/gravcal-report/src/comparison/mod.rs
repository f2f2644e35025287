//! Several calibrations of one robot beside each other: which sensor moved.

mod caveats;
mod json;
mod text;

use std::fmt;

use gravcal_calibration::comparison::Comparison;

use crate::json::JsonError;
pub use caveats::{different_robots, shared_inputs};

/// A comparison with the names of what is compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonReport<'a> {
    /// The files, in the order in which they were compared.
    pub files: &'a [String],
    /// Recordings and calibrations that several of them were made from: see [`shared_inputs`].
    pub shared: &'a [String],
    /// Descriptions of the robot, where they differ: see [`different_robots`].
    pub robots: &'a [String],
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

#[cfg(test)]
mod tests {
    use gravcal_calibration::comparison::{ComparedParameter, HomogeneityTest, LeftOut, SensorComparison};

    use super::*;

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
            corrected_p_value: (2.0 * p_value).min(1.0),
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
            in_all: true,
            models_differ_in: vec![],
            test: Some(test(196.4, 2.1e-43, true)),
            beside_others: None,
        };
        let position = SensorComparison {
            name: "joint1 position".into(),
            parameters: vec![parameter("joint1.position_gain", "rad/rad", [0.988, 0.9881], 0.0005)],
            left_out: vec![LeftOut {
                name: "joint1.position_offset".into(),
                why: "is held in calibration 1 (it defines the base frame)".into(),
                can_move: true,
            }],
            in_all: true,
            models_differ_in: vec![],
            test: Some(test(1.2, 0.55, false)),
            beside_others: None,
        };
        Comparison {
            sensors: vec![torque, position],
            base_frame: vec!["joint1.position_offset".into()],
            doubts: vec![vec![]; 2],
        }
    }

    fn report<'a>(comparison: &'a Comparison, files: &'a [String], shared: &'a [String]) -> ComparisonReport<'a> {
        ComparisonReport { files, shared, robots: &[], comparison, verbose: false }
    }

    #[test]
    fn the_verdict_stands_first_and_lines_fit() {
        let (comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        let text = report(&comparison, &files, &["poses.csv".to_owned()]).to_string();
        assert!(text.starts_with("Moved: joint2 torque\n"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.contains("  joint2 torque     196    2  < 0.001    < 0.001  moved\n"), "{text}");
        assert!(text.contains("joint2.torque_gain  count/(N·m)  1    7.124 ± 0.022\n"), "{text}");
        assert!(text.contains("were made from the same poses.csv"), "{text}");
        assert!(text.contains("Not seen: joint1.position_offset\n"), "{text}");
        assert!(text.contains("  joint1 position  1.20    2     0.55        1.0  gain only\n"), "{text}");
        let mut nothing = Comparison { sensors: comparison.sensors[1..].to_vec(), ..comparison };
        let text = report(&nothing, &files, &[]).to_string();
        assert!(text.starts_with("Nothing that can be compared moved; not seen: joint1.position_offset\n"), "{text}");
        assert!(text.contains("  1 test (Holm);"), "{text}");
        nothing.sensors[0].left_out.clear();
        let text = report(&nothing, &files, &[]).to_string();
        assert!(text.starts_with("Nothing moved, as far as these calibrations tell\n"), "{text}");
    }

    /// The offset that defines the base frame is fixed: gravity moves in its stead.
    #[test]
    fn a_move_of_gravity_names_what_it_may_stand_for() {
        let (mut comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        comparison.sensors[0].name = "gravity".into();
        let text = report(&comparison, &files, &[]).to_string();
        assert!(text.starts_with("Moved: gravity or joint1.position_offset\n"), "{text}");
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("either the base was tilted, or that offset moved"), "{text}");
        comparison.base_frame.clear();
        let text = report(&comparison, &files, &[]).to_string();
        assert!(text.starts_with("Moved: gravity\n") && !text.contains("tilted"), "{text}");
    }

    #[test]
    fn what_may_pass_for_a_move_is_warned_of() {
        let (mut comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        comparison.sensors[0].models_differ_in = vec!["joint2.coulomb_friction".into()];
        comparison.sensors[1].in_all = false;
        let robots = ["a.urdf (calibration 1)".to_owned(), "b.urdf (calibration 2)".to_owned()];
        let text = ComparisonReport { robots: &robots, ..report(&comparison, &files, &[]) }.to_string();
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for reported in [
            "Warning: their descriptions of the robot differ: a.urdf (calibration 1), b.urdf (calibration 2).",
            "Warning: not in all of these: joint1 position.",
            "Warning: joint2 torque has different models: joint2.coulomb_friction is not in all of these.",
        ] {
            assert!(words.contains(reported), "{text}");
        }
    }

    #[test]
    fn no_sensor_is_blamed_before_a_doubtful_calibration() {
        let (mut comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        comparison.doubts[1].push("its readings are explained 2.4 times worse than their stated noise".into());
        let text = report(&comparison, &files, &[]).to_string();
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.starts_with("Doubtful: calibration 2 (its readings are explained 2.4 times worse"), "{text}");
        assert!(words.contains("Moved, or spoilt by an error of a model: joint2 torque"), "{text}");
        let json: serde_json::Value =
            serde_json::from_str(&report(&comparison, &files, &[]).to_json().unwrap()).unwrap();
        assert_eq!(json["doubts"][1][0], comparison.doubts[1][0]);
        assert_eq!(json["doubts"][0], serde_json::json!([]));
        // Where nothing moved, doubts are no reason to speak of a move.
        comparison.sensors[0].test = None;
        let text = report(&comparison, &files, &[]).to_string();
        assert!(text.starts_with("Doubtful: ") && !text.contains("Moved"), "{text}");
    }

    #[test]
    fn json_has_all_numbers() {
        let (comparison, files) = (comparison(), ["monday.json".to_owned(), "tuesday.json".to_owned()]);
        let json: serde_json::Value =
            serde_json::from_str(&report(&comparison, &files, &[]).to_json().unwrap()).unwrap();
        assert_eq!(json["moved"][0], "joint2 torque");
        assert_eq!(json["not_seen"], serde_json::json!(["joint1.position_offset"]));
        assert_eq!(json["gravity_stands_for"], json["not_seen"]);
        assert_eq!(json["sensors"][0]["test"]["degrees_of_freedom"], 2);
        assert_eq!(json["sensors"][1]["parameters"][0]["values"][1], 0.9881);
    }
}
