//! What is determined of a solved joint problem, and gravity as it is told.

use gravcal_estimation::statistics::{DECIDED, LinearFunction, stored_coordinates};
use gravcal_estimation::{BlockId, Covariance, EvaluateError, RankAnalysis, Values};
use gravcal_identification::judge;
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use crate::joint::problem::JointProblem;
use crate::joint::solved::{Nearby, Solved};
use crate::joint::starting::gravity_free::gravity_free_joints;
use crate::joint::variables::State;
use crate::judgement::{Asked, Judgement, Situation, asked, explained, gravity_result, limits_of_use};
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
        self.judge_with_spreads(session, &self.readings().spreads)
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
        judgement.leave_open(self.readings().unread_and_unknown(session));
        judgement.leave_open(self.on_bound(session));
        judgement
    }

    /// The free parameters that the readings leave open.
    pub(in crate::joint) fn open(&self, session: &Session) -> Vec<ParameterId> {
        let judgement = self.judge(session);
        let is_open = |id: &ParameterId| session.fixed(*id).is_none() && !judgement.determines(*id);
        session.parameters().into_iter().filter(is_open).collect()
    }

    /// What is determined, as it is told: nothing where too few degrees of freedom are left to tell the size of the noise.
    pub(in crate::joint) fn judge_for_report(&self, session: &Session) -> Judgement {
        let mut judgement = self.judge(session);
        if self.freedom_of_noise(session).is_some() {
            judgement.leave_unsaid(session.parameters().into_iter().map(Asked::from).chain([Asked::Gravity]));
        }
        judgement
    }

    /// How many times worse than their stated noise the readings are explained, where that is no accident.
    pub(in crate::joint) fn misfit(&self, session: &Session) -> Result<Option<f64>, EvaluateError> {
        Ok(explained(session, self, self.least_chi_squared())?.misfit())
    }

    /// Column and limit of use of gravity and every parameter.
    pub(in crate::joint) fn limits_of_use(&self, session: &Session) -> Vec<(usize, f64)> {
        let judged_at = (self.judged_problem(), &self.estimate.values);
        limits_of_use(session, judged_at, &self.built.variables, &self.readings().spreads)
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
        let unread = self.readings().unread_and_unknown(session);
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

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A shoulder whose free parameters are all determined.
    fn solved() -> (Session, Solved) {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        (session, solved)
    }

    /// What the readings say there is what they say at the solution, in other shares.
    fn nearby(solved: &Solved, share: f64, open: Vec<usize>) -> Vec<Nearby> {
        let values = solved.estimate.values.clone();
        let analysis = RankAnalysis::new(solved.judged_problem(), &values).unwrap();
        vec![Nearby { values, analysis, share, open }]
    }

    fn open(session: &Session, solved: &Solved) -> Vec<ParameterId> {
        let judgement = solved.judge(session);
        session.parameters().into_iter().filter(|id| !judgement.determines(*id)).collect()
    }

    /// The share of a standard deviation nearby at which a parameter's limit of use is passed.
    #[test]
    fn what_is_beyond_its_limit_nearby_is_open() {
        let (session, mut solved) = solved();
        assert!(open(&session, &solved).is_empty());
        let second = ParameterId::Sensor(1, SensorParameter::PositionGain);
        let column = solved.judged_problem().columns_of(solved.built.variables.block(second)).next().unwrap();
        let (_, limit) = solved.limits_of_use(&session).into_iter().find(|(asked, _)| *asked == column).unwrap();
        let share = limit / solved.parameter_std(second);
        let mut is_open_at = |times: f64| {
            solved.nearby = nearby(&solved, times * share, Vec::new());
            open(&session, &solved).contains(&second)
        };
        assert!(!is_open_at(0.99) && is_open_at(1.01));
    }

    #[test]
    fn what_has_no_basis_nearby_is_open_and_nothing_else() {
        let (session, mut solved) = solved();
        let third = ParameterId::Sensor(2, SensorParameter::TorqueGain);
        let column = solved.judged_problem().columns_of(solved.built.variables.block(third)).next().unwrap();
        solved.nearby = nearby(&solved, 0.0, vec![column]);
        assert_eq!(open(&session, &solved), [third]);
        assert!(solved.judge(&session).determines(Asked::Gravity));
        let of_gravity = solved.judged_problem().columns_of(solved.built.variables.gravity).next().unwrap();
        solved.nearby = nearby(&solved, 0.0, vec![of_gravity]);
        assert!(open(&session, &solved).is_empty() && !solved.judge(&session).determines(Asked::Gravity));
    }

    #[test]
    fn more_than_half_open_is_mostly_open() {
        let (session, solved) = solved();
        let free: Vec<ParameterId> =
            session.parameters().into_iter().filter(|id| session.fixed(*id).is_none()).collect();
        let mostly = |count: usize| {
            let mut judgement = solved.judge(&session);
            judgement.leave_unsaid(free[..count].iter().copied());
            mostly_open(&session, &judgement)
        };
        assert!(!mostly(free.len() / 2) && mostly(free.len() / 2 + 1), "{}", free.len());
    }
}
