use super::*;
use gravcal_calibration::check::{
    CheckedParameter, Curable, Cure, PredictedStd, StepReport, SweepReport, TiltReport, TiltedGain,
};
use gravcal_calibration::result::Undetermined;

fn parameter(name: &str, unit: &str, predicted_std: Option<f64>) -> CheckedParameter {
    CheckedParameter { name: name.into(), unit: unit.into(), asked: true, determined: true, held: None, predicted_std }
}

fn cure(addition: &str, stds: &[Option<f64>]) -> Cure {
    let predicted = |(index, std): (usize, &Option<f64>)| PredictedStd {
        name: format!("joint{}.torque_gain", index + 1),
        unit: "count/(N·m)".into(),
        std: *std,
    };
    Cure { addition: addition.into(), predicted: stds.iter().enumerate().map(predicted).collect() }
}

fn report() -> CheckReport {
    let held = Some("zero by definition of the base frame".to_owned());
    CheckReport {
        assumes_upright: false,
        doubts: Vec::new(),
        judged_at: "Judged at nominal values, gravity along the declared hemisphere.".into(),
        poses: vec![("none".into(), 111), ("plate-a".into(), 37)],
        torque_readings: vec![("joint1".into(), 148), ("joint2".into(), 147)],
        standstills: Vec::new(),
        selection: Some("Torque readings left by the limits of motion: joint1 148 of 150, joint2 147 of 150.".into()),
        unmoved: Some("Position readings that are the same in all 150 poses: joint3.".into()),
        sweep_rule: "A sweep is five or more rows in which one joint moves.".into(),
        sweeps: vec![SweepReport {
            table: "bias.csv".into(),
            lines: [2, 38],
            joint: "joint1".into(),
            poses: 37,
            range_deg: [-90.0, 90.0],
            load: None,
            steps: vec![1, 3],
        }],
        steps: vec![
            StepReport { step: 1, finds: "joint1.torque_bias, joint1.position_gain".into(), sweeps: 1, problem: None },
            StepReport { step: 2, finds: "gravity".into(), sweeps: 0, problem: Some("no sweep of joint2".into()) },
        ],
        supposed_errors: None,
        parameters: vec![
            parameter("gravity", "deg", Some(0.0234)),
            CheckedParameter { determined: false, ..parameter("joint1.torque_gain", "count/(N·m)", None) },
            parameter("joint1.torque_bias", "count", Some(0.118)),
            CheckedParameter { held, asked: false, ..parameter("joint1.position_offset", "rad", None) },
            parameter("joint2.torque_bias", "count", None),
            parameter("joint2.position_offset", "rad", Some(0.001)),
        ],
        payloads: Vec::new(),
        undetermined: vec![
            Curable {
                undetermined: Undetermined {
                    combination: "joint1.torque_gain".into(),
                    parameters: vec!["joint1.torque_gain".into()],
                    why: "gravity is parallel to the axis of joint1".into(),
                    cure: "tilt the base".into(),
                },
                cures: vec![cure("tilt the base", &[Some(0.0123)]), cure("turn it over", &[None])],
            },
            Curable {
                undetermined: Undetermined {
                    combination: "joint2.position_gain".into(),
                    parameters: vec!["joint2.position_gain".into()],
                    why: "the range is short".into(),
                    cure: "move more".into(),
                },
                cures: Vec::new(),
            },
        ],
        tilts: vec![TiltReport {
            tilt_deg: 10.0,
            torque_gain: TiltedGain { determined: true, relative_std: Some(0.0123) },
            position_gain: TiltedGain { determined: false, relative_std: None },
        }],
        complete: false,
    }
}

#[test]
fn the_whole_table() {
    let report = report();
    assert_eq!(
        CheckTable { robot: "arm", report: &report, steps: true }.to_string(),
        "\
Check of arm
  not everything that is asked for can be determined: not joint1.torque_gain
  Judged at nominal values, gravity along the declared hemisphere.

Predicted standard deviations, joint estimator
                     unit          predicted std
  gravity            deg                   0.023
  joint1
    torque_gain      count/(N·m)    undetermined
    torque_bias      count                  0.12
    position_offset  deg               fixed [1]
  joint2
    torque_bias      count        determined [2]
    position_offset  deg                   0.057
  [1] fixed: zero by definition of the base frame
  [2] can be determined; how well depends on noise that no reading states

Undetermined by the joint estimator, cures in the order of effort
  joint1.torque_gain
    why  gravity is parallel to the axis of joint1
    cure tilt the base: joint1.torque_gain ± 0.012 count/(N·m)
    or   turn it over
  joint2.position_gain
    why  the range is short
    cure none was found among single additions and pairs; as a rule: move more

What a tilt of the base brings to the first joint: predicted std
  tilt, deg  torque gain, %  position gain, %
         10             1.2      undetermined

Poses by load: none 111, plate-a 37
Torque readings by joint: joint1 148, joint2 147
Torque readings left by the limits of motion: joint1 148 of 150, joint2 147 of
  150.
Position readings that are the same in all 150 poses: joint3.

Sweeps
  A sweep is five or more rows in which one joint moves.
  swept   poses  from, deg  to, deg  load  steps  table:lines
  joint1     37      -90.0     90.0  none  1, 3   bias.csv:2-38

Sequential procedure
  step 1 finds joint1.torque_bias, joint1.position_gain from 1 sweep
  step 2 cannot find gravity: no sweep of joint2
"
    );
}

