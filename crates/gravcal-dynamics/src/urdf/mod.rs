//! Chains from URDF text.
//!
//! The ways from the base to the tips become the chain, which branches where they part. Of what is off these ways,
//!
//! - bodies that fixed joints attach to a moving link are merged into it (mass, first moment and inertia tensor);
//! - what hangs on the base, fixed or movable, loads no joint and is left out;
//! - what hangs by a movable joint on a rigid body with a **tip** (a gripper's fingers) is cut off with all it carries; its
//!   mass is not part of the model, and [`Chain::cut_joints`] names what was cut;
//! - a movable joint on any other moving body is refused by name: what it carries would load the chain by an amount
//!   that depends on a coordinate nobody gives.
//!
//! Link k is named after, and expressed in the frame of, the child link of its joint; a last link is named after its
//! tip and expressed in the tip's frame, also where fixed joints lie between. A joint that mimics another of the chain has no
//! coordinate of its own.

mod body;
mod corrected;
mod ends;
mod error;
mod essentials;
mod inertials;
mod joint;
mod tree;
mod xml;

use body::RigidBody;
pub use corrected::{UPRIGHT_LINK, UrdfCorrection};
pub use ends::UrdfEnds;
pub use error::UrdfError;
use essentials::essentials;
use joint::Motion;
use tree::Tree;
use urdf_rs::{JointType, Robot};

use crate::body_inertia::BodyInertia;
use crate::chain::{Attachment, Chain, Mimic};
use crate::joint::{Joint, JointKind};
use crate::link::{Link, LinkInertia};
use crate::transform::Transform;

/// The joints of a URDF that slide, by name, wherever they hang: a gripper's fingers mostly do.
///
/// # Errors
/// The text is no URDF.
pub fn urdf_sliding_joints(text: &str) -> Result<Vec<String>, UrdfError> {
    let sliding = read(text)?.joints.into_iter().filter(|joint| joint.joint_type == JointType::Prismatic);
    Ok(sliding.map(|joint| joint.name).collect())
}

/// The joints of a URDF that move, by name, wherever they hang.
///
/// # Errors
/// The text is no URDF.
pub fn urdf_moving_joints(text: &str) -> Result<Vec<String>, UrdfError> {
    let moving = read(text)?.joints.into_iter().filter(|joint| joint.joint_type != JointType::Fixed);
    Ok(moving.map(|joint| joint.name).collect())
}

impl Chain {
    /// The chain from link `base` to the links `tips` of a URDF: one tip for a serial robot, one for each branch otherwise.
    ///
    /// Fixed joints are folded, a continuous joint is a revolute one without limits, and bodies that fixed joints attach
    /// to a moving link are merged into it. A joint that mimics another follows it, and has no coordinate of its own. What
    /// hangs on a tip's rigid body by a movable joint is cut off, masses included, and named by [`Chain::cut_joints`]. The
    /// last link of a branch bears its tip's name and frame; branches come in the order of their tips. Everything before
    /// `base` is taken to stand still. A moving body without any stated mass has no inertia.
    ///
    /// # Errors
    ///
    /// [`UrdfError`] for text that is no URDF (or still xacro), links that do not exist, no way or nothing movable
    /// between base and a tip, a tip on the way to another, loops, joints that a chain cannot hold (floating, planar,
    /// spherical, mimicking one that is not between base and tips), movable side branches before a last body, zero axes,
    /// limits the wrong way round, and numbers that are not finite or masses below zero.
    pub fn from_urdf(text: &str, base: &str, tips: &[&str]) -> Result<Chain, UrdfError> {
        let robot = read(text)?;
        let tree = Tree::new(&robot)?;
        let tips = tips.iter().map(|tip| tree.find("tip", tip)).collect::<Result<_, _>>()?;
        let ends = Ends { base: tree.find("base", base)?, tips };
        let segments = fold(&tree, &ends)?;
        let Carried { links, tensors, cut } = carried(&tree, &segments, &ends)?;
        let joints = segments.iter().map(|segment| segment.joint(&tree)).collect::<Result<_, _>>()?;
        let attachment = |segment: &Segment| {
            Ok(Attachment {
                parent: segment.parent,
                mimic: mimic(&tree, &segments, &tree.robot.joints[segment.joint])?,
            })
        };
        let attachments = segments.iter().map(attachment).collect::<Result<Vec<_>, UrdfError>>()?;
        let mut chain = Chain::branched(base, joints, links, &attachments)?;
        chain.cut_joints = cut;
        chain.tensors = tensors;
        Ok(chain)
    }
}

fn read(text: &str) -> Result<Robot, UrdfError> {
    let essentials = essentials(text)?;
    urdf_rs::read_from_string(&essentials).map_err(|error| UrdfError::Parse(error.to_string()))
}

/// Base and tips, as link indices.
struct Ends {
    base: usize,
    tips: Vec<usize>,
}

