//! What a session demands of the joint estimate: it is obeyed, told where the estimate leans on it, and refused where it makes
//! no sense or the method cannot obey.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::answer::{Answer, Estimator};
use crate::program::{Run, gravcal_in};
use crate::small_session::RESULTS;
use crate::tree;

/// A platform that one joint lifts; all that is unknown is its mass and how steep gravity is.
const LIFT: [(&str, &str); 4] = [
    (
        "robot.toml",
        r#"name = "lift"
convention = "standard-dh"
[[joint]]
name = "lift"
kind = "prismatic"
a_m = 0.0
alpha_deg = 0.0
d_m = 0.0
theta_deg = 0.0
link = "platform"
"#,
    ),
    (
        "session.toml",
        r#"robot = "robot.toml"
estimators = ["joint"]
solver = "clarabel"

[gravity]
magnitude_m_per_s2 = 9.8
hemisphere = [0.3, 0, -0.9]

[readings]
position = { columns = ["q"], unit = "m" }
torque = { columns = ["y"], unit = "N", std = 0.5 }

[[joint]]
name = "lift"
torque_gain = { fixed = 1, unit = "N/N" }
torque_bias = { fixed = 0, unit = "N" }
position_gain = { fixed = 1, unit = "m/m" }

[[load]]
name = "weight"
mass_kg = 5.0
link = "platform"
position_m = [0, 0, 0]

[[poses]]
file = "bare.csv"

[[poses]]
file = "weight.csv"
load = "weight"

[ask]
drop = ["gravity"]

[constraints]
masses = "positive"
"#,
    ),
    ("bare.csv", "q,y\n0.0,-0.4\n0.1,-0.4\n0.2,-0.4\n"),
    ("weight.csv", "q,y\n0.0,45\n0.1,45\n0.2,45\n"),
];

