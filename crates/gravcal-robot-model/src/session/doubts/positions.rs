//! Position readings that no joint can have.

use std::f64::consts::PI;

use gravcal_dynamics::JointKind;
use gravcal_recording::PositionUnit;

use super::names::{named, rows};
use super::unit::MistakenUnit;
use crate::parameter::SensorParameter;
use crate::session::Session;

/// A joint with limits turns no further than these or a full turn from zero, rad, and any other joint no further than two.
const FULL_TURN: f64 = 2.0 * PI;
/// Sensors read beyond limits by their offsets, and gains of some per cent.
const BEYOND: f64 = 1.1;
/// What any joint slides is less than this, m.
const LONGEST: f64 = 10.0;
/// Poses, as a share of them, in which alone a joint is too far: then cells are wrong, and not a unit. One always may be.
const FEW: f64 = 0.05;
/// Angles in radians are within this, rad, where they are taken for degrees.
const RADIANS_AS_DEGREES: f64 = FULL_TURN * PI / 180.0;

impl Session {
    /// Says so where joints turn or slide farther than any does: their positions are in another unit, all of them or in some rows.
    pub fn positions_too_far(&self) -> Option<String> {
        let told = too_far(self);
        (!told.is_empty()).then(|| told.join(" "))
    }
}

/// One sentence or two for each mistake.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    too_far(session).into_iter().chain(hardly_turning(session)).collect()
}

/// Whether angles may be, and not in few cells alone.
pub(super) fn are_in_another_unit(session: &Session) -> bool {
    let mut far = joints_too_far(session);
    far.retain(|joint| session.robot.chain.joints()[*joint].kind == JointKind::Revolute);
    hardly_turning(session).is_some() || !far.is_empty() && wrong_cells(session, &far).is_none()
}

fn joints_too_far(session: &Session) -> Vec<usize> {
    (0..session.joints.len()).filter(|joint| reach(session, *joint) > most(session, *joint)).collect()
}

fn too_far(session: &Session) -> Vec<String> {
    let kind = |joint: &usize| session.robot.chain.joints()[*joint].kind;
    let too_far = joints_too_far(session);
    if let Some(cells) = wrong_cells(session, &too_far) {
        return vec![cells];
    }
    let (turning, sliding): (Vec<usize>, Vec<usize>) =
        too_far.into_iter().partition(|joint| kind(joint) == JointKind::Revolute);
    let far = |joints: &[usize]| joints.iter().map(|joint| reach(session, *joint)).fold(0.0, f64::max);
    let turned = (!turning.is_empty()).then(|| {
        let what =
            format!("angles of {} reach {:.1} rad, farther than joints turn", named(session, &turning), far(&turning));
        report(session, &turning, &what, MistakenUnit::DEGREES_AS_RADIANS)
    });
    let slid = (!sliding.is_empty()).then(|| {
        let what = format!(
            "positions of {} reach {:.0} m, farther than joints slide",
            named(session, &sliding),
            far(&sliding)
        );
        report(session, &sliding, &what, MistakenUnit::MILLIMETERS_AS_METERS)
    });
    turned.into_iter().chain(slid).collect()
}

/// Says so where joints are too far in few poses only; nothing of sensors that count in their own unit from anywhere.
fn wrong_cells(session: &Session, joints: &[usize]) -> Option<String> {
    if joints.is_empty() || joints.iter().any(|joint| session.joints[*joint].position_unit.is_sensors_own()) {
        return None;
    }
    let is_far =
        |pose: &usize| joints.iter().any(|joint| coordinate(session, *joint, *pose).abs() > most(session, *joint));
    let far: Vec<usize> = (0..session.poses.len()).filter(is_far).collect();
    let few = (FEW * session.poses.len() as f64).max(1.0);
    (far.len() as f64 <= few).then(|| {
        format!(
            "As declared, positions of {} are farther than joints go in {}, and nowhere else: look at these cells, and leave out what is wrong.",
            named(session, joints),
            rows(session, far.into_iter())
        )
    })
}

/// What readings of these joints are.
fn report(session: &Session, joints: &[usize], what: &str, mistaken: MistakenUnit) -> String {
    let si = |joint: &usize| session.joints[*joint].position_unit.name() == mistaken.declared;
    match joints.iter().all(si) {
        true => {
            format!("As declared, {what}: the position readings {}. If so, {}.", mistaken.reported(), mistaken.cure())
        }
        false => format!(
            "As declared, {what}: the unit of the position readings, or their nominal gain, is another. Look at [readings] position and at position_gain in [[joint]]."
        ),
    }
}

/// How far a joint is from zero, rad or m; of a sensor that counts in its own unit from anywhere, how far it goes.
fn reach(session: &Session, joint: usize) -> f64 {
    let coordinates = (0..session.poses.len()).map(|pose| coordinate(session, joint, pose));
    match session.joints[joint].position_unit.is_sensors_own() {
        false => coordinates.map(f64::abs).fold(0.0, f64::max),
        true => {
            let ends = [f64::INFINITY, f64::NEG_INFINITY];
            let [lowest, highest] = coordinates.fold(ends, |[low, high], at| [at.min(low), at.max(high)]);
            highest - lowest
        }
    }
}

/// A joint's coordinate by nominal values, rad or m.
fn coordinate(session: &Session, joint: usize, pose: usize) -> f64 {
    let known = &session.joints[joint];
    let [gain, offset] =
        [SensorParameter::PositionGain, SensorParameter::PositionOffset].map(|quantity| known.of(quantity).nominal);
    gain * session.poses[pose].position[joint] + offset
}

fn most(session: &Session, joint: usize) -> f64 {
    let joint = &session.robot.chain.joints()[joint];
    match (joint.kind, joint.limits) {
        (JointKind::Prismatic, _) => LONGEST,
        (JointKind::Revolute, Some([lower, upper])) => BEYOND * lower.abs().max(upper.abs()).max(FULL_TURN),
        (JointKind::Revolute, None) => 2.0 * FULL_TURN,
    }
}

/// Angles in degrees that are all as small as angles in radians.
fn hardly_turning(session: &Session) -> Option<String> {
    let in_degrees = |joint: &usize| session.joints[*joint].position_unit == PositionUnit::Degree;
    let joints: Vec<usize> = (0..session.joints.len()).filter(in_degrees).collect();
    let angles = joints.iter().flat_map(|joint| session.poses.iter().map(|pose| pose.position[*joint].abs()));
    let largest = angles.fold(0.0, f64::max);
    let mistaken = MistakenUnit::RADIANS_AS_DEGREES;
    (largest > 0.0 && largest <= RADIANS_AS_DEGREES).then(|| {
        format!(
            "As declared, no joint is farther than {:.1} deg from zero in any pose: the position readings {}. If so, {}; else the \
             poses hardly differ, and tell little.",
            largest.to_degrees(),
            mistaken.reported(),
            mistaken.cure()
        )
    })
}
