//! The arms: the project's own, and URDFs of the shared data where these are there.

use std::path::{Path, PathBuf};

/// An arm with masses.
pub struct Arm {
    /// What the table calls it.
    pub name: &'static str,
    /// What `robot` is in a simulation.
    pub robot: String,
    pub joints: Vec<String>,
    /// The file of its masses, where that is a URDF.
    pub urdf: Option<PathBuf>,
    /// The link that carries loads.
    pub tip: &'static str,
    /// The load, kg.
    pub load: f64,
    /// How long a period of its motion is, s: longer where joints turn farther.
    pub period: f64,
}

/// Name, file, base, tip, load in kg, period in s and names of the joints.
type Urdf = (&'static str, &'static str, &'static str, &'static str, f64, f64, &'static [&'static str]);

const URDFS: [Urdf; 3] = [
    (
        "iiwa",
        "iiwa14_no_collision_drake.urdf",
        "base",
        "iiwa_link_7",
        5.0,
        20.0,
        &[
            "iiwa_joint_1",
            "iiwa_joint_2",
            "iiwa_joint_3",
            "iiwa_joint_4",
            "iiwa_joint_5",
            "iiwa_joint_6",
            "iiwa_joint_7",
        ],
    ),
    (
        "ur10e",
        "ur10e_ros-industrial.urdf",
        "base_link_inertia",
        "wrist_3_link",
        5.0,
        60.0,
        &[
            "shoulder_pan_joint",
            "shoulder_lift_joint",
            "elbow_joint",
            "wrist_1_joint",
            "wrist_2_joint",
            "wrist_3_joint",
        ],
    ),
    (
        "gen3",
        "kinova_gen3_7dof_v12.urdf",
        "base_link",
        "bracelet_link",
        2.0,
        20.0,
        &["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6", "joint_7"],
    ),
];

/// All of them; sessions take them in turn. `in_motion`: those whose inertia tensors are known alone, else the project's own for the first.
pub fn arms(in_motion: bool) -> Vec<Arm> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = here.join("../models/kuka-lbr-iiwa14/robot.toml");
    let own = Arm {
        name: URDFS[0].0,
        robot: format!("{:?}", own.to_string_lossy()),
        joints: (1..=7).map(|joint| format!("joint{joint}")).collect(),
        urdf: None,
        tip: "link7",
        load: 5.0,
        period: 20.0,
    };
    let shared = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(|| here.join("../../shared/data"), PathBuf::from);
    let there = URDFS.iter().map(|urdf| (shared.join("urdf").join(urdf.1), urdf)).filter(|(path, _)| path.is_file());
    let of_urdf = |(path, (name, _, base, tip, load, period, joints)): (PathBuf, &Urdf)| Arm {
        name,
        robot: format!("{{ urdf = {:?}, base = {base:?}, tip = {tip:?} }}", path.to_string_lossy()),
        urdf: Some(path),
        joints: joints.iter().map(ToString::to_string).collect(),
        tip,
        load: *load,
        period: *period,
    };
    let first = (!in_motion).then_some(own);
    let others = there.map(of_urdf).skip(usize::from(!in_motion));
    first.into_iter().chain(others).collect()
}
