//! A small session that is calibrated in a moment: the robot of the Sarcos shoulder, and three short tables of simulated
//! poses. Tests change one thing or another in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;

use crate::program::{Run, gravcal_in};
use crate::tree;

/// Where its results go.
pub const RESULTS: &str = "results";

/// First line of the session's tables.
pub const HEADER: &str = "joint1_position_rad,joint2_position_rad,joint3_position_rad,\
    joint1_torque_count,joint2_torque_count,joint3_torque_count\n";

/// The session; its tables are made by [`SIMULATION`].
const SESSION: &str = r#"robot = "robot.toml"

[gravity]
magnitude_m_per_s2 = 9.8
hemisphere = [-0.4, -0.6, -0.7]

[readings.position]
columns = ["joint1_position_rad", "joint2_position_rad", "joint3_position_rad"]
unit = "rad"

[readings.torque]
columns = ["joint1_torque_count", "joint2_torque_count", "joint3_torque_count"]
unit = "count"
std = 0.8

[[joint]]
name = "joint3"
position_gain = { nominal = 1.0, unit = "deg/deg" }

[[load]]
name = "plate-a"
mass_kg = 1.724
link = "link3"

[[load]]
name = "plate-b"
mass_kg = 1.724
link = "link3"

[[load_distance]]
between = ["plate-a", "plate-b"]
distance_m = 0.402

[[poses]]
file = "bare.csv"

[[poses]]
file = "plate-a.csv"
load = "plate-a"

[[poses]]
file = "plate-b.csv"
load = "plate-b"
"#;

/// Makes the tables.
const SIMULATION: &str = r#"robot = "robot.toml"
seed = 1
gravity = { direction = [-3.43, -5.94, -7.00], magnitude_m_per_s2 = 9.8 }
torque = { unit = "count", std = 0.8 }
position = { unit = "rad" }
random = [
    { file = "bare.csv", poses = 12 },
    { file = "plate-a.csv", poses = 12, load = "plate-a" },
    { file = "plate-b.csv", poses = 12, load = "plate-b" },
]
load = [
    { name = "plate-a", mass_kg = 1.724, link = "link3", position_m = [0.3108, 0.05, 0.5706] },
    { name = "plate-b", mass_kg = 1.724, link = "link3", position_m = [-0.0108, 0.05, 0.3294] },
]
"#;

/// Another robot, which the session does not name.
const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial><mass value="2.0"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="lower">
    <inertial><mass value="1.0"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="100" velocity="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/><origin xyz="0 0 0.4"/>
    <limit lower="-1.5" upper="1.5" effort="100" velocity="1"/>
  </joint>
</robot>
"#;

/// The session in a folder of its own.
pub fn small_session() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, contents) in small_files() {
        fs::write(folder.path().join(name), contents).unwrap();
    }
    folder
}

/// Names and contents of the session's files.
fn small_files() -> &'static [(PathBuf, Vec<u8>)] {
    static FILES: OnceLock<Vec<(PathBuf, Vec<u8>)>> = OnceLock::new();
    FILES.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let robot = fs::read_to_string(tree::root().join("models/sarcos-dextrous-arm/robot.toml")).unwrap();
        fs::write(folder.path().join("robot.toml"), robot).unwrap();
        fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
        let run = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
        assert_eq!(run.code, 0, "{run:?}");
        fs::write(folder.path().join("session.toml"), SESSION).unwrap();
        fs::write(folder.path().join("arm.urdf"), URDF).unwrap();
        tree::entries(folder.path()).iter().map(|file| (tree::name(file).into(), fs::read(file).unwrap())).collect()
    })
}

/// Calibrates it.
pub fn calibrate(folder: &Path) -> Run {
    gravcal_in(folder, ["calibrate", "--full", "session.toml", "--output", RESULTS])
}

/// Checks it.
pub fn check(folder: &Path) -> Run {
    gravcal_in(folder, ["check", "--full", "session.toml"])
}
