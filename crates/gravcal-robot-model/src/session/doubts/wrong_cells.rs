//! Single readings that are nothing like all others with the same load: a number that a recorder writes where it has none, a cell that was mistyped.

use std::collections::BTreeSet;

use super::names::rows;
use crate::number::shortest;
use crate::session::{ReadingId, Session};

/// What is so many times as far from the median as all others is no reading.
const FAR: f64 = 100.0;
/// Share of a channel's readings that may be so; one always may.
const FEW: f64 = 0.01;
/// Fewer readings do not tell how far they are from each other.
const FEWEST: usize = 20;
/// What is nearer to the others is rounding, in any unit.
const LEAST: f64 = 1e-9;

/// A sentence for each channel and load with such readings.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let loads: BTreeSet<Option<usize>> = session.poses.iter().map(|pose| pose.load).collect();
    let of_channel = |channel: usize| loads.iter().filter_map(move |load| doubt(session, channel, *load));
    (0..session.channel_count()).flat_map(of_channel).collect()
}

fn doubt(session: &Session, channel: usize, load: Option<usize>) -> Option<String> {
    let read = |pose: usize| Some((pose, session.reading(ReadingId { pose, channel })?.value));
    let carries = |pose: &usize| session.poses[*pose].load == load;
    let mut readings: Vec<(usize, f64)> = (0..session.poses.len()).filter(carries).filter_map(read).collect();
    if readings.len() < FEWEST {
        return None;
    }
    readings.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (_, middle) = readings[readings.len() / 2];
    readings.sort_by(|a, b| (b.1 - middle).abs().total_cmp(&(a.1 - middle).abs()));
    let few = ((FEW * readings.len() as f64) as usize).max(1);
    let usual = (readings[few].1 - middle).abs();
    let wrong: Vec<(usize, f64)> = readings[..few]
        .iter()
        .copied()
        .filter(|(_, value)| (value - middle).abs() > (FAR * usual).max(LEAST))
        .collect();
    let (_, worst) = *wrong.first().filter(|_| usual > 0.0)?;
    let (name, unit) = (session.channel_name(channel), session.channel_unit(channel));
    Some(format!(
        "The reading of {name} is {} {unit} in {}: more than {FAR} times as far from the median of these readings as the others are. Recorders write such numbers \
         where they have no reading. Leave these cells empty, or these rows out.",
        shortest(worst),
        rows(session, wrong.iter().map(|(pose, _)| *pose))
    ))
}
