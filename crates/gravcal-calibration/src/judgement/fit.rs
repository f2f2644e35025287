//! What the residuals of the torque readings say.

use gravcal_estimation::Estimate;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::joint::{JointProblem, Readings};
use crate::result::{Fit, HeldOut, JointFit};
use crate::session::Session;

/// Residuals of torque readings, collected by joint.
#[derive(Clone, Debug)]
pub(crate) struct JointResiduals {
    /// `(residual, assumed standard deviation)` in the unit of the reading, by joint.
    by_joint: Vec<Vec<(f64, f64)>>,
}

impl JointResiduals {
    /// From whitened residuals whose first rows are the given readings.
    pub fn new(session: &Session, readings: &Readings, rows: &[(usize, usize)], whitened: &[f64]) -> Self {
        let mut by_joint = vec![Vec::new(); session.joints.len()];
        for ((pose, joint), r) in rows.iter().zip(whitened) {
            let std = readings.std(session, *pose, *joint);
            by_joint[*joint].push((r * std, std));
        }
        JointResiduals { by_joint }
    }

    fn tell(&self, session: &Session) -> Vec<JointFit> {
        let estimated = session.noise_estimated();
        self.by_joint
            .iter()
            .enumerate()
            .filter(|(_, rows)| !rows.is_empty())
            .map(|(joint, rows)| {
                let count = rows.len() as f64;
                JointFit {
                    joint: session.robot.chain.joints()[joint].name.clone(),
                    unit: session.joints[joint].torque_unit.map_or_else(String::new, |u| u.to_string()),
                    readings: rows.len(),
                    rms: (rows.iter().map(|(r, _)| r * r).sum::<f64>() / count).sqrt(),
                    largest: rows.iter().fold(0.0, |m, (r, _)| m.max(r.abs())),
                    noise_std: rows.iter().map(|(_, std)| std).sum::<f64>() / count,
                    noise_estimated: estimated[joint],
                }
            })
            .collect()
    }
}

/// Tells the fit of a solved problem that determined so many parameters.
pub(crate) fn fit(
    session: &Session,
    readings: &Readings,
    posed: &JointProblem,
    estimate: &Estimate,
    whitened: &[f64],
    fitted: usize,
) -> Fit {
    let degrees_of_freedom = posed.problem.rows().saturating_sub(fitted);
    let chi_squared = 2.0 * estimate.cost;
    let stated = !session.noise_estimated().iter().any(|e| *e);
    let p_value = (stated && degrees_of_freedom > 0)
        .then(|| ChiSquared::new(degrees_of_freedom as f64).ok())
        .flatten()
        .map(|distribution| distribution.sf(chi_squared));
    Fit {
        chi_squared,
        degrees_of_freedom,
        p_value,
        joints: JointResiduals::new(session, readings, &posed.rows, whitened).tell(session),
        held_out: None,
    }
}

/// Tells how well poses were predicted that a fit did not see; `whitened` are the residuals of exactly `rows`.
pub(crate) fn held_out(session: &Session, readings: &Readings, rows: &[(usize, usize)], whitened: &[f64]) -> HeldOut {
    let mut poses: Vec<usize> = rows.iter().map(|(pose, _)| *pose).collect();
    poses.dedup();
    HeldOut {
        poses: poses.len(),
        chi_squared: whitened[..rows.len()].iter().map(|r| r * r).sum(),
        readings: rows.len(),
        joints: JointResiduals::new(session, readings, rows, whitened).tell(session),
    }
}
