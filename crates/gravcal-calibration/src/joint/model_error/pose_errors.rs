//! Errors that differ from pose to pose by more than noise of one size: joints are not where their sensors say (backlash, coarse encoders, joints
//! that do not hold), or torque sensors scatter more under more torque.
//!
//! Whitened residuals `r_p` of a pose then scatter by `σ² A` beside their noise: with `A = J Jᵀ`, `J` their slopes by the coordinates, or by turns of a body
//! without joints, where these are off by `δ ~ N(0, σ² I)`; with `A` the squares of the readings' torques where sensors scatter by a share `σ` of these. The score test
//! of `σ² = 0`, noise of each channel of unknown size, is
//!
//! ```text
//!     T = Σ_p (r_pᵀ Q_p r_p − tr(M_p Q_p)),   Q = A − diag(b),   b_c = Σ_{i∈c} A_ii M_ii² / Σ_{i∈c} M_ii²
//!     var T = 2 Σ_p tr(Q_p M_p Q_p M_p),      σ² ≈ T / Σ_p tr(Q_p M_p A_p M_p)
//! ```
//!
//! with `M` the residual maker among the rows of a pose (what poses have in common is little where they are many) and residuals by what their channel
//! scatters by: what is stated of the noise does not matter. Such errors do not average out as
//! noise does: intervals from noise of one size are too narrow, and tests on residuals find what is not there.

use std::collections::BTreeMap;

use gravcal_dynamics::JointKind;
use gravcal_estimation::statistics::{ResidualMaker, StatisticsError};
use gravcal_estimation::{EvaluateError, Loss};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{ReadingId, Session};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use crate::joint::building::displacements::predictions;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::joint::variables::State;
use crate::judgement::too_large;

/// Standard deviations of chance beyond which the errors are there.
const SURE: f64 = 4.0;
/// Half of the step over which slopes are taken, rad.
const STEP: f64 = 1e-4;

/// What errs from pose to pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PoseErrors {
    /// Joints are so far from where their sensors say, root mean square, rad.
    Positions(f64),
    /// Torque sensors scatter by this share of the torque.
    Torques(f64),
    /// A body without joints is turned so far from where its orientations say, root mean square about each axis, rad.
    Orientations(f64),
}

