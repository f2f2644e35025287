//! Arms in motion, from `simulation.toml` over recordings to the estimate.

use std::fs;
use std::path::Path;

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, ResidualTest, ResidualTestKind};

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
std = 1e-5
[recording]
rate_hz = 200
samples = 3000
move_s = 1
motion = { harmonics = 5, period_s = 10, seed = 2 }
[[load]]
name = "plate"
mass_kg = 1.5
link = "c"
position_m = [0.1, 0.05, 0.1]
[[joint]]
name = "j2"
torque_sensor = { gain = { value = 1.04, unit = "N·m/(N·m)" }, bias = { value = 0.3, unit = "N·m" } }
position_sensor = { gain = { value = 1.003, unit = "rad/rad" }, offset = { value = 1.5, unit = "deg" } }
sensor_models = [{ kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.4, unit = "N·m" } } }]
[[random]]
file = "bare.csv"
poses = 2
[[random]]
file = "loaded.csv"
poses = 2
load = "plate"
"#;

/// What is said of an arm that moves too fast for it to be known well how its joints bend.
const FAST: &str = "The arm moves so fast";

fn simulation(folder: &Path, text: &str) -> Simulation {
    let link = |name: &str| LINK.replace("NAME", name);
    let joint = |name: &str, parent: &str, child: &str| {
        JOINT.replace("NAME", name).replace("PARENT", parent).replace("CHILD", child)
    };
    let joints = [joint("j1", "base", "a"), joint("j2", "a", "b"), joint("j3", "b", "c")].concat();
    let links = ["a", "b", "c"].map(link).concat();
    let urdf = format!("<robot name=\"arm\"><link name=\"base\"/>{links}{joints}</robot>");
    fs::write(folder.join("arm.urdf"), urdf).unwrap();
    fs::write(folder.join("simulation.toml"), text).unwrap();
    Simulation::read(&folder.join("simulation.toml")).unwrap()
}

#[test]
fn a_simulated_arm_in_motion_is_identified() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = simulation(folder.path(), SIMULATION);
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    assert!(fs::read_to_string(&files[0]).unwrap().contains("[readings.motion]"));
    let session = read_session(&files[0]).unwrap();
    // Two stretches of 15 s in each of two tables; a window each twentieth of a second.
    assert!((1100..1200).contains(&session.poses.len()), "{}", session.poses.len());
    assert!(session.has_windows() && session.searched.iter().all(|searched| searched.found() > 500));
    is_identified(&simulation, &session);
}

/// Friction that builds up over 2 mrad after the joint turned round: the travel is told, and with it the model explains the readings; a model
/// without it does not.
#[test]
fn friction_that_builds_up_is_identified() {
    let folder = tempfile::tempdir().unwrap();
    let model = "sensor_models = [{ kind = \"presliding-friction\", parameters = { coulomb_friction = { value = 0.8, unit = \"N·m\" }, \
                 presliding_travel = { value = 0.002, unit = \"rad\" } } }]";
    let coulomb = SIMULATION.lines().find(|line| line.starts_with("sensor_models")).unwrap();
    let simulation = simulation(folder.path(), &SIMULATION.replace(coulomb, model));
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    let result = is_identified(&simulation, &read_session(&files[0]).unwrap());
    let travel = result.parameters.iter().find(|parameter| parameter.name == "j2.presliding_travel").unwrap();
    let (value, std) = (travel.value.unwrap(), travel.std.unwrap());
    assert!((value - 0.002).abs() < 4.0 * std && std < 2e-4, "{value} {std}");
    let left = |result: &EstimatorResult| result.fit.as_ref().unwrap().joints[1].rms;
    let session = fs::read_to_string(&files[0]).unwrap().replace("presliding-friction", "coulomb-friction");
    fs::write(&files[0], session).unwrap();
    let without = estimated(&read_session(&files[0]).unwrap());
    let named = |test: &&ResidualTest| test.named && test.kind == ResidualTestKind::Presliding && test.channel == "j2";
    assert!(without.residual_tests.iter().any(|test| named(&test)), "{:?}", without.notes);
    assert!(result.residual_tests.iter().all(|test| test.kind != ResidualTestKind::Presliding || test.channel != "j2"));
    assert!(left(&without) > 1.1 * left(&result), "{} {}", left(&without), left(&result));
}

