//! Noise that a fit is to find, and that too few readings are left to tell.

use gravcal_robot_model::session::Session;

use crate::joint::building::build::build_problem;
use crate::joint::error::EstimateError;
use crate::joint::identifiability::uncertainty::LEAST_FREEDOM;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::solved::Solved;
use crate::joint::variables::State;
use crate::result::Undetermined;

/// Noise that no std states, where too few readings are left to tell it: then nothing tells how well anything is known.
pub(crate) struct UntoldNoise {
    rows: usize,
    rank: usize,
}

impl UntoldNoise {
    pub(in crate::joint) fn of_solved(solved: &Solved) -> UntoldNoise {
        UntoldNoise { rows: solved.judged_problem().rows(), rank: solved.analysis.rank() }
    }

    /// The same as something undetermined, on which these hang.
    pub fn of(&self, parameters: Vec<String>) -> Undetermined {
        let UntoldNoise { rows, rank } = self;
        let freedom = rows.saturating_sub(*rank);
        Undetermined {
            combination: "the size of the noise".into(),
            parameters,
            why: format!(
                "the noise is not stated, and {rows} readings that determine {rank} numbers leave {freedom} degrees of freedom to estimate it \
                 from; at least {LEAST_FREEDOM} are needed. Without it nothing tells how well anything is known"
            ),
            cure: "state the std of the torque readings (readings.torque.std), or record more poses".into(),
        }
    }
}

impl Solved {
    /// Noise that a fit is to find where too few readings are left to tell it. Beside what is known from an earlier calibration, readings that tell
    /// no more numbers than they are have residuals of any size: the likelihood of their noise has no maximum.
    pub(crate) fn untold_noise(
        &self,
        session: &Session,
        readings: &MeasurementSet,
    ) -> Result<Option<UntoldNoise>, EstimateError> {
        let own = UntoldNoise::of_solved(self);
        let untold = untold_beside_earlier(session, readings)?;
        Ok(untold.or((own.rows < own.rank + LEAST_FREEDOM).then_some(own)))
    }
}

/// The same of readings beside an earlier calibration that tell no more numbers than they are.
pub(in crate::joint) fn untold_beside_earlier(
    session: &Session,
    readings: &MeasurementSet,
) -> Result<Option<UntoldNoise>, EstimateError> {
    if session.earlier.is_none() {
        return Ok(None);
    }
    let alone = Session { earlier: None, ..session.clone() };
    let built = build_problem(&alone, readings, &State::nominal(session))?;
    let untold = UntoldNoise::of_solved(&Solved::at_start(built)?);
    Ok((untold.rows <= untold.rank).then_some(untold))
}
