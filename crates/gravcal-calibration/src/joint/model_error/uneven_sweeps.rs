//! Slow sweeps that run faster one way than the other: viscous friction does not cancel in the mean of both ways.
//!
//! ```text
//!     h = f + v (u + d)/2        half the difference of both ways, at the speeds u up and d down: Coulomb and viscous friction
//!     m = τ + v (u − d)/2        their mean
//! ```
//!
//! How much of the friction is viscous, one pair of speeds does not tell; all of it makes the mean `h (u − d)/(u + d)` too large.

use std::collections::HashMap;

use gravcal_estimation::statistics::StatisticsError;
use gravcal_recording::Sweep;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::solved::Solved;

impl Solved {
    /// By how much each column of the problem may be off, one entry a joint, and what is told of it. Intervals include it then.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(in crate::joint) fn moved_by_uneven_sweeps(
        &self,
        session: &Session,
    ) -> Result<(Vec<Vec<f64>>, Option<String>), StatisticsError> {
        let (mut joints, mut errors) = (Vec::new(), Vec::new());
        for joint in 0..session.joints.len() {
            let shifts = shifts(session, joint);
            let of_joint = self.errors_of(session, |id| {
                let pose = &session.poses[id.pose];
                // Of both ways apart each has its own speed.
                let is_mean = pose.conditions.direction.get(joint).is_none_or(|direction| *direction == 0.0);
                let own = id.channel == joint && pose.sweep_label.is_some() && is_mean;
                if own { shifts.get(&(pose.table, pose.line)).copied().unwrap_or(0.0) } else { 0.0 }
            });
            if let Some(of_joint) = of_joint {
                joints.push(joint);
                errors.push(of_joint);
            }
        }
        let shifted = self.shifted_by(session, &errors)?;
        let telling = joints.iter().zip(&shifted).filter(|(_, shifted)| shifted.matters).map(|(joint, _)| *joint);
        let listed: Vec<String> = telling
            .map(|joint| {
                let largest = shifts(session, joint).into_values().map(f64::abs).fold(0.0, f64::max);
                format!("{} ({} {})", session.channel_name(joint), significant(largest, 2), session.channel_unit(joint))
            })
            .collect();
        let told = (!listed.is_empty()).then(|| {
            format!(
                "Sweeps run faster one way than the other, so that viscous friction does not cancel in their mean: it may be off, at most, by this \
                 much at {}. Intervals allow for it. Sweep both ways at one speed, or estimate the friction: sensor_models = [{{ kind = \
                 \"coulomb-friction\" }}, {{ kind = \"viscous-friction\" }}] in the [[joint]].",
                listed.join(", ")
            )
        });
        Ok((shifted.into_iter().map(|shifted| shifted.moved).collect(), told))
    }
}

/// By table and line of a pose: by how much the mean of both ways of a joint's sweeps may be off, unit of its reading.
fn shifts(session: &Session, joint: usize) -> HashMap<(usize, u64), f64> {
    let mut shifts = HashMap::new();
    for searched in session.fitted_recordings() {
        let sweeps = searched.sweeps.iter().flat_map(|sweeps| &sweeps.found).filter(|sweep| sweep.joint == joint);
        for sweep in sweeps {
            let Some(shift) = shift(sweep) else { continue };
            for bin in &sweep.bins {
                let line = bin.sides[0].line.min(bin.sides[1].line);
                shifts.insert((searched.table, line), shift);
            }
        }
    }
    shifts
}

/// `h (u − d)/(u + d)` of a sweep; nothing where its torque or its speeds are not known.
fn shift(sweep: &Sweep) -> Option<f64> {
    let (half, _) = sweep.half_difference()?;
    let speed = |side: usize| {
        let own = sweep.bins.iter().map(|bin| bin.sides[side].conditions.velocity.get(sweep.joint).copied());
        let own: Option<Vec<f64>> = own.collect();
        own.filter(|own| !own.is_empty()).map(|own| own.iter().sum::<f64>() / own.len() as f64)
    };
    let (up, down) = (speed(0)?, speed(1)?);
    let share = (up + down) / (up - down);
    (share.is_finite() && share.abs() < 1.0).then_some(half.value * share)
}

#[cfg(test)]
mod tests {
    use gravcal_recording::{Conditions, Reading, StaticPose, SweptBin};

    use super::*;

    /// A joint that takes 3 N·m and has viscous friction of 2 N·m·s, swept up and down at these speeds: the mean of both ways, less 3, is what may be off.
    #[test]
    fn friction_that_is_all_viscous_is_what_the_mean_is_off() {
        for [up, down] in [[0.1, 0.1], [0.3, 0.1], [0.05, 0.2]] {
            let side = |speed: f64| StaticPose {
                torque: vec![Some(Reading { value: 3.0 + 2.0 * speed, std: None })],
                conditions: Conditions { velocity: vec![speed], ..Conditions::default() },
                ..StaticPose::default()
            };
            let bins = vec![SweptBin { sides: [side(up), side(-down)] }; 3];
            let sweep = Sweep { joint: 0, bins, ..Sweep::default() };
            let mean: Vec<f64> = sweep.poses(false).filter_map(|pose| Some(pose.torque[0]?.value)).collect();
            assert!(mean.iter().all(|mean| (mean - 3.0 - shift(&sweep).unwrap()).abs() < 1e-12), "{mean:?}");
        }
    }
}