/// Friction opposes the motion of a joint, in N·m/(rad/s), however its encoder counts: here backwards, in counts of a tenth of a milliradian.
#[test]
fn friction_is_that_of_the_joint_and_not_of_its_encoder() {
    const COUNT: f64 = -1e-4;
    let folder = tempfile::tempdir().unwrap();
    let viscous = "sensor_models = [{ kind = \"viscous-friction\", parameters = { viscous_friction = { value = 0.7, unit = \"N·m/(rad/s)\" } } }, {";
    let simulation = simulation(folder.path(), &SIMULATION.replace("sensor_models = [{", viscous));
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    for table in ["bare.csv", "loaded.csv"].map(|name| folder.path().join(name)) {
        let text = fs::read_to_string(&table).unwrap();
        let header = text.lines().find(|line| line.starts_with("time_s")).unwrap();
        let place = header.split(',').position(|column| column == "j2.position").unwrap();
        let counted = |line: &str| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if let Some((angle, cell)) = cells.get_mut(place).and_then(|cell| Some((cell.parse::<f64>().ok()?, cell))) {
                *cell = (angle / COUNT).to_string();
            }
            cells.join(",") + "\n"
        };
        fs::write(&table, text.lines().map(counted).collect::<String>()).unwrap();
    }
    let friction = |result: &EstimatorResult| {
        ["j2.coulomb_friction", "j2.viscous_friction"].map(|name| {
            let found = result.parameters.iter().find(|parameter| parameter.name == name).unwrap();
            (found.value.unwrap(), found.std.unwrap())
        })
    };
    let text = fs::read_to_string(&files[0]).unwrap();
    let units = "unit = [\"rad\", \"rad\", \"rad\"]";
    assert!(text.contains(units) && text.contains("name = \"j2\"\n"), "{text}");
    let in_counts = text.replacen(units, "unit = [\"rad\", \"count\", \"rad\"]", 1);
    let gain =
        "name = \"j2\"\nposition_gain = { nominal = 1e-4, unit = \"rad/count\" }\nposition_sign = \"reversed\"\n";
    fs::write(&files[0], in_counts.replace("name = \"j2\"\n", gain)).unwrap();
    let result = estimated(&read_session(&files[0]).unwrap());
    for ((value, std), truth) in friction(&result).into_iter().zip([0.4, 0.7]) {
        assert!((value - truth).abs() < 4.0 * std && std < 0.05, "{value} ± {std}, {truth}");
    }
}

/// Motors before gears: their inertia is in the torques, and the session asks for it.
#[test]
fn simulated_rotors_are_identified() {
    let folder = tempfile::tempdir().unwrap();
    let with_rotors = SIMULATION.replace(
        "sensor_models = [{ kind",
        "rotor_inertia = { value = 0.3, unit = \"kg·m²\" }\nsensor_models = [{ kind",
    );
    let simulation = simulation(folder.path(), &with_rotors);
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    assert!(fs::read_to_string(&files[0]).unwrap().contains("rotor_inertia = \"unknown\""));
    assert!(fs::read_to_string(folder.path().join("truth.toml")).unwrap().contains("j2.rotor_inertia"));
    is_identified(&simulation, &read_session(&files[0]).unwrap());
    // Before a gear that bends the rotor moves as its encoder reads.
    let bending =
        with_rotors.replace("[recording]", "[deflection]\ncompliance_rad_per_newton_metre = -2e-4\n[recording]");
    let simulation = self::simulation(folder.path(), &bending);
    let files = write_session(&simulation, 0, folder.path(), true).unwrap();
    is_identified(&simulation, &read_session(&files[0]).unwrap());
    fs::write(folder.path().join("simulation.toml"), with_rotors.replace("motion = {", "# motion = {")).unwrap();
    let error = Simulation::read(&folder.path().join("simulation.toml")).unwrap_err().to_string();
    assert!(error.contains("rotor_inertia: an arm that stands does not feel it"), "{error}");
}

