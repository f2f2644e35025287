//! What a session says that can hardly be so, seen before anything is solved: positions and torques in another unit than declared, and
//! rows of an arm in motion that are taken as static poses.

mod motion;
mod positions;
mod torques;
mod unit;

pub(crate) use motion::Joined;
pub use unit::MistakenUnit;

use super::Session;

impl Session {
    /// The same in sentences, each with what to do about it.
    pub(crate) fn find_doubts(&self) -> Vec<String> {
        let units = positions::doubts(self).into_iter().chain(torques::doubt(self));
        units.chain(motion::doubts(self)).collect()
    }
}

/// Names of joints in a sentence.
fn named(session: &Session, joints: &[usize]) -> String {
    let names = joints.iter().map(|joint| session.robot.chain.joints()[*joint].name.as_str());
    names.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
