//! Names in sentences.

use crate::session::Session;

/// Names of joints in a sentence.
pub(super) fn named(session: &Session, joints: &[usize]) -> String {
    let names = joints.iter().map(|joint| session.robot.chain.joints()[*joint].name.as_str());
    names.collect::<Vec<_>>().join(", ")
}
