//! What a session says that can hardly be so, seen before anything is solved: positions and torques in another unit than declared, and
//! rows of an arm in motion that are taken as static poses.

mod motion;
mod names;
mod positions;
mod torques;
mod unit;

pub(crate) use motion::Joined;
pub use unit::MistakenUnit;

use super::contents::Session;

impl Session {
    /// The same in sentences, each with what to do about it.
    pub(crate) fn find_doubts(&self) -> Vec<String> {
        let units = positions::doubts(self).into_iter().chain(torques::doubt(self));
        units.chain(motion::doubts(self)).collect()
    }
}

#[cfg(test)]
mod tests;
