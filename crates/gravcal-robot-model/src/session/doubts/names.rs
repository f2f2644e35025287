//! Names in sentences.

use crate::session::Session;

/// So many rows are named.
const NAMED: usize = 3;

/// Rows of some poses in a sentence.
pub(super) fn rows(session: &Session, poses: impl Iterator<Item = usize>) -> String {
    let poses: Vec<usize> = poses.collect();
    let named = poses.iter().take(NAMED).map(|pose| {
        let (file, line) = session.row_of(*pose);
        format!("row {line} of {file}")
    });
    let named = named.collect::<Vec<_>>().join(", ");
    if poses.len() > NAMED { format!("{named} and {} more", poses.len() - NAMED) } else { named }
}

/// Names of joints in a sentence.
pub(super) fn named(session: &Session, joints: &[usize]) -> String {
    let names = joints.iter().map(|joint| session.robot.chain.joints()[*joint].name.as_str());
    names.collect::<Vec<_>>().join(", ")
}
