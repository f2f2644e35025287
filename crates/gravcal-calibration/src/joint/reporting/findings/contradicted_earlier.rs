//! An earlier calibration that the readings contradict.

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::{solve_built, solve_from};
use crate::joint::variables::State;

/// Probability below which an earlier calibration is contradicted.
const CONTRADICTED_PRIOR: f64 = 1e-4;

impl Answer {
    /// Holds an earlier calibration against the readings: χ² must not grow by more than chance where it is heeded.
    pub(in crate::joint::reporting) fn remark_on_earlier(
        &self,
        session: &Session,
        findings: &mut Findings,
        environment: &SolveEnvironment<'_>,
    ) -> Result<(), EstimateError> {
        let solved = &self.solved;
        let Some(earlier) = session.earlier.as_ref().filter(|_| solved.estimate.termination.converged()) else {
            return Ok(());
        };
        environment.report("holding the earlier calibration against the readings");
        let alone = Session { earlier: None, ..session.clone() };
        let start = solved.state(&State::nominal(session));
        let without = solve_from(&alone, solved.readings(), start, environment)?;
        // Noise that is found beside what contradicts the readings has grown until it explains that as well.
        let problem = build_with_constraints(session, without.readings(), &solved.state(&State::nominal(session)))?;
        let heeded = solve_built(problem.resting_at_start(), environment)?;
        let freedom = |solved: &Solved| solved.judged_problem().rows().saturating_sub(solved.analysis.rank());
        let gained = freedom(&heeded).saturating_sub(freedom(&without)) as f64;
        let growth = heeded.least_chi_squared() - without.least_chi_squared();
        let left = freedom(&without).max(1) as f64;
        let (growth, p) = match session.noise_estimated().contains(&true) {
            true => {
                let growth = growth / (without.least_chi_squared() / left);
                (growth, FisherSnedecor::new(gained, left).map(|law| law.sf((growth / gained).max(0.0))).ok())
            }
            false => (growth, ChiSquared::new(gained).map(|law| law.sf(growth.max(0.0))).ok()),
        };
        let Some(p) = p else { return Ok(()) };
        let converged = [&without, &heeded].iter().all(|solved| solved.estimate.termination.converged());
        if converged && p < CONTRADICTED_PRIOR {
            let farthest = heeded.farthest_from(earlier).map_or_else(String::new, |off| format!("; off are {off}"));
            // Readings that are explained without it are not to blame.
            let fail = if without.misfit(session)?.is_none() { Findings::fail_first } else { Findings::fail };
            fail(findings, Mistake {
                what: format!("the readings contradict the earlier calibration: χ² grows by {growth:.0} for {gained:.0} numbers{farthest}"),
                advice: "What [prior] knows is not what was read here: a base that was moved, links or loads that are not as \
                         they were (leave them out of prior.unchanged), or a sensor that has changed (compare the two \
                         calibrations, `gravcal compare`)."
                    .into(),
            });
        }
        Ok(())
    }
}
