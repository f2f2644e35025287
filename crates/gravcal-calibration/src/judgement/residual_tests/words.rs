//! What tests say, in sentences.

use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use super::terms::{Words, of_compliance, of_creep, of_direction, of_hysteresis, of_recorder, words_of};
use super::too_large::{SOMETHING_ELSE, is_too_large};
use super::wording::{SMALL, WIDENED, chance, together};
use crate::result::{ResidualTest, ResidualTestKind};

/// What is named, in sentences; neighbours that are alike, friction at rest, what sensors keep, joints that give way and what a recorder did once for all channels.
pub(crate) fn in_words(session: &Session, tests: &[ResidualTest]) -> Vec<String> {
    let of_kind = |kind: &ResidualTestKind| -> Vec<&ResidualTest> {
        tests.iter().filter(|test| test.named && test.kind == *kind).collect()
    };
    let named = tests.iter().filter(|test| test.named);
    let worded: Vec<(&ResidualTest, Words)> =
        named.filter_map(|test| words_of(session, test).map(|words| (test, words))).collect();
    let each = worded.iter().map(|(test, words)| of_one(test, words));
    each.chain(by_unit(of_kind(&ResidualTestKind::Direction)).iter().filter_map(|tests| of_direction(session, tests)))
        .chain(by_unit(of_kind(&ResidualTestKind::Hysteresis)).iter().filter_map(|tests| of_hysteresis(session, tests)))
        .chain(of_creep(&of_kind(&ResidualTestKind::Creep)))
        .chain(of_compliance(session, &of_kind(&ResidualTestKind::Compliance)))
        .chain(of_recorder(session, &of_kind(&ResidualTestKind::TorqueLag)))
        .chain(of_recorder(session, &of_kind(&ResidualTestKind::TorqueFilter)))
        .chain(of_neighbours(session, &of_kind(&ResidualTestKind::Neighbours)))
        .chain(beside(&worded).into_iter().map(str::to_owned))
        .collect()
}

/// What else may be as wrong, and widens intervals: each once.
fn beside(worded: &[(&ResidualTest, Words)]) -> Vec<&'static str> {
    let widens = worded.iter().filter(|(test, _)| test.spoils_intervals);
    let mut said: Vec<&'static str> = widens.filter_map(|(_, words)| words.beside).collect();
    said.sort_unstable();
    said.dedup();
    said
}

/// Joints that turn and joints that slide apart.
fn by_unit(tests: Vec<&ResidualTest>) -> Vec<Vec<&ResidualTest>> {
    let mut groups: Vec<Vec<&ResidualTest>> = Vec::new();
    for test in tests {
        match groups.iter_mut().find(|group| group[0].unit == test.unit) {
            Some(group) => group.push(test),
            None => groups.push(vec![test]),
        }
    }
    groups
}

fn of_one(test: &ResidualTest, Words { what, cure, .. }: &Words) -> String {
    let cure = if is_too_large(&test.kind, test.size) { SOMETHING_ELSE } else { cure };
    let consequence = if test.spoils_intervals { WIDENED } else { SMALL };
    let (p, in_noise) = (chance(test.corrected_p_value), significant(test.in_noise, 2));
    format!("{what} ({p}, {in_noise} times the noise of a reading, all tests counted.) {consequence} {cure}")
}

fn of_neighbours(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let (channels, [least, most], p) = together(tests)?;
    let correlation = if tests.len() > 1 { format!("{least:.2} to {most:.2}") } else { format!("{most:.2}") };
    let consequence = match tests.iter().any(|test| test.spoils_intervals) {
        true => {
            "The intervals are too narrow: take standard deviations from blocks of poses ([uncertainty] kind = \"jackknife\")."
        }
        false => "Intervals are hardly touched by it, or already allow for it.",
    };
    if session.has_windows() {
        return Some(format!(
            "The residuals of {channels} are alike in neighbouring windows (correlation {correlation}), as windows overlap and what the model \
             lacks lasts longer. ({}, all tests counted.) {consequence}",
            chance(p)
        ));
    }
    Some(format!(
        "The residuals of {channels} are alike in neighbouring poses (correlation {correlation}): errors are not noise, and more poses nearby tell \
         less than they seem to. ({}, all tests counted.) {consequence} Visit poses in another order, far from each other.",
        chance(p)
    ))
}
