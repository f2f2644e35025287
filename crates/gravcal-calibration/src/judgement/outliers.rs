//! Readings that a robust loss counts less than half.

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::Solved;
use crate::result::Outlier;

/// What is counted less than this is called an outlier.
const HALF: f64 = 0.5;
/// How many are told to people.
const TOLD: usize = 10;

/// The outliers of a solved problem, those that count least first; none without a loss.
pub(crate) fn outliers(session: &Session, solved: &Solved) -> Result<Vec<Outlier>, EvaluateError> {
    let (problem, values) = (&solved.built.problem, &solved.estimate.values);
    let residuals = problem.residuals(values)?;
    let weights = problem.weights(values)?;
    let rows = solved.built.rows.iter().zip(residuals).zip(weights);
    let mut outliers: Vec<Outlier> = rows
        .filter(|(_, weight)| *weight < HALF)
        .map(|((ReadingId { pose, channel }, residual), weight)| {
            let (table, line) = session.row_of(*pose);
            Outlier { table, line, joint: session.channel_name(*channel), residual_in_std: residual, weight }
        })
        .collect();
    outliers.sort_by(|a, b| {
        a.weight.total_cmp(&b.weight).then(b.residual_in_std.abs().total_cmp(&a.residual_in_std.abs()))
    });
    Ok(outliers)
}

/// The loss and the worst outliers in words; nothing without a loss.
pub(crate) fn outlier_note(loss: Loss, readings: usize, outliers: &[Outlier]) -> Option<String> {
    let width = loss.width()?;
    let mut note = format!(
        "Loss {}, width {width} standard deviations: {} of {readings} readings count less than half.",
        loss.name(),
        outliers.len()
    );
    let worst: Vec<String> = outliers.iter().take(TOLD).map(ToString::to_string).collect();
    if !worst.is_empty() {
        let heading = if outliers.len() > TOLD { "The worst" } else { "They are" };
        note += &format!(" {heading}: {}.", worst.join("; "));
    }
    Some(note)
}