impl Solved {
    /// What errs from pose to pose; nothing where no readings show it, or it is an unknown already. Motion has errors of its own.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(crate) fn pose_errors(&self, session: &Session) -> Result<Option<PoseErrors>, StatisticsError> {
        let known = !self.built.variables.position_unknowns.is_empty() || session.has_windows();
        let minimum = self.estimate.termination.converged()
            && self.built.loss == Loss::None
            && self.readings().order == Order::Together
            && self.judged_problem().rows() > self.analysis.rank()
            && self.may_leave_out_poses();
        if known || !minimum || too_large(self) {
            return Ok(None);
        }
        let maker = ResidualMaker::new(&self.solution())?;
        let scales = self.to_unit_noise(session, &maker);
        if session.poses.iter().any(|pose| pose.orientation.is_some()) {
            let turned = self.score(&maker, &scales, &self.of_orientations(session, &scales)?);
            return Ok(turned.map(|turned| PoseErrors::Orientations(turned.size)));
        }
        let positions = self.score(&maker, &scales, &self.of_positions(session, &scales)?);
        let torques = self.score(&maker, &scales, &self.of_torques(session, &scales)?);
        Ok(match (positions, torques) {
            (Some(positions), Some(torques)) if torques.deviations > positions.deviations => {
                Some(PoseErrors::Torques(torques.size))
            }
            (Some(positions), _) => Some(PoseErrors::Positions(positions.size)),
            (None, torques) => torques.map(|torques| PoseErrors::Torques(torques.size)),
        })
    }

    /// The score test; nothing where chance may be all.
    fn score(&self, maker: &ResidualMaker, scales: &[f64], poses: &[OfPose]) -> Option<Scored> {
        let shared = self.shares_of_channels(scales.len(), poses, maker);
        let channel = |row: &usize| self.built.rows[*row].channel;
        let (mut score, mut variance, mut scale) = (0.0, 0.0, 0.0);
        for OfPose { rows, a } in poses {
            let m = DMatrix::from_fn(rows.len(), rows.len(), |i, j| maker.entry(rows[i], rows[j]));
            let b = rows.iter().map(|row| shared[channel(row)]);
            let q = a - DMatrix::from_diagonal(&DVector::from_iterator(rows.len(), b));
            let residuals = rows.iter().map(|row| scales[channel(row)] * maker.residuals()[*row]);
            let r = DVector::from_iterator(rows.len(), residuals);
            let (qm, am) = (&q * &m, a * &m);
            score += r.dot(&(&q * &r)) - qm.trace();
            variance += 2.0 * (&qm * &qm).trace();
            scale += (&qm * &am).trace();
        }
        let deviations = score / variance.sqrt();
        (scale > 0.0 && deviations > SURE).then(|| Scored { deviations, size: (score / scale).sqrt() })
    }

    /// What makes the residuals of each channel those of unit noise, whatever is stated of it.
    fn to_unit_noise(&self, session: &Session, maker: &ResidualMaker) -> Vec<f64> {
        let mut sums = vec![[0.0; 2]; session.channel_count()];
        for ((id, r), m) in self.built.rows.iter().zip(maker.residuals()).zip(maker.diagonal()) {
            let [squares, freedom] = &mut sums[id.channel];
            *squares += r * r;
            *freedom += m;
        }
        let scale = |[squares, freedom]: [f64; 2]| {
            if squares > 0.0 && freedom > 0.0 { (freedom / squares).sqrt() } else { 1.0 }
        };
        sums.into_iter().map(scale).collect()
    }

    /// `J Jᵀ` of each pose.
    fn of_positions(&self, session: &Session, scales: &[f64]) -> Result<Vec<OfPose>, EvaluateError> {
        let chain = session.robot.chain.joints().iter().enumerate();
        let turning = chain.filter(|(_, joint)| joint.kind != JointKind::Prismatic);
        let slope = |joint: usize| {
            let slope = self.slope_of_coordinate(joint, self.built.rows.len())?;
            Ok(slope.iter().zip(&self.built.rows).map(|(slope, id)| slope * scales[id.channel]).collect())
        };
        let slopes: Vec<Vec<f64>> = turning.map(|(joint, _)| slope(joint)).collect::<Result<_, EvaluateError>>()?;
        Ok(self.by_pose(|i, j| slopes.iter().map(|slope| slope[i] * slope[j]).sum()))
    }

    /// The same of a body that is turned about each axis of the base.
    fn of_orientations(&self, session: &Session, scales: &[f64]) -> Result<Vec<OfPose>, EvaluateError> {
        let state = self.state(&State::nominal(session));
        let read = |session: &Session| predictions(session, self.readings(), &state, &session.robot.chain);
        let here = read(session)?;
        let slope = |axis: usize| {
            let turn = Rotation3::new(Vector3::ith(axis, STEP));
            let mut turned = session.clone();
            for orientation in turned.poses.iter_mut().filter_map(|pose| pose.orientation.as_mut()) {
                let other = turn.matrix() * Matrix3::from_fn(|row, column| orientation[row][column]);
                *orientation = std::array::from_fn(|row| std::array::from_fn(|column| other[(row, column)]));
            }
            let there = read(&turned)?;
            let of_row = |id: &ReadingId| {
                let by = (there[id.pose][id.channel] - here[id.pose][id.channel]) / STEP;
                scales[id.channel] * by / self.readings().std(session, *id)
            };
            Ok(self.built.rows.iter().map(of_row).collect())
        };
        let slopes: Vec<Vec<f64>> = (0..3).map(slope).collect::<Result<_, EvaluateError>>()?;
        Ok(self.by_pose(|i, j| slopes.iter().map(|slope| slope[i] * slope[j]).sum()))
    }

    /// The squares of what gravity makes each sensor read, in standard deviations.
    fn of_torques(&self, session: &Session, scales: &[f64]) -> Result<Vec<OfPose>, EvaluateError> {
        let readings = self.gravity_readings(session)?;
        let joints = session.joints.len();
        let in_noise = |row: usize| match self.built.rows[row] {
            id if id.channel < joints => scales[id.channel] * readings[row] / self.readings().std(session, id),
            _ => 0.0,
        };
        Ok(self.by_pose(|i, j| if i == j { in_noise(i).powi(2) } else { 0.0 }))
    }

    /// What a step of a joint's coordinate does to the whitened residuals of the readings, by differences: the offset may be fixed, and then has no
    /// column. Zeros follow, up to so many rows.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(crate) fn slope_of_coordinate(&self, joint: usize, rows: usize) -> Result<Vec<f64>, EvaluateError> {
        let offset = self.built.variables.sensors[joint][SensorParameter::PositionOffset as usize];
        self.slope(rows, STEP, |values, by| values.set(offset, &[values.scalar(offset) + by]))
    }

    /// The rows of each pose, with `A` between any two of them.
    fn by_pose(&self, a: impl Fn(usize, usize) -> f64) -> Vec<OfPose> {
        let mut poses: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        self.built.rows.iter().enumerate().for_each(|(row, id)| poses.entry(id.pose).or_default().push(row));
        let with_a = |rows: Vec<usize>| {
            let a = DMatrix::from_fn(rows.len(), rows.len(), |i, j| a(rows[i], rows[j]));
            OfPose { rows, a }
        };
        poses.into_values().map(with_a).collect()
    }

    /// `b`, by channel.
    fn shares_of_channels(&self, channels: usize, poses: &[OfPose], maker: &ResidualMaker) -> Vec<f64> {
        let mut sums = vec![[0.0; 2]; channels];
        for OfPose { rows, a } in poses {
            for (place, row) in rows.iter().enumerate() {
                let weight = maker.entry(*row, *row).powi(2);
                let [above, below] = &mut sums[self.built.rows[*row].channel];
                *above += weight * a[(place, place)];
                *below += weight;
            }
        }
        sums.into_iter().map(|[above, below]| if below > 0.0 { above / below } else { 0.0 }).collect()
    }
}

