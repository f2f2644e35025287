//! What can be wrong with a URDF, or with the chain asked of it.

use crate::chain::ChainError;

/// Why a URDF does not give the chain from base to tips.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// The text holds xacro macros, not yet expanded.
    #[error("this is a xacro file, not a URDF: expand it first (`xacro robot.xacro > robot.urdf`)")]
    Xacro,
    /// The text is no XML, or lacks what URDF asks for.
    #[error("not a readable URDF: {0}; expected XML with <robot>, <link> and <joint> elements")]
    Parse(String),
    /// The base or tip asked for is not in the file.
    #[error(
        "{role} link `{name}` is not in the URDF{}; links there: {}",
        suggestion(.nearest),
        listed(.links)
    )]
    MissingLink {
        /// "base" or "tip".
        role: &'static str,
        /// The name asked for.
        name: String,
        /// The most similar name in the file.
        nearest: Option<String>,
        /// Every link of the file.
        links: Vec<String>,
    },
    /// A joint names a link that the file does not define.
    #[error(
        "joint `{joint}` has the {role} `{link}`, which the URDF does not define; add <link name=\"{link}\"/> or \
         correct the name"
    )]
    UnknownLink {
        /// Name of the joint.
        joint: String,
        /// "parent" or "child".
        role: &'static str,
        /// The undefined link.
        link: String,
    },
    /// Two links share a name.
    #[error("two links of the URDF are named `{0}`; give each its own name")]
    RepeatedLink(String),
    /// A link hangs on two joints: a closed loop.
    #[error(
        "link `{link}` is the child of two joints, `{first}` and `{second}`: closed loops are not supported; remove \
         one of the two joints"
    )]
    TwoParents {
        /// The link.
        link: String,
        /// One of its joints.
        first: String,
        /// The other.
        second: String,
    },
    /// Links that are their own ancestors.
    #[error("the URDF's links form a loop: {}; expected a tree with one root link", .links.join(" -> "))]
    Loop {
        /// Along the loop, the first link repeated at the end.
        links: Vec<String>,
    },
    /// No way leads outward from base to tip.
    #[error("no chain of joints leads from base `{base}` to tip `{tip}`: {hint}")]
    NoPath {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
        /// What to ask for instead.
        hint: String,
    },
    /// Base and tip belong to one rigid body.
    #[error(
        "nothing moves between base `{base}` and tip `{tip}`: all joints between them are fixed; choose a tip beyond a \
         movable joint"
    )]
    NothingMoves {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
    },
    /// A joint of a type that a chain cannot hold.
    #[error(
        "joint `{joint}` between base and tip is {kind}; supported are revolute, continuous, prismatic and fixed: \
         choose base and tips so that it is not between them, or replace it"
    )]
    UnsupportedJoint {
        /// Name of the joint.
        joint: String,
        /// Its type.
        kind: &'static str,
    },
    /// No tip at all.
    #[error("no tip is named: name the last link, or the last link of each branch")]
    NoTip,
    /// A tip that another one makes superfluous.
    #[error(
        "tip `{tip}` is on the way to tip `{other}`, or on one rigid body with it: leave one of the two out (joints on the \
         way to a tip are part of the robot anyway)"
    )]
    TipOnTheWay {
        /// The tip.
        tip: String,
        /// The other one.
        other: String,
    },
    /// A joint that follows one that is not part of the robot.
    #[error(
        "joint `{joint}` mimics `{leader}`, which is no moving joint between base and tips: name a tip beyond `{leader}` as \
         well, choose tips so that `{joint}` is not on the way, or make it fixed"
    )]
    Leader {
        /// Name of the joint.
        joint: String,
        /// The joint it follows.
        leader: String,
    },
    /// A movable side branch.
    #[error(
        "joint `{joint}` hangs on link `{link}`, is not on the way from `{base}` to {tips}, and can move, so what it \
         carries loads the joints before it by an unknown amount; name a tip beyond it as well (tip = [\"…\", \"…\"]), or \
         make it fixed in the URDF"
    )]
    Branch {
        /// Name of the joint.
        joint: String,
        /// The link it hangs on.
        link: String,
        /// The base asked for.
        base: String,
        /// The tips asked for.
        tips: String,
    },
    /// An axis without direction.
    #[error("axis of joint `{joint}` is zero; expected a direction such as xyz=\"0 0 1\"")]
    ZeroAxis {
        /// Name of the joint.
        joint: String,
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
    /// A joint that is to be corrected is not in the file.
    #[error("joint `{name}`, which the calibration corrects, is not in the URDF: it is of another robot")]
    MissingJoint {
        /// The joint.
        name: String,
    },
    /// Gravity is known in a frame that moves against the root.
    #[error(
        "joint `{joint}` moves between the URDF's root and link `{base}`, in whose frame gravity is known: the tilt of the root \
         is not known"
    )]
    MovingRoot {
        /// The joint.
        joint: String,
        /// The link.
        base: String,
    },
    /// The name of the new root is taken.
    #[error("the URDF has a link `{name}` already: it has been corrected before; correct the original")]
    UprightLinkTaken {
        /// The name.
        name: String,
    },
    /// The joints and links between base and tips do not make a chain.
    #[error(transparent)]
    Chain(#[from] ChainError),
}

fn suggestion(nearest: &Option<String>) -> String {
    match nearest {
        Some(name) => format!(" (did you mean `{name}`?)"),
        None => String::new(),
    }
}

fn listed(links: &[String]) -> String {
    match links {
        [] => "none".to_owned(),
        _ => links.join(", "),
    }
}
