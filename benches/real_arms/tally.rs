//! What the sessions of a line come to.

use std::collections::BTreeMap;

use clap::ValueEnum;

use crate::judge::{Judged, Reported};
use crate::line::Line;

/// What the columns of a row are.
pub fn heading() -> String {
    format!(
        "{:10} {:>8} {:>8}  {:>15}  {:>13}  {:>5}  {:>6}  {:>5}  {:>15}  {:>18}  {:>28}  {:>9}",
        "line",
        "friction",
        "sessions",
        "exit 0/2/3/4",
        "held | biases",
        "± mc",
        "rms z",
        "max z",
        "exit 0: held, z",
        "exit 0: biases z>3",
        "worst parameter, held",
        "median std"
    ) + "  named, by arm"
}

/// One row.
pub fn row(line: Line, friction: f64, sessions: &[Judged]) -> String {
    let exits = [0, 2, 3, 4].map(|exit| sessions.iter().filter(|session| session.exit == exit).count().to_string());
    let all = || sessions.iter().flat_map(|session| &session.reported);
    let (biases, others): (Vec<&Reported>, Vec<&Reported>) =
        all().partition(|reported| reported.name.ends_with("_bias"));
    let relied_on: Vec<&Reported> =
        sessions.iter().filter(|session| session.exit == 0).flat_map(|s| &s.reported).collect();
    let share = |reported: &[&Reported]| {
        100.0 * reported.iter().filter(|reported| reported.held).count() as f64 / reported.len() as f64
    };
    let squares = all().map(|reported| reported.error * reported.error);
    let rms = (squares.sum::<f64>() / all().count() as f64).sqrt();
    let largest = |reported: &mut dyn Iterator<Item = &Reported>| {
        reported.map(|reported| reported.error.abs()).fold(0.0, f64::max)
    };
    let mut stds: Vec<f64> = others.iter().map(|reported| reported.std).collect();
    stds.sort_by(f64::total_cmp);
    // Parameters of one session are not independent: a session counts as a few of them.
    let noise = 100.0 * (0.05 * 0.95 / (sessions.len() as f64 * 5.0)).sqrt();
    format!(
        "{:10} {friction:>8} {:>8}  {:>15}  {:>5.1} | {:>5.1}  {noise:>5.1}  {rms:>6.2}  {:>5.1}  {:>8.1}, {:>5.1}  {:>18}  {:>28}  {:>9.2e}  {}",
        line.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned()),
        sessions.len(),
        exits.join("/"),
        share(&others),
        share(&biases),
        largest(&mut all()),
        share(&relied_on),
        largest(&mut relied_on.iter().copied()),
        far_biases(&relied_on),
        worst(all()),
        stds.get(stds.len() / 2).copied().unwrap_or(f64::NAN),
        named(sessions),
    )
}

/// How many biases are further than three standard deviations from the truth, of how many, and the largest.
fn far_biases(relied_on: &[&Reported]) -> String {
    let errors: Vec<f64> = relied_on
        .iter()
        .filter(|reported| reported.name.ends_with("_bias"))
        .map(|reported| reported.error.abs())
        .collect();
    let far = errors.iter().filter(|error| **error > 3.0).count();
    format!("{far} of {}, {:.1}", errors.len(), errors.iter().copied().fold(0.0, f64::max))
}

/// In how many sessions the word was found, of how many, for each arm.
fn named(sessions: &[Judged]) -> String {
    let mut arms: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for session in sessions {
        let [named, count] = arms.entry(session.arm).or_default();
        *named += usize::from(session.named);
        *count += 1;
    }
    arms.into_iter().map(|(arm, [named, count])| format!("{arm} {named}/{count}")).collect::<Vec<_>>().join(", ")
}

/// The parameter whose interval holds the truth least often.
fn worst<'t>(all: impl Iterator<Item = &'t Reported>) -> String {
    let mut held: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for reported in all {
        let [holds, count] = held.entry(&reported.name).or_default();
        *holds += usize::from(reported.held);
        *count += 1;
    }
    let share = |[holds, count]: [usize; 2]| 100.0 * holds as f64 / count as f64;
    let least = held.into_iter().min_by(|a, b| share(a.1).total_cmp(&share(b.1)));
    least.map_or_else(|| "-".to_owned(), |(name, counts)| format!("{name} {:.0} %", share(counts)))
}