#[test]
fn a_complete_session_says_so_first() {
    let report = CheckReport { complete: true, ..report() };
    let text = CheckTable { robot: "arm", report: &report, steps: true }.to_string();
    assert!(text.starts_with("Check of arm\n  everything that is asked for can be determined\n"));
}

#[test]
fn an_upright_base_is_said_to_be_assumed() {
    let reported = |assumes_upright| {
        let report = CheckReport { assumes_upright, ..report() };
        CheckSummary { robot: "arm", report: &report, steps: false }.to_string()
    };
    let said = "Assumed: an upright base, as no [gravity] hemisphere is stated.\n";
    assert!(reported(true).contains(said) && !reported(false).contains(said));
}

#[test]
fn a_tilt_without_stated_noise_tells_what_can_be_determined() {
    let gain = |determined| TiltedGain { determined, relative_std: None };
    let tilt = TiltReport { tilt_deg: 5.0, torque_gain: gain(false), position_gain: gain(true) };
    let text =
        CheckTable { robot: "arm", report: &CheckReport { tilts: vec![tilt], ..report() }, steps: true }.to_string();
    let reported = "  tilt, deg  torque gain, %  position gain, %\n\
                \x20       5.0    undetermined    determined [1]\n\
                \x20 [1] can be determined; how well depends on noise that no reading states\n";
    assert!(text.contains(reported), "{text}");
}

#[test]
fn json_has_the_same_fields() {
    let json: serde_json::Value = serde_json::from_str(&check_json(&report()).unwrap()).unwrap();
    assert_eq!(json["complete"], false);
    assert_eq!(json["parameters"][0]["name"], "gravity");
    assert_eq!(json["undetermined"][0]["cure"], "tilt the base");
    assert_eq!(json["undetermined"][0]["cures"][0]["predicted"][0]["std"], 0.0123);
}

#[test]
fn of_a_cure_of_many_parameters_some_are_listed() {
    let many = Curable {
        cures: vec![cure("attach a load", &[Some(0.5), Some(0.25), Some(0.125)])],
        ..report().undetermined[0].clone()
    };
    let text = CheckTable { robot: "arm", report: &CheckReport { undetermined: vec![many], ..report() }, steps: true }
        .to_string();
    let words: Vec<&str> = text.split_whitespace().collect();
    let reported = "joint1.torque_gain ± 0.50 count/(N·m), joint2.torque_gain ± 0.25 count/(N·m), … (3 in all)";
    assert!(words.join(" ").contains(reported), "{text}");
}

#[test]
fn of_steps_that_nobody_asked_for_nothing_is_said() {
    let report = report();
    let full = CheckTable { robot: "arm", report: &report, steps: false }.to_string();
    let summary = |steps| CheckSummary { robot: "arm", report: &report, steps }.to_string();
    for text in [&full, &summary(false)] {
        assert!(!text.contains("equential") && !text.contains("Sweeps"), "{text}");
    }
    assert!(summary(true).contains("The sequential estimator cannot find gravity\n"), "{}", summary(true));
}

#[test]
fn a_summary_has_one_line_a_joint_and_the_first_cures() {
    let report = report();
    let text = CheckSummary { robot: "arm", report: &report, steps: true }.to_string();
    assert!(text.starts_with("Check of arm: "), "{text}");
    let joint = text.lines().find(|line| line.starts_with("joint1 ")).unwrap();
    assert_eq!(joint.split_whitespace().collect::<Vec<_>>(), ["joint1", "open", "0.12", "fixed"], "{text}");
    assert!(text.contains("tilt the base") && text.contains("gravity 0.023 deg"), "{text}");
    assert!(text.lines().count() <= 25 && text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn a_summary_says_what_errors_its_numbers_allow_for() {
    let report = CheckReport { supposed_errors: Some(1e-3), ..report() };
    let text = CheckSummary { robot: "arm", report: &report, steps: false }.to_string();
    let words: Vec<&str> = text.split_whitespace().collect();
    let heading = "Standard deviations to expect, if readings err by 0.1 % of a joint's largest torque, beyond noise";
    assert!(words.join(" ").contains(heading), "{text}");
}
