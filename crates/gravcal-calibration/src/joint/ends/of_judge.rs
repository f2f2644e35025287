//! The end of the method that judges, beside the solution of another.
//!
//! What readings leave open makes a long valley of χ², of hardly any slope, and methods end at different places of it. What is told must not depend on
//! that. So a solution that leaves something open is judged where the method that judges ends, unless it is the likelier one:
//!
//! ```text
//!     C < C_J − Δ        the solution stays; the judge's end is kept beside it where C_J < C + 12.5
//!     otherwise          the judge's end is judged, with the way on which the solution was found
//! ```
//!
//! `C`, `C_J`: − ln of the likelihood of both. Δ is 10 where what is determined is the same at both: the rest follows noise. Else it is ½, which the
//! last digits of a solve decide, and the solution is kept beside the judge's end where the readings do not rule it out.

use gravcal_estimation::{Estimate, EvaluateError};
use gravcal_identification::{DECISIVE, IMPLAUSIBLE, UNSETTLED};
use gravcal_robot_model::session::Session;

use crate::joint::solved::Solved;
use crate::joint::variables::State;

impl Solved {
    /// The end of the method that judges, unless this is likelier.
    ///
    /// # Errors
    /// Where a problem cannot be evaluated.
    pub(in crate::joint) fn or_end_of_judge(
        mut self,
        mut of_judge: Solved,
        session: &Session,
    ) -> Result<Solved, EvaluateError> {
        if !of_judge.is_minimum_of_all() || of_judge.hemisphere_contradicted {
            return Ok(self);
        }
        let apart = of_judge.minus_log_likelihood(session)? - self.minus_log_likelihood(session)?;
        let nominal = State::nominal(session);
        let here = self.state(&nominal);
        let is_another = of_judge.has_moved_from(session, &here);
        if apart > if is_another { UNSETTLED } else { DECISIVE } {
            self.elsewhere.extend((apart < IMPLAUSIBLE).then(|| of_judge.state(&nominal)));
            return Ok(self);
        }
        of_judge.elsewhere.extend((is_another && apart > -IMPLAUSIBLE).then_some(here));
        // Iterations of a problem with other unknowns cannot be told beside this solution.
        if of_judge.built.problem.columns().len() != self.built.problem.columns().len() {
            return Ok(of_judge);
        }
        let Estimate { iterations, iterates, termination, .. } = self.estimate;
        let estimate = Estimate { iterations, iterates, termination, ..of_judge.estimate };
        Ok(Solved { estimate, ..of_judge })
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter::PositionOffset;

    use super::*;
    use crate::joint::error::EstimateError;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    #[test]
    fn a_solution_stays_only_where_it_is_likelier_than_the_end_of_the_judge() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        with_environment(|environment| {
            let solved = || solve(&session, &readings, None, environment);
            // Away from its minimum by an offset.
            let moved = |by: f64| {
                let Solved { built, mut estimate, .. } = solved()?;
                let block = built.variables.sensors[1][PositionOffset as usize];
                estimate.values.set(block, &[estimate.values.scalar(block) + by]);
                estimate.cost = built.problem.cost(&estimate.values)?;
                estimate.iterations.truncate(1);
                Solved::judged(built, estimate)
            };
            let values = |solved: &Solved| solved.estimate.values.clone();
            let lowest = values(&solved()?);
            // rad: within two standard deviations, beyond, and so far away that the readings rule it out.
            for (by, is_another, is_plausible) in [(1e-4, false, true), (1e-3, true, true), (1e-2, true, false)] {
                let (there, other) = (values(&moved(by)?), moved(by)?);
                let stays = solved()?.or_end_of_judge(other, &session)?;
                let (expected, kept) = if is_another { (&lowest, usize::from(is_plausible)) } else { (&there, 0) };
                assert_eq!((&values(&stays), stays.elsewhere.len()), (expected, kept), "{by}");
                let judged = moved(by)?.or_end_of_judge(solved()?, &session)?;
                assert_eq!(values(&judged), lowest);
                assert_eq!((judged.estimate.iterations.len(), judged.elsewhere.len()), (1, kept));
            }
            Ok::<_, EstimateError>(())
        })
        .unwrap();
    }
}
