//! What a recorder did to torques and not to positions, to first order.
//!
//! ```text
//!     y(t) = ŷ(t − l) ≈ ŷ − l dŷ/dt           torques come l later
//!     y = f ∗ ŷ      ≈ ŷ + ½ σ² d²ŷ/dt²       torques pass a filter of the width σ: that of a Hann window of length L is 0.181 L
//! ```
//!
//! Slopes are taken from window to window.

use gravcal_estimation::EvaluateError;
use gravcal_recording::FILTER_LENGTH;
use gravcal_robot_model::session::{ReadingId, Session};

use super::rows::ReadingRow;
use crate::joint::Solved;

/// Width of a Hann window in its length, `√(1/12 − 1/(2π²))`, times that of a filter of 1 Hz.
const WIDTH: f64 = 0.180_756 * FILTER_LENGTH;
/// Windows that follow each other by more than so many of the least times from one to the next have others between them that are left out.
const FOLLOWS: f64 = 1.5;

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
pub fn slopes(session: &Session, predictions: &[f64], rows: &[ReadingRow]) -> Vec<[f64; 2]> {
    let time = |place: usize| {
        let pose = &session.poses[rows[place].pose];
        pose.course.as_ref().and(pose.conditions.time)
    };
    let table = |place: usize| session.poses[rows[place].pose].table;
    let step = |place: usize| {
        let later = place + 1;
        let (true, Some(before), Some(after)) =
            (later < rows.len() && table(place) == table(later), time(place), time(later))
        else {
            return f64::INFINITY;
        };
        after - before
    };
    let steps: Vec<f64> = (0..rows.len().saturating_sub(1)).map(step).collect();
    let least = steps.iter().copied().filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let at = |place: usize| {
        if place == 0 || place + 1 >= rows.len() {
            return [0.0; 2];
        }
        let (before, after) = (steps[place - 1], steps[place]);
        if before.max(after) > FOLLOWS * least || before <= 0.0 || after <= 0.0 {
            return [0.0; 2];
        }
        let [low, here, high] = [place - 1, place, place + 1].map(|place| predictions[rows[place].row]);
        let (falls, rises) = ((here - low) / before, (high - here) / after);
        [(falls * after + rises * before) / (before + after), 2.0 * (rises - falls) / (before + after)]
    };
    (0..rows.len()).map(at).collect()
}