/// One movable joint with the fixed ones around it.
struct Segment {
    /// Index of the movable joint.
    joint: usize,
    kind: JointKind,
    /// The segment that it hangs on; `None`: the base.
    parent: Option<usize>,
    /// From the link before (the child of the movable joint before, or the base) to the joint frame.
    before: Transform,
    /// From the child link's frame to the segment's link frame: identity but for those that end at a tip.
    after: Transform,
    /// The tip at which it ends.
    tip: Option<usize>,
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

/// A link on the way to a tip, seen from the segment that moves it.
#[derive(Clone)]
struct Place {
    /// `None`: the base, which nothing moves.
    segment: Option<usize>,
    /// Its frame in that of the segment's child link.
    pose: Transform,
}

/// The movable joints on the ways to the tips, by branches in the order of the tips, the fixed ones folded into the
/// transforms around them.
fn fold(tree: &Tree, ends: &Ends) -> Result<Vec<Segment>, UrdfError> {
    let mut segments: Vec<Segment> = Vec::new();
    let mut places: Vec<Option<Place>> = vec![None; tree.robot.links.len()];
    places[ends.base] = Some(Place { segment: None, pose: Transform::identity() });
    for index in tree.ways(ends.base, &ends.tips)? {
        let source = &tree.robot.joints[index];
        let Some(Place { segment: parent, pose }) = places[tree.parent_link(index)].clone() else { continue };
        let before = pose * joint::origin(source)?;
        places[tree.child(index)] = Some(match joint::motion(source)? {
            Motion::Fixed => Place { segment: parent, pose: before },
            Motion::Moving(kind) => {
                segments.push(Segment { joint: index, kind, parent, before, after: Transform::identity(), tip: None });
                Place { segment: Some(segments.len() - 1), pose: Transform::identity() }
            }
        });
    }
    for &tip in &ends.tips {
        end_at(tree, ends, &mut segments, &places, tip)?;
    }
    Ok(segments)
}

/// Lets the segment that moves a tip end there.
fn end_at(
    tree: &Tree,
    ends: &Ends,
    segments: &mut [Segment],
    places: &[Option<Place>],
    tip: usize,
) -> Result<(), UrdfError> {
    let Some(Place { segment: Some(own), pose }) = &places[tip] else {
        return Err(UrdfError::NothingMoves { base: tree.link_name(ends.base), tip: tree.link_name(tip) });
    };
    let on_the_way = |other: &usize| {
        let Some(Place { segment: Some(segment), .. }) = places[*other] else { return false };
        *other != tip && std::iter::successors(Some(segment), |segment| segments[*segment].parent).any(|s| s == *own)
    };
    let repeated = ends.tips.iter().filter(|other| **other == tip).count() > 1;
    let other = if repeated { Some(&tip) } else { ends.tips.iter().find(|other| on_the_way(other)) };
    if let Some(&other) = other {
        return Err(UrdfError::TipOnTheWay { tip: tree.link_name(tip), other: tree.link_name(other) });
    }
    (segments[*own].after, segments[*own].tip) = (*pose, Some(tip));
    Ok(())
}

/// Whom a joint follows, among the segments.
fn mimic(tree: &Tree, segments: &[Segment], source: &urdf_rs::Joint) -> Result<Option<Mimic>, UrdfError> {
    let Some(mimic) = &source.mimic else { return Ok(None) };
    let leader = segments.iter().position(|segment| tree.robot.joints[segment.joint].name == mimic.joint);
    let missing = || UrdfError::Leader { joint: source.name.clone(), leader: mimic.joint.clone() };
    Ok(Some(Mimic {
        leader: leader.ok_or_else(missing)?,
        multiplier: mimic.multiplier.unwrap_or(1.0),
        offset: mimic.offset.unwrap_or(0.0),
    }))
}

/// The links of the chain, and what was cut off behind the last ones.
struct Carried {
    links: Vec<Link>,
    /// About each link's origin, kg·m².
    tensors: Vec<[f64; 6]>,
    /// The names of the joints that were cut off.
    cut: Vec<String>,
}

fn carried(tree: &Tree, segments: &[Segment], ends: &Ends) -> Result<Carried, UrdfError> {
    let mut all = Carried { links: Vec::new(), tensors: Vec::new(), cut: Vec::new() };
    for segment in segments {
        let child = tree.child(segment.joint);
        let body = RigidBody::gather(tree, child)?;
        let name = match segment.tip {
            None => {
                refuse_branches(tree, &body, segments, ends)?;
                tree.link_name(child)
            }
            Some(tip) => {
                all.cut.extend(body.movable_joints.iter().map(|&joint| tree.joint_name(joint)));
                tree.link_name(tip)
            }
        };
        let BodyInertia { mass, first_moment, tensor } = body.inertia_in(&segment.after);
        all.links.push(Link { name, inertia: (mass > 0.0).then_some(LinkInertia { mass, first_moment }) });
        all.tensors.push(tensor);
    }
    Ok(all)
}

/// Only joints on the way to a tip may move what hangs on a body before the last.
fn refuse_branches(tree: &Tree, body: &RigidBody, segments: &[Segment], ends: &Ends) -> Result<(), UrdfError> {
    let known = |joint: usize| segments.iter().any(|segment| segment.joint == joint);
    match body.movable_joints.iter().find(|&&joint| !known(joint)) {
        None => Ok(()),
        Some(&joint) => Err(UrdfError::Branch {
            joint: tree.joint_name(joint),
            link: tree.link_name(tree.parent_link(joint)),
            base: tree.link_name(ends.base),
            tips: ends.tips.iter().map(|tip| format!("`{}`", tree.link_name(*tip))).collect::<Vec<_>>().join(", "),
        }),
    }
}

#[cfg(test)]
mod tests;
