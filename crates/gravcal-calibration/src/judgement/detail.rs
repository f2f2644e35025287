//! What pictures need of a solved problem.

use gravcal_estimation::EvaluateError;

use crate::joint::Solved;
use crate::result::{Detail, Prediction};
use crate::session::Session;

/// The readings with their predictions, and what the Jacobian is worth; not the way there.
pub(crate) fn detail(session: &Session, solved: &Solved) -> Result<Detail, EvaluateError> {
    Ok(Detail {
        predictions: predictions(session, solved)?,
        singular_values: solved.spectrum.singular_values().to_vec(),
        way: Vec::new(),
    })
}

/// Every reading that entered, with what the estimate says it should be.
pub(crate) fn predictions(session: &Session, solved: &Solved) -> Result<Vec<Prediction>, EvaluateError> {
    let whitened = solved.posed.problem.residuals(&solved.estimate.values)?;
    let rows = solved.posed.rows.iter().zip(&whitened);
    let predict = |((pose, channel), whitened): (&(usize, usize), &f64)| {
        let (pose, channel) = (*pose, *channel);
        let reading = session.reading(pose, channel)?.value;
        let std = solved.readings.std(session, pose, channel);
        Some(Prediction { pose, channel, reading, predicted: reading + whitened * std, std })
    };
    Ok(rows.filter_map(predict).collect())
}
