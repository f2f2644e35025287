//! How far joints travel for each unit of their position readings, roughly, for finding slow sweeps.

use gravcal_dynamics::{Chain, JointKind};
use gravcal_recording::Travel;

use super::known::JointPriors;
use crate::parameter::SensorParameter;

/// Width of a bin where nothing is said, rad: 1°, over which the curvature of a torque `τ` changes it by `τ`/80,000.
pub const BIN: f64 = std::f64::consts::PI / 180.0;
/// Largest acceleration of a slow sweep where nothing is said, rad/s²: of a mass at 1 m, half a hundredth of gravity.
pub const STEADY: f64 = 0.05;

/// By nominal position gains.
pub fn travels(chain: &Chain, joints: &[JointPriors]) -> Vec<Travel> {
    let gains = joints.iter().map(|joint| joint.of(SensorParameter::PositionGain).nominal.abs());
    let travel = |(joint, gain): (&gravcal_dynamics::Joint, f64)| match joint.kind {
        JointKind::Revolute => Travel::Turns(gain),
        JointKind::Prismatic => Travel::Slides(gain),
    };
    chain.joints().iter().zip(gains).map(travel).collect()
}
