//! JSON has no infinite numbers and no NaN; `serde_json` writes `null` for them, which would read as "not determined".
//! They are looked for beforehand instead, in every number of a result.
//!
//! Results are taken apart field by field, so that a new field cannot be forgotten here.

use gravcal_calibration::result::{
    ActiveConstraint, Concern, ConsistentModel, CovarianceResult, DeflectionResult, EstimatorResult, Fit, FixedBlock,
    GravityResult, HeldOut, Iteration, JointFit, LinkInertiaResult, LossResult, MomentResult, NoiseSource, Outlier,
    ParameterResult, PayloadNumber, PayloadResult, PositionErrorResult, ResidualTest, SensorModelTest, SmallerModel,
    TakenAsExact, TestAgainstZero, UncertaintyResult, UnexplainedResult, WeakCombination,
};
use thiserror::Error;

/// A result holds a number that a file cannot: infinite, or none at all.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("the result cannot be written: {place} is {found}")]
pub struct NotFinite {
    place: String,
    found: f64,
}

/// A number with where it stands.
type Number = (String, f64);

/// Looks at every number of the results.
///
/// # Errors
/// For the first that is not finite, with where it stands.
pub(crate) fn check_finite(results: &[EstimatorResult]) -> Result<(), NotFinite> {
    match results.iter().flat_map(numbers).find(|(_, value)| !value.is_finite()) {
        Some((place, found)) => Err(NotFinite { place, found }),
        None => Ok(()),
    }
}

fn numbers(result: &EstimatorResult) -> Vec<Number> {
    let EstimatorResult {
        name,
        verdict: _,
        termination: _,
        iterations: _,
        trace,
        gravity,
        parameters,
        covariance,
        moments,
        deflections,
        position_errors,
        sensor_models,
        residual_tests,
        taken_as_exact,
        undetermined: _,
        active_constraints,
        weak,
        held,
        uncertainty,
        loss,
        outliers,
        fit,
        payloads,
        consistent_model,
        concerns,
        notes: _,
        reasons: _,
        detail: _,
    } = result;
    let inside = gravity.iter().flat_map(of_gravity);
    let inside = inside.chain(parameters.iter().flat_map(of_parameter));
    let inside = inside.chain(of_covariance(covariance));
    let inside = inside.chain(moments.iter().flat_map(of_moment));
    let inside = inside.chain(deflections.iter().flat_map(of_deflection));
    let inside = inside.chain(position_errors.iter().flat_map(of_position_error));
    let inside = inside.chain(sensor_models.iter().flat_map(of_model_test));
    let inside = inside.chain(residual_tests.iter().flat_map(of_residual_test));
    let inside = inside.chain(taken_as_exact.iter().flat_map(of_exact));
    let inside = inside.chain(active_constraints.iter().flat_map(of_constraint));
    let inside = inside.chain(weak.iter().flat_map(of_weak));
    let inside = inside.chain(held.iter().flat_map(of_held));
    let inside = inside.chain(uncertainty.iter().flat_map(of_uncertainty));
    let inside = inside.chain(loss.iter().flat_map(of_loss));
    let inside = inside.chain(outliers.iter().flat_map(of_outlier));
    let inside = inside.chain(fit.iter().flat_map(of_fit));
    let inside = inside.chain(payloads.iter().flat_map(of_payload));
    let inside = inside.chain(consistent_model.iter().flat_map(of_consistent_model));
    let inside = inside.chain(concerns.iter().flat_map(of_concern));
    let inside = inside.chain(trace.iter().flat_map(of_iteration));
    inside.map(|(place, value)| (format!("{name}: {place}"), value)).collect()
}

fn of_gravity(gravity: &GravityResult) -> Vec<Number> {
    let GravityResult { vector_m_per_s2, std_m_per_s2, ci95_m_per_s2, cone95_deg, asked: _ } = gravity;
    let mut numbers = each("gravity", vector_m_per_s2);
    numbers.extend(each("standard deviation of gravity", std_m_per_s2));
    numbers.extend(each("interval of gravity", ci95_m_per_s2.as_flattened()));
    numbers.extend(each("cone of gravity", [cone95_deg]));
    numbers
}

