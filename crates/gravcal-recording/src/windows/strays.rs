//! Rows in which a joint is suddenly elsewhere, and back in the next: a bit that was lost, a number that was mistyped.
//!
//! A spline would follow such a reading, and what moves so has torques of inertia that no joint feels.

use std::collections::BTreeSet;

use super::clock::Recorded;
use super::unwrap::{ABRUPT, STEP};

/// A row that is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stray {
    /// The joint that is elsewhere in it.
    pub joint: usize,
    /// The row of the file.
    pub row: u64,
    /// By how many turns.
    pub turns: f64,
}

/// Leaves them out where a joint is elsewhere by less than half a turn: what is farther is an error of the recording. `turns`: a full turn in each reading.
pub(super) fn leave_out(recorded: &mut Recorded, turns: &[Option<f64>]) -> Vec<Stray> {
    let mut strays = Vec::new();
    let mut left_out = BTreeSet::new();
    for run in recorded.runs() {
        for row in run.start + 1..run.end.saturating_sub(1) {
            let stray = turns.iter().enumerate().find_map(|(joint, turn)| {
                let turn = (*turn)?;
                let [before, here, after] = [row - 1, row, row + 1].map(|row| recorded.value(row, joint) / turn);
                let (by, beyond) = (here - before, after - before);
                let is_stray = (STEP..0.5).contains(&by.abs()) && ABRUPT * beyond.abs() < by.abs();
                is_stray.then_some(Stray { joint, row: recorded.rows[row], turns: by })
            });
            if let Some(stray) = stray {
                strays.push(stray);
                left_out.insert(row);
            }
        }
    }
    if !left_out.is_empty() {
        recorded.leave_out(&left_out);
    }
    strays
}
