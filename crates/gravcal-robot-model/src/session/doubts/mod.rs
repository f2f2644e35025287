//! What a session says that can hardly be so, seen before anything is solved: lengths in millimetres, loads that hang far off, gravity of another planet,
//! positions and torques in another unit than declared, of another joint than their columns name or of two joints that are read as one's, sensors that are
//! stuck or at an end of their range, single readings that are nothing like all others, rows of an arm in motion that are taken as static poses, files without a torque, and recordings of two sources or of which a part is lost.

mod clipped;
mod columns;
mod copies;
mod far_away;
mod motion;
mod names;
mod positions;
mod recordings;
mod robot;
mod stated;
mod stuck;
mod torques;
mod unit;
mod unread;
mod wrong_cells;

pub use clipped::ClippedEnd;
pub use motion::Joined;
pub use unit::MistakenUnit;

use super::contents::Session;

impl Session {
    /// The same in sentences, each with what to do about it.
    pub fn find_doubts(&self) -> Vec<String> {
        let stated = robot::doubts(self).into_iter().chain(stated::doubts(self)).chain(far_away::doubts(self));
        let columns = stated.chain(columns::doubts(self));
        let positions = positions::doubts(self);
        let units = positions.into_iter().chain(torques::doubt(self, positions::are_in_another_unit(self)));
        columns
            .chain(units)
            .chain(unread::doubt(self))
            .chain(wrong_cells::doubts(self))
            .chain(stuck::doubts(self))
            .chain(clipped::doubts(self))
            .chain(copies::doubts(self))
            .chain(motion::doubts(self))
            .chain(recordings::doubts(self))
            .collect()
    }
}
