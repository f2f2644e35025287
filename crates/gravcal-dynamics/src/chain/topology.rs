//! Which link hangs on which.
//!
//! Links are numbered by branches: a parent before its child, and what hangs on a link right behind it. So beyond link k
//! are the links `k..ends[k]`, and a chain without branches is one run.

use std::ops::Range;

use super::attachment::Attachment;
use super::error::ChainError;
use crate::joint::Joint;
use crate::link::Link;

/// The tree of a chain's links.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Topology {
    /// Of each link, the one that it hangs on; `None`: the base.
    pub parents: Vec<Option<usize>>,
    /// Of each link, one past the last that it carries.
    pub ends: Vec<usize>,
    /// Runs of links each of which carries the next and nothing else.
    pub runs: Vec<Run>,
}

/// Links one after the other, without a branch but at the last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Run {
    pub links: Range<usize>,
    /// The link that the first one hangs on, last of its own run; `None`: the base.
    pub parent: Option<usize>,
}

impl Topology {
    /// # Errors
    ///
    /// A parent that does not come before its child, a branch that goes on after another has begun.
    pub fn new(joints: &[Joint], links: &[Link], attachments: &[Attachment]) -> Result<Self, ChainError> {
        let parents: Vec<Option<usize>> = attachments.iter().map(|attachment| attachment.parent).collect();
        for (link, parent) in parents.iter().enumerate() {
            check_order(&parents[..link], *parent)
                .map_err(|wrong| wrong.error(&joints[link], parent.and_then(|parent| links.get(parent))))?;
        }
        let ends = ends(&parents);
        let runs = runs(&parents);
        Ok(Topology { parents, ends, runs })
    }

    /// Of one link.
    pub fn single() -> Self {
        Topology { parents: vec![None], ends: vec![1], runs: vec![Run { links: 0..1, parent: None }] }
    }

    /// Whether each link carries the next and nothing else.
    pub fn is_serial(&self) -> bool {
        self.runs.len() == 1
    }

    /// The links from the base to `link`.
    pub fn path(&self, link: usize) -> Vec<usize> {
        let mut path: Vec<usize> = std::iter::successors(Some(link), |link| self.parents[*link]).collect();
        path.reverse();
        path
    }
}

enum WrongOrder {
    NotBefore,
    BranchEnded,
}

impl WrongOrder {
    fn error(self, joint: &Joint, parent: Option<&Link>) -> ChainError {
        let joint = joint.name.clone();
        match (self, parent) {
            (WrongOrder::BranchEnded, Some(parent)) => ChainError::BrokenBranch { joint, parent: parent.name.clone() },
            _ => ChainError::ParentNotBefore { joint },
        }
    }
}

/// The parent of the link after `before`: the last of these, or one that it hangs on.
fn check_order(before: &[Option<usize>], parent: Option<usize>) -> Result<(), WrongOrder> {
    let Some(parent) = parent else { return Ok(()) };
    if parent >= before.len() {
        return Err(WrongOrder::NotBefore);
    }
    let open = std::iter::successors(before.len().checked_sub(1), |link| before[*link]);
    if open.into_iter().any(|link| link == parent) { Ok(()) } else { Err(WrongOrder::BranchEnded) }
}

fn ends(parents: &[Option<usize>]) -> Vec<usize> {
    let mut ends: Vec<usize> = (1..=parents.len()).collect();
    for (link, parent) in parents.iter().enumerate().rev() {
        if let Some(parent) = parent {
            ends[*parent] = ends[*parent].max(ends[link]);
        }
    }
    ends
}

fn runs(parents: &[Option<usize>]) -> Vec<Run> {
    let children = |link: usize| parents.iter().filter(|parent| **parent == Some(link)).count();
    let mut runs: Vec<Run> = Vec::new();
    for (link, parent) in parents.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if link > 0 && *parent == Some(link - 1) && children(link - 1) == 1 => run.links.end = link + 1,
            _ => runs.push(Run { links: link..link + 1, parent: *parent }),
        }
    }
    runs
}
