//! What the readings would be if all sensors and gravity were as they were assumed: what a calibration is compared with.

use gravcal_estimation::BlockId;

use super::{EstimateError, Signals, Unknowns, pose, select, solve_posed, start_around};
use crate::judgement::predictions;
use crate::result::Prediction;
use crate::session::Session;
use crate::workbench::Workbench;

/// Every reading with what nominal sensors and assumed gravity explain of it at best: masses, moments and placements, which
/// nobody knows beforehand, are solved for.
///
/// # Errors
/// Where that problem cannot be posed or has no answer.
pub fn predict_nominally(session: &Session, workbench: &Workbench<'_>) -> Result<Vec<Prediction>, EstimateError> {
    let readings = select(session, Signals::All);
    let start = start_around(session, &readings, &Unknowns::nominal(session))?;
    let mut posed = pose(session, &readings, &start)?;
    let layout = &posed.layout;
    let sensors = layout.sensors.iter().flatten();
    let assumed: Vec<BlockId> = sensors.chain(&layout.further).chain([&layout.gravity]).copied().collect();
    posed.problem = posed.problem.holding(&assumed, "taken as nominal");
    Ok(predictions(session, &solve_posed(readings, posed, workbench)?)?)
}

#[cfg(test)]
mod tests {
    use gravcal_solvers::LevenbergMarquardt;

    use super::*;
    use crate::joint::estimate_jointly;
    use crate::testing::sarcos_shoulder;

    /// Sum of squared residuals in standard deviations.
    fn chi_squared(predictions: &[Prediction]) -> f64 {
        predictions.iter().map(|one| (one.residual() / one.std).powi(2)).sum()
    }

    #[test]
    fn true_sensors_explain_what_the_estimate_explains_and_nominal_ones_do_not() {
        let simulation = sarcos_shoulder();
        let mut session = simulation.session(0);
        let solver = LevenbergMarquardt::default();
        let workbench = Workbench::new(&solver, &|_: &str| {});
        let result = estimate_jointly(&session, Signals::All, None, &workbench).unwrap();
        let explained = chi_squared(&result.detail.predictions);
        assert!((explained / result.fit.as_ref().unwrap().chi_squared - 1.0).abs() < 1e-9);
        assert!(chi_squared(&predict_nominally(&session, &workbench).unwrap()) > 100.0 * explained);

        let gravity = nalgebra::Vector3::from(simulation.truth.gravity);
        session.gravity.hemisphere = Some(gravity.normalize().into());
        for (joint, truth) in session.joints.iter_mut().zip(&simulation.truth.sensors) {
            joint.parameters.iter_mut().zip(truth).for_each(|(known, value)| known.nominal = *value);
        }
        let at_truth = chi_squared(&predict_nominally(&session, &workbench).unwrap());
        assert!(at_truth > explained && at_truth < 1.1 * explained, "{at_truth} {explained}");
    }

    #[test]
    fn the_way_ends_at_the_estimate() {
        let session = sarcos_shoulder().session(0);
        let solver = LevenbergMarquardt::default();
        let result = estimate_jointly(&session, Signals::All, None, &Workbench::new(&solver, &|_: &str| {})).unwrap();
        let way = &result.detail.way;
        assert_eq!(way.len(), result.trace.len());
        for (parameter, value) in result.parameters.iter().zip(way.last().unwrap()) {
            assert!(parameter.value.is_none_or(|told| told == *value), "{} {value}", parameter.name);
        }
        assert!(way[0] != *way.last().unwrap());
    }
}
