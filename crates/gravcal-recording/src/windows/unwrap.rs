//! Angles that wrap.
//!
//! A sensor that shows 179° and then −180° has turned by a degree. From one row to the next no joint turns by half a turn, at the rates
//! that windows need: what jumps by about a whole turn goes on, and a jump of another size is an error of the recording. So is a smaller one that is far from
//! the steps before and after it: two recordings in one file, or an encoder that was set anew.

use std::ops::Range;

use super::clock::Recorded;

/// A jump farther from a whole number of turns is none of them.
const WHOLE: f64 = 0.2;

/// A step of so much of a turn, and so many times as large as those beside it, is no motion.
pub(super) const STEP: f64 = 0.05;
pub(super) const ABRUPT: f64 = 10.0;

/// A joint that is suddenly elsewhere.
pub(super) struct Jump {
    pub joint: usize,
    pub row: u64,
    /// By how many turns.
    pub turns: f64,
}

/// Adds full turns, so that every joint goes on within each run; gives how often each wraps. `turns`: a full turn in each reading.
pub(super) fn unwrap(recorded: &mut Recorded, turns: &[Option<f64>]) -> Result<Vec<u64>, Jump> {
    let mut wraps = vec![0; recorded.joints];
    for run in recorded.runs() {
        for (joint, turn) in turns.iter().enumerate() {
            let Some(turn) = turn else { continue };
            let mut added = 0.0;
            for row in run.start + 1..run.end {
                let by = (recorded.value(row, joint) + added - recorded.value(row - 1, joint)) / turn;
                let is_abrupt = |beside: f64| by.abs() > ABRUPT * beside / turn;
                if by.abs() > 0.5 {
                    if (by - by.round()).abs() > WHOLE {
                        return Err(Jump { joint, row: recorded.rows[row], turns: by });
                    }
                    added -= by.round() * turn;
                    wraps[joint] += 1;
                } else if by.abs() > STEP && steps_beside(recorded, &run, (row, joint)).is_some_and(is_abrupt) {
                    return Err(Jump { joint, row: recorded.rows[row], turns: by });
                }
                recorded.add(row, joint, added);
            }
        }
    }
    Ok(wraps)
}

/// The larger of the steps before and after one, as they were recorded; nothing where either is not in the run.
fn steps_beside(recorded: &Recorded, run: &Range<usize>, (row, joint): (usize, usize)) -> Option<f64> {
    let step = |to: usize| (recorded.value(to, joint) - recorded.value(to - 1, joint)).abs();
    (row >= run.start + 2 && row + 1 < run.end).then(|| step(row - 1).max(step(row + 1)))
}
