//! What a recorder did to torques and not to positions, to first order.
//!
//! ```text
//!     y(t) = ŷ(t − l) ≈ ŷ − l dŷ/dt           torques come l later
//!     y = f ∗ ŷ      ≈ ŷ + ½ σ² d²ŷ/dt²       torques pass a filter of the width σ: that of a Hann window of length L is 0.181 L
//! ```
//!
//! Slopes are taken from window to window, the second ones from each to one that hardly shares a moment with it.

use gravcal_estimation::EvaluateError;
use gravcal_recording::FILTER_LENGTH;
use gravcal_robot_model::session::{Pose, ReadingId, Session};

use super::rows::ReadingRow;
use crate::joint::Solved;

/// Width of a Hann window in its length, `√(1/12 − 1/(2π²))`, times that of a filter of 1 Hz.
const WIDTH: f64 = 0.180_756 * FILTER_LENGTH;
/// Second slopes follow the motion over so long at most, s: the length of a window of which nothing is said. Longer windows leave noise out by themselves.
const FOLLOWED: f64 = 0.32;
/// Windows that follow each other by more than so many of the least times from one to the next than they should have others between them that are left out.
const FOLLOWS: f64 = 0.5;

/// Cut-off, Hz, of a filter that adds so much of the second slope, s².
pub fn cut_off(half_square: f64) -> f64 {
    WIDTH / (2.0 * half_square.abs()).sqrt()
}

/// The other way round.
pub fn half_square(cut_off: f64) -> f64 {
    0.5 * (WIDTH / cut_off).powi(2)
}

/// Readings of windows as they are predicted, by row; empty where the arm stands.
pub fn predictions(session: &Session, solved: &Solved) -> Result<Vec<f64>, EvaluateError> {
    if !session.has_windows() {
        return Ok(Vec::new());
    }
    let residuals = solved.built.problem.residuals(&solved.estimate.values)?;
    let prediction = |(id, residual): (&ReadingId, f64)| {
        let reading = session.reading(*id).map_or(0.0, |reading| reading.value);
        reading + residual * solved.readings().std(session, *id)
    };
    Ok(solved.built.rows.iter().zip(residuals).map(prediction).collect())
}

/// First and second slope over time at each of a channel's rows; zero where the windows beside are not there.
///
/// The second is over windows that hardly share a moment. Windows that begin sooner share the noise of what positions say of the acceleration: it is in the residual, and its
/// second slope, with the opposite sign, would pass for a filter.
pub fn slopes(session: &Session, predictions: &[f64], rows: &[ReadingRow]) -> Vec<[f64; 2]> {
    let course = Course { session, predictions, rows };
    let steps = (1..rows.len()).filter_map(|later| course.time_from([later - 1, later]));
    let least = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let windows = session.searched.iter().filter_map(|searched| searched.windows.as_ref());
    let length = windows.map(|windows| windows.length).fold(0.0, f64::max);
    let alone = ((length.min(FOLLOWED) / least).round() as usize).max(1);
    let of = |place: usize| {
        let slope = course.beside(place, 1, least).map_or(0.0, Beside::slope);
        [slope, course.beside(place, alone, least).map_or(0.0, Beside::bend)]
    };
    (0..rows.len()).map(of).collect()
}

/// What is predicted of a channel, from window to window.
struct Course<'a> {
    session: &'a Session,
    predictions: &'a [f64],
    rows: &'a [ReadingRow],
}

impl Course<'_> {
    /// From the window of one row to that of another; nothing where they are of different tables, or no windows.
    fn time_from(&self, ends: [usize; 2]) -> Option<f64> {
        let [before, after] = ends.map(|place| &self.session.poses[self.rows[place].pose]);
        let time = |pose: &Pose| pose.course.as_ref().and(pose.conditions.time);
        (before.table == after.table).then_some(time(after)? - time(before)?)
    }

    /// A row and those that are so many before and behind it; nothing where others between them are left out. `least`: time from one to the next.
    fn beside(&self, place: usize, apart: usize, least: f64) -> Option<Beside> {
        let (before, after) = (place.checked_sub(apart)?, place + apart);
        if after >= self.rows.len() {
            return None;
        }
        let steps = [self.time_from([before, place])?, self.time_from([place, after])?];
        let follow = steps.iter().all(|step| *step > 0.0 && *step <= (apart as f64 + FOLLOWS) * least);
        follow.then(|| Beside {
            values: [before, place, after].map(|place| self.predictions[self.rows[place].row]),
            steps,
        })
    }
}

/// Three values over time, and the times between them.
struct Beside {
    values: [f64; 3],
    steps: [f64; 2],
}

impl Beside {
    fn slopes(&self) -> [f64; 2] {
        let [low, here, high] = self.values;
        [(here - low) / self.steps[0], (high - here) / self.steps[1]]
    }

    fn slope(self) -> f64 {
        let ([falls, rises], [before, after]) = (self.slopes(), self.steps);
        (falls * after + rises * before) / (before + after)
    }

    fn bend(self) -> f64 {
        let ([falls, rises], [before, after]) = (self.slopes(), self.steps);
        2.0 * (rises - falls) / (before + after)
    }
}
