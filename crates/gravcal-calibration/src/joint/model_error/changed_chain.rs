//! What the readings would be of an arm in motion whose joints sit or are tilted otherwise than the robot's description says.
//!
//! At rest a joint that sits aside is a first moment more (`lengths.rs`), and one that is tilted takes its torque along (`axes.rs`). In motion it also accelerates
//! otherwise what hangs on it: so the same problem is posed of a changed chain, and its readings are predicted at the same values.

use gravcal_dynamics::Chain;
use gravcal_estimation::EvaluateError;
use gravcal_robot_model::session::Session;

use crate::joint::building::build::build_problem;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// Step of a place, m, and of a tilt, rad: torques are nearly linear in either.
const STEP: f64 = 1e-5;

impl Solved {
    /// What a unit of each change (metre, radian) does to the whitened residuals of the problem that is judged. `changed`: the chain with a step of it.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated beside the solution.
    pub(in crate::joint::model_error) fn by_changes_of_chain<const N: usize>(
        &self,
        session: &Session,
        changed: [&dyn Fn(f64) -> Chain; N],
    ) -> Result<Vec<Vec<f64>>, EvaluateError> {
        let (state, mut other) = (self.state(&State::nominal(session)), session.clone());
        let mut residuals = |chain: Chain| {
            other.robot.chain = chain;
            // It was built before, of the chain as it is described.
            let built =
                build_problem(&other, self.readings(), &state).map_err(|error| EvaluateError(error.to_string()))?;
            built.problem.residuals(&self.estimate.values)
        };
        let here = residuals(session.robot.chain.clone())?;
        let column = |chain: &dyn Fn(f64) -> Chain| {
            let there = residuals(chain(STEP))?;
            let readings = here.iter().zip(there).take(self.built.rows.len());
            let mut column: Vec<f64> = readings.map(|(here, there)| (there - here) / STEP).collect();
            column.resize(self.judged_problem().rows(), 0.0);
            Ok(column)
        };
        changed.into_iter().map(column).collect()
    }
}