fn of_exact(exact: &TakenAsExact) -> Vec<Number> {
    let TakenAsExact { wrong: _, parameter, off_in_std, cure: _ } = exact;
    each(&format!("{parameter} if what is taken as exact is not"), [off_in_std])
}

fn of_concern(concern: &Concern) -> Vec<Number> {
    match concern {
        Concern::Misfit { times_noise } | Concern::NoiseStatedTooLarge { times_noise } => {
            each("residuals over the stated noise", [times_noise])
        }
        Concern::ResidualShape { tests: _ } | Concern::OneSidedApproach { joints: _ } => Vec::new(),
        Concern::FarPositionGain { parameter, ratio } => each(&format!("{parameter} over its nominal value"), [ratio]),
    }
}

fn of_iteration(iteration: &Iteration) -> Vec<Number> {
    let Iteration { cost, largest_cosine, step, damping } = iteration;
    each("an iteration of the trace", [cost, largest_cosine, step, damping])
}

fn of_parameter(parameter: &ParameterResult) -> Vec<Number> {
    let ParameterResult { name, unit: _, convention: _, value, std, ci95, determined: _, held: _, asked: _, nominal } =
        parameter;
    let mut numbers = each(name, value);
    numbers.extend(each(&format!("standard deviation of {name}"), std));
    numbers.extend(each(&format!("95 % interval of {name}"), ci95.iter().flatten()));
    numbers.extend(each(&format!("nominal value of {name}"), [nominal]));
    numbers
}

fn of_covariance(covariance: &CovarianceResult) -> Vec<Number> {
    let CovarianceResult { order, matrix } = covariance;
    let row = |(name, row): (&String, &Vec<f64>)| each(&format!("covariance of {name}"), row);
    order.iter().zip(matrix).flat_map(row).collect()
}

fn of_moment(moment: &MomentResult) -> Vec<Number> {
    let MomentResult { terms, value, std } = moment;
    let names: Vec<&str> = terms.iter().map(|(name, _)| name.as_str()).collect();
    let coefficients = terms.iter().map(|(_, coefficient)| coefficient);
    each(&format!("combination of {}", names.join(", ")), coefficients.chain([value, std]))
}

fn of_deflection(deflection: &DeflectionResult) -> Vec<Number> {
    let DeflectionResult { table, lines: [first, last], joint, unit: _, value, std, prior_std } = deflection;
    let place = format!("deflection of {joint} in {table}:{first}-{last}");
    each(&place, value.iter().chain([std, prior_std]))
}

fn of_position_error(error: &PositionErrorResult) -> Vec<Number> {
    let PositionErrorResult { joint, unit: _, poses: _, rms, std, prior_std, observable: _ } = error;
    each(&format!("errors of the position of {joint}"), [rms, std, prior_std])
}

fn of_weak(weak: &WeakCombination) -> Vec<Number> {
    let WeakCombination { combination, terms, times_worse } = weak;
    let coefficients = terms.iter().map(|(_, _, coefficient)| coefficient);
    each(&format!("weak combination {combination}"), coefficients.chain([times_worse]))
}

fn of_held(held: &FixedBlock) -> Vec<Number> {
    let FixedBlock { name, value, why: _ } = held;
    each(&format!("held value of {name}"), value)
}

fn of_uncertainty(uncertainty: &UncertaintyResult) -> Vec<Number> {
    match uncertainty {
        UncertaintyResult::Noise {
            source: NoiseSource::Stated | NoiseSource::Residuals | NoiseSource::StatedAndUnexplained,
            widened_by,
        } => each("widening of the noise", widened_by),
        UncertaintyResult::Jackknife(jackknife) => each("correlation of neighbouring poses", &jackknife.correlation),
        UncertaintyResult::LargerOfNoiseAndJackknife { source: _, widened_by, jackknife } => {
            let mut numbers = each("widening of the noise", widened_by);
            numbers.extend(each("correlation of neighbouring poses", &jackknife.correlation));
            numbers
        }
        UncertaintyResult::Sandwich { blocks: _, block_poses: _ } => Vec::new(),
        UncertaintyResult::Bootstrap {
            blocks: _,
            block_poses: _,
            replicates: _,
            not_converged: _,
            undetermined: _,
        } => Vec::new(),
    }
}

