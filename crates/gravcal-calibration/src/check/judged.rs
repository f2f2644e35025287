//! The judgement of the joint problem at given values, as `check` tells it.

use gravcal_estimation::BlockId;
use gravcal_robot_model::session::{ReadingId, Session};

use super::report::{CheckedParameter, CheckedPayload};
use super::sign;
use crate::joint::{
    EstimateError, JointProblem, MeasurementSet, Solved, State, build_with_constraints, last_frame_choices, payloads,
    unknown_sign,
};
use crate::judgement::Asked;
use crate::result::{ParameterResult, Undetermined};

/// Largest less smallest of some hundred readings of mere noise, in standard deviations.
const NOISE_SPREAD: f64 = 5.0;

/// What can be known at given values.
#[derive(Clone, Debug)]
pub(super) struct NominalVerdict {
    /// Gravity first, then the session's parameters.
    pub parameters: Vec<CheckedParameter>,
    /// Loads of unknown mass.
    pub payloads: Vec<CheckedPayload>,
    /// What cannot.
    pub undetermined: Vec<Undetermined>,
}

impl NominalVerdict {
    /// The parameter of this name.
    pub fn of(&self, name: &str) -> Option<&CheckedParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Whether a parameter is determined.
    pub fn determines(&self, name: &str) -> bool {
        self.of(name).is_some_and(|parameter| parameter.determined)
    }
}

/// Judges the readings at the given values; a standard deviation follows from a first guess where no reading states its noise. `noise_found`: whether a
/// fit finds noise from the residuals; then nothing is determined where too few are left for that.
pub(super) fn judge_at(
    session: &Session,
    readings: &MeasurementSet,
    (values, noise_found): (&State, bool),
) -> Result<NominalVerdict, EstimateError> {
    let readings = &readings.with_displacements(session, values)?;
    let mut judged = Solved::at_start(build_with_constraints(session, readings, values)?)?;
    judged.sign_known = sign::is_decided(session, readings, values)?;
    // Readings count, not their values: a bias is judged against the torque that the nominal model predicts.
    let spreads = predicted_spreads(session, &judged)?;
    let judgement = judged.judge_with_spreads(session, &spreads);
    let (built, covariance) = (&judged.built, judged.covariance());
    let std = |id: BlockId| built.problem.columns_of(id).map(|column| covariance.std(column)).reduce(f64::max);
    let mut parameters = vec![CheckedParameter {
        name: "gravity".into(),
        unit: "deg".into(),
        asked: session.asks("gravity"),
        determined: judgement.determines(Asked::Gravity),
        held: None,
        predicted_std: std(built.variables.gravity)
            .filter(|_| judgement.determines(Asked::Gravity))
            .map(|std| (std / session.gravity.magnitude).to_degrees()),
    }];
    for id in session.parameters() {
        let blank = ParameterResult::blank(session, id);
        let determined = blank.determined && judgement.determines(id);
        parameters.push(CheckedParameter {
            name: blank.name,
            unit: blank.unit,
            asked: blank.asked,
            determined,
            held: blank.held,
            predicted_std: std(built.variables.block(id)).filter(|_| determined),
        });
    }
    let untold = if noise_found { judged.untold_noise(session, readings)? } else { None };
    let untold = untold.map(|untold| untold.of(without_numbers(&mut parameters)));
    let situation = judged.situation(session);
    let combinations = judgement.combinations.iter().map(|c| situation.report(&c.into()));
    let mut undetermined: Vec<Undetermined> = untold.into_iter().chain(combinations).collect();
    undetermined.extend(unknown_sign(session, &judged, &spreads));
    undetermined.extend(last_frame_choices(session));
    let payloads = payloads(session, &judged).into_iter().map(|payload| CheckedPayload {
        predicted_mass_std_kg: payload.mass_kg.map(|mass| mass.std),
        load: payload.load,
        undetermined: payload.undetermined,
    });
    Ok(NominalVerdict { parameters, payloads: payloads.collect(), undetermined })
}

/// Takes what is determined for undetermined; the names of those that are asked for.
fn without_numbers(parameters: &mut [CheckedParameter]) -> Vec<String> {
    let mut names = Vec::new();
    for parameter in parameters.iter_mut().filter(|parameter| parameter.determined && parameter.held.is_none()) {
        (parameter.determined, parameter.predicted_std) = (false, None);
        names.extend(parameter.asked.then(|| parameter.name.clone()));
    }
    names
}

/// Largest less smallest reading that the nominal model predicts for each channel, unit of the reading; never less than
/// noise alone spreads them, so that a joint that carries nothing still tells its bias.
fn predicted_spreads(session: &Session, judged: &Solved) -> Result<Vec<f64>, EstimateError> {
    let mut noise = vec![1.0; session.channel_count()];
    for id in &judged.built.rows {
        noise[id.channel] = judged.readings().std(session, *id);
    }
    let ranges = predicted_ranges(session, &judged.built)?;
    Ok(ranges.iter().zip(noise).map(|([low, high], std)| (high - low).max(NOISE_SPREAD * std)).collect())
}

/// Smallest and largest reading that the nominal model predicts for each channel, unit of the reading.
pub(super) fn predicted_ranges(session: &Session, built: &JointProblem) -> Result<Vec<[f64; 2]>, EstimateError> {
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; session.channel_count()];
    for (ReadingId { channel, .. }, predicted) in built.predicted(session)? {
        let [low, high] = ranges[channel];
        ranges[channel] = [low.min(predicted), high.max(predicted)];
    }
    Ok(ranges)
}
