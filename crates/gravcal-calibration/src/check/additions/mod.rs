//! What could be added to a session: things to state, poses to record, loads to attach.
//!
//! An addition is a small function from a session to the session with it ([`Hypothetical`]), and its words. Groups of
//! additions stand in the order of their effort; within a group they are the same thing done to one joint or load or another.

mod addition;
mod base;
mod conditions;
mod load;
mod poses;
mod priors;
mod torque;

use super::hypothetical::Hypothetical;

pub(super) use addition::Addition;

/// Everything that is tried, in groups of like additions, smallest effort first.
pub(super) fn additions(now: &Hypothetical) -> Vec<Vec<Addition>> {
    vec![
        priors::hemisphere(now),
        priors::torque_gain(now),
        priors::placement(now),
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
