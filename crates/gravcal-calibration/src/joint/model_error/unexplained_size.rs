//! How large unexplained errors are, beside the noise and beside what gravity makes a sensor read.
//!
//! Beside the noise of means they may be a hundred times as large, and all is well: the longer a dwell, the less noise has its mean. What
//! they spoil is told by their size beside gravity's torque on the joint itself (standard deviation over the poses). A joint that carries
//! next to nothing spoils nothing: it is held against a tenth of what the joint of its kind carries that carries most. The first joint of an upright
//! arm has the friction of the second and nothing to carry: where its errors are like those of a neighbour that gravity explains, they are friction, too.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{ReadingId, Session, UnexplainedError};

use crate::joint::solved::Solved;
use crate::judgement::Judgement;
use crate::result::UnexplainedResult;

/// Share of what the like channel reads of gravity that reads most of it: no channel is held against less.
const LEAST_SHARE: f64 = 0.1;
/// From this share of what they are held against on, errors contradict the model.
pub(in crate::joint) const LARGE: f64 = 0.1;
/// From this share of what gravity makes a sensor read on, errors are told.
pub(in crate::joint) const WARNING: f64 = 0.03;
/// Beyond this share of the torques of gravity residuals explain nothing.
const NOTHING_EXPLAINED: f64 = 1.0;
/// Errors of neighbours up to this ratio are alike: their gears are.
const ALIKE: f64 = 2.0;

/// Errors of a channel, or noise that was found in it, beside what gravity makes it read.
#[derive(Clone, Copy, Debug)]
pub(in crate::joint) struct BesideGravity {
    /// Their standard deviation, unit of the reading.
    pub std: f64,
    /// Of what gravity makes the channel read, unit of the reading.
    pub gravity_std: f64,
    /// Of what they are held against.
    pub share: f64,
}

impl BesideGravity {
    /// Errors that a result tells; nothing where nothing feels gravity.
    pub fn of(size: UnexplainedResult) -> Option<BesideGravity> {
        let UnexplainedResult { std, gravity_std, share_of_gravity, .. } = size;
        Some(BesideGravity { std, gravity_std, share: share_of_gravity? })
    }
}

/// Which joints err no more than a neighbour does whose readings gravity explains, and carry next to nothing beside others. `errors`: by channel.
pub(in crate::joint) fn err_as_neighbours(session: &Session, errors: &[Option<BesideGravity>]) -> Vec<bool> {
    let of_joints = &errors[..session.joints.len()];
    let explained = |own: &Option<BesideGravity>| own.filter(|own| own.share <= LARGE).map_or(0.0, |own| own.std);
    let explained: Vec<f64> = of_joints.iter().map(explained).collect();
    let is_alike = |(channel, own): (usize, &Option<BesideGravity>)| {
        own.is_some_and(|BesideGravity { std, gravity_std, share }| {
            let held_against = std / share;
            channel < explained.len()
                && held_against > gravity_std
                && std <= ALIKE * session.of_nearest(&explained, channel)
        })
    };
    errors.iter().enumerate().map(is_alike).collect()
}

impl Solved {
    /// Whether errors were found that are large beside what gravity makes their own channel read: they may excuse a mistake in the session.
    ///
    /// # Errors
    /// As [`Solved::unexplained_sizes`].
    pub(in crate::joint) fn has_large_unexplained_errors(&self, session: &Session) -> Result<bool, EvaluateError> {
        let sizes = self.unexplained_sizes(session)?;
        Ok(sizes.into_iter().flatten().any(|size| size.std > WARNING * size.gravity_std))
    }

    /// Whether errors or noise were found that are so large beside what gravity makes any channel read that they contradict the model.
    ///
    /// # Errors
    /// As [`Solved::unexplained_sizes`].
    pub(in crate::joint) fn contradicts_model(&self, session: &Session) -> Result<bool, EvaluateError> {
        let errors = self.unexplained_sizes(session)?.into_iter().map(|size| BesideGravity::of(size?));
        let noise = self.noise_beside_gravity(session)?;
        let both: Vec<Option<BesideGravity>> = errors.zip(noise).map(|(errors, noise)| errors.or(noise)).collect();
        let excused = err_as_neighbours(session, &both);
        Ok(both.iter().zip(excused).any(|(own, excused)| !excused && own.is_some_and(|own| own.share > LARGE)))
    }

