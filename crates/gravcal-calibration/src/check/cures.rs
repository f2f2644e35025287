//! The smallest additions to a session that would determine what it leaves open.
//!
//! Each addition is made to the session in thought, with poses at which the readings are not known but their noise is, and
//! judged as the session itself is: by the Jacobian at nominal values. What no addition cures by itself is tried with two.

use super::additions::{Addition, additions};
use super::hypothetical::Hypothetical;
use super::judged::NominalVerdict;
use super::report::{Curable, Cure, PredictedStd};
use crate::joint::EstimateError;
use crate::result::Undetermined;

/// So many are told of each thing at most.
const TOLD: usize = 3;

/// Whatever is undetermined, with its cures.
pub(super) fn cures(now: &Hypothetical, undetermined: &[Undetermined]) -> Result<Vec<Curable>, EstimateError> {
    if undetermined.is_empty() {
        return Ok(Vec::new());
    }
    let groups = additions(now);
    let mut singles = Vec::new();
    for group in &groups {
        let tried: Result<Vec<Tried<'_>>, EstimateError> = group.iter().map(|one| Tried::alone(one, now)).collect();
        singles.push(tried?);
    }
    let mut found: Vec<Vec<Cure>> =
        (0..undetermined.len()).map(|open| first_cures(&singles, undetermined, open)).collect();
    if found.iter().any(Vec::is_empty) {
        let pairs = pairs(&groups, now)?;
        for (open, cures) in found.iter_mut().enumerate().filter(|(_, cures)| cures.is_empty()) {
            *cures = first_cures(&pairs, undetermined, open);
        }
    }
    Ok(undetermined.iter().zip(found).map(|(open, cures)| curable(open, cures)).collect())
}

/// One or two additions, and what could then be known.
struct Tried<'a> {
    words: String,
    states: Option<&'a str>,
    verdict: NominalVerdict,
}

impl<'a> Tried<'a> {
    fn alone(addition: &'a Addition, now: &Hypothetical) -> Result<Tried<'a>, EstimateError> {
        let verdict = addition.made(now).judge()?;
        Ok(Tried { words: addition.words.clone(), states: addition.states.as_deref(), verdict })
    }

    fn together(first: &Addition, second: &Addition, now: &Hypothetical) -> Result<Tried<'a>, EstimateError> {
        let verdict = second.made(&first.made(now)).judge()?;
        Ok(Tried { words: format!("{}; and {}", first.words, second.words), states: None, verdict })
    }

    fn cures(&self, needed: &[&str]) -> bool {
        let circular = needed.len() == 1 && self.states == Some(needed[0]);
        !circular && needed.iter().all(|name| self.verdict.determines(name))
    }

    fn cure(&self, parameters: &[String]) -> Cure {
        let known = parameters.iter().filter_map(|name| self.verdict.of(name)).filter(|known| known.determined);
        let predicted = known.map(|known| PredictedStd {
            name: known.name.clone(),
            unit: known.unit.clone(),
            std: known.predicted_std,
        });
        Cure { addition: self.words.clone(), predicted: predicted.collect() }
    }
}

/// Two additions of different groups, the greater effort of both as small as can be. Groups that offer the same for one
/// joint or another stay out of it.
fn pairs<'a>(groups: &[Vec<Addition>], now: &Hypothetical) -> Result<Vec<Vec<Tried<'a>>>, EstimateError> {
    let only: Vec<&Addition> = groups.iter().filter(|group| group.len() == 1).map(|group| &group[0]).collect();
    let indices = (0..only.len()).flat_map(|second| (0..second).map(move |first| (first, second)));
    let tried = |(first, second): (usize, usize)| Ok(vec![Tried::together(only[first], only[second], now)?]);
    indices.map(tried).collect()
}

/// The first of each group that cures one thing.
fn first_cures(groups: &[Vec<Tried<'_>>], undetermined: &[Undetermined], open: usize) -> Vec<Cure> {
    let needed = needed(undetermined, open);
    let first = |group: &Vec<Tried<'_>>| {
        group.iter().find(|tried| tried.cures(&needed)).map(|tried| tried.cure(&undetermined[open].parameters))
    };
    groups.iter().filter_map(first).take(TOLD).collect()
}

/// The parameters that a cure must determine: those of the combination, but for those that are undetermined with fewer others,
/// too, which are another cure's matter.
fn needed(undetermined: &[Undetermined], open: usize) -> Vec<&str> {
    let own = &undetermined[open].parameters;
    let elsewhere = |name: &str| {
        undetermined
            .iter()
            .any(|other| other.parameters.len() < own.len() && other.parameters.iter().any(|n| n == name))
    };
    let needed: Vec<&str> = own.iter().map(String::as_str).filter(|name| !elsewhere(name)).collect();
    if needed.is_empty() { own.iter().map(String::as_str).collect() } else { needed }
}

fn curable(open: &Undetermined, cures: Vec<Cure>) -> Curable {
    let mut undetermined = open.clone();
    if let Some(first) = cures.first() {
        undetermined.cure = first.addition.clone();
    }
    Curable { undetermined, cures }
}
