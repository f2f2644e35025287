//! Joints that come to (nearly) all of their standstills from one side: what friction leaves at rest is then in their bias.
//!
//! ```text
//!     y = k τ + b + f ρ sgn(approach)        ρ: the share of friction f that is left at rest, of mean ρ̄ and spread σ_ρ
//! ```
//!
//! From both sides `f ρ̄` cancels. From one side it is a part of `b`, and only `f σ_ρ` shows, as scatter beyond the noise. The mean is
//! at most about twice the spread, so that a bias is as uncertain as twice that scatter.

use crate::parameter::Quantity;
use crate::result::{CovarianceResult, EstimatorResult, JointFit, ParameterResult};
use crate::session::Session;

/// Share of the standstills beyond which a joint came from one side.
const ONE_SIDED: f64 = 0.8;
/// Fewest standstills of known direction that say so.
const LEAST: usize = 5;
/// Mean of what is left at rest, over its spread, at most.
const LEAN: f64 = 2.0;

/// Widens what is told of biases that hold friction at rest, and says which.
pub(super) fn widen(session: &Session, result: &mut EstimatorResult) {
    let joints = 0..session.joints.len();
    let found: Vec<(usize, f64)> =
        joints.filter_map(|joint| Some((joint, left_at_rest(session, result, joint)?))).collect();
    for (joint, left) in found {
        let name = &session.robot.chain.joints()[joint].name;
        let bias = Quantity::TorqueBias.name(name);
        let Some(parameter) = result.parameters.iter_mut().find(|parameter| parameter.name == bias) else { continue };
        let Some(before) = parameter.std.filter(|std| *std > 0.0) else { continue };
        parameter.widen_to(before.hypot(LEAN * left));
        result.covariance.add(&bias, (LEAN * left).powi(2));
        result.notes.push(format!(
            "{name} came to more than {:.0} % of its standstills from one side, and its readings scatter by {left:.2e} {} beyond \
             their noise: {bias} holds the friction that is left at rest, and its interval is widened by {LEAN} times that. Come \
             to the same poses from both sides.",
            100.0 * ONE_SIDED, parameter.unit
        ));
    }
}

/// By how much readings of a one-sided joint scatter beyond their noise, unit of the reading; `None` where they do not, or the session
/// estimates the joint's friction.
fn left_at_rest(session: &Session, result: &EstimatorResult, joint: usize) -> Option<f64> {
    if session.terms.with_friction().contains(&joint) || !is_one_sided(session, joint) {
        return None;
    }
    let fit = result.fit.as_ref()?.joints.iter().find(|fit| fit.joint == session.robot.chain.joints()[joint].name)?;
    Some(unexplained(session, fit, joint)).filter(|left| *left > 0.0)
}

/// Whether the joint came to its standstills from one side; of tables nothing is known.
fn is_one_sided(session: &Session, joint: usize) -> bool {
    if !session.searched.iter().any(|searched| searched.standstills.is_some()) {
        return false;
    }
    let stands = session.poses.iter().filter(|pose| pose.sweep_label.is_none() && pose.torque[joint].is_some());
    let sides = stands.filter_map(|pose| pose.conditions.direction.get(joint)).filter(|side| **side != 0.0);
    let (rising, all) = sides.fold((0, 0), |(rising, all), side| (rising + usize::from(*side > 0.0), all + 1));
    all >= LEAST && rising.max(all - rising) as f64 > ONE_SIDED * all as f64
}

/// Root of the mean square of the residuals less that of the readings' own standard errors.
fn unexplained(session: &Session, fit: &JointFit, joint: usize) -> f64 {
    let own = session.poses.iter().filter_map(|pose| pose.torque[joint]).filter_map(|reading| reading.std);
    let (sum, count) = own.fold((0.0, 0), |(sum, count), std| (sum + std * std, count + 1));
    // Scatter that noise alone may make is none.
    let (noise, freedom) = (sum / f64::from(count.max(1)), fit.readings.max(1) as f64);
    let chance = noise * (1.0 + 3.0 * (2.0 / freedom).sqrt());
    if fit.rms * fit.rms > chance { (fit.rms * fit.rms - noise).sqrt() } else { 0.0 }
}

impl ParameterResult {
    fn widen_to(&mut self, std: f64) {
        if let (Some(value), Some(before), Some(ci95)) = (self.value, self.std, self.ci95) {
            self.ci95 = Some(ci95.map(|end| value + (end - value) * std / before));
        }
        self.std = Some(std);
    }
}

impl CovarianceResult {
    fn add(&mut self, name: &str, variance: f64) {
        if let Some(place) = self.order.iter().position(|other| other == name) {
            self.matrix[place][place] += variance;
        }
    }
}