    /// Of each channel where the session has such errors.
    pub(crate) fn unexplained_sizes(&self, session: &Session) -> Result<Vec<Option<UnexplainedResult>>, EvaluateError> {
        let errors = session.unexplained_errors();
        if errors.iter().all(|error| *error == UnexplainedError::Absent) {
            return Ok(vec![None; errors.len()]);
        }
        let (gravity, noise) = (self.gravity_std(session)?, self.noise_by_channel(session));
        let references = references(session, &gravity);
        let size = |(channel, error): (usize, &UnexplainedError)| {
            let noise = noise[channel].filter(|_| *error != UnexplainedError::Absent)?;
            let std = (self.readings().unexplained[channel] + self.readings().lasting_variance(channel)).sqrt();
            let reference = references[channel];
            Some(UnexplainedResult {
                std,
                estimated: *error == UnexplainedError::Estimated,
                times_noise: std / noise,
                gravity_std: gravity[channel],
                share_of_gravity: (reference > 0.0).then(|| std / reference),
            })
        };
        Ok(errors.iter().enumerate().map(size).collect())
    }

    /// Noise that was found in each channel whose readings state none.
    pub(in crate::joint) fn noise_beside_gravity(
        &self,
        session: &Session,
    ) -> Result<Vec<Option<BesideGravity>>, EvaluateError> {
        let (noise, found) = (self.noise_by_channel(session), session.noise_estimated());
        let gravity = self.gravity_std(session)?;
        let references = references(session, &gravity);
        let of_channel = |channel: usize| {
            let (noise, reference) = (noise[channel].filter(|_| found[channel])?, references[channel]);
            let std = noise.hypot(self.readings().lasting_variance(channel).sqrt());
            let beside = BesideGravity { std, gravity_std: gravity[channel], share: std / reference };
            (reference > 0.0).then_some(beside)
        };
        Ok((0..session.channel_count()).map(of_channel).collect())
    }

    /// Whether residuals are larger than the torques of gravity, all joints counted together: then they are no noise of anything, the model is another
    /// robot's, or the arm moves. `judgement`: what is determined of the gains.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint) fn leaves_all_unexplained(
        &self,
        session: &Session,
        judgement: &Judgement,
    ) -> Result<bool, EvaluateError> {
        let gain = |joint: usize| self.gain_or_nominal(session, judgement, joint);
        Ok(self.residual_beside_gravity(session, gain)?.is_some_and(|share| share > NOTHING_EXPLAINED))
    }

    /// The gain of a torque sensor; the nominal one where the readings leave it open.
    pub(in crate::joint) fn gain_or_nominal(&self, session: &Session, judgement: &Judgement, joint: usize) -> f64 {
        let id = ParameterId::Sensor(joint, SensorParameter::TorqueGain);
        match judgement.determines(id) {
            true => self.estimate.values.scalar(self.built.variables.block(id)),
            false => session.prior(id).nominal,
        }
    }

    /// Root mean square of the residuals of all torque readings over that of gravity's torque in them, both in N·m (N where a joint slides);
    /// nothing where no torque is read. `gain`: of each joint's torque sensor, by which its readings count beside
    /// those of others; one that the readings leave open may come out at next to nothing, and is not for its estimate to tell.
    fn residual_beside_gravity(
        &self,
        session: &Session,
        gain: impl Fn(usize) -> f64,
    ) -> Result<Option<f64>, EvaluateError> {
        let residuals = self.built.problem.residuals(&self.estimate.values)?;
        let rows = self.built.rows.iter().zip(self.gravity_readings(session)?).zip(residuals);
        let (mut left, mut gravity) = (0.0, 0.0);
        for ((id, reading), residual) in rows.filter(|((id, _), _)| id.channel < session.joints.len()) {
            left += (residual * self.readings().std(session, *id) / gain(id.channel)).powi(2);
            gravity += (reading / gain(id.channel)).powi(2);
        }
        Ok((gravity > 0.0).then(|| (left / gravity).sqrt()))
    }

    /// Standard deviation over its readings of what gravity makes each channel read, unit of the reading.
    fn gravity_std(&self, session: &Session) -> Result<Vec<f64>, EvaluateError> {
        let mut read = vec![Vec::new(); session.channel_count()];
        for (ReadingId { channel, .. }, reading) in self.built.rows.iter().zip(self.gravity_readings(session)?) {
            read[*channel].push(reading);
        }
        Ok(read.iter().map(|read| spread(read)).collect())
    }

    /// What gravity makes a sensor read, by row, unit of the reading: what is left of the model's predictions when those of sensors without
    /// gain are subtracted.
    pub(crate) fn gravity_readings(&self, session: &Session) -> Result<Vec<f64>, EvaluateError> {
        let (problem, values) = (&self.built.problem, &self.estimate.values);
        let mut without = values.clone();
        let joints = (0..session.joints.len()).map(|joint| ParameterId::Sensor(joint, SensorParameter::TorqueGain));
        let instruments = session.instruments.iter().flat_map(|instrument| instrument.gain_parameters());
        for id in joints.chain(instruments.map(ParameterId::Further)) {
            without.set(self.built.variables.block(id), &[0.0]);
        }
        let (with, without) = (problem.residuals(values)?, problem.residuals(&without)?);
        let reading =
            |(id, (with, without)): (&ReadingId, (&f64, &f64))| (with - without) * self.readings().std(session, *id);
        Ok(self.built.rows.iter().zip(with.iter().zip(&without)).map(reading).collect())
    }

    /// Root mean square of the readings' own noise, by channel; nothing where nothing is read.
    fn noise_by_channel(&self, session: &Session) -> Vec<Option<f64>> {
        let mut squares = vec![Vec::new(); session.channel_count()];
        for id in &self.built.rows {
            squares[id.channel].push(self.readings().own_std(session, *id).powi(2));
        }
        let mean = |squares: &Vec<f64>| squares.iter().sum::<f64>() / squares.len() as f64;
        squares.iter().map(|own| (!own.is_empty()).then(|| mean(own).sqrt())).collect()
    }
}

