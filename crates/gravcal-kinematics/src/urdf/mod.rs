//! Chains from URDF text.
//!
//! The path from base to tip becomes the chain. Of what is off the path,
//!
//! - bodies that fixed joints attach to a moving link are merged into it (mass and first moment);
//! - what hangs on the base, fixed or movable, loads no joint and is left out;
//! - what hangs by a movable joint on the **last** rigid body (a gripper's fingers) is cut off with all it carries; its
//!   mass is not part of the model, and [`Chain::cut_joints`] names what was cut;
//! - a movable joint on any other moving body is refused by name: what it carries would load the chain by an amount
//!   that depends on a coordinate nobody gives.
//!
//! Link k is named after, and expressed in the frame of, the child link of joint k; the last link is named after the
//! tip and expressed in the tip's frame, also where fixed joints lie between.

mod body;
mod error;
mod essentials;
mod joint;
mod tree;

use body::RigidBody;
pub use error::UrdfError;
use essentials::essentials;
use joint::Motion;
use tree::Tree;
use urdf_rs::Robot;

use crate::chain::Chain;
use crate::joint::{Joint, JointKind};
use crate::link::Link;
use crate::transform::Transform;

impl Chain {
    /// The chain from link `base` to link `tip` of a URDF.
    ///
    /// Fixed joints are folded, a continuous joint is a revolute one without limits, and bodies that fixed joints attach
    /// to a moving link are merged into it. What hangs on the tip's rigid body by a movable joint is cut off, masses
    /// included, and named by [`Chain::cut_joints`]. The last link bears the tip's name and frame. Everything before
    /// `base` is taken to stand still. A moving body without any stated mass has no inertia.
    ///
    /// # Errors
    ///
    /// [`UrdfError`] for text that is no URDF (or still xacro), links that do not exist, no path or nothing movable
    /// between base and tip, loops, joints that a chain cannot hold (mimic, floating, planar, spherical), movable side
    /// branches before the last body, zero axes, limits the wrong way round, and numbers that are not finite or masses
    /// below zero.
    pub fn from_urdf(text: &str, base: &str, tip: &str) -> Result<Chain, UrdfError> {
        let robot = read(text)?;
        let tree = Tree::new(&robot)?;
        let ends = Ends { base: tree.find("base", base)?, tip: tree.find("tip", tip)? };
        let path = tree.path(ends.base, ends.tip)?;
        let segments = fold(&tree, &path, &ends)?;
        let (links, cut) = carried(&tree, &segments, &ends)?;
        let joints = segments.iter().map(|segment| segment.joint(&tree)).collect::<Result<_, _>>()?;
        let mut chain = Chain::new(base, joints, links)?;
        chain.cut_joints = cut;
        Ok(chain)
    }
}

fn read(text: &str) -> Result<Robot, UrdfError> {
    let essentials = essentials(text)?;
    urdf_rs::read_from_string(&essentials).map_err(|error| UrdfError::Parse(error.to_string()))
}

/// Base and tip, as link indices.
struct Ends {
    base: usize,
    tip: usize,
}

/// One movable joint of the path with the fixed ones around it.
struct Segment {
    /// Index of the movable joint.
    joint: usize,
    kind: JointKind,
    /// From the link before (the child of the movable joint before, or the base) to the joint frame.
    before: Transform,
    /// From the child link's frame to the segment's link frame: identity but for the last, which ends at the tip.
    after: Transform,
}

impl Segment {
    fn joint(&self, tree: &Tree) -> Result<Joint, UrdfError> {
        let source = &tree.robot.joints[self.joint];
        Ok(Joint {
            name: source.name.clone(),
            kind: self.kind,
            before: self.before,
            axis: joint::axis(source)?,
            after: self.after,
            limits: joint::limits(source),
        })
    }
}

/// The movable joints of the path, the fixed ones folded into the transforms around them.
fn fold(tree: &Tree, path: &[usize], ends: &Ends) -> Result<Vec<Segment>, UrdfError> {
    let mut segments: Vec<Segment> = Vec::new();
    let mut fixed = Transform::identity();
    for &index in path {
        let source = &tree.robot.joints[index];
        fixed = fixed * joint::origin(source)?;
        if let Motion::Moving(kind) = joint::motion(source)? {
            segments.push(Segment { joint: index, kind, before: fixed, after: Transform::identity() });
            fixed = Transform::identity();
        }
    }
    match segments.last_mut() {
        Some(last) => last.after = fixed,
        None => {
            let [base, tip] = [ends.base, ends.tip].map(|link| tree.link_name(link));
            return Err(UrdfError::NothingMoves { base, tip });
        }
    }
    Ok(segments)
}

/// The links of the chain, and the names of the joints that were cut off behind the last one.
fn carried(tree: &Tree, segments: &[Segment], ends: &Ends) -> Result<(Vec<Link>, Vec<String>), UrdfError> {
    let mut links = Vec::new();
    let mut cut = Vec::new();
    for (k, segment) in segments.iter().enumerate() {
        let child = tree.child(segment.joint);
        let body = RigidBody::gather(tree, child)?;
        let name = match segments.get(k + 1) {
            Some(next) => {
                refuse_branches(tree, &body, next.joint, ends)?;
                tree.link_name(child)
            }
            None => {
                cut = body.movable_joints.iter().map(|&joint| tree.joint_name(joint)).collect();
                tree.link_name(ends.tip)
            }
        };
        links.push(Link { name, inertia: body.inertia_in(&segment.after) });
    }
    Ok((links, cut))
}

/// Only the path's next joint may move what hangs on a body before the last.
fn refuse_branches(tree: &Tree, body: &RigidBody, next: usize, ends: &Ends) -> Result<(), UrdfError> {
    match body.movable_joints.iter().find(|&&joint| joint != next) {
        None => Ok(()),
        Some(&joint) => Err(UrdfError::Branch {
            joint: tree.joint_name(joint),
            link: tree.link_name(tree.parent_link(joint)),
            base: tree.link_name(ends.base),
            tip: tree.link_name(ends.tip),
        }),
    }
}

#[cfg(test)]
mod tests;
