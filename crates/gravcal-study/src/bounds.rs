//! The Cramér-Rao bound: the smallest standard deviations that an unbiased estimator can have, from the readings that it uses.

use gravcal_calibration::joint::{self, EstimateError, Signals, Solved, State};
use gravcal_robot_model::Session;

use crate::quantities::Measured;

/// Bounds of some kinds of readings, in the order of what is measured. `None` for what the readings do not determine.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bounds(Vec<(Signals, Vec<Option<f64>>)>);

impl Bounds {
    /// At the true values.
    pub fn new(
        session: &Session,
        truth: &State,
        signals: &[Signals],
        quantities: &[Measured],
    ) -> Result<Bounds, EstimateError> {
        let of = |signals: &Signals| Ok((*signals, bound(session, truth, *signals, quantities)?));
        Ok(Bounds(signals.iter().map(of).collect::<Result<_, EstimateError>>()?))
    }

    /// Those of one kind of readings; nothing where they could not be computed.
    pub fn of(&self, signals: Signals) -> &[Option<f64>] {
        self.0.iter().find(|(kind, _)| *kind == signals).map_or(&[], |(_, bounds)| bounds)
    }
}

/// Standard deviations at the true values; `None` for a quantity that the readings do not determine.
pub(crate) fn bound(
    session: &Session,
    truth: &State,
    signals: Signals,
    quantities: &[Measured],
) -> Result<Vec<Option<f64>>, EstimateError> {
    let readings = joint::select(session, signals);
    let built = joint::build_problem(session, &readings, truth)?;
    let judged = Solved::at_start(built)?;
    let open = |quantity: &Measured| {
        let variables = &judged.built.variables;
        let id = match quantity {
            Measured::Gravity(_) => variables.gravity,
            Measured::Sensor(joint, q) => variables.sensors[*joint][*q as usize],
        };
        let columns: Vec<usize> = judged.built.problem.columns_of(id).collect();
        !judged.analysis.null_space_within(&columns).is_empty()
    };
    Ok(quantities.iter().map(|q| (!open(q)).then(|| q.std(&judged))).collect())
}
