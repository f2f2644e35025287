//! The guide to iiwa, Panda, UR and Gen3 (`docs/how-to/robots.md`), followed with simulated recordings of the arms' published URDFs.

use std::fs;
use std::path::Path;

use crate::answer::Estimator;
use crate::experiments::{say, shared_data};
use crate::program::{Calibration, gravcal_in};
use crate::tree;

/// An arm whose second joint has a torque gain of 1.08 and a bias of 0.7 N·m.
struct Arm {
    urdf: &'static str,
    base: &'static str,
    /// The last link that moves.
    tip: &'static str,
    /// How many joints, and which has the fault.
    joints: (usize, &'static str),
    /// Further keys of the recording.
    recording: &'static str,
}

const PANDA: Arm = Arm {
    urdf: "panda_arm_drake.urdf",
    base: "panda_link0",
    tip: "panda_link7",
    joints: (7, "panda_joint2"),
    recording: "",
};
const GEN3: Arm = Arm {
    urdf: "kinova_gen3_7dof_v12.urdf",
    base: "base_link",
    tip: "bracelet_link",
    joints: (7, "joint_2"),
    recording: "",
};
const UR5E: Arm = Arm {
    urdf: "ur5e_ros-industrial.urdf",
    base: "base_link",
    tip: "wrist_3_link",
    joints: (6, "shoulder_lift_joint"),
    recording: ", approach = \"both-ways\", friction = { coulomb_newton_metre = 1.0 }",
};

impl Arm {
    /// A folder with the URDF, and two recordings of one kind of file; nothing where there is no URDF.
    fn recorded(&self, kind: &str) -> Option<tempfile::TempDir> {
        let urdf = shared_data(&tree::experiment("kuka-lwr4")).join("urdf").join(self.urdf);
        if !urdf.is_file() {
            say(&format!("SKIPPED: the guide to robots: there is no file {}", urdf.display()));
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("arm.urdf"), fs::read(urdf).unwrap()).unwrap();
        let Arm { base, tip, recording, joints: (_, faulty), .. } = self;
        let simulation = format!(
            r#"robot = {{ urdf = "arm.urdf", base = "{base}", tip = "{tip}" }}
seed = 5
gravity = {{ direction = [0.1, 0.05, -1.0], magnitude_m_per_s2 = 9.80665 }}
torque = {{ unit = "N·m", std = 0.02 }}
position = {{ unit = "rad" }}
recording = {{ rate_hz = 125, samples = 125, move_s = 1.5, settling_s = 0.4{recording} }}
load = [{{ name = "plate", mass_kg = 2.0, link = "{tip}", position_m = [0.03, 0.02, 0.06] }}]
random = [{{ file = "bare.{kind}", poses = 40 }}, {{ file = "loaded.{kind}", poses = 40, load = "plate" }}]
[[joint]]
name = "{faulty}"
torque_sensor = {{ gain = {{ value = 1.08, unit = "N·m/(N·m)" }}, bias = {{ value = 0.7, unit = "N·m" }} }}
"#
        );
        fs::write(folder.path().join("simulation.toml"), simulation).unwrap();
        let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--output", "simulated"]);
        assert_eq!(run.code, 0, "{run:?}");
        for file in ["bare", "loaded"] {
            let file = format!("{file}.{kind}");
            fs::rename(folder.path().join("simulated").join(&file), folder.path().join(&file)).unwrap();
        }
        Some(folder)
    }

    /// What the guide tells to do: inspect, look over the draft, add the load, calibrate. `more` is what the draft asks to fill in.
    fn calibrated(&self, folder: &Path, kind: &str, more: &str) -> Estimator {
        let bare = format!("bare.{kind}");
        let run = gravcal_in(folder, ["inspect", &bare, "--robot", "arm.urdf", "--session", "session.toml"]);
        assert_eq!(run.code, 0, "{run:?}");
        let path = folder.join("session.toml");
        let draft = fs::read_to_string(&path).unwrap().replace("# hemisphere = [0, 0, -1]", "hemisphere = [0, 0, -1]");
        assert!(draft.contains(&format!("tip = \"{}\"", self.tip)), "{draft}");
        let load = format!(
            "{more}\n[[load]]\nname = \"plate\"\nmass_kg = 2.0\nlink = \"{}\"\n\n[[poses]]\nfile = \"loaded.{kind}\"\nload = \"plate\"\n",
            self.tip
        );
        fs::write(&path, format!("{draft}\n{load}")).unwrap();
        let calibration = Calibration::of(&path);
        assert!([0, 3].contains(&calibration.run.code), "{:?}", calibration.run);
        calibration.estimator("joint")
    }
}

/// The joint's gain (or what else of it) has a number that is right.
fn assert_found(joint: &Estimator, name: &str, truth: f64) {
    let found = joint.parameter(name).unwrap();
    let (value, std) = (found.value.unwrap(), found.std.unwrap());
    assert!((value - truth).abs() < 4.0 * std && std < 0.01 * truth.abs().max(1.0), "{name}: {value} ± {std}");
}

#[test]
fn a_fault_is_found_in_a_panda_and_a_gen3() {
    for arm in [PANDA, GEN3] {
        let Some(folder) = arm.recorded("mcap") else { return };
        let joint = arm.calibrated(folder.path(), "mcap", "");
        let (joints, faulty) = arm.joints;
        assert_found(&joint, &format!("{faulty}.torque_gain"), 1.08);
        assert_found(&joint, &format!("{faulty}.torque_bias"), 0.7);
        let gains = joint.parameters.iter().filter(|one| one.name.ends_with(".torque_gain") && one.value.is_some());
        assert_eq!(gains.count(), joints, "{}", arm.urdf);
    }
}

/// The columns of efforts as currents: 0.1 A for 1 N·m.
fn as_currents(path: &Path) {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().unwrap();
    let effort: Vec<bool> = header.split(',').map(|name| name.ends_with(".effort")).collect();
    let mut currents = header.replace(".effort", ".current") + "\n";
    for line in lines {
        let cells = line.split(',').zip(&effort).map(|(cell, effort)| match effort {
            true => (0.1 * cell.parse::<f64>().unwrap()).to_string(),
            false => cell.to_owned(),
        });
        currents += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    fs::write(path, currents).unwrap();
}

#[test]
fn a_fault_is_found_in_the_currents_of_a_ur5e() {
    let Some(folder) = UR5E.recorded("csv") else { return };
    ["bare.csv", "loaded.csv"].iter().for_each(|file| as_currents(&folder.path().join(file)));
    // The motors' constants are known to a tenth or so; gravcal finds them.
    let filled_in = r#"[joints]
torque_gain = { nominal = 0.11, unit = "A/(N·m)" }
sensor_models = [{ kind = "coulomb-friction" }]
"#;
    let joint = UR5E.calibrated(folder.path(), "csv", filled_in);
    assert_found(&joint, "shoulder_lift_joint.torque_gain", 0.108);
    assert_found(&joint, "shoulder_lift_joint.torque_bias", 0.07);
    assert_found(&joint, "elbow_joint.torque_gain", 0.1);
}
