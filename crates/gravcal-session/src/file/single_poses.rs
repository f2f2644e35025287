//! Unknowns that each pose has for itself, and what else a session may ask for beside them.

use gravcal_estimation::Loss;
use gravcal_robot_model::session::{Deflection, Session, UncertaintyChoice};
use gravcal_robot_model::sweeps::sweeping;

use crate::document::{Document, Field, FileError};

/// What gives poses unknowns of their own, where something does.
fn unknowns_of_single_poses(session: &Session) -> Option<Field> {
    let Deflection { hold_std, pose_std, reading_std, compliance: _, stiff: _, rounding_std: _ } = &session.deflection;
    if reading_std.iter().any(|std| *std > 0.0) {
        Some(Field::new("readings").key("position").key("std"))
    } else if pose_std.is_some() {
        Some(Field::new("deflection").key("pose_std_deg"))
    } else {
        // Poses of no sweep are holds of their own.
        (hold_std.is_some() && sweeping(session).iter().any(Option::is_none))
            .then(|| Field::new("deflection").key("hold_std_deg"))
    }
}

/// Whether everything else that the session asks for goes with unknowns of single poses.
pub(super) fn check_single_poses(document: &Document, session: &Session) -> Result<(), FileError> {
    let Some(source) = unknowns_of_single_poses(session) else { return Ok(()) };
    let refuse = |why: &str| Err(document.error(&source, why));
    if session.noise_estimated().iter().any(|estimated| *estimated) {
        return refuse(
            "errors of each pose's positions cannot be told from noise of unknown size in its torques: state the torque \
             readings' std, or leave this out",
        );
    }
    if session.loss != Loss::None {
        return refuse("errors of each pose's positions would hide its outliers: leave [loss] out, or this");
    }
    if !matches!(session.uncertainty, UncertaintyChoice::Noise | UncertaintyChoice::Jackknife { .. }) {
        return refuse(
            "standard deviations from the scatter of blocks are not known where each pose has unknowns of its own: write \
             [uncertainty] kind = \"jackknife\" or \"noise\", or leave this out",
        );
    }
    Ok(())
}