fn of_model_test(tested: &SensorModelTest) -> Vec<Number> {
    let SensorModelTest { joint, model, parameters: _, test } = tested;
    let numbers = |TestAgainstZero { kind: _, statistic, degrees_of_freedom: _, p_value }: &TestAgainstZero| {
        [(format!("{joint} {model} statistic"), *statistic), (format!("{joint} {model} p_value"), *p_value)]
    };
    test.iter().flat_map(numbers).collect()
}

fn of_residual_test(tested: &ResidualTest) -> Vec<Number> {
    let ResidualTest {
        channel,
        kind,
        statistic,
        degrees_of_freedom,
        blocks: _,
        p_value,
        corrected_p_value,
        size,
        unit: _,
        in_noise,
        named: _,
        spoils_intervals: _,
    } = tested;
    let numbers = degrees_of_freedom.iter().chain([statistic, p_value, corrected_p_value, size, in_noise]);
    each(&format!("{kind} in the residuals of {channel}"), numbers)
}

fn of_constraint(active: &ActiveConstraint) -> Vec<Number> {
    let ActiveConstraint { constraint, multiplier, unit: _ } = active;
    each(&format!("multiplier of `{constraint}`"), [multiplier])
}

fn of_loss(loss: &LossResult) -> Vec<Number> {
    let LossResult { kind: _, width } = loss;
    each("width of the loss", [width])
}

fn of_outlier(outlier: &Outlier) -> Vec<Number> {
    let Outlier { table, line, joint, residual_in_std, weight } = outlier;
    each(&format!("outlier of {joint} in {table} line {line}"), [residual_in_std, weight])
}

fn of_fit(fit: &Fit) -> Vec<Number> {
    // Residuals of single readings are in no file.
    let Fit {
        chi_squared,
        degrees_of_freedom: _,
        p_value,
        times_noise,
        median_ratio,
        joints,
        held_out,
        held_out_missing: _,
        smaller_models,
        residuals: _,
    } = fit;
    let mut numbers = each("χ²", [chi_squared]);
    numbers.extend(each("p-value", p_value));
    numbers.extend(each("residuals over the stated noise", times_noise));
    numbers.extend(each("median of the residuals", median_ratio));
    numbers.extend(joints.iter().flat_map(of_joint));
    let smaller = smaller_models.iter().map(|SmallerModel { kind: _, held_out }| held_out);
    numbers.extend(held_out.iter().chain(smaller).flat_map(of_held_out));
    numbers
}

fn of_payload(payload: &PayloadResult) -> Vec<Number> {
    let PayloadResult { load, link: _, mass_kg, center_of_mass_m, tensor_kg_m2, undetermined: _ } = payload;
    let numbers = mass_kg.iter().chain(center_of_mass_m.iter().flatten()).chain(tensor_kg_m2.iter().flatten());
    let of_one = |PayloadNumber { value, std, ci95 }: &PayloadNumber| {
        each(&format!("load {load}"), [value, std].into_iter().chain(ci95))
    };
    numbers.flat_map(of_one).collect()
}

fn of_consistent_model(model: &ConsistentModel) -> Vec<Number> {
    let ConsistentModel {
        links,
        relative_std,
        tensors_from_readings: _,
        variance_inflation,
        chi_squared_growth,
        held_out,
    } = model;
    let mut numbers: Vec<Number> = links.iter().flat_map(of_link).collect();
    numbers.extend(each("standard deviation of the robot's inertias", relative_std));
    numbers.extend(each("growth of χ² and of variances", [variance_inflation, chi_squared_growth]));
    numbers.extend(held_out.iter().flat_map(of_held_out));
    numbers
}

