//! The links of a URDF as a tree: who hangs on whom.

use std::collections::HashMap;

use urdf_rs::Robot;

use super::error::UrdfError;
use crate::nearest::nearest;

/// Links and joints by index into the URDF's own lists; checked to be free of loops.
pub(super) struct Tree<'a> {
    pub robot: &'a Robot,
    /// Of each joint: the link it hangs on, and the link it carries.
    ends: Vec<[usize; 2]>,
    /// Of each link: the joint that carries it.
    parent_joint: Vec<Option<usize>>,
    /// Of each link: the joints that hang on it.
    child_joints: Vec<Vec<usize>>,
}

impl<'a> Tree<'a> {
    /// # Errors
    ///
    /// Repeated links, joints between undefined links, links with two parents, loops.
    pub fn new(robot: &'a Robot) -> Result<Self, UrdfError> {
        let index = link_indices(robot)?;
        let mut tree = Tree {
            robot,
            ends: Vec::new(),
            parent_joint: vec![None; robot.links.len()],
            child_joints: vec![Vec::new(); robot.links.len()],
        };
        for joint in 0..robot.joints.len() {
            tree.attach(joint, &index)?;
        }
        tree.check_for_loops()?;
        Ok(tree)
    }

    fn attach(&mut self, joint: usize, index: &HashMap<&str, usize>) -> Result<(), UrdfError> {
        let robot = self.robot;
        let end = |role, link: &'a str| {
            index.get(link).copied().ok_or_else(|| UrdfError::UnknownLink {
                joint: self.joint_name(joint),
                role,
                link: link.to_owned(),
            })
        };
        let parent = end("parent", &robot.joints[joint].parent.link)?;
        let child = end("child", &robot.joints[joint].child.link)?;
        if let Some(first) = self.parent_joint[child] {
            return Err(UrdfError::TwoParents {
                link: self.link_name(child),
                first: self.joint_name(first),
                second: self.joint_name(joint),
            });
        }
        self.ends.push([parent, child]);
        self.parent_joint[child] = Some(joint);
        self.child_joints[parent].push(joint);
        Ok(())
    }

    /// Whoever cannot be reached from a root (a link without parent) hangs on a loop.
    fn check_for_loops(&self) -> Result<(), UrdfError> {
        let mut reached = vec![false; self.parent_joint.len()];
        let is_root = |link: &usize| self.parent_joint[*link].is_none();
        let mut open: Vec<usize> = (0..reached.len()).filter(is_root).collect();
        while let Some(link) = open.pop() {
            reached[link] = true;
            open.extend(self.child_joints(link).iter().map(|&joint| self.child(joint)));
        }
        match reached.iter().position(|reached| !reached) {
            Some(link) => Err(UrdfError::Loop { links: self.loop_above(link) }),
            None => Ok(()),
        }
    }

    /// The loop that a link without a root above it hangs on, from parent to child.
    fn loop_above(&self, link: usize) -> Vec<String> {
        let mut upward = Vec::new();
        let mut next = Some(link);
        while let Some(link) = next {
            if let Some(start) = upward.iter().position(|seen| *seen == link) {
                upward.drain(..start);
                upward.push(link);
                break;
            }
            upward.push(link);
            next = self.parent(link);
        }
        upward.into_iter().rev().map(|link| self.link_name(link)).collect()
    }

    /// Index of the link that is to be base or tip.
    pub fn find(&self, role: &'static str, name: &str) -> Result<usize, UrdfError> {
        let names = || self.robot.links.iter().map(|link| link.name.as_str());
        names().position(|link| link == name).ok_or_else(|| UrdfError::MissingLink {
            role,
            name: name.to_owned(),
            nearest: nearest(name, names()).map(str::to_owned),
            links: names().map(str::to_owned).collect(),
        })
    }

    /// The joints on the ways from base to tips, outward, each once: a branch to its end before the next, in the order of
    /// the tips.
    ///
    /// # Errors
    ///
    /// No tip, or no way to one.
    pub fn ways(&self, base: usize, tips: &[usize]) -> Result<Vec<usize>, UrdfError> {
        if tips.is_empty() {
            return Err(UrdfError::NoTip);
        }
        let ways = tips.iter().map(|tip| self.path(base, *tip)).collect::<Result<Vec<_>, _>>()?;
        let mut first_tip: HashMap<usize, usize> = HashMap::new();
        for (tip, way) in ways.iter().enumerate() {
            way.iter().for_each(|joint| _ = first_tip.entry(*joint).or_insert(tip));
        }
        let mut joints = Vec::new();
        let mut open = vec![base];
        while let Some(link) = open.pop() {
            let mut onward: Vec<usize> = self.child_joints(link).to_vec();
            onward.retain(|joint| first_tip.contains_key(joint));
            onward.sort_by_key(|joint| std::cmp::Reverse(first_tip[joint]));
            joints.extend(self.parent_joint[link].filter(|_| link != base));
            open.extend(onward.into_iter().map(|joint| self.child(joint)));
        }
        Ok(joints)
    }

    /// The joints from base to tip, outward.
    fn path(&self, base: usize, tip: usize) -> Result<Vec<usize>, UrdfError> {
        let mut joints = Vec::new();
        let mut link = tip;
        while link != base {
            let Some(joint) = self.parent_joint[link] else {
                return Err(self.no_path(base, tip));
            };
            joints.push(joint);
            link = self.ends[joint][0];
        }
        joints.reverse();
        Ok(joints)
    }

    fn no_path(&self, base: usize, tip: usize) -> UrdfError {
        let above_tip = self.ancestors(tip);
        let shared = self.ancestors(base).into_iter().find(|link| above_tip.contains(link));
        let hint = match shared {
            Some(link) if link == tip => "the tip lies before the base; exchange the two".to_owned(),
            Some(link) => format!(
                "they branch apart at link `{}`; a base there, or before it, reaches the tip",
                self.link_name(link)
            ),
            None => "the URDF holds more than one tree, and they are in different ones; join the trees by a joint"
                .to_owned(),
        };
        UrdfError::NoPath { base: self.link_name(base), tip: self.link_name(tip), hint }
    }

    /// The link itself and all it hangs on, inward.
    fn ancestors(&self, link: usize) -> Vec<usize> {
        self.links_to_root(link).collect()
    }

    /// The same one by one.
    pub fn links_to_root(&self, link: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(link), |link| self.parent(*link))
    }

    /// The joint that carries a link.
    pub fn parent_joint(&self, link: usize) -> Option<usize> {
        self.parent_joint[link]
    }

    fn parent(&self, link: usize) -> Option<usize> {
        self.parent_joint[link].map(|joint| self.ends[joint][0])
    }

    /// The link that a joint hangs on.
    pub fn parent_link(&self, joint: usize) -> usize {
        self.ends[joint][0]
    }

    /// The link that a joint carries.
    pub fn child(&self, joint: usize) -> usize {
        self.ends[joint][1]
    }

    /// The joints that hang on a link.
    pub fn child_joints(&self, link: usize) -> &[usize] {
        &self.child_joints[link]
    }

    pub fn link_name(&self, link: usize) -> String {
        self.robot.links[link].name.clone()
    }

    pub fn joint_name(&self, joint: usize) -> String {
        self.robot.joints[joint].name.clone()
    }
}

fn link_indices(robot: &Robot) -> Result<HashMap<&str, usize>, UrdfError> {
    let mut index = HashMap::new();
    for (i, link) in robot.links.iter().enumerate() {
        if index.insert(link.name.as_str(), i).is_some() {
            return Err(UrdfError::RepeatedLink(link.name.clone()));
        }
    }
    Ok(index)
}
