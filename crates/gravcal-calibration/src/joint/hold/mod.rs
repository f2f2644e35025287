//! Parameters that the data do not determine, held while the rest is solved for.
//!
//! - **Gauges.** Where a combination of sensor parameters has no effect at all (the common scale of all torque gains),
//!   one of them is held at its start, or the solution would drift along it. The held problem has the same optimum, and
//!   is judged without the hold, so that nothing looks determined that is not.
//! - **Idle joints.** A joint whose axis is parallel to gravity in every pose carries none of it, and its torque gain is
//!   undetermined. Left free, the gain (and the moments that only this joint sees) would explain its noise by a tilt that
//!   is not there. The gain is held at zero: the joint's readings then say only what they can, its bias.
//! - **Runaways.** Where the data say too little of a parameter, its estimate may end anywhere, and linearized there the
//!   others' uncertainty would mean nothing. It is put back to its nominal value and held, unless the data rule that out: what is known
//!   as 8.7 ± 0.1 is no runaway from a nominal 1.
//!
//! Either is taken back where the readings, with it held, are explained decidedly worse than before.
//!
//! The last two are held in the judgement too, and the result says so. A runaway that is part of a combination without
//! effect takes the combination's anchor with it, or the held value would seem to fix the combination.

mod set_aside;

use gravcal_estimation::{BlockId, NormalEquations};

use super::constraints::{self, constrained};
use super::idle::idle_joints;
use super::in_order::estimate_in_order;
use super::problem::{JointProblem, pose};
use super::readings::Readings;
use super::sample::Sample;
use super::solve::Solved;
use super::{EstimateError, Unknowns};
use crate::judgement::Combination;
use crate::parameter::{ParameterId, Quantity};
use crate::session::Session;
use crate::workbench::Workbench;
use set_aside::{Reason, decisive, undetermined_to_hold};

pub(crate) use set_aside::SetAside;

/// Rounds at most until the holds no longer change.
const ROUNDS: usize = 10;

/// What is held.
pub(super) struct Holds<'a> {
    /// A part of the readings, with the noise of the start: it shows what has no effect.
    sample: &'a Sample,
    set_aside: Vec<SetAside>,
    gauges: Vec<ParameterId>,
    /// Joints that were idle at any solution so far.
    idle: Vec<bool>,
    /// Joints that looked idle, but whose readings need their gain.
    carrying: Vec<bool>,
    /// Parameters that looked like runaways, but whose nominal values the readings rule out.
    ruled_out: Vec<ParameterId>,
    /// Before gains of idle joints were held, and before runaways were.
    before_idle: Option<Before>,
    before_runaways: Option<Before>,
}

/// How well the readings were explained before something was held.
#[derive(Clone, Copy, Debug)]
struct Before {
    cost: f64,
    /// What of it counts as decisive.
    decisive: f64,
}

impl Before {
    fn of(solved: &Solved) -> Before {
        Before { cost: solved.estimate.cost, decisive: decisive(solved) }
    }

    /// Whether what has been held since leaves more of the readings unexplained than chance would.
    fn explained_decidedly_better(self, solved: &Solved) -> bool {
        solved.estimate.cost > self.cost + self.decisive
    }
}

impl<'a> Holds<'a> {
    /// The gauges that the readings of `sample` need, judged at `start`; or by its normal equations not far from there, if these show
    /// that none is needed.
    pub fn at_start(
        session: &Session,
        sample: &'a Sample,
        start: &Unknowns,
        shown: Option<&NormalEquations>,
    ) -> Result<Self, EstimateError> {
        let none = vec![false; session.joints.len()];
        let mut holds = Holds {
            sample,
            set_aside: Vec::new(),
            gauges: Vec::new(),
            idle: none.clone(),
            carrying: none,
            ruled_out: Vec::new(),
            before_idle: None,
            before_runaways: None,
        };
        if !shown.is_some_and(|shown| sample.determines_all(session, shown)) {
            holds.start_over(session, start)?;
        }
        Ok(holds)
    }

    /// Forgets what was held but for idle joints' gains, and finds the gauges anew.
    fn start_over(&mut self, session: &Session, start: &Unknowns) -> Result<(), EstimateError> {
        self.set_aside.retain(SetAside::is_idle_joint);
        self.before_runaways = None;
        // A part of the poses shows what has no effect; what all of them say is judged where they lead.
        let start = allowed(session, start, &self.set_aside);
        let posed = held(session, self.sample.posed_at(session, &start), &self.set_aside)?;
        let judged = Solved::at_start(self.sample.readings.clone(), posed)?.with_holds(&self.set_aside, &self.idle);
        self.gauges = gauges(&judged.judge(session).combinations);
        Ok(())
    }

