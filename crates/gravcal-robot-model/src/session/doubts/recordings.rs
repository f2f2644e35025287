//! Recordings whose clock can hardly be right, of which a part is lost, and columns that two sources fill by turns.

use gravcal_recording::file_name;

use crate::session::{Searched, Session};

/// Losses that are told of each recording.
const TOLD: usize = 3;

/// One sentence for each.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    session
        .searched
        .iter()
        .flat_map(|searched| clock(searched).into_iter().chain(lost(searched)).chain(alternating(searched)))
        .collect()
}

fn clock(searched: &Searched) -> Option<String> {
    Some(format!("{}: {}", file_name(&searched.path), searched.clock().doubt()?))
}

fn lost(searched: &Searched) -> Option<String> {
    let Searched { path, lost, .. } = searched;
    let more = if lost.len() > TOLD { "; …" } else { "" };
    let told = lost.iter().take(TOLD).cloned().collect::<Vec<_>>().join("; ");
    (!lost.is_empty()).then(|| {
        format!(
            "Not all of {} is read: {told}{more}. What is left counts: look whether that is enough.",
            file_name(path)
        )
    })
}

fn alternating(searched: &Searched) -> Option<String> {
    let columns: Vec<String> = searched.alternating().into_iter().map(|column| format!("`{column}`")).collect();
    let goes = if columns.len() == 1 { "goes" } else { "go" };
    (!columns.is_empty()).then(|| {
        format!(
            "{}: {} {goes} back and forth from row to row by more than the noise, as where two sources fill a column by turns: two nodes that \
             publish on one topic, or two recordings in one. A mean of two sources is no reading of either. Record one of them alone, or give each its own topic.",
            file_name(&searched.path),
            columns.join(", ")
        )
    })
}

impl Session {
    /// Whether readings come from two sources by turns, in a recording that enters the fit.
    pub fn is_of_two_sources(&self) -> bool {
        self.fitted_recordings().any(|searched| !searched.alternating().is_empty())
    }
}