/// The lift with something in its session replaced.
fn lift(old: &str, new: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in LIFT {
        assert!(name != "session.toml" || text.contains(old), "{old}");
        let text = if name == "session.toml" { text.replacen(old, new, 1) } else { text.to_owned() };
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn calibrate(folder: &Path, options: &[&str]) -> Run {
    gravcal_in(folder, ["calibrate", "--full", "session.toml", "--output", RESULTS].iter().chain(options))
}

fn joint(folder: &Path) -> Estimator {
    let text = fs::read(folder.join(RESULTS).join("calibration.json")).unwrap();
    let answer: Answer = serde_json::from_slice(&text).unwrap();
    answer.estimators.into_iter().find(|estimator| estimator.name == "joint").unwrap()
}

/// With gravity g along the axis and the platform's mass m, three readings of −0.4 N must be m g, three of 45 N (m + 5) g,
/// each to 0.5 N: without constraints m = −0.044 kg. At m = 0 the loaded readings give g = 9 m/s², the bare ones leave 0.4 N
/// each, and ½ χ² = 3 · ½ (0.4/0.5)² has the slope 3 · 0.4 · 9/0.5² = 43.2 by m: it would fall by that for each kg.
#[test]
fn a_mass_that_would_be_negative_is_zero_and_named() {
    let folder = lift("", "");
    let run = calibrate(folder.path(), &[]);
    assert_eq!(run.code, 0, "{run:?}");
    let reported = "Active constraints, and by how much ½ χ² would fall if they gave way\n  \
                platform.mass is at least 0: 43.2 per kg\n";
    assert!(run.stdout.contains(reported), "{}", run.stdout);
    let joint = joint(folder.path());
    let [active] = &joint.active_constraints[..] else { panic!("{joint:?}") };
    assert_eq!((active.constraint.as_str(), active.unit.as_str()), ("platform.mass is at least 0", "kg"));
    assert!((active.multiplier - 43.2).abs() < 1e-9, "{active:?}");
    let [mass] = &joint.moments[..] else { panic!("{joint:?}") };
    assert_eq!(mass.value, 0.0);
    assert!(
        (mass.std - 0.032).abs() < 1e-3,
        "a bound that leans by 1.4 deviations leaves open what it holds: {mass:?}"
    );
}

#[test]
fn a_mass_that_may_be_negative_is() {
    let folder = lift("[constraints]\nmasses = \"positive\"\n", "");
    let run = calibrate(folder.path(), &[]);
    assert_eq!(run.code, 0, "{run:?}");
    let joint = joint(folder.path());
    assert!(joint.active_constraints.is_empty() && !run.stdout.contains("Active constraints"));
    assert!((joint.moments[0].value + 0.044).abs() < 1e-3, "{:?}", joint.moments);
}

/// The true gain of joint 6 is 6 % below its nominal value, those of joints 1 and 5 are as far and farther above.
#[test]
fn gains_stay_within_what_is_allowed() {
    let experiment = tree::experiment("seven-joints-tilted");
    let folder = tempfile::tempdir().unwrap();
    for table in ["bare.csv", "weight-a.csv", "weight-b.csv"] {
        fs::copy(experiment.join(table), folder.path().join(table)).unwrap();
    }
    fs::copy(tree::root().join("models/kuka-lbr-iiwa14/robot.toml"), folder.path().join("robot.toml")).unwrap();
    let session = fs::read_to_string(experiment.join("session.toml")).unwrap();
    let session = session.replace("../../models/kuka-lbr-iiwa14/robot.toml", "robot.toml");
    let constraints =
        "\n[constraints]\ntorque_gains_within = 0.055\nmasses = \"positive\"\ncenter_of_mass_within_m = 0.3\n";
    fs::write(folder.path().join("session.toml"), session + constraints).unwrap();
    let run = calibrate(folder.path(), &["--solver", "clarabel", "--estimator", "joint"]);
    assert!([0, 4].contains(&run.code), "{run:?}");
    let active: Vec<String> = joint(folder.path()).active_constraints.into_iter().map(|a| a.constraint).collect();
    for name in ["joint1", "joint5", "joint6"] {
        let constraint = format!("{name}.torque_gain is within 5.5 % of 1");
        assert!(active.contains(&constraint), "{active:?}");
    }
    assert!(active.iter().all(|name| name.contains("torque_gain")), "masses and centres are free enough: {active:?}");
}

#[test]
fn constraints_that_make_no_sense_are_reported() {
    let mistakes: [(&str, &[&str]); 6] = [
        (
            "center_of_mass_within_m = -0.1",
            &["session.toml:36: constraints.center_of_mass_within_m: -0.1 is not a distance"],
        ),
        (
            "center_of_mass_within_m = { platfrom = 0.1 }",
            &[
                "session.toml:36: constraints.center_of_mass_within_m.platfrom: there is no link `platfrom`",
                "`platform`",
            ],
        ),
        (
            "masses = \"negative\"",
            &["session.toml:36: constraints.masses: unknown variant `negative`, expected `positive`"],
        ),
        ("mass = \"positive\"", &["session.toml:36: constraints.mass: unknown field `mass`", "`masses`"]),
        ("torque_gains_within = 0", &["session.toml:36: constraints.torque_gains_within: 0 is not a share"]),
        (
            "center_of_mass_within_m = \"near\"",
            &["session.toml:36: constraints.center_of_mass_within_m: ", "expected one number for all links or a table"],
        ),
    ];
    for (written, reported) in mistakes {
        let folder = lift("masses = \"positive\"", written);
        assert_eq!(calibrate(folder.path(), &[]).refusal(reported), None, "{written}");
        assert!(!folder.path().join(RESULTS).exists(), "{written}");
    }
}

#[test]
fn constraints_that_would_not_be_obeyed_are_refused() {
    let folder = lift("", "");
    let refused = calibrate(folder.path(), &["--solver", "levenberg-marquardt"]);
    let reported =
        ["session.toml:35: constraints: levenberg-marquardt cannot take", "platform.mass is at least 0", "clarabel"];
    assert_eq!(refused.refusal(&reported), None);
    let refused = calibrate(folder.path(), &["--estimator", "sequential"]);
    assert_eq!(refused.refusal(&["session.toml:35: constraints: only the joint estimators obey constraints"]), None);
    assert!(!folder.path().join(RESULTS).exists());
}
