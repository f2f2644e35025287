//! What a reader needs to know beside numbers and verdict, in sentences.

use gravcal_robot_model::session::{EarlierCalibration, Session};

use crate::joint::building::{modelled, sweep_moments};
use crate::joint::error::EstimateError;
use crate::joint::reporting::payloads::frame_notes;
use crate::joint::reporting::session_notes::session_notes;
use crate::joint::solved::Solved;
use crate::judgement::{driving_friction_notes, negative_rotor_notes, outlier_note, too_large, tool_notes, weak_note};
use crate::result::{EstimatorResult, ParameterResult};

const ALONG_CONSTRAINTS: &str = "Standard deviations hold along the active constraints: what these hold is taken as \
                                 known exactly.";

/// All of them, behind the reasons for the verdict; `result`: with fit and solution.
pub(super) fn notes(
    session: &Session,
    solved: &Solved,
    result: &EstimatorResult,
) -> Result<Vec<String>, EstimateError> {
    let of_fit = result.fit.iter().flat_map(|fit| fit.held_out_missing.iter().map(no_held_out_note));
    let mut notes: Vec<String> = of_fit.collect();
    notes.extend(notes_of_session(session, solved, &result.parameters));
    notes.extend(frame_notes(session, &result.payloads));
    notes.extend(modelled::notes(session, solved)?);
    notes.extend(outlier_note(solved.built.loss, solved.built.rows.len(), &result.outliers));
    notes.extend(untested_note(solved));
    // Where the solver stopped anywhere, so did these.
    notes.extend(result.weak.iter().filter(|_| solved.estimate.termination.converged()).map(weak_note));
    Ok(notes)
}

/// What a reader needs to know of a session and of what it held.
fn notes_of_session(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Vec<String> {
    let mut notes: Vec<String> = session_notes(session).into_iter().collect();
    notes.extend(session.earlier.iter().flat_map(EarlierCalibration::notes));
    notes.extend(sweep_moments::left_out_note(session));
    notes.extend(driving_friction_notes(session, parameters));
    notes.extend(negative_rotor_notes(session, parameters));
    notes.extend(tool_notes(session, solved, parameters));
    notes.extend((!solved.estimate.active.is_empty()).then(|| ALONG_CONSTRAINTS.to_owned()));
    notes
}

/// Says where residuals are not tested as there are too many readings and unknowns.
fn untested_note(solved: &Solved) -> Option<String> {
    let (rows, columns) = (solved.judged_problem().rows(), solved.judged_problem().columns().len());
    too_large(solved).then(|| {
        format!(
            "Residuals were not tested for drifts, harmonics and neighbours: {rows} readings with {columns} unknowns are \
             too many. Calibrate fewer poses, or without unknowns of each pose (readings.position.std), for a test."
        )
    })
}

fn no_held_out_note(why: &String) -> String {
    format!("Held-out poses were not predicted: the second fit was {why}.")
}
