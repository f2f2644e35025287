//! A session as it is, or as it would be after some addition, at nominal values: what a judgement looks at.

use gravcal_recording::{Orientation, Reading};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{InertiaPrior, Pose, PoseTable, ReadingId, Session, UnexplainedError};
use nalgebra::{Quaternion, UnitQuaternion};

use super::judged::{NominalVerdict, judge_at, predicted_ranges};
use crate::joint::{EstimateError, MeasurementSet, Signals, State, build_with_constraints, select};

/// An addition is judged beside about so many poses of the session, which stand for all of them.
const POSES: usize = 300;

/// Errors that the noise does not explain, where a fit will tell how large they are: so large a share of the torque that a joint carries
/// at most. Friction that is left at rest makes errors of most arms at least so large.
pub(super) const ROUGH: f64 = 1e-3;

/// The same of each channel, unit of its reading; zero where such errors are stated, or there are none.
fn rough_errors(session: &Session, readings: &MeasurementSet, values: &State) -> Result<Vec<f64>, EstimateError> {
    let errors = session.unexplained_errors();
    let mut rough = vec![0.0; errors.len()];
    if !errors.contains(&UnexplainedError::Estimated) {
        return Ok(rough);
    }
    let ranges = predicted_ranges(session, &build_with_constraints(session, readings, values)?)?;
    for (channel, [low, high]) in ranges.into_iter().enumerate() {
        if errors[channel] == UnexplainedError::Estimated && high > low {
            rough[channel] = ROUGH * 0.5 * (high - low);
        }
    }
    Ok(rough)
}

/// One of a sequence of orientations that fill all turns evenly: Shoemake's map of the unit cube to unit quaternions (*Uniform
/// random rotations*, 1992), at the multiples, modulo one, of the powers of the root of `x⁴ = x + 1`.
fn turned_every_way(index: usize) -> Orientation {
    let root = (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(0.25));
    let [share, first, second] = [1, 2, 3].map(|power| (0.5 + (index as f64 + 1.0) * root.powi(-power)).fract());
    let [first, second] = [first, second].map(|share| std::f64::consts::TAU * share);
    let (a, b) = ((1.0 - share).sqrt(), share.sqrt());
    let quaternion = Quaternion::new(a * first.sin(), a * first.cos(), b * second.sin(), b * second.cos());
    let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| rotation[(row, column)]))
}

/// A session, real or not, with the values at which it is judged. Its readings count, their values do not.
#[derive(Clone, Debug)]
pub(crate) struct Hypothetical {
    /// The session.
    pub session: Session,
    /// Where it is judged.
    pub values: State,
    /// Whether a fit finds the size of the readings' errors from their residuals.
    pub noise_found: bool,
    /// Standard deviation of a further reading, by channel; `None` where none of the channel is read.
    pub noise: Vec<Option<f64>>,
}

impl Hypothetical {
    /// The session as it is.
    ///
    /// # Errors
    /// Where the joint problem cannot be built.
    pub fn now(session: &Session) -> Result<Hypothetical, EstimateError> {
        let readings = select(session, Signals::All);
        let values = State::nominal(session);
        let rough = rough_errors(session, &readings, &values)?;
        let noise = |channel: usize| {
            let all = (0..session.poses.len()).map(|pose| ReadingId { pose, channel });
            let read = all.filter(|id| session.reading(*id).is_some());
            let stds: Vec<f64> = read.map(|id| readings.std(session, id).hypot(rough[channel])).collect();
            (!stds.is_empty()).then(|| stds.iter().sum::<f64>() / stds.len() as f64)
        };
        let noise: Vec<Option<f64>> = (0..session.channel_count()).map(noise).collect();
        let noise_found = readings.noise_found(session);
        let mut session = session.clone();
        for pose in 0..session.poses.len() {
            for (channel, noise) in noise.iter().enumerate() {
                if let Some(reading) = session.reading_mut(ReadingId { pose, channel }) {
                    reading.std = reading.std.map(|std| std.hypot(rough[channel])).or(*noise);
                }
            }
        }
        Ok(Hypothetical { values, session, noise_found, noise })
    }

    /// The same with fewer poses, each of so many times the weight that they say about as much: every so many of each load. All are
    /// kept where moments are described by sweep: a sweep must stay one.
    pub fn thinned(mut self) -> Hypothetical {
        if self.session.inertia == InertiaPrior::Sweep {
            return self;
        }
        let stride = self.session.poses.len().div_ceil(POSES).max(1);
        let mut counts = vec![0; self.session.loads.len() + 1];
        self.session.poses.retain(|pose| {
            let count: &mut usize = &mut counts[pose.load.map_or(0, |load| load + 1)];
            *count += 1;
            (*count - 1).is_multiple_of(stride)
        });
        for pose in &mut self.session.poses {
            for reading in pose.torque.iter_mut().chain(&mut pose.instruments).flatten() {
                reading.std = reading.std.map(|std| std / (stride as f64).sqrt());
            }
        }
        self
    }

    /// What can be known.
    pub fn judge(&self) -> Result<NominalVerdict, EstimateError> {
        judge_at(&self.session, &select(&self.session, Signals::All), (&self.values, self.noise_found))
    }

    /// Adds poses with a load (or none) at the given coordinates, rad or m (a body without joints is turned every way), in which
    /// everything is read that the session reads. The conditions are those of the session's poses, one after the other.
    pub fn record(&mut self, load: Option<usize>, coordinates: Vec<Vec<f64>>) {
        let position = |(joint, coordinate): (usize, &f64)| {
            let sensor = self.values.sensors[joint];
            (coordinate - sensor[SensorParameter::PositionOffset as usize])
                / sensor[SensorParameter::PositionGain as usize]
        };
        let reading = |std: &Option<f64>| std.map(|std| Reading { value: 0.0, std: Some(std) });
        let (torque, instruments) = self.noise.split_at(self.session.joints.len());
        let before = self.session.poses.len().max(1);
        let body = self.session.joints.is_empty();
        let pose = |(index, coordinates): (usize, &Vec<f64>)| Pose {
            table: self.session.tables.len(),
            line: index as u64,
            sweep_label: None,
            load,
            position: coordinates.iter().enumerate().map(position).collect(),
            orientation: body.then(|| turned_every_way(index)),
            torque: torque.iter().map(reading).collect(),
            instruments: instruments.iter().map(reading).collect(),
            conditions: self.session.poses.get(index % before).map_or_else(Default::default, |p| p.conditions.clone()),
            course: None,
        };
        let poses: Vec<Pose> = coordinates.iter().enumerate().map(pose).collect();
        self.session.poses.extend(poses);
        let path = format!("supposed-{}", self.session.tables.len()).into();
        self.session.tables.push(PoseTable { path, load, swept: None, step: None });
    }

    /// True coordinates of the joints in a pose, rad or m, at nominal values.
    pub fn coordinates(&self, pose: &Pose) -> Vec<f64> {
        self.session.terms.coordinates(&pose.position, &pose.conditions, &self.values)
    }
}
