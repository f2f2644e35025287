//! Joints that come to more of their standstills from one side than chance would have it: what friction leaves at rest is then in their bias.
//!
//! ```text
//!     y = k τ + b + f ρ sgn(approach)        ρ: the share of friction f that is left at rest, of mean ρ̄ and spread σ_ρ
//!     m = (from below − from above)/n        the bias holds m f ρ̄;  m² is 1/n by chance
//! ```
//!
//! What is left at rest scatters by `u = f √(σ_ρ² + (1 − m²) ρ̄²)` beyond the noise, of which errors of either sign are a part and the
//! bias's deviation allows for. From one side alone only `f σ_ρ` shows; the mean is at most about twice the spread. So
//! `f ρ̄ ≤ u · min(2, 1/√(1 − m²))`, and `(m² − 1/n)` times its square is what a bias's variance lacks.

use crate::parameter::Quantity;
use crate::result::{CovarianceResult, EstimatorResult, JointFit, ParameterResult};
use crate::session::Session;

/// Fewest standstills of known direction that say so.
const LEAST: usize = 5;
/// Mean of what is left at rest, over its spread, at most.
const LEAN: f64 = 2.0;
/// By what share a standard deviation grows that is worth a remark.
const REMARKABLE: f64 = 0.5;

/// Widens what is told of biases that hold friction at rest, and says which.
pub(super) fn widen(session: &Session, result: &mut EstimatorResult) {
    for joint in 0..session.joints.len() {
        let Some((sides, left)) = left_at_rest(session, result, joint) else { continue };
        let name = &session.robot.chain.joints()[joint].name;
        let bias = Quantity::TorqueBias.name(name);
        let Some(parameter) = result.parameters.iter_mut().find(|parameter| parameter.name == bias) else { continue };
        let Some(before) = parameter.std.filter(|std| *std > 0.0) else { continue };
        let held = left * sides.held();
        let std = before.hypot(held);
        parameter.widen_to(std);
        result.covariance.add(&bias, held * held);
        if std > (1.0 + REMARKABLE) * before {
            result.notes.push(format!(
                "{name} came to {:.0} % of its standstills from one side, and its readings scatter by {left:.2e} {} beyond their noise: \
                 {bias} holds friction that is left at rest, and its interval is widened by what that may be. Come to the same poses \
                 from both sides.",
                100.0 * sides.larger_share(), parameter.unit
            ));
        }
    }
}

/// From which sides a joint came.
#[derive(Clone, Copy, Debug)]
struct Sides {
    rising: usize,
    all: usize,
}

impl Sides {
    /// Of the standstills of recordings; of tables nothing is known.
    fn of(session: &Session, joint: usize) -> Option<Sides> {
        if !session.searched.iter().any(|searched| searched.standstills.is_some()) {
            return None;
        }
        let stands = session.poses.iter().filter(|pose| pose.sweep_label.is_none() && pose.torque[joint].is_some());
        let sides = stands.filter_map(|pose| pose.conditions.direction.get(joint)).filter(|side| **side != 0.0);
        let (rising, all) = sides.fold((0, 0), |(rising, all), side| (rising + usize::from(*side > 0.0), all + 1));
        (all >= LEAST).then_some(Sides { rising, all })
    }

    fn larger_share(self) -> f64 {
        self.rising.max(self.all - self.rising) as f64 / self.all as f64
    }

    /// What a bias holds and its deviation lacks, over what is left at rest.
    fn held(self) -> f64 {
        let squared = (2.0 * self.larger_share() - 1.0).powi(2);
        let mean = LEAN.min((1.0 - squared).max(f64::MIN_POSITIVE).sqrt().recip());
        (squared - 1.0 / self.all as f64).max(0.0).sqrt() * mean
    }
}

/// From which sides a joint came, and by how much its readings scatter beyond their noise, unit of the reading; `None` where they do not, or
/// the session estimates the joint's friction.
fn left_at_rest(session: &Session, result: &EstimatorResult, joint: usize) -> Option<(Sides, f64)> {
    if session.terms.with_friction().contains(&joint) {
        return None;
    }
    let sides = Sides::of(session, joint)?;
    let fit = result.fit.as_ref()?.joints.iter().find(|fit| fit.joint == session.robot.chain.joints()[joint].name)?;
    Some(unexplained(session, fit, joint)).filter(|left| *left > 0.0).map(|left| (sides, left))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bias_holds_what_chance_does_not_even_out() {
        let held = |rising, all| Sides { rising, all }.held();
        // Ten and ten, and twelve and eight as chance would have it.
        assert!(held(10, 20) == 0.0 && held(12, 20) == 0.0);
        assert!((held(0, 400) - LEAN * (1.0 - 1.0 / 400.0f64).sqrt()).abs() < 1e-12 && held(0, 9) == held(9, 9));
        // Of 2 : 1, a third of the mean of what is left.
        let mean = (1.0f64 - 1.0 / 9.0).sqrt().recip();
        assert!((held(200, 300) - (1.0f64 / 9.0 - 1.0 / 300.0).sqrt() * mean).abs() < 1e-12);
        assert!((50..100).all(|k| held(k, 100) <= held(k + 1, 100)));
    }
}