    /// Solves from `start` until no further parameter needs to be held.
    pub fn solve(
        &mut self,
        session: &Session,
        readings: &Readings,
        start: &Unknowns,
        workbench: &Workbench<'_>,
    ) -> Result<Solved, EstimateError> {
        let mut from = start.clone();
        for round in 0.. {
            let posed = pose_with(session, readings, &from, &self.set_aside)?;
            let held: Vec<BlockId> = self.gauges.iter().map(|id| posed.layout.block(*id)).collect();
            let (posed, estimate) = estimate_in_order(&posed, &held, readings, workbench)?;
            let solved = Solved { gauges: held, ..Solved::judged(readings.clone(), posed, estimate)? };
            let newly_idle = self.find_idle(session, &solved.unknowns(&from));
            let solved = solved.with_holds(&self.set_aside, &self.idle);
            let combinations = solved.judge(session).combinations;
            let more = undetermined_to_hold(session, &solved, &combinations, &self.ruled_out);
            let gauges = gauges(&combinations);
            let settled = gauges == self.gauges && more.is_empty() && !self.held_wrongly(newly_idle);
            if settled && self.release_wrong(&solved) {
                self.start_over(session, start)?;
                from = start.clone();
                continue;
            }
            if round >= ROUNDS || settled {
                return Ok(solved);
            }
            if more.iter().any(SetAside::is_idle_joint) {
                self.before_idle.get_or_insert(Before::of(&solved));
            } else if !more.is_empty() {
                self.before_runaways.get_or_insert(Before::of(&solved));
            }
            self.set_aside.extend(more.iter().cloned());
            if self.held_wrongly(newly_idle) || more.iter().any(SetAside::is_idle_joint) {
                self.start_over(session, start)?;
                from = start.clone();
            } else if more.is_empty() {
                from = solved.unknowns(&from);
                self.gauges = gauges;
            } else {
                // What ran away left the others where nothing good starts from.
                self.gauges = gauges;
                from = start.clone();
            }
        }
        unreachable!("the loop returns")
    }

    /// Adds the joints that are idle at these values; whether there are any.
    fn find_idle(&mut self, session: &Session, values: &Unknowns) -> bool {
        let found =
            idle_joints(session, values).into_iter().zip(&self.carrying).map(|(idle, carrying)| idle && !carrying);
        let mut newly = false;
        for (ever, now) in self.idle.iter_mut().zip(found) {
            newly |= now && !*ever;
            *ever |= now;
        }
        newly
    }

    /// Takes back what was held last and leaves the readings decidedly worse explained; whether there is any.
    fn release_wrong(&mut self, solved: &Solved) -> bool {
        let wrong = |before: Option<Before>| before.is_some_and(|before| before.explained_decidedly_better(solved));
        if wrong(self.before_runaways) {
            self.release_runaways();
        } else if wrong(self.before_idle) {
            self.release_idle();
        } else {
            return false;
        }
        true
    }

    /// Takes the parameters that are held as runaways for ones that are as far from their nominal values as they were found.
    fn release_runaways(&mut self) {
        let runaways = self.set_aside.iter().filter(|aside| aside.reason == Reason::Runaway);
        self.ruled_out.extend(runaways.map(|aside| aside.parameter));
    }

    /// Takes the joints whose gains are held as idle for ones that carry gravity.
    fn release_idle(&mut self) {
        for joint in 0..self.idle.len() {
            self.carrying[joint] |= self.idle[joint];
            self.idle[joint] = false;
        }
        self.set_aside.clear();
        self.before_idle = None;
    }

    /// Whether a joint that turned out to be idle anchors a combination.
    fn held_wrongly(&self, newly_idle: bool) -> bool {
        let anchors = self.set_aside.iter().filter(|s| !s.is_idle_joint()).map(|s| s.parameter);
        let is_idle = |id| matches!(id, ParameterId::Sensor(joint, Quantity::TorqueGain) if self.idle[joint]);
        newly_idle && anchors.chain(self.gauges.iter().copied()).any(is_idle)
    }
}

/// Judges a session at given values, without solving: the gains of joints that carry no gravity there are held.
pub(crate) fn judge_at_start(
    session: &Session,
    readings: &Readings,
    values: &Unknowns,
) -> Result<Solved, EstimateError> {
    let idle = idle_joints(session, values);
    let free = Solved::at_start(readings.clone(), pose(session, readings, values)?)?.with_holds(&[], &idle);
    let mut set_aside = undetermined_to_hold(session, &free, &free.judge(session).combinations, &[]);
    set_aside.retain(SetAside::is_idle_joint);
    let posed = pose_with(session, readings, values, &set_aside)?;
    Ok(Solved::at_start(readings.clone(), posed)?.with_holds(&set_aside, &idle))
}

pub(super) fn pose_with(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
    set_aside: &[SetAside],
) -> Result<JointProblem, EstimateError> {
    let posed = pose(session, readings, &allowed(session, start, set_aside))?;
    held(session, posed, set_aside)
}

/// A start that obeys the constraints and what is set aside.
fn allowed(session: &Session, start: &Unknowns, set_aside: &[SetAside]) -> Unknowns {
    let mut start = start.clone();
    constraints::respect(session, &mut start);
    for SetAside { parameter, value, .. } in set_aside {
        *start.value_mut(*parameter) = *value;
    }
    start
}

/// The problem with what is set aside held, under the session's constraints.
fn held(session: &Session, mut posed: JointProblem, set_aside: &[SetAside]) -> Result<JointProblem, EstimateError> {
    for SetAside { parameter, reason, .. } in set_aside {
        let id = posed.layout.block(*parameter);
        posed.problem = posed.problem.holding(&[id], reason.in_words());
    }
    Ok(constrained(session, posed)?)
}

/// The anchor of each combination without any effect.
fn gauges(combinations: &[Combination]) -> Vec<ParameterId> {
    let without_effect = |c: &&Combination| c.std_over_limit.is_none() && !c.gravity;
    combinations.iter().filter(without_effect).filter_map(|c| c.anchor).collect()
}
