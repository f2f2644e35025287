//! Recordings and tables whose clock can hardly be right, recordings of which a part is lost, and columns that two sources fill by turns.

use gravcal_recording::file_name;

use crate::session::{Searched, Session};

/// So often, and so many times as often as it stands, an arm that creeps moves on.
const OFTEN: u64 = 20;
const CREEPS: u64 = 4;
/// A clock runs for so many rows between two beginnings at least.
const FEWEST_BETWEEN: usize = 10;
/// Losses that are told of each recording.
const TOLD: usize = 3;

/// One sentence for each.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let of_recordings = session.searched.iter().flat_map(|searched| {
        clock(searched)
            .into_iter()
            .chain(lost(searched))
            .chain(alternating(searched))
            .chain(creeping(session, searched))
    });
    of_recordings.chain(begun_anew(session)).collect()
}

/// Tables of static poses whose times go back once or a few times, and on from there: rows that are out of order go back in many places.
fn begun_anew(session: &Session) -> Vec<String> {
    let doubt = |table: usize| {
        let own = session
            .poses
            .iter()
            .filter(|pose| pose.table == table && pose.sweep_label.is_none() && pose.course.is_none());
        let times: Vec<(u64, f64)> = own.map(|pose| Some((pose.line, pose.conditions.time?))).collect::<Option<_>>()?;
        let back: Vec<u64> = times.windows(2).filter(|pair| pair[1].1 < pair[0].1).map(|pair| pair[1].0).collect();
        let (line, few) = (back.first()?, back.len() * FEWEST_BETWEEN <= times.len());
        few.then(|| {
            format!(
                "{}: times go back in line {line}{}, as where a clock begins anew. What goes with time (a drift) takes these rows for simultaneous. Give \
                 each part a table of its own, or let times go on.",
                file_name(&session.tables[table].path),
                if back.len() > 1 { format!(" and {} more", back.len() - 1) } else { String::new() }
            )
        })
    };
    (0..session.tables.len()).filter_map(doubt).collect()
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

/// Joints that creep through most of what would be standstills.
fn creeping(session: &Session, searched: &Searched) -> Option<String> {
    let standstills = searched.standstills.as_ref()?;
    let most = standstills.moved_on.iter().copied().max()?;
    let found = standstills.found.len() as u64;
    let names: Vec<&str> = standstills
        .moved_on
        .iter()
        .zip(session.robot.chain.joints())
        .filter(|(times, _)| 2 * **times > most)
        .map(|(_, joint)| joint.name.as_str())
        .collect();
    (most >= OFTEN && most > CREEPS * found).then(|| {
        format!(
            "{}: {most} times the arm hardly moved, and {} moved on before it stood long enough: beside {found} standstills. It creeps, or its position is \
             read so finely that it seems to. Let it come to rest, or take the recording as one of an arm in motion (readings.motion = {{}}).",
            file_name(&searched.path),
            names.join(", ")
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
