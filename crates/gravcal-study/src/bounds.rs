//! The Cramér-Rao bound: the smallest standard deviations that an unbiased estimator can have, from the readings that it uses.

use gravcal_calibration::Session;
use gravcal_calibration::joint::{self, EstimateError, Signals, Solved, Unknowns};

use crate::quantities::Measured;

/// Bounds of all torque readings, and of those that the paper's steps read, in the order of what is measured. `None` for what
/// the readings do not determine.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bounds {
    paper: Vec<Option<f64>>,
    all: Vec<Option<f64>>,
}

impl Bounds {
    /// At the true values, of the kinds of readings that are asked for: the paper's, all.
    pub fn new(
        session: &Session,
        truth: &Unknowns,
        measured: &[(usize, Measured)],
        [paper, all]: &[bool; 2],
    ) -> Result<Bounds, EstimateError> {
        let measured: Vec<Measured> = measured.iter().map(|(_, measured)| *measured).collect();
        let of = |wanted: bool, signals| match wanted {
            true => bound(session, truth, signals, &measured),
            false => Ok(Vec::new()),
        };
        Ok(Bounds { paper: of(*paper, Signals::PaperSteps)?, all: of(*all, Signals::All)? })
    }

    /// Those of one kind of readings.
    pub fn of(&self, signals: Signals) -> &[Option<f64>] {
        match signals {
            Signals::PaperSteps => &self.paper,
            Signals::All => &self.all,
        }
    }
}

/// Standard deviations at the true values; `None` for a quantity that the readings do not determine.
pub(crate) fn bound(
    session: &Session,
    truth: &Unknowns,
    signals: Signals,
    quantities: &[Measured],
) -> Result<Vec<Option<f64>>, EstimateError> {
    let readings = joint::select(session, signals);
    let posed = joint::pose(session, &readings, truth)?;
    let judged = Solved::at_start(readings, posed)?;
    let open = |quantity: &Measured| {
        let layout = &judged.posed.layout;
        let id = match quantity {
            Measured::Gravity(_) => layout.gravity,
            Measured::Sensor(joint, q) => layout.sensors[*joint][*q as usize],
        };
        let columns: Vec<usize> = judged.posed.problem.columns_of(id).collect();
        !judged.spectrum.null_space_within(&columns).is_empty()
    };
    Ok(quantities.iter().map(|q| (!open(q)).then(|| q.std(&judged))).collect())
}
