//! What can be wrong with a chain.

/// Why joints and links do not make a chain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChainError {
    /// A chain needs at least one joint.
    #[error("the chain from `{base}` has no joint; give at least one revolute or prismatic joint")]
    NoJoints {
        /// Name of the base.
        base: String,
    },
    /// Every joint moves exactly one link.
    #[error("{joints} joints but {links} links; give exactly one link for each joint, in the same order")]
    LinkCount {
        /// Number of joints.
        joints: usize,
        /// Number of links.
        links: usize,
    },
    /// Every joint hangs somewhere.
    #[error("{joints} joints but {attachments} attachments; say of each joint where it hangs, in the same order")]
    AttachmentCount {
        /// Number of joints.
        joints: usize,
        /// Number of attachments.
        attachments: usize,
    },
    /// A parent at or behind its child.
    #[error("joint `{joint}` hangs on a link that does not come before its own; give parents first")]
    ParentNotBefore {
        /// Name of the joint.
        joint: String,
    },
    /// A branch that goes on after another one began.
    #[error(
        "joint `{joint}` hangs on link `{parent}`, whose branch has ended; give the joints of a branch one right after the \
         other, then those of the next"
    )]
    BrokenBranch {
        /// Name of the joint.
        joint: String,
        /// Name of the link.
        parent: String,
    },
    /// A joint that mimics none of the chain.
    #[error("joint `{joint}` mimics a joint that is not there; expected the index of one of the chain's joints")]
    UnknownLeader {
        /// Name of the joint.
        joint: String,
    },
    /// Joints that mimic each other.
    #[error(
        "joint `{joint}` mimics itself by way of others; one joint of the circle must have a coordinate of its own"
    )]
    MimicCircle {
        /// Name of the joint.
        joint: String,
    },
    /// Two joints share a name.
    #[error("two joints are named `{0}`; results are told by joint name, so give each its own")]
    RepeatedJoint(String),
    /// Two links, or a link and the base, share a name.
    #[error("two links (the base counts as one) are named `{0}`; give each its own name")]
    RepeatedLink(String),
    /// The axis is not of unit length.
    #[error("axis {axis:?} of joint `{joint}` has length {length}; expected a unit vector: divide it by its length")]
    Axis {
        /// Name of the joint.
        joint: String,
        /// The axis as given.
        axis: [f64; 3],
        /// Its length.
        length: f64,
    },
    /// The lower limit lies above the upper one.
    #[error("limits of joint `{joint}` are the wrong way round: lower {lower} is above upper {upper}; swap them")]
    Limits {
        /// Name of the joint.
        joint: String,
        /// Lower limit, rad or m.
        lower: f64,
        /// Upper limit, rad or m.
        upper: f64,
    },
    /// NaN or infinity.
    #[error("{what} is not finite; expected ordinary numbers in SI units")]
    NotFinite {
        /// Which number, of which joint or link.
        what: String,
    },
    /// A mass below zero.
    #[error("mass of link `{link}` is {mass} kg; expected zero or more")]
    NegativeMass {
        /// Name of the link.
        link: String,
        /// The mass, kg.
        mass: f64,
    },
}