/// What the errors of each channel are held against: what gravity makes it read, or a share of what it makes the like channel read.
fn references(session: &Session, gravity: &[f64]) -> Vec<f64> {
    let of_channel = |channel: usize| gravity[channel].max(LEAST_SHARE * most_alike(session, gravity, channel));
    (0..gravity.len()).map(of_channel).collect()
}

/// The largest of channels of the same kind, in the unit of this one.
fn most_alike(session: &Session, gravity: &[f64], channel: usize) -> f64 {
    let Some((instrument, axis)) = session.axis(channel) else {
        let joints = session.robot.chain.joints();
        let gain = |joint: usize| session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
        let alike = (0..joints.len()).filter(|joint| joints[*joint].kind == joints[channel].kind);
        return alike.map(|joint| gravity[joint] / gain(joint)).fold(0.0, f64::max) * gain(channel);
    };
    let alike = (0..gravity.len()).filter(|other| {
        session.axis(*other).is_some_and(|(owner, other)| owner == instrument && other / 3 == axis / 3)
    });
    alike.map(|other| gravity[other]).fold(0.0, f64::max)
}

/// Standard deviation; 0 of none.
pub(in crate::joint) fn spread(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{sarcos_shoulder, sarcos_with_instruments};

    fn near(found: &[f64], expected: &[f64]) -> bool {
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs())
    }

    /// In torque: sensors of other gains are compared by what they carry.
    #[test]
    fn a_joint_that_carries_next_to_nothing_is_held_against_a_tenth_of_the_one_that_carries_most() {
        let mut session = sarcos_shoulder().session(0);
        for (joint, gain) in [1.0, 10.0, -100.0].into_iter().enumerate() {
            session.joints[joint].parameters[SensorParameter::TorqueGain as usize].nominal = gain;
        }
        // 0.5, 20 and 40 N·m.
        let found = references(&session, &[0.5, 200.0, 4000.0]);
        assert!(near(&found, &[4.0, 200.0, 4000.0]), "{found:?}");
        assert_eq!(references(&session, &[0.0; 3]), [0.0; 3]);
    }

    /// Joint 1 errs as joint 2, and joint 3 by more than twice as much as joint 2, which is its neighbour and which gravity explains.
    #[test]
    fn a_joint_that_carries_next_to_nothing_may_err_as_its_neighbour_does() {
        let mut session = sarcos_shoulder().session(0);
        session.joints[1].parameters[SensorParameter::TorqueGain as usize].nominal =
            10.0 * session.nominal(ParameterId::Sensor(0, SensorParameter::TorqueGain));
        session.joints[2].parameters[SensorParameter::TorqueGain as usize].nominal =
            session.nominal(ParameterId::Sensor(0, SensorParameter::TorqueGain));
        let beside =
            |std: f64, gravity_std: f64, against: f64| Some(BesideGravity { std, gravity_std, share: std / against });
        let errors = [beside(0.7, 1.0, 5.0), beside(5.0, 500.0, 500.0), beside(1.1, 2.0, 5.0)];
        assert_eq!(err_as_neighbours(&session, &errors), [true, false, false]);
        // One that carries as much as it is held against has no such excuse, nor has one whose neighbour errs by as large a share.
        let carries = [beside(0.7, 5.0, 5.0), errors[1], errors[2]];
        assert_eq!(err_as_neighbours(&session, &carries), [false; 3]);
        let both = [errors[0], beside(60.0, 500.0, 500.0), None];
        assert_eq!(err_as_neighbours(&session, &both), [false; 3]);
    }

    /// Forces with forces, moments with moments, and neither with joints nor with another instrument.
    #[test]
    fn an_axis_is_held_against_axes_of_its_kind() {
        let session = sarcos_with_instruments().session(0);
        let gravity = [1e6, 1e6, 1e6, 0.1, 50.0, 2.0, 0.01, 0.2, 4.0, 1.0, 0.001, 0.5];
        let found = references(&session, &gravity);
        assert!(near(&found[3..], &[5.0, 50.0, 5.0, 0.4, 0.4, 4.0, 1.0, 0.1, 0.5]), "{found:?}");
    }
}
