//! Arms: from URDF text, read by `urdf-rs` and put together here, without what is judged.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64;
use urdf_rs::{JointType, Pose, Robot};

use super::statics::Joint;

/// No joint turns further than this to either side, rad.
const REACH: f64 = 2.6;

/// The serial chain from a base to a tip; every other joint of the robot is locked at zero.
#[derive(Clone, Debug)]
pub struct Arm {
    /// In lists.
    pub name: String,
    /// Where a session finds its URDF.
    pub urdf: Urdf,
    /// Link in whose frame gravity is given.
    pub base: String,
    /// Link on which loads hang.
    pub tip: String,
    /// From base to tip.
    pub joints: Vec<Joint>,
    /// The tip's frame in that of the last link.
    pub tip_frame: Isometry3<f64>,
}

/// A URDF as a session is given it.
#[derive(Clone, Debug)]
pub enum Urdf {
    /// A file that is there.
    File(PathBuf),
    /// To be written beside the session.
    Text(String),
}

/// Name, file, base and tip of the robots of the shared data.
const ROBOTS: [[&str; 4]; 7] = [
    ["panda", "panda_example-robot-data.urdf", "panda_link0", "panda_hand"],
    ["gen3", "kinova_gen3_7dof_v12.urdf", "base_link", "end_effector_link"],
    ["ur10", "ur10_example-robot-data.urdf", "base_link", "ee_link"],
    ["ur5e", "ur5e_ros-industrial.urdf", "base_link", "wrist_3_link"],
    ["iiwa14", "iiwa14_no_collision_drake.urdf", "iiwa_link_0", "iiwa_link_7"],
    ["z1", "z1_example-robot-data.urdf", "link00", "link06"],
    ["pr2", "pr2_example-robot-data.urdf", "torso_lift_link", "r_gripper_palm_link"],
];

/// The robots whose URDFs lie in a folder.
///
/// # Errors
/// Says which file cannot be read, or why it makes no arm.
pub fn robots(folder: &Path) -> Result<Vec<Arm>, String> {
    let robot = |[name, file, base, tip]: [&str; 4]| {
        let path = folder.join(file);
        let located = |error: String| format!("{}: {error}", path.display());
        let path = path.canonicalize().map_err(|error| located(error.to_string()))?;
        let text = std::fs::read_to_string(&path).map_err(|error| located(error.to_string()))?;
        Arm::new(name, (Urdf::File(path.clone()), &text), base, tip).map_err(located)
    };
    ROBOTS.into_iter().map(robot).collect()
}

/// An arm of 3 to 8 joints with any twists and lengths up to half a metre; links grow lighter towards the tip.
///
/// # Errors
/// Where its own URDF makes no arm.
pub fn random(random: &mut Pcg64) -> Result<Arm, String> {
    let joints = random.random_range(3..=8);
    let mut parts = vec!["<robot name=\"arm\">".to_owned(), "<link name=\"link0\"/>".to_owned()];
    for joint in 1..=joints {
        let mut three = |reach: f64| -> [f64; 3] { std::array::from_fn(|_| random.random_range(-reach..reach)) };
        let ([x, y, z], [roll, pitch, yaw], [cx, cy, cz]) = (three(0.35), three(PI), three(0.15));
        // The first joint's axis is the base's z, as that of most arms: upright, it carries nothing.
        let [roll, pitch] = if joint == 1 { [0.0; 2] } else { [roll, pitch] };
        let mass = random.random_range(1.0..6.0) / (1.0 + 0.3 * f64::from(joint));
        parts.push(format!(
            "<link name=\"link{joint}\"><inertial><origin xyz=\"{cx} {cy} {cz}\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial></link>"
        ));
        parts.push(format!(
            "<joint name=\"joint{joint}\" type=\"revolute\"><parent link=\"link{}\"/><child link=\"link{joint}\"/>\
             <origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-2.1\" upper=\"2.1\" effort=\"1\" velocity=\"1\"/></joint>",
            joint - 1
        ));
    }
    parts.push("</robot>".to_owned());
    let text = parts.join("\n");
    Arm::new("random", (Urdf::Text(text.clone()), &text), "link0", &format!("link{joints}"))
}

impl Arm {
    fn new(name: &str, (urdf, text): (Urdf, &str), base: &str, tip: &str) -> Result<Arm, String> {
        let robot = urdf_rs::read_from_string(text).map_err(|error| error.to_string())?;
        let (mut joints, mut before) = (Vec::new(), Isometry3::identity());
        let way = way(&robot, base, tip)?;
        for (index, joint) in way.iter().enumerate() {
            before *= isometry(&joint.origin);
            if joint.joint_type == JointType::Fixed {
                continue;
            }
            joints.push(Joint {
                name: joint.name.clone(),
                before: std::mem::replace(&mut before, Isometry3::identity()),
                axis: Vector3::from(joint.axis.xyz.0).normalize(),
                limits: limits(joint)?,
                body: body(&robot, &joint.child.link, next_moving(&way[index + 1..])),
            });
        }
        Ok(Arm { name: name.into(), urdf, base: base.into(), tip: tip.into(), joints, tip_frame: before })
    }

    /// How many joints.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }
}

/// The joints from base to tip, in this order.
fn way<'r>(robot: &'r Robot, base: &str, tip: &str) -> Result<Vec<&'r urdf_rs::Joint>, String> {
    let (mut way, mut link) = (Vec::new(), tip);
    while link != base {
        let carrying = robot.joints.iter().find(|joint| joint.child.link == link);
        let joint = carrying.ok_or_else(|| format!("no way leads from link `{base}` to link `{tip}`"))?;
        way.push(joint);
        link = &joint.parent.link;
    }
    way.reverse();
    Ok(way)
}

fn next_moving<'r>(way: &[&'r urdf_rs::Joint]) -> Option<&'r str> {
    way.iter().find(|joint| joint.joint_type != JointType::Fixed).map(|joint| joint.name.as_str())
}

fn limits(joint: &urdf_rs::Joint) -> Result<[f64; 2], String> {
    match joint.joint_type {
        JointType::Continuous => Ok([-REACH, REACH]),
        JointType::Revolute => Ok([joint.limit.lower.max(-REACH), joint.limit.upper.min(REACH)]),
        _ => Err(format!("joint `{}` does not turn: arms have revolute joints here", joint.name)),
    }
}

/// Mass and first moment of a link and of all that hangs on it at zero, in its frame, but for what `without` moves.
fn body(robot: &Robot, link: &str, without: Option<&str>) -> [f64; 4] {
    let (mut mass, mut moment) = (0.0, Vector3::zeros());
    let mut open = vec![(link, Isometry3::identity())];
    while let Some((link, pose)) = open.pop() {
        for own in robot.links.iter().filter(|own| own.name == link) {
            mass += own.inertial.mass.value;
            let centre: Point3<f64> = pose * Point3::from(own.inertial.origin.xyz.0);
            moment += centre.coords * own.inertial.mass.value;
        }
        let hanging = robot.joints.iter().filter(|joint| joint.parent.link == link);
        let hanging = hanging.filter(|joint| Some(joint.name.as_str()) != without);
        open.extend(hanging.map(|joint| (joint.child.link.as_str(), pose * isometry(&joint.origin))));
    }
    [mass, moment.x, moment.y, moment.z]
}

fn isometry(Pose { xyz, rpy }: &Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = rpy.0;
    Isometry3::from_parts(Translation3::from(xyz.0), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}
