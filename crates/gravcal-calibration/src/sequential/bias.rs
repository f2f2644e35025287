//! Step 1: torque bias and position gain of one joint from its own sweeps (paper, section 2.1).

use gravcal_estimation::{Block, BlockId, Factor, Noise, ProblemBuilder};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{Sinusoid, SinusoidBlocks};
use gravcal_robot_model::session::{ReadingId, Session};

use super::carried::{CarriedErrors, place};
use super::contradiction::{NoiseScale, refuse_contradiction};
use super::fitting::{StepFit, StepProblem};
use super::found::{Found, Frozen, Missing};
use crate::closed_form::{fit_sinusoid, search_position_gain};
use crate::joint::MeasurementSet;
use crate::plan::Plan;

const CURE: &str = "sweep this joint over its whole range while the others stand, and read its torque";
const CONTRADICTED: &str = "let the other joints stand still while this one sweeps, state the noise as large as it is, or rely on the \
                            joint estimator, which knows more of the robot";

/// What step 1 finds for one joint.
#[derive(Clone, Debug)]
pub struct Bias {
    /// Torque bias.
    pub torque_bias: Found,
    /// Position gain.
    pub position_gain: Found,
    /// Standard deviation of the residuals, unit of the torque reading, where there was a fit.
    pub residual_std: Option<f64>,
    /// Degrees of freedom of these residuals.
    pub degrees_of_freedom: usize,
    /// Largest |residual| of the sinusoids, unit of the torque reading.
    pub largest_residual: Option<f64>,
    /// Solver iterations.
    pub iterations: usize,
}

impl Bias {
    fn missing(missing: Missing) -> Bias {
        Bias {
            torque_bias: Err(missing.clone()),
            position_gain: Err(missing),
            residual_std: None,
            degrees_of_freedom: 0,
            largest_residual: None,
            iterations: 0,
        }
    }
}

/// Position and torque reading of `observed` while `swept` moves, with their poses; rows without a reading dropped.
pub(super) fn readings_of(
    session: &Session,
    poses: &[usize],
    swept: usize,
    observed: usize,
) -> Vec<(usize, (f64, f64))> {
    poses
        .iter()
        .filter_map(|pose| {
            let p = &session.poses[*pose];
            Some((*pose, (p.position[swept], p.torque[observed].as_ref()?.value)))
        })
        .collect()
}

/// Fits the sinusoids of all step-1 sweeps of a joint with a common gain and bias, eq. (8).
pub(super) fn find_bias(
    session: &Session,
    plan: &Plan,
    readings: &MeasurementSet,
    joint: usize,
    errors: &mut CarriedErrors,
    environment: &SolveEnvironment<'_>,
) -> Bias {
    let mut bias = fit(session, plan, readings, joint, errors, environment).unwrap_or_else(Bias::missing);
    // What is given as exact is known also where no sweep tells it.
    if let Some(value) = exact(session, joint, SensorParameter::TorqueBias) {
        bias.torque_bias = Ok(Frozen { value, std: 0.0 });
    }
    if let Some(value) = exact(session, joint, SensorParameter::PositionGain) {
        bias.position_gain = Ok(Frozen { value, std: 0.0 });
    }
    bias
}

/// The value of a parameter that is no unknown.
fn exact(session: &Session, joint: usize, quantity: SensorParameter) -> Option<f64> {
    session.fixed_reason(joint, quantity).map(|_| session.joints[joint].of(quantity).nominal)
}

/// A block of one number, held where the session gives its value as exact.
fn add_scalar(
    session: &Session,
    joint: usize,
    quantity: SensorParameter,
    start: f64,
    builder: &mut ProblemBuilder,
) -> BlockId {
    let block = Block::scalar(quantity.as_str(), session.parameter_unit(joint, quantity));
    let block = if quantity == SensorParameter::TorqueBias { block.linear() } else { block };
    match exact(session, joint, quantity) {
        Some(value) => builder.add_block(block.fixed("given as exact"), &[value]),
        None => builder.add_block(block, &[start]),
    }
}

