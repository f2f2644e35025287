//! Gravity torques and tip poses against Pinocchio's, for eleven robots of ten URDFs from seven sources.
//!
//! `pinocchio_facts.toml` holds Pinocchio's numbers; `pinocchio_facts.py` wrote it and says how. The URDFs are read where
//! they are, in `GRAVCAL_SHARED_DATA` or `../shared/data` beside the project; without them there is nothing to compare,
//! and the test says so.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod shared;

use std::path::Path;

use gravcal_dynamics::{Chain, GravityTorque};
use serde::Deserialize;
use shared::{chain, largest_difference, shared_data};

/// N·m, N·m/rad, m: rounding of two different orders of summation.
const TOLERANCE: f64 = 1e-10;

#[derive(Deserialize)]
struct Facts {
    gravity_upright: [f64; 3],
    gravity_tilted: [f64; 3],
    robot: Vec<Robot>,
}

#[derive(Deserialize)]
struct Robot {
    file: String,
    base: String,
    tips: Vec<String>,
    joints: Vec<String>,
    pose: Vec<Pose>,
}

#[derive(Deserialize)]
struct Pose {
    coordinates: Vec<f64>,
    tip_position: [f64; 3],
    tip_rotation: [[f64; 3]; 3],
    torque_upright: Vec<f64>,
    torque_tilted: Vec<f64>,
    by_coordinate_tilted: Option<Vec<Vec<f64>>>,
}

/// Largest deviations over everything compared.
#[derive(Debug, Default)]
struct Worst {
    torque: f64,
    by_coordinate: f64,
    tip: f64,
}

fn facts() -> Facts {
    toml::from_str(include_str!("pinocchio_facts.toml")).unwrap()
}

/// The file's nominal masses and moments, flat; zero where it states none.
fn nominal_inertia(chain: &Chain) -> Vec<f64> {
    let inertias = chain.links().iter().map(|link| link.inertia.unwrap_or_default());
    inertias.flat_map(|i| [i.mass, i.first_moment[0], i.first_moment[1], i.first_moment[2]]).collect()
}

fn compare_pose(chain: &Chain, facts: &Facts, pose: &Pose, worst: &mut Worst) {
    let inertia = nominal_inertia(chain);
    let mut torque = vec![0.0; chain.joint_count()];
    chain.gravity_torque(&pose.coordinates, facts.gravity_upright, &inertia, &mut torque);
    worst.torque = worst.torque.max(largest_difference(&torque, &pose.torque_upright));

    let mut tilted = GravityTorque::new(chain.joint_count(), chain.link_count());
    chain.linearize_gravity_torque(&pose.coordinates, facts.gravity_tilted, &inertia, &mut tilted);
    worst.torque = worst.torque.max(largest_difference(&tilted.torque, &pose.torque_tilted));
    if let Some(rows) = &pose.by_coordinate_tilted {
        let difference = largest_difference(&tilted.by_coordinate, &rows.concat());
        worst.by_coordinate = worst.by_coordinate.max(difference);
    }

    let poses = chain.forward(&pose.coordinates);
    let tip = poses[poses.len() - 1];
    let position = largest_difference(&tip.translation(), &pose.tip_position);
    let rotation = largest_difference(&tip.rotation().concat(), &pose.tip_rotation.concat());
    worst.tip = worst.tip.max(position).max(rotation);
}

fn compare_robot(folder: &Path, facts: &Facts, robot: &Robot) -> Worst {
    let chain = chain(folder, &robot.file, &robot.base, &robot.tips, &robot.joints);
    let mut worst = Worst::default();
    for pose in &robot.pose {
        compare_pose(&chain, facts, pose, &mut worst);
    }
    worst
}

#[test]
fn agrees_with_pinocchio() {
    let Some(folder) = shared_data() else { return };
    let facts = facts();
    assert_eq!(facts.robot.len(), 11);
    for robot in &facts.robot {
        let worst = compare_robot(&folder, &facts, robot);
        println!("{}: {worst:?}", robot.file);
        assert!(worst.torque < TOLERANCE, "{}: {worst:?}", robot.file);
        assert!(worst.by_coordinate < TOLERANCE, "{}: {worst:?}", robot.file);
        assert!(worst.tip < TOLERANCE, "{}: {worst:?}", robot.file);
    }
}

#[test]
fn the_hand_of_the_panda_ends_the_chain() {
    let Some(folder) = shared_data() else { return };
    let text = std::fs::read_to_string(folder.join("urdf/panda_example-robot-data.urdf")).unwrap();
    let chain = Chain::from_urdf(&text, "panda_link0", &["panda_hand"]).unwrap();
    assert_eq!(chain.cut_joints(), ["panda_finger_joint1", "panda_finger_joint2"]);
    // Link 7 and the hand, without the fingers' 15 g each.
    assert!((chain.links()[6].inertia.unwrap().mass - (0.735522 + 0.73)).abs() < 1e-12);

    for finger in ["panda_rightfinger", "panda_leftfinger"] {
        let one = Chain::from_urdf(&text, "panda_link0", &[finger]).unwrap_err().to_string();
        assert!(one.contains("name a tip beyond it as well"), "{one}");
    }
    let both = Chain::from_urdf(&text, "panda_link0", &["panda_leftfinger", "panda_rightfinger"]).unwrap();
    assert_eq!((both.joint_count(), both.link_count(), both.cut_joints().len()), (8, 9, 0));
}
