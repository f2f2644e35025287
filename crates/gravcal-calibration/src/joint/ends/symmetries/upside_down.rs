//! Gravity the other way up, with masses, moments and placements negative, gives the same torques, unless a load of known mass hangs on known
//! lengths.
//!
//! Where no hemisphere is declared both are solved for, the one that explains the readings better is taken, and the sign counts as known only
//! if that is decisive. What unknowns rest on decides nothing, but gains keep their sign ([`with_gains_known`]).

use gravcal_identification::{DECISIVE, SolveEnvironment, Symmetry};
use gravcal_robot_model::parameter::Limit;
use gravcal_robot_model::session::{ParameterPrior, PriorKind, Session};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::{solve_built, solve_from};
use crate::joint::starting::sample::Sample;
use crate::joint::variables::State;

/// Standard deviation of a gain where gravity is told from its opposite, as a share of it.
const GAIN_KNOWN: f64 = 0.3;

/// Where no hemisphere is declared.
pub(super) struct UpsideDown<'a> {
    pub session: &'a Session,
    /// By it images are looked at.
    pub sample: &'a Sample,
}

impl Symmetry for UpsideDown<'_> {
    type Solution = Solved;
    type Start = State;
    type Error = EstimateError;

    fn name(&self) -> &'static str {
        "gravity the other way up"
    }

    fn images(&self, solved: &Solved, environment: &SolveEnvironment<'_>) -> Result<Vec<State>, EstimateError> {
        if self.session.gravity.hemisphere.is_some() {
            return Ok(Vec::new());
        }
        let found = solved.state(&State::nominal(self.session));
        let image = found.upside_down(self.session);
        let known = with_gains_known(self.session);
        let sample = Sample::new(&known, &self.sample.readings)?;
        let [here, there] = [&found, &image].map(|start| sample.rough_minimum(&known, start, environment));
        let ruled_out = there.reached && there.cost > here.cost + DECISIVE;
        Ok(if ruled_out { Vec::new() } else { vec![image] })
    }

    fn follow(
        &self,
        image: State,
        solved: &Solved,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Solved>, EstimateError> {
        let nominal = State::nominal(self.session);
        let built = build_with_constraints(self.session, solved.readings(), &image)?.with_loss(solved.built.loss)?;
        let other = solve_built(built, environment)?;
        let [here, there] = [solved, &other].map(|solution| solution.state(&nominal).gravity);
        let opposite = here.iter().zip(there).map(|(a, b)| a * b).sum::<f64>() < 0.0;
        Ok(opposite.then_some(other))
    }

    fn height(&self, solved: &Solved) -> f64 {
        solved.estimate.cost
    }

    /// With the noise that is found there.
    fn replaced(
        &self,
        solved: Solved,
        end: Solved,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        solve_from(self.session, solved.readings(), end.state(&State::nominal(self.session)), environment)
    }
}

/// The session with gains known but for a share of them: gravity the other way up is explained by sensors that are all reversed, too, and
/// the sign of a sensor is as declared.
pub(crate) fn with_gains_known(session: &Session) -> Session {
    let mut known = session.clone();
    for id in session.parameters() {
        let parameter = session.parameter(id);
        if let (Limit::ShareOfNominal(_), ParameterPrior { nominal, kind: PriorKind::Flat }) =
            (parameter.limit, parameter.prior)
        {
            known.prior_mut(id).kind = PriorKind::Gaussian { std: GAIN_KNOWN * nominal.abs() };
        }
    }
    known
}