/// What the test says: by how many standard deviations of chance, and `σ`.
struct Scored {
    deviations: f64,
    size: f64,
}

/// Rows of one pose.
struct OfPose {
    rows: Vec<usize>,
    a: DMatrix<f64>,
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::session::UncertaintyChoice;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    use super::*;

    /// What is found where the joints of each pose are off by so much, rad.
    fn found(seed: u64, off: f64, change: impl Fn(&mut Session)) -> Option<PoseErrors> {
        let mut session = sarcos_shoulder().session(seed);
        session.uncertainty = UncertaintyChoice::Noise;
        change(&mut session);
        let mut random = Pcg64::seed_from_u64(seed);
        let gains: Vec<f64> =
            (0..3).map(|joint| session.joints[joint].of(SensorParameter::PositionGain).nominal).collect();
        for position in session.poses.iter_mut().map(|pose| &mut pose.position) {
            let errors = gains.iter().map(|gain| off / gain * random.sample::<f64, _>(StandardNormal));
            position.iter_mut().zip(errors).for_each(|(position, error)| *position += error);
        }
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        solved.pose_errors(&session).unwrap()
    }

    fn without_std(session: &mut Session) {
        session
            .poses
            .iter_mut()
            .flat_map(|pose| pose.torque.iter_mut().flatten())
            .for_each(|reading| reading.std = None);
    }

    #[test]
    fn joints_that_are_off_from_pose_to_pose_are_found_with_how_far() {
        let off = 0.3f64.to_radians();
        for seed in 0..4 {
            for std in [found(seed, off, |_| {}), found(seed, off, without_std)] {
                let Some(PoseErrors::Positions(std)) = std else { panic!("seed {seed}: {std:?}") };
                assert!((std / off - 1.0).abs() < 0.3, "{} deg", std.to_degrees());
            }
        }
    }

    /// Each torque is off by 2 % of it, one standard deviation.
    #[test]
    fn torques_that_scatter_by_a_share_are_found_with_the_share() {
        let gains = sarcos_shoulder().truth.sensors;
        for seed in 0..4 {
            let mut random = Pcg64::seed_from_u64(seed);
            let noises: Vec<f64> = (0..3000).map(|_| random.sample(StandardNormal)).collect();
            let wavers = |session: &mut Session| {
                for (number, pose) in session.poses.iter_mut().enumerate() {
                    for (joint, reading) in pose.torque.iter_mut().enumerate() {
                        let Some(reading) = reading else { continue };
                        let torque = reading.value - gains[joint][SensorParameter::TorqueBias as usize];
                        reading.value += 0.02 * torque * noises[(3 * number + joint) % noises.len()];
                    }
                }
            };
            let found = found(seed, 0.0, wavers);
            let Some(PoseErrors::Torques(share)) = found else { panic!("seed {seed}: {found:?}") };
            assert!((share / 0.02 - 1.0).abs() < 0.3, "{share}");
        }
    }

    /// Noise alone, however large beside what is stated, is none of it.
    #[test]
    fn noise_of_any_size_is_no_error_that_torques_share() {
        for seed in 0..6 {
            assert_eq!(found(seed, 0.0, |_| {}), None);
            assert_eq!(found(seed, 0.0, without_std), None);
            let understated = |session: &mut Session| {
                let readings = session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten());
                readings.for_each(|reading| reading.std = reading.std.map(|std| 0.1 * std));
            };
            assert_eq!(found(seed, 0.0, understated), None);
        }
    }
}