fn of_link(inertia: &LinkInertiaResult) -> Vec<Number> {
    let LinkInertiaResult { link, mass_kg, center_of_mass_m, tensor_kg_m2 } = inertia;
    let all = [mass_kg].into_iter().chain(center_of_mass_m).chain(tensor_kg_m2);
    each(&format!("inertia of {link}"), all)
}

fn of_held_out(held_out: &HeldOut) -> Vec<Number> {
    let HeldOut { poses: _, stretches: _, files: _, chi_squared, readings: _, joints } = held_out;
    let joints = joints.iter().flat_map(of_joint);
    let numbers = each("χ²", [chi_squared]).into_iter().chain(joints);
    numbers.map(|(place, value)| (format!("held-out {place}"), value)).collect()
}

fn of_joint(fit: &JointFit) -> Vec<Number> {
    let JointFit {
        joint,
        unit: _,
        readings: _,
        rms,
        largest,
        noise_std,
        noise_estimated: _,
        unexplained,
        lasting_std,
        range,
    } = fit;
    let mut numbers = each(&format!("residual of {joint}"), [rms, largest, noise_std, range]);
    if let Some(UnexplainedResult { std, estimated: _, times_noise, gravity_std, share_of_gravity }) = unexplained {
        let numbers_of = [std, times_noise, gravity_std].into_iter().chain(share_of_gravity);
        numbers.extend(each(&format!("unexplained error of {joint}"), numbers_of));
    }
    numbers.extend(each(&format!("lasting error of {joint}"), lasting_std));
    numbers
}

fn each<'a>(place: &str, values: impl IntoIterator<Item = &'a f64>) -> Vec<Number> {
    values.into_iter().map(|value| (place.to_owned(), *value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{determined, fit, result};

    fn complete() -> EstimatorResult {
        let mut joint = result("joint");
        joint.parameters = vec![determined("joint1.torque_gain", "count/(N·m)", 7.1, 0.1)];
        joint.covariance = CovarianceResult { order: vec!["joint1.torque_gain".into()], matrix: vec![vec![0.01]] };
        joint.moments = vec![MomentResult { terms: vec![("link1.mass".into(), 1.0)], value: 2.0, std: 0.1 }];
        joint.fit = Some(fit());
        joint.trace = vec![Iteration { cost: 50.6, largest_cosine: 1e-11, step: 1e-6, damping: 1e-8 }];
        joint
    }

    #[test]
    fn a_sound_result_passes() {
        assert_eq!(check_finite(&[complete()]), Ok(()));
    }

    #[test]
    fn the_place_is_named() {
        let refused = |spoil: fn(&mut EstimatorResult)| {
            let mut spoilt = complete();
            spoil(&mut spoilt);
            check_finite(&[complete(), spoilt]).unwrap_err().to_string()
        };
        let reading = |place: &str| format!("the result cannot be written: joint: {place}");
        assert_eq!(
            refused(|r| r.parameters[0].std = Some(f64::NAN)),
            reading("standard deviation of joint1.torque_gain is NaN")
        );
        assert_eq!(
            refused(|r| r.covariance.matrix[0][0] = f64::INFINITY),
            reading("covariance of joint1.torque_gain is inf")
        );
        assert_eq!(refused(|r| r.trace[0].cost = f64::INFINITY), reading("an iteration of the trace is inf"));
        assert_eq!(refused(|r| r.moments[0].value = f64::NAN), reading("combination of link1.mass is NaN"));
        assert_eq!(
            refused(|r| r.fit.as_mut().unwrap().held_out.as_mut().unwrap().joints[0].rms = f64::NAN),
            reading("held-out residual of joint1 is NaN")
        );
        assert_eq!(refused(|r| r.gravity.as_mut().unwrap().cone95_deg = f64::NAN), reading("cone of gravity is NaN"));
    }
}
