//! Rows in which a joint is suddenly elsewhere, and back in the next: a bit that was lost, a number that was mistyped.
//!
//! A spline would follow such a reading, and what moves so has torques of inertia that no joint feels.

use super::clock::Recorded;
use super::unwrap::{ABRUPT, STEP};

/// Share of the rows that may be so: more are no single ones.
const FEW: f64 = 0.01;

/// A row in which a joint is elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stray {
    /// The joint.
    pub joint: usize,
    /// The row of the file.
    pub row: u64,
    /// By how many turns.
    pub turns: f64,
}

/// Takes the joint's position in such a row from the rows beside it, where it is elsewhere by less than half a turn: what is farther is an error of the
/// recording. `turns`: a full turn in each reading.
pub(super) fn take_from_neighbours(recorded: &mut Recorded, turns: &[Option<f64>]) -> Vec<Stray> {
    let mut found: Vec<(usize, Stray)> = Vec::new();
    for run in recorded.runs() {
        for row in run.start + 2..run.end.saturating_sub(2) {
            for (joint, turn) in turns.iter().enumerate() {
                let Some(turn) = turn else { continue };
                let at = |row: usize| recorded.value(row, joint) / turn;
                let by = at(row) - at(row - 1);
                // As it moves, it does not stand there: at low rates one that turns round is as far from both of its neighbours as these from theirs.
                let moves = [at(row + 1) - at(row - 1), at(row - 1) - at(row - 2), at(row + 2) - at(row + 1)];
                let most = moves.into_iter().map(f64::abs).fold(0.0, f64::max);
                if (STEP..0.5).contains(&by.abs()) && ABRUPT * most < by.abs() {
                    found.push((row, Stray { joint, row: recorded.rows[row], turns: by }));
                }
            }
        }
    }
    if found.len() as f64 > FEW * recorded.len() as f64 {
        return Vec::new();
    }
    for (row, Stray { joint, .. }) in &found {
        let between = 0.5 * (recorded.value(row - 1, *joint) + recorded.value(row + 1, *joint));
        recorded.add(*row, *joint, between - recorded.value(*row, *joint));
    }
    found.into_iter().map(|(_, stray)| stray).collect()
}
