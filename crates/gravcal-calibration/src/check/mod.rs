//! What a session can and cannot determine, before any solve.
//!
//! The Jacobian of the joint problem is judged at nominal values: gravity along the declared direction (of an
//! upright base without one), nominal sensors, the robot's assumed masses. Torque readings are not looked at (only which are there, and their noise).

mod additions;
mod cures;
mod hypothetical;
mod judged;
mod report;
mod rough;
mod sign;
mod sweeps;
#[cfg(test)]
mod tests;
mod tilts;

use crate::joint::{EstimateError, MeasurementSet, Signals, select};
use crate::plan::Plan;

pub use report::{
    CheckReport, CheckedParameter, CheckedPayload, Curable, Cure, PredictedStd, StepReport, SweepReport, TiltReport,
    TiltedGain,
};

use cures::cures;
use gravcal_robot_model::session::Session;
use hypothetical::Hypothetical;
use sweeps::{report_steps, report_sweep, sweep_rule};
use tilts::tilts;

/// Judges a session without solving it.
///
/// # Errors
/// Where the joint problem cannot be built: no readings, nothing unknown.
pub fn check(session: &Session) -> Result<CheckReport, EstimateError> {
    let plan = Plan::new(session);
    let now = Hypothetical::now(session)?;
    let mut verdict = now.judge()?;
    let loads = verdict.payloads.iter().all(|load| load.undetermined.is_none());
    let complete = loads && verdict.parameters.iter().all(|p| p.determined || !p.asked);
    let mut tilts = tilts(&now)?;
    let mut undetermined = cures(&now.thinned(), &verdict.undetermined)?;
    if session.noise_estimated().contains(&true) {
        // What is determined was judged with a first guess of the noise: no figure to tell.
        verdict.parameters.iter_mut().for_each(|parameter| parameter.predicted_std = None);
        verdict.payloads.iter_mut().for_each(|payload| payload.predicted_mass_std_kg = None);
        let predicted = undetermined.iter_mut().flat_map(|open| &mut open.cures).flat_map(|cure| &mut cure.predicted);
        predicted.for_each(|predicted| predicted.std = None);
        for tilt in &mut tilts {
            (tilt.torque_gain.relative_std, tilt.position_gain.relative_std) = (None, None);
        }
    }
    Ok(CheckReport {
        doubts: session.doubts.clone(),
        judged_at: judged_at(session),
        poses: count_poses(session),
        torque_readings: count_readings(session, &select(session, Signals::All)),
        standstills: session
            .searched
            .iter()
            .flat_map(|searched| searched.notes(&session.readings))
            .chain(session.motion_notes())
            .chain(rough::notes(session))
            .collect(),
        selection: session.selection_note(),
        unmoved: session.unmoved_note(),
        sweep_rule: sweep_rule(),
        sweeps: plan.sweeps.iter().enumerate().map(|(i, _)| report_sweep(session, &plan, i)).collect(),
        assumes_upright: session.gravity.hemisphere.is_none(),
        steps: report_steps(session, &plan),
        supposed_errors: rough::supposed(session),
        parameters: verdict.parameters,
        payloads: verdict.payloads,
        undetermined,
        tilts,
        complete,
    })
}

fn judged_at(session: &Session) -> String {
    let gravity = match session.gravity.hemisphere {
        Some([x, y, z]) => format!("along the declared hemisphere ({x:.3}, {y:.3}, {z:.3})"),
        None => "as on an upright base (no hemisphere is declared)".to_owned(),
    };
    format!("nominal values: gravity {gravity}, nominal sensors, assumed masses of {}", session.robot.name)
}

fn count_poses(session: &Session) -> Vec<(String, usize)> {
    let count = |load: Option<usize>| session.poses.iter().filter(|p| p.load == load).count();
    let loads = session.loads.iter().enumerate().map(|(i, load)| (load.name.clone(), count(Some(i))));
    [("none".to_owned(), count(None))].into_iter().chain(loads).collect()
}

fn count_readings(session: &Session, readings: &MeasurementSet) -> Vec<(String, usize)> {
    let count = |channel: usize| readings.used.iter().filter(|used| used.contains(&channel)).count();
    (0..session.channel_count()).map(|channel| (session.channel_name(channel), count(channel))).collect()
}
