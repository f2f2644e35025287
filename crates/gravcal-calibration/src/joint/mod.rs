//! The joint estimator: every torque reading once, all unknowns together.

mod blocks;
mod conclusion;
mod constraints;
mod earlier;
mod error;
mod factors;
mod fit;
mod groups;
mod held_out;
mod idle;
mod in_order;
mod linear_part;
mod median;
mod mistakes;
mod model_tests;
mod nearby;
mod noise;
mod one_sided;
mod order;
mod placements;
mod pose_blocks;
mod posing;
mod position_unknowns;
mod problem;
mod readings;
mod reference;
mod reversed;
mod robust;
mod sample;
mod select;
mod solve;
mod solved;
mod start;
mod sweep_moments;
mod tell;
mod torques;
mod twins;
mod uncertainty;
mod unexplained;
mod unexplained_size;
mod unknowns;

use gravcal_estimation::statistics::{DECIDED, LinearFunction, stored_coordinates};
use gravcal_estimation::{BlockId, Covariance, Spectrum, Values};

use crate::judgement::{Judged, Judgement, Situation, gravity_result, judge};
use crate::parameter::ParameterId;
use crate::result::{Brief, EstimatorResult, GravityResult};
use crate::session::Session;
use crate::workbench::Workbench;
use conclusion::{Conclusion, conclude};
use idle::idle_joints;
use solved::Nearby;

pub use error::{EstimateError, PosingError};
pub(crate) use groups::why_not_by_groups;
pub use groups::{pose_by_pose, step_by_step};
pub(crate) use held_out::fit_with_held_out;
pub(crate) use median::{NORMAL_MEDIAN, median};
pub use order::Order;
pub use posing::pose;
pub(crate) use posing::pose_with_constraints;
pub use problem::JointProblem;
pub use readings::Readings;
pub use select::{Signals, select};
pub use solve::solve;
pub(crate) use solve::solve_posed;
pub use solved::Solved;
pub(crate) use start::start_around;
use tell::tell;
pub(crate) use tell::{last_frame_choices, session_notes, unknown_sign};
pub(crate) use twins::DECISIVE;
pub use unknowns::{Layout, PositionUnknown, Unknowns};

/// Solves the joint problem, from `known` values (the sequential estimator's) if they start it better than the
/// nominal ones.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub fn estimate_jointly(
    session: &Session,
    signals: Signals,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let name = match signals {
        Signals::All => "joint",
        Signals::PaperSteps => "joint-paper-signals",
    };
    estimate(session, name, &select(session, signals), known, workbench)
}

/// Solves the joint problem of these readings, in the order in which they are to enter, and tells it under `name`.
///
/// # Errors
/// As [`estimate_jointly`].
pub fn estimate(
    session: &Session,
    name: &str,
    readings: &Readings,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let conclusion = conclude(session, readings, known, workbench)?;
    let fit = fit_with_held_out(session, &conclusion.solved, workbench)?;
    let mut result = tell(session, name, conclusion, fit, workbench)?;
    one_sided::widen(session, &mut result);
    Ok(result)
}

/// The same answer without what only a reader needs: no prediction of poses that were held out, no moments, no tests of sensor
/// models. For batches.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub fn estimate_briefly(
    session: &Session,
    readings: &Readings,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<Brief, EstimateError> {
    let Conclusion { solved, gravity, parameters, verdict, termination, .. } =
        conclude(session, readings, known, workbench)?;
    let iterations = solved.estimate.iterations.len().saturating_sub(1);
    Ok(Brief { verdict, termination, iterations, gravity, parameters })
}

/// The joint problem at nominal values, with its constraints: what a solver must be able to take.
pub(crate) fn pose_at_nominal(session: &Session) -> Result<JointProblem, EstimateError> {
    Ok(pose_with_constraints(session, &select(session, Signals::All), &Unknowns::nominal(session))?)
}

impl Solved {
    /// What is determined.
    pub(crate) fn judge(&self, session: &Session) -> Judgement {
        self.judge_with_spreads(session, &self.readings.spreads)
    }

    /// The same with given spreads (largest less smallest reading of each channel).
    pub(crate) fn judge_with_spreads(&self, session: &Session, spreads: &[f64]) -> Judgement {
        let JointProblem { problem, layout, .. } = &self.posed;
        let judged = |values: &Values, spectrum: &Spectrum, covariance: &Covariance| {
            judge(session, &Judged { problem, values, layout, spectrum }, covariance, spreads)
        };
        let mut judgement = judged(&self.estimate.values, &self.spectrum, self.covariance());
        for Nearby { values, spectrum, share, open } in &self.nearby {
            let at_least = spectrum.covariance().scaled(share * share);
            judgement.leave_open_what_is_open_in(&judged(values, spectrum, &at_least));
            let is_open = |id: BlockId| problem.columns_of(id).any(|column| open.contains(&column));
            judgement.gravity &= !is_open(layout.gravity);
            judgement.leave_open(session.parameters().into_iter().filter(|id| is_open(layout.block(*id))));
        }
        judgement.gravity &= self.sign_known;
        judgement.leave_open(self.readings.unread_and_unknown(session));
        judgement.leave_open(self.on_bound(session));
        judgement
    }

    pub(crate) fn situation<'s>(&self, session: &'s Session) -> Situation<'s> {
        let g = self.estimate.values.get(self.posed.layout.gravity);
        let read = (0..session.joints.len()).map(|joint| self.posed.rows.iter().any(|(_, j)| *j == joint)).collect();
        let unread = self.readings.unread_and_unknown(session);
        let idle = idle_joints(session, &self.unknowns(&Unknowns::nominal(session)));
        Situation { session, gravity: [g[0], g[1], g[2]], read, unread, on_bound: self.on_bound(session), idle }
    }

    /// Parameters that a constraint holds which the readings would like to pass: no interval about its bound would mean anything.
    fn on_bound(&self, session: &Session) -> Vec<ParameterId> {
        let decided = self.estimate.active.iter().zip(&self.leans).filter(|(_, lean)| **lean >= DECIDED);
        let held: Vec<BlockId> =
            decided.flat_map(|(active, _)| &active.holds).flat_map(|f| f.terms.iter().map(|(id, ..)| *id)).collect();
        session.parameters().into_iter().filter(|id| held.contains(&self.posed.layout.block(*id))).collect()
    }

    fn gravity(&self, session: &Session) -> GravityResult {
        let (problem, values, id) = (&self.posed.problem, &self.estimate.values, self.posed.layout.gravity);
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
