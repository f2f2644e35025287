//! Joints that bend while the arm moves: what their compliances do to the readings of windows.
//!
//! ```text
//!     θ_j = s_j q_j + o_j + c_j τ_j(t),     θ̇_j = s_j q̇_j + c_j τ̇_j,     θ̈_j = s_j q̈_j + c_j τ̈_j
//!     C_j = [y(c_1, …, c_j, 0, …) − y(c_1, …, c_(j−1), 0, …)] / c_j
//! ```
//!
//! `τ_j(t)` is the torque that passes the joint's gear at each moment of a window, as the model has it (`carried.rs`): without friction and without the rotor's,
//! which are on the motor's side. `y(c)` are predictions for positions as they would be read beyond joints that bend so. What
//! a compliance does to the readings, `C_j`, is a constant of each fit. It is a secant: at the compliances of a solution all joints together do exactly
//! what they do there. How well that is known numerically says `unresolved.rs`.

mod bent_arm;
mod carried;
mod derivatives;
mod moments;
mod unresolved;

pub(in crate::joint) use unresolved::UnresolvedBending;

use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_robot_model::session::Session;

use crate::joint::measurement_set::{Effect, MeasurementSet};
use crate::joint::model_error::bending_in_motion::bent_arm::{BentArm, compliances, difference};
use crate::joint::variables::State;

/// A compliance that is a larger share of its prior's standard deviation is itself the step of its secant; else the step is this share.
const STEP: f64 = 0.01;

/// What a compliance of 1 rad/(N·m) of each joint that may bend (`std` is positive) does to the readings of windows, by pose and channel; zero of
/// static poses. Nothing where there are no windows.
///
/// # Errors
/// Where a residual has no value there.
pub(in crate::joint) fn effects_in_motion(
    session: &Session,
    readings: &MeasurementSet,
    state: &State,
    std: &[f64],
) -> Result<Vec<Effect>, EvaluateError> {
    let Some(arm) = BentArm::of(session, readings, state) else { return Ok(Vec::new()) };
    let (carried, _) = arm.moments.carried_by_bent_joints(&arm.session, state, &compliances(state, std.len()));
    let bending: Vec<usize> = (0..std.len()).filter(|joint| std[*joint] > 0.0).collect();
    let found = |joint: usize| state.bending.get(joint).copied().unwrap_or(0.0);
    let step = |joint: usize| if found(joint).abs() > STEP * std[joint] { found(joint) } else { STEP * std[joint] };
    // The first joints bend, and the others do not.
    let predicted = |count: usize| {
        let mut compliances = vec![0.0; std.len()];
        bending[..count].iter().for_each(|joint| compliances[*joint] = step(*joint));
        arm.predictions(&compliances, &carried)
    };
    let predicted = in_parallel(0..=bending.len(), predicted).into_iter().collect::<Result<Vec<Effect>, _>>()?;
    let effect = |(joint, pair): (&usize, &[Effect])| difference(&pair[1], &pair[0], 1.0 / step(*joint));
    Ok(bending.iter().zip(predicted.windows(2)).map(effect).collect())
}
