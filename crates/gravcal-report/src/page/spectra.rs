//! Spectra of an arm in motion, as the page holds them.

use std::collections::BTreeMap;

use gravcal_calibration::result::ReadingResidual;
use gravcal_robot_model::Session;
use serde::Serialize;

use super::arrays::base64;
use crate::motion_spectra::motion_spectra;

/// Of one channel, in its unit over √Hz.
#[derive(Serialize)]
pub(super) struct Spectra {
    /// Hz.
    frequency: String,
    reading: String,
    residual: String,
    /// Beyond it windows let little pass, Hz.
    cut_off: f64,
}

/// Those of a channel whose residuals these are, by pose; nothing where it has too few windows that follow each other.
pub(super) fn spectra(session: &Session, own: &BTreeMap<usize, &ReadingResidual>) -> Option<Spectra> {
    let found = motion_spectra(session, own)?;
    Some(Spectra {
        frequency: base64(found.frequency),
        reading: base64(found.reading),
        residual: base64(found.residual),
        cut_off: found.cut_off,
    })
}