fn fit(
    session: &Session,
    plan: &Plan,
    readings: &MeasurementSet,
    joint: usize,
    errors: &mut CarriedErrors,
    environment: &SolveEnvironment<'_>,
) -> Result<Bias, Missing> {
    let sweeps: Vec<Vec<(usize, (f64, f64))>> = plan.bias[joint]
        .iter()
        .map(|sweep| readings_of(session, &plan.sweeps[*sweep].poses, joint, joint))
        .filter(|sweep| sweep.len() > 4)
        .collect();
    let name = &session.robot.chain.joints()[joint].name;
    if sweeps.is_empty() {
        return Err(Missing::new(format!("step 1 has no sweep of {name} with its torque read"), CURE));
    }
    let pairs: Vec<Vec<(f64, f64)>> = sweeps.iter().map(|s| s.iter().map(|(_, r)| *r).collect()).collect();
    let prior = |quantity| session.joints[joint].of(quantity);
    let nominal = prior(SensorParameter::PositionGain).nominal;
    let gain = exact(session, joint, SensorParameter::PositionGain)
        .or_else(|| search_position_gain(&pairs, nominal))
        .ok_or_else(|| Missing::new(format!("the sweeps of {name} form no sinusoid"), CURE))?;

    let mut step = StepProblem::default();
    let builder = &mut step.builder;
    let position_gain = add_scalar(session, joint, SensorParameter::PositionGain, gain, builder);
    let starts: Vec<_> = pairs.iter().filter_map(|sweep| fit_sinusoid(sweep, gain, None)).collect();
    let bias = starts.iter().map(|s| s.coefficients[2]).sum::<f64>() / starts.len() as f64;
    let torque_bias = add_scalar(session, joint, SensorParameter::TorqueBias, bias, builder);
    let std = |pose| readings.std(session, ReadingId { pose, channel: joint });
    for (index, (sweep, start)) in sweeps.iter().zip(&starts).enumerate() {
        let block = Block::vector(format!("sweep{index}"), "", &["a", "c"]).linear();
        let coefficients = builder.add_block(block, &[start.coefficients[0], start.coefficients[1]]);
        let blocks = SinusoidBlocks { position_gain, torque_bias, coefficients };
        let std: Vec<f64> = sweep.iter().map(|(pose, _)| std(*pose)).collect();
        let noise = Noise::independent(&std).map_err(|e| Missing::new(e.to_string(), CURE))?;
        builder.add_factor(Factor::new(Sinusoid::new(blocks, pairs[index].clone()), noise));
    }
    let fitted = StepFit::solve(step, environment, CURE)?;
    errors.take(
        &fitted,
        &[
            (torque_bias, place(joint, SensorParameter::TorqueBias)),
            (position_gain, place(joint, SensorParameter::PositionGain)),
        ],
    );
    let noise = if session.noise_estimated()[joint] { NoiseScale::Unknown } else { NoiseScale::Stated };
    let allowed =
        refuse_contradiction(&fitted, errors, noise, (&format!("step 1 of {name} (sinusoids)"), CONTRADICTED));
    let spread = readings.spreads[joint];
    let found = |block: BlockId, limit: f64| allowed.clone().and_then(|()| fitted.frozen(block, limit, CURE));
    Ok(Bias {
        torque_bias: found(torque_bias, 0.5 * spread),
        position_gain: found(position_gain, 0.1 * nominal.abs()).and_then(|found| {
            same_sign(found, nominal).ok_or_else(|| Missing::new(format!("the sweeps of {name} are no sinusoid"), CURE))
        }),
        residual_std: residual_std(&fitted, &sweeps, std),
        degrees_of_freedom: fitted.degrees_of_freedom,
        largest_residual: largest_residual(&fitted, &sweeps, std),
        iterations: fitted.estimate.iterations.len() - 1,
    })
}

fn same_sign(found: Frozen, nominal: f64) -> Option<Frozen> {
    (found.value * nominal > 0.0).then_some(found)
}

/// Residuals in the unit of the reading.
fn residuals(fitted: &StepFit, sweeps: &[Vec<(usize, (f64, f64))>], std: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
    let whitened = fitted.problem.residuals(fitted.values()).ok()?;
    Some(sweeps.iter().flatten().zip(whitened).map(|((pose, _), r)| r * std(*pose)).collect())
}

fn residual_std(fitted: &StepFit, sweeps: &[Vec<(usize, (f64, f64))>], std: impl Fn(usize) -> f64) -> Option<f64> {
    let squares: f64 = residuals(fitted, sweeps, std)?.iter().map(|r| r * r).sum();
    let freedom = fitted.degrees_of_freedom;
    (freedom > 0 && squares > 0.0).then(|| (squares / freedom as f64).sqrt())
}

fn largest_residual(fitted: &StepFit, sweeps: &[Vec<(usize, (f64, f64))>], std: impl Fn(usize) -> f64) -> Option<f64> {
    residuals(fitted, sweeps, std)?.into_iter().map(f64::abs).reduce(f64::max)
}
