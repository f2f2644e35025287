//! Parameters of which the data say too little, and which are to be held.

use super::super::Unknowns;
use super::super::solve::Solved;
use super::super::twins::DECISIVE;
use crate::judgement::{Combination, limit};
use crate::parameter::{ParameterId, Quantity};
use crate::session::Session;

/// An undetermined gain ran away when it left its nominal value by this share of it, an offset by this angle in rad
/// (or this way in m), any other by so many times the standard deviation with which it would be of no use.
const RUNAWAY_SHARE: f64 = 0.5;
const RUNAWAY_ANGLE: f64 = 1.0;
const RUNAWAY_LIMITS: f64 = 5.0;

/// Why a parameter of which the data say too little is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// The torque gain of a joint that carries no gravity, held at zero.
    Idle,
    /// Far from its nominal value, put back to it.
    Runaway,
    /// Fixes a combination without effect that a runaway in it would seem to fix; held at its nominal value.
    Anchor,
}

impl Reason {
    pub(super) fn in_words(self) -> &'static str {
        match self {
            Reason::Idle => "the joint carries no gravity: its readings say only their bias",
            Reason::Runaway => "the data say too little of it: put back to its nominal value",
            Reason::Anchor => "it fixes a combination without effect, of which the data say too little",
        }
    }
}

/// A parameter of which the data say too little, and the value at which it is held.
#[derive(Clone, Debug)]
pub(crate) struct SetAside {
    pub parameter: ParameterId,
    pub value: f64,
    pub reason: Reason,
    /// How it is told among what is undetermined.
    pub combination: Combination,
}

impl SetAside {
    /// Whether this is the gain of a joint that carries no gravity.
    pub fn is_idle_joint(&self) -> bool {
        self.reason == Reason::Idle
    }
}

/// Cost by which a solution must exceed this one to be ruled out, with noise that is at least what this one leaves.
pub(super) fn decisive(solved: &Solved) -> f64 {
    let rows = solved.posed.rows.len() as f64;
    DECISIVE * (2.0 * solved.estimate.cost / rows).max(1.0)
}

/// What else needs to be held at a solution with these undetermined combinations: idle joints' torque gains; once there are none,
/// runaways, which may only have looked weak beside an idle joint, and the anchors that must go with them. `ruled_out`: what has
/// turned out to be no runaway.
pub(super) fn undetermined_to_hold(
    session: &Session,
    solved: &Solved,
    combinations: &[Combination],
    ruled_out: &[ParameterId],
) -> Vec<SetAside> {
    let idle = idle_gains(solved, combinations);
    if !idle.is_empty() {
        return idle;
    }
    let mut found = runaways(session, solved, combinations);
    found.retain(|runaway| !ruled_out.contains(&runaway.parameter));
    let anchors = anchors_to_go_with(session, combinations, &found);
    found.extend(anchors);
    found
}

/// Free parameters in combinations, each once: parameter, its combination, and itself alone as one.
fn free_parameters<'c>(
    solved: &Solved,
    combinations: &'c [Combination],
) -> Vec<(ParameterId, &'c Combination, Combination)> {
    let posed = &solved.posed;
    let mut free: Vec<(ParameterId, &Combination, Combination)> = Vec::new();
    for combination in combinations {
        for term @ (parameter, _) in &combination.parameters {
            let held = posed.problem.columns_of(posed.layout.block(*parameter)).is_empty();
            if !held && free.iter().all(|(other, _, _)| other != parameter) {
                let std_over_limit = combination.std_over_limit;
                let alone = Combination { parameters: vec![*term], gravity: false, std_over_limit, anchor: None };
                free.push((*parameter, combination, alone));
            }
        }
    }
    free
}

fn idle_gains(solved: &Solved, combinations: &[Combination]) -> Vec<SetAside> {
    let is_idle = |parameter: ParameterId, combination: &Combination| {
        let alone = combination.std_over_limit.is_some() || combination.parameters.len() == 1;
        alone && matches!(parameter, ParameterId::Sensor(joint, Quantity::TorqueGain) if solved.idle[joint])
    };
    free_parameters(solved, combinations)
        .into_iter()
        .filter(|(parameter, combination, _)| is_idle(*parameter, combination))
        .map(|(parameter, _, alone)| SetAside { parameter, value: 0.0, reason: Reason::Idle, combination: alone })
        .collect()
}

fn runaways(session: &Session, solved: &Solved, combinations: &[Combination]) -> Vec<SetAside> {
    let (unknowns, spreads) = (solved.unknowns(&Unknowns::nominal(session)), &solved.readings.spreads);
    let weak = free_parameters(solved, combinations).into_iter().filter(|(_, c, _)| c.std_over_limit.is_some());
    weak.filter_map(|(parameter, _, alone)| {
        let (found, value) = (unknowns.value(parameter), session.nominal(parameter));
        let distance = (found - value).abs();
        let std = alone.std_over_limit? * limit(session, parameter, found, spreads);
        // What putting it back would cost, as far as the residuals are linear.
        let ruled_out = 0.5 * (distance / std).powi(2) > decisive(solved);
        (ran_away(session, parameter, distance, spreads) && !ruled_out).then_some(SetAside {
            parameter,
            value,
            reason: Reason::Runaway,
            combination: alone,
        })
    })
    .collect()
}

fn anchors_to_go_with(session: &Session, combinations: &[Combination], found: &[SetAside]) -> Vec<SetAside> {
    let broken = combinations.iter().filter(|c| found.iter().any(|s| c.breaks_with(s.parameter)));
    broken
        .filter_map(|combination| {
            let parameter = combination.anchor?;
            let value = session.nominal(parameter);
            let new = found.iter().all(|s| s.parameter != parameter);
            new.then(|| SetAside { parameter, value, reason: Reason::Anchor, combination: combination.clone() })
        })
        .collect()
}

/// Whether an undetermined parameter is this far from its nominal value. One in which the readings are linear disturbs
/// no other, wherever it ends.
fn ran_away(session: &Session, parameter: ParameterId, distance: f64, spreads: &[f64]) -> bool {
    match parameter {
        ParameterId::Sensor(_, Quantity::TorqueGain | Quantity::PositionGain) => {
            distance > RUNAWAY_SHARE * session.nominal(parameter).abs()
        }
        ParameterId::Sensor(_, Quantity::PositionOffset) => distance > RUNAWAY_ANGLE,
        ParameterId::Sensor(_, Quantity::TorqueBias) => false,
        ParameterId::Further(index) => {
            !session.further[index].linear && distance > RUNAWAY_LIMITS * session.limit(parameter, spreads)
        }
    }
}