/// Joints that bend by 3e-4 rad/(N·m) as their links move, beyond encoders that do not see it: intervals hold. Taken as
/// stiff the arm is not what its readings say, and the residuals tell so.
#[test]
fn joints_that_bend_in_motion_are_identified() {
    let folder = tempfile::tempdir().unwrap();
    let text = SIMULATION
        .replace("[recording]", "[deflection]\ncompliance_rad_per_newton_metre = [-3e-4, -3e-4, -3e-4]\n[recording]");
    let simulation = simulation(folder.path(), &text.replace("samples = 3000", "samples = 6000"));
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    let session = read_session(&files[0]).unwrap();
    let result = is_identified(&simulation, &session);
    assert!(!result.notes.iter().any(|note| note.contains(FAST)), "{:?}", result.notes);
    let stiff = fs::read_to_string(&files[0]).unwrap() + "\n[deflection]\ncompliance_std_rad_per_newton_metre = 0\n";
    fs::write(&files[0], stiff).unwrap();
    let taken_as_stiff = estimated(&read_session(&files[0]).unwrap());
    let rms = |result: &EstimatorResult| result.fit.as_ref().unwrap().joints[1].rms;
    assert!(rms(&taken_as_stiff) > 1.3 * rms(&result), "{} {}", rms(&taken_as_stiff), rms(&result));
    let named = |test: &ResidualTest| test.named && test.kind == ResidualTestKind::Compliance;
    assert!(taken_as_stiff.residual_tests.iter().any(named), "{:?}", taken_as_stiff.notes);
    let cure = "leave out [deflection] compliance_std_rad_per_newton_metre = 0";
    assert!(taken_as_stiff.notes.iter().any(|note| note.contains(cure)), "{:?}", taken_as_stiff.notes);
    // What is an unknown is told with its size, and spoils nothing.
    let told: Vec<&ResidualTest> = result.residual_tests.iter().filter(|test| named(test)).collect();
    assert!(!told.is_empty(), "{:?}", result.notes);
    assert!(told.iter().all(|test| !test.spoils_intervals && (test.size + 3e-4).abs() < 1e-4), "{told:?}");
}

/// Joints ten times as soft: over how many moments torques are followed moves numbers by more than half a standard deviation. Intervals hold all the same, and the report says what to do.
#[test]
fn how_joints_bend_in_fast_motion_is_allowed_for() {
    let folder = tempfile::tempdir().unwrap();
    let text = SIMULATION.replace("[recording]", "[deflection]\ncompliance_rad_per_newton_metre = -3e-3\n[recording]");
    let simulation = simulation(folder.path(), &text.replace("samples = 3000", "samples = 6000"));
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    let result = is_identified(&simulation, &read_session(&files[0]).unwrap());
    let told = result.notes.iter().find(|note| note.contains(FAST)).unwrap_or_else(|| panic!("{:?}", result.notes));
    assert!(told.contains("Intervals allow for it. Move more slowly"), "{told}");
}

/// Moves from pose to pose take the torques of inertia as well: read as motion they tell the same.
#[test]
fn moves_between_simulated_poses_are_motion() {
    let folder = tempfile::tempdir().unwrap();
    let still = SIMULATION.replace(
        "samples = 3000\nmove_s = 1\nmotion = { harmonics = 5, period_s = 10, seed = 2 }",
        "samples = 10\nmove_s = 1",
    );
    let still = still.replace("poses = 2", "poses = 40").replace("std = 1e-5\n", "");
    let simulation = simulation(folder.path(), &still);
    let files = write_session(&simulation, 0, folder.path(), false).unwrap();
    let text = fs::read_to_string(&files[0]).unwrap();
    assert!(text.contains("[readings.still]"), "{text}");
    fs::write(&files[0], text.replace("[readings.still]", "[readings.motion]")).unwrap();
    is_identified(&simulation, &read_session(&files[0]).unwrap());
}

/// All that is determined lies where the truth does, and nothing is open but the frame of the last link.
fn is_identified(simulation: &Simulation, session: &Session) -> EstimatorResult {
    let result = estimated(session);
    let open: Vec<&str> = result.parameters.iter().filter(|p| p.value.is_none()).map(|p| p.name.as_str()).collect();
    assert_eq!(open, ["j3.position_offset"]);
    let ids = simulation.template.parameters();
    let mut squares = Vec::new();
    for id in ids {
        let name = simulation.template.parameter_name(id);
        let Some(found) = result.parameters.iter().find(|parameter| parameter.name == name) else { continue };
        // What defines a frame has a value without an error.
        if let (Some(value), Some(std)) = (found.value, found.std.filter(|std| *std > 0.0)) {
            squares.push(((value - simulation.truth.value(id)) / std).powi(2));
        }
    }
    assert!(squares.len() > 10, "{squares:?}");
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(rms < 1.6, "{rms} {squares:?}");
    let gain = result.parameters.iter().find(|parameter| parameter.name == "j2.torque_gain").unwrap();
    let truth = simulation.truth.sensors[1][SensorParameter::TorqueGain as usize];
    assert!((gain.value.unwrap() - truth).abs() < 0.01, "{gain:?}");
    result
}

fn estimated(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap()
}
