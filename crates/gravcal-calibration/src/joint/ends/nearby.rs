//! Where a solution rests, and what the readings say at values near it that may be the true ones: one list, one loop.
//!
//! What is not determined at such a place is not determined, and no standard deviation is told that is less than its share of that there
//! (`identifiability/widening.rs`): no place takes the solution's, so that their order decides nothing. But where one explains the readings
//! better, the solution was no minimum: one goes on from there, as along the bend of a valley.
//!
//! | places | why the truth may be there |
//! |---|---|
//! | where the readings say less | it is some standard deviations from the estimate, to any side |
//! | nearer to nominal values | what the readings leave open lies where their noise left it |
//! | exactly aligned | arms are built and mounted at right angles, and an estimate is a little off them |
//! | at the ends of other starts | the readings do not tell these from the solution |

use gravcal_estimation::{RankAnalysis, Values};
use gravcal_identification::{BASELESS, DECISIVE, SolveEnvironment, least_informed_nearby};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use crate::joint::ends::aligned::aligned;
use crate::joint::ends::nearer_to_nominal::nearer_to_nominal;
use crate::joint::ends::surroundings::{Place, Surroundings};
use crate::joint::ends::symmetries::{in_hemisphere, not_as_declared};
use crate::joint::error::EstimateError;
use crate::joint::solved::{Nearby, Solved};
use crate::joint::solving::solve_from::solve_from;
use crate::joint::variables::State;

/// Values at which ½ χ² is smaller by more are better than the estimate, which then was no minimum.
const BETTER: f64 = 0.1;
/// How often an estimate goes on from better values, at most.
const ROUNDS: usize = 3;

/// Places about a solution.
type Places = fn(&Surroundings<'_>, &SolveEnvironment<'_>) -> Result<Vec<Place>, EstimateError>;

const PLACES: [Places; 4] = [where_readings_say_less, nearer_to_nominal, aligned, ends_of_other_starts];

impl Solved {
    /// The same at rest, with values nearby that may be the true ones; from better values where there are such.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated nearby.
    pub(in crate::joint) fn with_nearby(
        self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let mut solved = self;
        for rounds_left in (0..=ROUNDS).rev() {
            let least = solved.estimate.cost;
            solved = solved.resting_as_declared(session, environment)?;
            solved.nearby = solved.look_around(session, environment)?;
            if rounds_left == 0 {
                break;
            }
            let Some(likelier) = solved.likelier_nearby(session, least, environment)? else { break };
            solved = solved.replaced_by(likelier);
        }
        Ok(solved)
    }

    fn look_around(&self, session: &Session, environment: &SolveEnvironment<'_>) -> Result<Vec<Nearby>, EstimateError> {
        let Some(around) = Surroundings::of(self, session) else { return Ok(Vec::new()) };
        let mut nearby = Vec::new();
        for places in PLACES {
            for place in places(&around, environment)? {
                nearby.push(around.judged(place)?);
            }
        }
        Ok(nearby)
    }

    /// The end to which the best of the places nearby leads, where ½ χ² is less there than `least` and that end is likelier.
    fn likelier_nearby(
        &self,
        session: &Session,
        least: f64,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Solved>, EstimateError> {
        let problem = self.judged_problem().without_reference();
        let costs = self.nearby.iter().map(|near| Ok((problem.cost(&near.values)?, &near.values)));
        let costs = costs.collect::<Result<Vec<_>, EstimateError>>()?;
        let lowest = costs.into_iter().min_by(|(a, _), (b, _)| a.total_cmp(b));
        let Some((_, better)) = lowest.filter(|(cost, _)| *cost < least - BETTER) else { return Ok(None) };
        let nominal = State::nominal(session);
        // What leads nowhere leaves the estimate as it is.
        let other = solve_from(session, self.readings(), self.built.variables.state(better, &nominal), environment);
        let Ok(other) = other.and_then(|other| in_hemisphere(session, other, environment)) else { return Ok(None) };
        let contradicts = other.hemisphere_contradicted && !self.hemisphere_contradicted;
        let [own, of_other] = [self, &other].map(|solution| not_as_declared(session, &solution.state(&nominal)));
        let margin = if of_other > own { DECISIVE } else { 0.0 };
        let likelier = other.minus_log_likelihood(session)? < self.minus_log_likelihood(session)? - margin;
        Ok((!contradicts && likelier).then_some(other))
    }
}

impl Surroundings<'_> {
    /// What the readings say at a place.
    fn judged(&self, Place { values, share }: Place) -> Result<Nearby, EstimateError> {
        let analysis = RankAnalysis::new(self.solved.judged_problem(), &values)?;
        let (known, there) = (self.solved.analysis.covariance(), analysis.covariance());
        let baseless =
            |(column, limit): &&(usize, f64)| there.std(*column) > (BASELESS * known.std(*column)).max(*limit);
        let open = self.asked.iter().filter(baseless).map(|(column, _)| *column).collect();
        Ok(Nearby { values, analysis, share, open })
    }
}

/// Where some direction has less effect than at the estimate, or the error of a parameter has.
fn where_readings_say_less(around: &Surroundings<'_>, _: &SolveEnvironment<'_>) -> Result<Vec<Place>, EstimateError> {
    let problem = around.solved.judged_problem();
    let columns = |id: ParameterId| problem.columns_of(around.solved.built.variables.block(id));
    let determined = around.session.parameters().into_iter().filter(|id| around.judgement.determines(*id));
    let determined: Vec<usize> = determined.flat_map(columns).collect();
    let linearized_at = (problem, &around.solved.estimate.values);
    let found = least_informed_nearby(linearized_at, &around.asked, &determined, (&around.plausible, around.matters))?;
    Ok(found.into_iter().map(|(values, growth)| Place::of_growth(values, growth)).collect())
}

fn ends_of_other_starts(around: &Surroundings<'_>, _: &SolveEnvironment<'_>) -> Result<Vec<Place>, EstimateError> {
    let values = |state: &State| -> Values { around.solved.built.starting_at(around.session, state).initial };
    Ok(around.solved.elsewhere.iter().map(|state| Place { values: values(state), share: 1.0 }).collect())
}
