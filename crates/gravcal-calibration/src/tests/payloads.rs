//! Loads of unknown mass: found as the difference of a link with and without them.

use std::fs;
use std::path::{Path, PathBuf};

use gravcal_robot_model::session::LAST_FRAME_CHOICE;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

use crate::check::check;
use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, PayloadNumber};
use gravcal_identification::SolveEnvironment;

const LINK: &str = r#"<link name="NAME"><inertial><origin xyz="0.1 0.05 0.12"/><mass value="2"/>
    <inertia ixx="0.03" iyy="0.025" izz="0.02" ixy="0.002" ixz="-0.001" iyz="0.003"/></inertial></link>"#;
const JOINT: &str = r#"<joint name="NAME" type="revolute"><parent link="PARENT"/><child link="CHILD"/>
    <origin xyz="0.1 0.05 0.3" rpy="1.2 0.3 0"/><axis xyz="0 0 1"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>"#;
const SIMULATION: &str = r#"
robot = { urdf = "arm.urdf", base = "base", tip = "c" }
seed = 3
[gravity]
direction = [0.1, -0.2, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.02
[position]
unit = "rad"
MOTION
[[load]]
name = "plate"
mass_kg = 1.5
link = "c"
position_m = [0.1, 0.05, 0.1]
[[load]]
name = "tool"
mass_kg = 0.8
link = "c"
position_m = [0.05, -0.1, 0.2]
[[joint]]
name = "j2"
torque_sensor = { gain = { value = 1.04, unit = "N·m/(N·m)" }, bias = { value = 0.3, unit = "N·m" } }
[[random]]
file = "bare.csv"
poses = POSES
[[random]]
file = "plate.csv"
poses = POSES
load = "plate"
[[random]]
file = "tool.csv"
poses = POSES
load = "tool"
"#;
const PLACE: [f64; 3] = [0.05, -0.1, 0.2];

/// The session of a simulated arm, standing or in motion, whose tool is of unknown mass.
fn written(folder: &Path, moving: bool, change: impl Fn(String) -> String) -> PathBuf {
    let link = |name: &str| LINK.replace("NAME", name);
    let joint = |name: &str, parent: &str, child: &str| {
        JOINT.replace("NAME", name).replace("PARENT", parent).replace("CHILD", child)
    };
    let joints = [joint("j1", "base", "a"), joint("j2", "a", "b"), joint("j3", "b", "c")].concat();
    let links = ["a", "b", "c"].map(link).concat();
    fs::write(folder.join("arm.urdf"), format!("<robot name=\"arm\"><link name=\"base\"/>{links}{joints}</robot>"))
        .unwrap();
    let motion =
        "[recording]\nrate_hz = 200\nsamples = 2000\nmove_s = 1\nmotion = { harmonics = 5, period_s = 10, seed = 2 }";
    let (motion, poses) = if moving { (motion, "2") } else { ("", "60") };
    fs::write(folder.join("simulation.toml"), SIMULATION.replace("MOTION", motion).replace("POSES", poses)).unwrap();
    let simulation = Simulation::read(&folder.join("simulation.toml")).unwrap();
    let files = write_session(&simulation, 0, folder, false).unwrap();
    let text = fs::read_to_string(&files[0]).unwrap();
    assert!(text.contains("mass_kg = 0.8"), "{text}");
    fs::write(&files[0], change(text.replace("mass_kg = 0.8", "mass_kg = \"unknown\""))).unwrap();
    files[0].clone()
}

fn estimate(path: &Path) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    let session = read_session(path).unwrap();
    estimate_jointly(&session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap()
}

fn assert_found(found: &PayloadNumber, truth: f64, most: f64) {
    let z = (found.value - truth) / found.std;
    assert!(z.abs() < 4.0 && found.std < most, "{found:?} is not {truth}");
}

#[test]
fn mass_and_centre_are_found_beside_a_known_load() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), false, |text| text);
    let result = estimate(&path);
    let [tool] = result.payloads.as_slice() else { panic!("{result:?}") };
    assert_eq!((tool.load.as_str(), tool.link.as_str()), ("tool", "c"));
    assert_found(tool.mass_kg.as_ref().unwrap(), 0.8, 0.02);
    for (found, truth) in tool.center_of_mass_m.as_ref().unwrap().iter().zip(PLACE) {
        assert_found(found, truth, 0.02);
    }
    assert!(tool.tensor_kg_m2.is_none() && tool.undetermined.is_none(), "{tool:?}");
    // The last joint's offset, which nothing tells, turns the frame in which the centre stands.
    let offset = result.parameters.iter().find(|parameter| parameter.name == "j3.position_offset").unwrap();
    assert_eq!(offset.held.as_deref(), Some(LAST_FRAME_CHOICE));
    let noted = |note: &String| {
        note.contains("is told with j3.position_offset held, as no reading tells it, and the frame of link c turns")
    };
    assert!(result.notes.iter().any(noted), "{:?}", result.notes);
    // The torque gains lean on the other load, as if the tool were not there.
    let gain = result.parameters.iter().find(|parameter| parameter.name == "j2.torque_gain").unwrap();
    assert!((gain.value.unwrap() - 1.04).abs() < 4.0 * gain.std.unwrap(), "{gain:?}");
    let report = check(&read_session(&path).unwrap()).unwrap();
    assert!(report.payloads[0].undetermined.is_none(), "{:?}", report.payloads);
}

#[test]
fn without_anything_that_tells_a_scale_no_number_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let lone = |text: String| text.replace("mass_kg = 1.5", "mass_kg = \"unknown\"");
    let path = written(folder.path(), false, lone);
    let result = estimate(&path);
    assert_eq!(result.payloads.len(), 2);
    for payload in &result.payloads {
        assert!(payload.mass_kg.is_none() && payload.center_of_mass_m.is_none(), "{payload:?}");
        assert!(payload.undetermined.as_ref().unwrap().contains("torque gains"), "{payload:?}");
    }
    let open = result.parameters.iter().filter(|p| p.name.ends_with("torque_gain") && p.value.is_none()).count();
    assert_eq!(open, 3);
    let report = check(&read_session(&path).unwrap()).unwrap();
    assert!(
        !report.complete && report.payloads.iter().all(|load| load.undetermined.is_some()),
        "{:?}",
        report.payloads
    );
}

#[test]
fn a_load_that_always_hangs_there_cannot_be_distinguished_from_its_link() {
    let folder = tempfile::tempdir().unwrap();
    let always = |text: String| {
        let kept: Vec<&str> = text.split("[[poses]]").collect();
        let tool = kept.iter().find(|part| part.contains("tool.csv")).unwrap();
        format!("{}[[poses]]{tool}", kept[0])
    };
    let result = estimate(&written(folder.path(), false, always));
    let tool = result.payloads.iter().find(|payload| payload.load == "tool").unwrap();
    assert!(tool.mass_kg.is_none() && tool.undetermined.as_ref().unwrap().contains("without it"), "{tool:?}");
}

#[test]
fn in_motion_the_tensor_is_found_too() {
    let folder = tempfile::tempdir().unwrap();
    let result = estimate(&written(folder.path(), true, |text| text));
    let tool = result.payloads.iter().find(|payload| payload.load == "tool").unwrap();
    assert_found(tool.mass_kg.as_ref().unwrap(), 0.8, 0.02);
    for (found, truth) in tool.center_of_mass_m.as_ref().unwrap().iter().zip(PLACE) {
        assert_found(found, truth, 0.02);
    }
    // Simulated loads are points.
    tool.tensor_kg_m2.as_ref().unwrap().iter().for_each(|entry| assert_found(entry, 0.0, 0.02));
}
