//! What could be added to a session: things to state, poses to record, loads to attach.
//!
//! An addition is a small function from a session to the session with it ([`Supposed`]), and its words. Groups of
//! additions stand in the order of their effort; within a group they are the same thing done to one joint or load or another.

mod base;
mod conditions;
mod knowledge;
mod load;
mod poses;
mod torque;

use super::supposed::Supposed;

/// One addition.
pub(super) struct Addition {
    /// What to do.
    pub words: String,
    /// The parameter that it states: no cure of that one alone.
    pub states: Option<String>,
    make: Box<dyn Fn(&mut Supposed)>,
}

impl Addition {
    fn new(words: String, make: impl Fn(&mut Supposed) + 'static) -> Addition {
        Addition { words, states: None, make: Box::new(make) }
    }

    /// The session with the addition.
    pub fn made(&self, now: &Supposed) -> Supposed {
        let mut supposed = now.clone();
        (self.make)(&mut supposed);
        supposed
    }
}

/// Everything that is tried, in groups of like additions, smallest effort first.
pub(super) fn additions(now: &Supposed) -> Vec<Vec<Addition>> {
    vec![
        knowledge::hemisphere(now),
        knowledge::torque_gain(now),
        knowledge::placement(now),
        poses::more(now),
        poses::third_position(now),
        poses::wider_sweep(now),
        conditions::others(now),
        poses::bare_besides_loaded(now),
        load::attached(now),
        load::second_placement(now),
        load::at_known_position(now),
        load::two_placements(now),
        base::tilted(now),
        torque::of_unread_joint(now),
    ]
}
