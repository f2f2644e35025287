//! Random chains and poses for the property tests.

use std::f64::consts::PI;

use proptest::array::uniform3;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::chain::Chain;
use crate::dh::{DhConvention, DhRow, chain_from_dh};
use crate::joint::{Joint, JointKind};
use crate::link::Link;
use crate::transform::Transform;

/// A chain, and everything the gravity torque depends on.
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    pub chain: Chain,
    pub coordinates: Vec<f64>,
    pub gravity: [f64; 3],
    pub inertia: Vec<f64>,
}

/// One to seven joints of both kinds with axes in every direction, in any pose.
pub(crate) fn pose() -> impl Strategy<Value = Pose> {
    vec((joint(), -PI..PI, inertia()), 1..8).prop_flat_map(|parts| {
        let joints: Vec<Joint> = parts.iter().map(|(joint, ..)| joint.clone()).collect();
        let chain = numbered(joints);
        let coordinates: Vec<f64> = parts.iter().map(|(_, coordinate, _)| *coordinate).collect();
        let inertia: Vec<f64> = parts.iter().flat_map(|(.., inertia)| *inertia).collect();
        uniform3(-10.0..10.0).prop_map(move |gravity| Pose {
            chain: chain.clone(),
            coordinates: coordinates.clone(),
            gravity,
            inertia: inertia.clone(),
        })
    })
}

/// Denavit-Hartenberg rows, one to seven, of both kinds.
pub(crate) fn dh_rows() -> impl Strategy<Value = Vec<DhRow>> {
    let row = (kind(), -1.0..1.0, -PI..PI, -1.0..1.0, -PI..PI);
    vec(row, 1..8).prop_map(|rows| {
        let numbered = rows.into_iter().enumerate();
        numbered.map(|(i, (kind, a, alpha, d, theta))| dh_row(i, kind, [a, alpha, d, theta])).collect()
    })
}

/// Row number i (from 0) with `[a, alpha, d, theta]`.
pub(crate) fn dh_row(i: usize, kind: JointKind, [a, alpha, d, theta]: [f64; 4]) -> DhRow {
    DhRow { name: format!("joint{i}"), kind, a, alpha, d, theta, limits: None, link: link(i) }
}

/// The chain of standard rows.
pub(crate) fn standard_chain(rows: &[DhRow]) -> Chain {
    chain_from_dh("base", DhConvention::Standard, rows).unwrap()
}

fn numbered(mut joints: Vec<Joint>) -> Chain {
    for (i, joint) in joints.iter_mut().enumerate() {
        joint.name = format!("joint{i}");
    }
    let links = (0..joints.len()).map(link).collect();
    Chain::new("base", joints, links).unwrap()
}

fn link(i: usize) -> Link {
    Link { name: format!("link{i}"), inertia: None }
}

fn kind() -> impl Strategy<Value = JointKind> {
    // One prismatic joint in four: about what makes most chains mixed and leaves most joints turning.
    prop_oneof![3 => Just(JointKind::Revolute), 1 => Just(JointKind::Prismatic)]
}

fn joint() -> impl Strategy<Value = Joint> {
    (kind(), transform(), axis(), transform()).prop_map(|(kind, before, axis, after)| Joint {
        name: String::new(),
        kind,
        before,
        axis,
        after,
        limits: None,
    })
}

fn transform() -> impl Strategy<Value = Transform> {
    (uniform3(-1.0..1.0), uniform3(-PI..PI)).prop_map(|(xyz, rpy)| Transform::from_xyz_rpy(xyz, rpy))
}

/// Any direction, with the coordinate axes (both senses) as often as all others.
fn axis() -> impl Strategy<Value = [f64; 3]> {
    let along =
        prop_oneof![Just([0.0, 0.0, 1.0]), Just([0.0, 0.0, -1.0]), Just([0.0, -1.0, 0.0]), Just([1.0, 0.0, 0.0])];
    let any = (-1.0..1.0, -PI..PI).prop_map(|(z, angle): (f64, f64)| {
        let radius = (1.0 - z * z).sqrt();
        [radius * angle.cos(), radius * angle.sin(), z]
    });
    prop_oneof![along, any]
}

/// `[mass, h_x, h_y, h_z]`.
fn inertia() -> impl Strategy<Value = [f64; 4]> {
    (0.0..5.0, uniform3(-1.0..1.0)).prop_map(|(mass, [x, y, z])| [mass, x, y, z])
}
