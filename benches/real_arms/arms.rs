//! The arms: the project's own, and URDFs of the shared data where these are there.

use std::path::{Path, PathBuf};

/// An arm with masses.
pub struct Arm {
    /// What `robot` is in a simulation.
    pub robot: String,
    pub joints: Vec<String>,
    /// The link that carries loads.
    pub tip: &'static str,
    /// The load, kg.
    pub load: f64,
}

/// File, base, tip, load in kg and names of the joints.
type Urdf = (&'static str, &'static str, &'static str, f64, &'static [&'static str]);

const URDFS: [Urdf; 2] = [
    (
        "ur10e_ros-industrial.urdf",
        "base_link_inertia",
        "wrist_3_link",
        5.0,
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
        "kinova_gen3_7dof_v12.urdf",
        "base_link",
        "bracelet_link",
        2.0,
        &["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6", "joint_7"],
    ),
];

/// All of them; sessions take them in turn.
pub fn arms() -> Vec<Arm> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = here.join("../models/kuka-lbr-iiwa14/robot.toml");
    let own = Arm {
        robot: format!("{:?}", own.to_string_lossy()),
        joints: (1..=7).map(|joint| format!("joint{joint}")).collect(),
        tip: "link7",
        load: 5.0,
    };
    let shared = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(|| here.join("../../shared/data"), PathBuf::from);
    let there = URDFS.iter().map(|urdf| (shared.join("urdf").join(urdf.0), urdf)).filter(|(path, _)| path.is_file());
    let of_urdf = |(path, (_, base, tip, load, joints)): (PathBuf, &Urdf)| Arm {
        robot: format!("{{ urdf = {:?}, base = {base:?}, tip = {tip:?} }}", path.to_string_lossy()),
        joints: joints.iter().map(ToString::to_string).collect(),
        tip,
        load: *load,
    };
    std::iter::once(own).chain(there.map(of_urdf)).collect()
}
