//! Whether the readings of a session tell gravity from its opposite, before any solve.
//!
//! The readings that the nominal values predict are explained with gravity the other way up, masses, moments and placements
//! negative ([`State::upside_down`]). With r what is left of them there and J the Jacobian, whitened, the best that a
//! first step can do is the cost
//!
//! ```text
//!     ½ (rᵀr − (Jᵀr)ᵀ (JᵀJ)⁺ (Jᵀr))
//! ```
//!
//! Gains keep their sign ([`with_gains_known`]), because to first order a gain may become its negative, which undoes what the
//! weight of a load on known lengths tells.

use gravcal_identification::DECISIVE;
use gravcal_robot_model::session::Session;

use crate::joint::{EstimateError, MeasurementSet, Solved, State, build_problem, with_gains_known};

/// Whether gravity's sign is declared, or can be decided by the readings.
pub(super) fn is_decided(session: &Session, readings: &MeasurementSet, values: &State) -> Result<bool, EstimateError> {
    if session.gravity.hemisphere.is_some() {
        return Ok(true);
    }
    let mut session = with_gains_known(session);
    let predicted = build_problem(&session, readings, values)?.predicted(&session)?;
    for (id, value) in predicted {
        if let Some(reading) = session.reading_mut(id) {
            reading.value = value;
        }
    }
    let other = values.upside_down(&session);
    let judged = Solved::at_start(build_problem(&session, readings, &other)?)?;
    Ok(cost_after_a_step(&judged)? > DECISIVE)
}

fn cost_after_a_step(judged: &Solved) -> Result<f64, EstimateError> {
    let columns = judged.built.problem.columns().len();
    let rows = judged.built.problem.augmented_jacobian(&judged.estimate.values)?;
    let (mut gradient, mut squares) = (vec![0.0; columns], 0.0);
    for row in rows.chunks_exact(columns + 1) {
        squares += row[columns] * row[columns];
        gradient.iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry * row[columns]);
    }
    let terms: Vec<(usize, f64)> = gradient.into_iter().enumerate().collect();
    let explained = judged.covariance().std_of(&terms).powi(2);
    Ok(0.5 * (squares - explained))
}
