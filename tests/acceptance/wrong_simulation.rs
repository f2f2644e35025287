//! What a user can get wrong in a simulation: told with its file, line and field, and nothing is written.

use std::fs;

use crate::program::gravcal_in;
use crate::tree;

const SIMULATION: &str = r#"robot = "robot.toml"
seed = 1
gravity = { direction = [0.0, -6.0, -7.0], magnitude_m_per_s2 = 9.8 }

[torque]
unit = "count"
std = 0.8
converter = { bits = 12, range = [0.0, 4096.0] }

[position]
unit = "rad"

[[load]]
name = "plate"
mass_kg = 1.7
link = "link3"
position_m = [0.3, 0.05, 0.5]

[[sweep]]
file = "sweep.csv"
joint = "joint1"
range_deg = [-90.0, 90.0]
poses = 9
held_deg = { joint2 = -90.0, joint3 = -90.0 }

[[random]]
file = "random.csv"
poses = 10
load = "plate"
"#;

/// What is replaced, by what, and what must be told; `{line}` is the line of the change.
const MISTAKES: &[(&str, &str, &str)] = &[
    ("seed = 1", "sed = 1", "simulation.toml:{line}: sed: unknown field"),
    ("seed = 1", "seed = -1", "simulation.toml:{line}: seed: "),
    ("\"robot.toml\"", "\"absent.toml\"", "absent.toml: there is no such file"),
    ("[0.0, -6.0, -7.0]", "[0, 0, 0]", "simulation.toml:{line}: gravity.direction: a direction needs a length"),
    ("std = 0.8", "std = nan", "simulation.toml:{line}: torque.std: expected a finite number"),
    ("std = 0.8", "std = -0.8", "simulation.toml:{line}: torque.std: -0.8 is not a standard deviation"),
    ("unit = \"count\"", "unit = \"lbf\"", "simulation.toml:{line}: torque.unit: the unit `lbf` does not fit"),
    ("bits = 12", "bits = 99", "simulation.toml:{line}: torque.converter.bits: 99 bits"),
    ("[0.0, 4096.0]", "[4096.0, 0.0]", "simulation.toml:{line}: torque.converter.range: "),
    ("mass_kg = 1.7", "mass_kg = -1.7", "simulation.toml:{line}: load[0].mass_kg: -1.7 is not a mass"),
    ("\"link3\"", "\"link9\"", "simulation.toml:{line}: load[0].link: there is no link `link9`"),
    ("\"joint1\"", "\"joint9\"", "simulation.toml:{line}: sweep[0].joint: there is no joint `joint9`"),
    ("poses = 9", "poses = 1", "simulation.toml:{line}: sweep[0].poses: 1 pose identifies nothing"),
    ("poses = 9", "poses = 9000000000000000000", "simulation.toml:{line}: sweep[0].poses: "),
    ("poses = 10", "poses = 9000000000000000000", "simulation.toml:{line}: random[0].poses: "),
    ("\"random.csv\"", "\"sweep.csv\"", "simulation.toml:{line}: random[0].file: `sweep.csv` is already sweep[0].file"),
    ("\"random.csv\"", "\"../random.csv\"", "simulation.toml:{line}: random[0].file: "),
    ("\"random.csv\"", "\"session.toml\"", "simulation.toml:{line}: random[0].file: "),
    ("load = \"plate\"", "load = \"disc\"", "simulation.toml:{line}: random[0].load: there is no load `disc`"),
];

#[test]
fn the_simulation_without_mistakes_is_written() {
    let folder = prepared(SIMULATION);
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--output", "made"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(folder.path().join("made/session.toml").is_file());
}

#[test]
fn mistakes_in_a_simulation_are_reported() {
    let wrong: Vec<String> = MISTAKES.iter().filter_map(|(old, new, reported)| untold(old, new, reported)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// A recording whose numbers are large has an end all the same, or is refused.
#[test]
fn recordings_without_end_are_refused() {
    let recording = "\n[recording]\nrate_hz = 500\nsamples = 150\nmove_s = 0.4\n";
    let simulation = SIMULATION.replace(".csv", ".mcap") + recording;
    let cases = [
        ("samples = 150", "samples = 9223372036854775807", "recording.samples: 19 poses at this rate"),
        ("rate_hz = 500", "rate_hz = 1e17", "recording.rate_hz: 100000000000000000 Hz are too many"),
        ("rate_hz = 500", "rate_hz = 1e-9", "recording.rate_hz: 19 poses at this rate take"),
        ("move_s = 0.4", "move_s = 1e300", "recording.samples: "),
        ("move_s = 0.4", "move_s = 0.4\nsettling_s = 1e12", "recording.samples: "),
    ];
    for (old, new, reported) in cases {
        let folder = prepared(&simulation.replacen(old, new, 1));
        let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--output", "made"]);
        assert_eq!(run.refusal(&[reported]), None, "{new}");
        assert!(!folder.path().join("made").exists());
    }
}

#[test]
fn a_session_that_cannot_be_written_is_reported() {
    let folder = prepared(SIMULATION);
    for output in ["robot.toml", "robot.toml/made"] {
        let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--output", output]);
        assert_eq!(run.refusal(&["robot.toml"]), None);
    }
}

fn untold(old: &str, new: &str, reported: &str) -> Option<String> {
    let line = 1 + SIMULATION.split_once(old).unwrap().0.matches('\n').count();
    let folder = prepared(&SIMULATION.replacen(old, new, 1));
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--output", "made"]);
    if folder.path().join("made").exists() {
        return Some(format!("{new}: something was written"));
    }
    run.refusal(&[&reported.replace("{line}", &line.to_string())]).map(|wrong| format!("{new}: {wrong}"))
}

/// A simulation beside its robot.
fn prepared(simulation: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let robot = tree::root().join("models/sarcos-dextrous-arm/robot.toml");
    fs::copy(robot, folder.path().join("robot.toml")).unwrap();
    fs::write(folder.path().join("simulation.toml"), simulation).unwrap();
    folder
}
