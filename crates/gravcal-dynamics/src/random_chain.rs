//! Random chains and poses for the property tests.

use std::f64::consts::PI;

use proptest::array::uniform3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::chain::{Attachment, Chain, Mimic};
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

impl Pose {
    /// The coordinate of a link's mover, by the definition of mimicking.
    pub fn of_link(&self, link: usize) -> f64 {
        self.chain.drive(link).coordinate(&self.coordinates)
    }
}

/// One to eight joints of both kinds with axes in every direction, serial or branched, some mimicking others, in any pose.
pub(crate) fn pose() -> impl Strategy<Value = Pose> {
    let parts = vec((joint(), -PI..PI, inertia()), 1..9);
    let attached = vec((any::<Index>(), any::<Index>(), -2.0..2.0, -1.0..1.0), 8);
    let shape = (any::<bool>(), any::<bool>(), attached);
    (parts, shape, uniform3(-10.0..10.0)).prop_map(|(parts, (serial, coupled, attached), gravity)| {
        let mut attachments: Vec<Attachment> = Vec::new();
        for (k, (place, leader, multiplier, offset)) in attached.into_iter().enumerate().take(parts.len()) {
            // The links on which the next one may hang without breaking a branch, the base last.
            let open = std::iter::successors(k.checked_sub(1), |link| attachments[*link].parent);
            let open: Vec<Option<usize>> = open.map(Some).chain([None]).collect();
            let parent = if serial { open[0] } else { *place.get(&open) };
            // Every third joint mimics one of those that never do.
            let leader = 3 * leader.index(parts.len().div_ceil(3));
            let mimic = (coupled && k % 3 == 2).then_some(Mimic { leader, multiplier, offset });
            attachments.push(Attachment { parent, mimic });
        }
        let chain = branched(parts.iter().map(|(joint, ..)| joint.clone()).collect(), &attachments);
        let coordinates = parts.iter().take(chain.joint_count()).map(|(_, coordinate, _)| *coordinate).collect();
        let inertia = parts.iter().flat_map(|(.., inertia)| *inertia).collect();
        Pose { chain, coordinates, gravity, inertia }
    })
}

/// A chain of joints hung like that, all with names of their own.
pub(crate) fn branched(mut joints: Vec<Joint>, attachments: &[Attachment]) -> Chain {
    for (i, joint) in joints.iter_mut().enumerate() {
        joint.name = format!("joint{i}");
    }
    let links = (0..joints.len()).map(link).collect();
    Chain::branched("base", joints, links, attachments).unwrap()
}

/// A joint that turns about the x of the link it hangs on, half a metre out.
pub(crate) fn turning() -> Joint {
    Joint {
        name: String::new(),
        kind: JointKind::Revolute,
        before: Transform::along([0.5, 0.1, 0.0]),
        axis: [1.0, 0.0, 0.0],
        after: Transform::about_z(0.3),
        limits: None,
    }
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
