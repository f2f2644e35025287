//! Poses that say little: one to three joints move, or all of them by 5° to 30°, or there are 5 to 10 poses, or several of these.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::arm::Arm;
use super::draw::{normal, with_each_load, within};
use super::truth::Table;

/// Where joints stand, or about which angle they move.
#[derive(Clone, Copy)]
enum Rest {
    /// At zero.
    Zero,
    /// Near zero.
    NearZero,
    /// Somewhere about the middle of their range.
    Middle,
}

/// The tables of a poor session.
pub fn tables(arm: &Arm, placements: usize, random: &mut Pcg64) -> Vec<Table> {
    let [few_joints, little, few_poses] = shortcomings(random);
    let rest = [Rest::Zero, Rest::NearZero, Rest::Middle][random.random_range(0..3)];
    let moving = if few_joints { some_of(arm.joint_count(), random) } else { vec![true; arm.joint_count()] };
    let width = random.random_range(5.0..30.0_f64).to_radians();
    let range = |(joint, moves): (&super::statics::Joint, &bool), random: &mut Pcg64| {
        let at = rest.at(joint.limits, random);
        match (moves, little) {
            (false, _) => [at, at],
            (true, true) => [at - 0.5 * width, at + 0.5 * width],
            (true, false) => joint.limits,
        }
    };
    let ranges: Vec<[f64; 2]> = arm.joints.iter().zip(&moving).map(|joint| range(joint, random)).collect();
    let poses = if few_poses { random.random_range(5..=10) } else { random.random_range(30..=100) };
    with_each_load(placements, &mut |_| within(&ranges, poses, random))
}

/// Few joints move, all move little, few poses: one of these at least.
fn shortcomings(random: &mut Pcg64) -> [bool; 3] {
    let sure = random.random_range(0..3);
    std::array::from_fn(|which| which == sure || random.random_range(0.0..1.0) < 0.3)
}

/// One to three of so many.
fn some_of(joints: usize, random: &mut Pcg64) -> Vec<bool> {
    let mut moving = vec![false; joints];
    for _ in 0..random.random_range(1..=3) {
        moving[random.random_range(0..joints)] = true;
    }
    moving
}

impl Rest {
    fn at(self, [low, high]: [f64; 2], random: &mut Pcg64) -> f64 {
        match self {
            Rest::Zero => 0.0,
            Rest::NearZero => 0.02 * normal(random),
            Rest::Middle => 0.5 * (low + high) + random.random_range(-0.3..0.3),
        }
    }
}
