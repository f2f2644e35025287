//! What is determined of a solved joint problem, and gravity as it is told.

use gravcal_estimation::statistics::{DECIDED, LinearFunction, stored_coordinates};
use gravcal_estimation::{BlockId, Covariance, RankAnalysis, Values};
use gravcal_identification::judge;
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use crate::joint::problem::JointProblem;
use crate::joint::solved::{Nearby, Solved};
use crate::joint::starting::gravity_free::gravity_free_joints;
use crate::joint::variables::State;
use crate::judgement::{Asked, Judgement, Situation, asked, gravity_result};
use crate::result::GravityResult;

/// Whether more than half of the free parameters are open.
pub(in crate::joint) fn mostly_open(session: &Session, judgement: &Judgement) -> bool {
    let free = session.parameters().into_iter().filter(|id| session.fixed(*id).is_none());
    let (open, determined): (Vec<ParameterId>, Vec<_>) = free.partition(|id| !judgement.determines(*id));
    open.len() > determined.len()
}

impl Solved {
    /// What is determined.
    pub(crate) fn judge(&self, session: &Session) -> Judgement {
        self.judge_with_spreads(session, &self.readings.spreads)
    }

    /// The same with given spreads (largest less smallest reading of each channel).
    pub(crate) fn judge_with_spreads(&self, session: &Session, spreads: &[f64]) -> Judgement {
        let JointProblem { problem, variables, .. } = &self.built;
        let judged = |values: &Values, analysis: &RankAnalysis, covariance: &Covariance| {
            judge(problem, analysis, covariance, &asked(session, variables, values, spreads))
        };
        let mut judgement = judged(&self.estimate.values, &self.analysis, self.covariance());
        for Nearby { values, analysis, share, open } in &self.nearby {
            let at_least = analysis.covariance().scaled(share * share);
            judgement.leave_open_what_is_open_in(&judged(values, analysis, &at_least));
            let is_open = |id: BlockId| problem.columns_of(id).any(|column| open.contains(&column));
            judgement.leave_unsaid(is_open(variables.gravity).then_some(Asked::Gravity));
            judgement.leave_open(session.parameters().into_iter().filter(|id| is_open(variables.block(*id))));
        }
        judgement.leave_unsaid((!self.sign_known).then_some(Asked::Gravity));
        judgement.leave_unsaid(self.turning_with_gravity(session, spreads));
        judgement.leave_open(self.readings.unread_and_unknown(session));
        judgement.leave_open(self.on_bound(session));
        judgement
    }

    /// Parameters that have another value with gravity the other way up, where the readings do not tell which way that is.
    pub(crate) fn turning_with_gravity(&self, session: &Session, spreads: &[f64]) -> Vec<ParameterId> {
        if self.sign_known {
            return Vec::new();
        }
        let found = self.state(&State::nominal(session));
        let other = found.upside_down(session);
        let turns = |id: &ParameterId| (found.value(*id) - other.value(*id)).abs() > session.limit(*id, spreads);
        session.parameters().into_iter().filter(turns).collect()
    }

    pub(crate) fn situation<'s>(&self, session: &'s Session) -> Situation<'s> {
        let g = self.estimate.values.get(self.built.variables.gravity);
        let read =
            (0..session.joints.len()).map(|joint| self.built.rows.iter().any(|id| id.channel == joint)).collect();
        let unread = self.readings.unread_and_unknown(session);
        let gravity_free = gravity_free_joints(session, &self.state(&State::nominal(session)));
        Situation { session, gravity: [g[0], g[1], g[2]], read, unread, on_bound: self.on_bound(session), gravity_free }
    }

    /// Parameters that a constraint holds which the readings would like to pass: no interval about its bound would mean anything.
    fn on_bound(&self, session: &Session) -> Vec<ParameterId> {
        let decided = self.estimate.active.iter().zip(&self.leans).filter(|(_, lean)| **lean >= DECIDED);
        let fixed: Vec<BlockId> =
            decided.flat_map(|(active, _)| &active.holds).flat_map(|f| f.terms.iter().map(|(id, ..)| *id)).collect();
        session.parameters().into_iter().filter(|id| fixed.contains(&self.built.variables.block(*id))).collect()
    }

    pub(in crate::joint) fn gravity(&self, session: &Session) -> GravityResult {
        let (problem, values, id) = (&self.built.problem, &self.estimate.values, self.built.variables.gravity);
        let axes = stored_coordinates(problem, values, &[id]);
        let radius = |_std: f64, along: [f64; 3]| {
            let of_axis = |(axis, share): (&LinearFunction, f64)| {
                axis.iter().map(|(column, c)| (*column, share * c)).collect::<Vec<_>>()
            };
            let function: LinearFunction = axes.iter().zip(along).flat_map(of_axis).collect();
            self.uncertainty.cone(&function)
        };
        let g = values.get(id);
        let ci95 = std::array::from_fn(|axis| {
            let function = axes.get(axis).map_or(&[][..], |function| function.as_slice());
            self.uncertainty.interval(g[axis], function)
        });
        gravity_result([g[0], g[1], g[2]], &self.gravity_covariance(), ci95, session.asks("gravity"), radius)
    }
}
