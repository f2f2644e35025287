//! What columns of terms are made of: the readings of a fit, and what moves them.

use std::collections::{BTreeMap, BTreeSet};

use gravcal_dynamics::JointKind;
use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_recording::file_name;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::sensors::Need;
use gravcal_robot_model::session::{Pose, ReadingId, Session};

use super::base::TurnedGravity;
use super::clock_rate::fast_clock;
use super::delayed;
use super::loads::{StatedLoad, stated_distances, stated_loads};
use super::predicted_axes::PredictedAxes;
use super::predicted_torques::PredictedTorques;
use super::pull::pulled;
use super::rows::ReadingRow;
use super::uneven_friction::modelled_friction;
use crate::joint::{DisplacedJoints, Solved, sides_by_order};

/// The channel of what all joints do.
pub const ALL_JOINTS: &str = "all joints";
/// Gains, gravity and zeros of encoders change between recordings and not between sweeps: more tables are not compared by them.
pub const MOST_RECORDINGS: usize = 6;
/// Rows of a table that can be told to drift.
const DRIFTING: usize = 4;

/// Makes columns: what a unit of a term's coefficient does to the whitened residuals.
pub struct Columns<'a> {
    pub session: &'a Session,
    pub solved: &'a Solved,
    /// Rows of the problem that is judged.
    pub rows: usize,
    /// By channel.
    readings: Vec<Vec<ReadingRow>>,
    /// By joint, what a step of its coordinate does to the whitened residuals; empty of joints that slide.
    slopes: Vec<Vec<f64>>,
    /// What a turn of gravity does to the whitened residuals, rad⁻¹, about two axes perpendicular to it.
    pub turned_gravity: [Vec<f64>; 2],
    /// What a base does that gives way.
    pub leaning: Vec<Vec<f64>>,
    /// What is stated of each load.
    pub loads: Vec<StatedLoad>,
    /// What a metre more of each stated distance does to the whitened residuals; empty of one that is known with a standard deviation.
    pub distances: Vec<Vec<Vec<f64>>>,
    /// What a newton at the last link does.
    pub pulled: Vec<Vec<f64>>,
    /// What a clock does that is fast by its own rate.
    pub fast_clock: Vec<Vec<f64>>,
    /// Joints whose place or axis is taken as exact.
    pub displaced: DisplacedJoints,
    /// What a radian does about each axis of instruments whose mounting is taken as exact.
    pub turned_instruments: Vec<Vec<f64>>,
    /// By pose and joint, the torque under which the joint gives way: the model's own, as errors of a reading are in its residual, too.
    pub torques: Vec<Vec<f64>>,
    /// Readings of torque sensors, as the model has them.
    pub predicted: PredictedTorques,
    /// Readings of instruments, as the model has them.
    pub of_axes: PredictedAxes,
    /// By pose, when it was read, s; nothing where any pose does not tell.
    times: Option<Vec<f64>>,
    /// The poses that are read, in the order of their times.
    pub in_order: Vec<usize>,
    /// By pose, its place among them.
    pub places: Vec<usize>,
    /// By pose, its place among those of its table.
    places_in_table: Vec<usize>,
    /// By row, where the arm moves.
    predictions: Vec<f64>,
    /// By pose and joint, where the order of poses tells from which side joints came.
    sides: Vec<Vec<f64>>,
}

impl<'a> Columns<'a> {
    /// `rows`: of the problem that is judged, whose first ones are the readings.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated beside the solution.
    pub fn new(session: &'a Session, solved: &'a Solved, rows: usize) -> Result<Columns<'a>, EvaluateError> {
        let joints = session.robot.chain.joints().iter().enumerate();
        let slope = |(joint, described): (usize, &gravcal_dynamics::Joint)| match described.kind {
            JointKind::Prismatic => Ok(Vec::new()),
            _ => solved.slope_of_coordinate(joint, rows),
        };
        let times: Option<Vec<f64>> = session.poses.iter().map(|pose| pose.conditions.time).collect();
        let times = times.filter(|times| times.iter().any(|time| *time != times[0]));
        let slopes = in_parallel(joints, slope).into_iter().collect::<Result<_, _>>()?;
        let predictions = delayed::predictions(session, solved)?;
        let mut readings = vec![Vec::new(); session.channel_count()];
        for (row, id) in solved.built.rows.iter().enumerate() {
            readings[id.channel].push(ReadingRow { row, pose: id.pose, std: solved.readings().std(session, *id) });
        }
        let torques = solved.bending_torques(session)?;
        let mut in_order: Vec<usize> = solved.built.rows.iter().map(|id| id.pose).collect();
        in_order.dedup();
        if let Some(times) = &times {
            in_order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        }
        let mut places = vec![0; session.poses.len()];
        in_order.iter().enumerate().for_each(|(place, pose)| places[*pose] = place);
        let (mut places_in_table, mut counts) = (vec![0; session.poses.len()], BTreeMap::new());
        for pose in &in_order {
            let count: &mut usize = counts.entry(session.poses[*pose].table).or_default();
            places_in_table[*pose] = *count;
            *count += 1;
        }
        let turned_gravity = TurnedGravity::new(solved, rows)?;
        Ok(Columns {
            session,
            solved,
            rows,
            readings,
            slopes,
            leaning: turned_gravity.leaning(session, solved),
            turned_gravity: turned_gravity.columns,
            loads: stated_loads(session, solved, rows)?,
            distances: stated_distances(session, solved, rows)?,
            pulled: pulled(session, solved),
            fast_clock: fast_clock(session, solved, rows)?,
            displaced: solved.displaced_joints(session)?,
            turned_instruments: solved.turned_instruments(session)?,
            torques,
            predicted: PredictedTorques::new(session, solved)?,
            of_axes: PredictedAxes::new(session, solved)?,
            times,
            in_order,
            places,
            places_in_table,
            predictions,
            sides: sides_by_order(session),
        })
    }

    /// Unit of what [`when`](Self::when) tells.
    pub fn unit_of_time(&self) -> &'static str {
        if self.times.is_some() { "s" } else { "pose" }
    }

    /// Whether a channel is of a joint, and not of an instrument.
    pub fn is_joint(&self, channel: usize) -> bool {
        channel < self.session.joints.len()
    }

    /// Whether the arm moves while it is read.
    pub fn in_motion(&self) -> bool {
        !self.predictions.is_empty()
    }

    /// Whether a joint slides, so that its coordinate moves none of its own torque.
    pub fn slides(&self, joint: usize) -> bool {
        self.slopes[joint].is_empty()
    }

    /// How often a channel is read.
    pub fn read(&self, channel: usize) -> usize {
        self.readings[channel].len()
    }

    /// The table that a pose is of.
    pub fn table(&self, pose: usize) -> usize {
        self.session.poses[pose].table
    }

    /// Time, or number of the pose.
    pub fn when(&self, pose: usize) -> f64 {
        self.times.as_ref().map_or(pose as f64, |times| times[pose])
    }

    /// Tables in which a channel is read.
    pub fn tables(&self, channel: usize) -> Vec<usize> {
        let tables: BTreeSet<usize> = self.poses(channel).map(|pose| self.session.poses[pose].table).collect();
        tables.into_iter().collect()
    }

    /// Tables in which anything is read.
    pub fn tables_of_all(&self) -> Vec<usize> {
        let tables = self.solved.built.rows.iter().map(|id| self.session.poses[id.pose].table);
        tables.collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// The pose of every reading of a channel.
    pub fn poses(&self, channel: usize) -> impl Iterator<Item = usize> {
        self.readings[channel].iter().map(|reading| reading.pose)
    }

    /// A term that adds to the readings of a channel.
    pub fn reading(&self, channel: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut column = vec![0.0; self.rows];
        for ReadingRow { row, pose, std } in &self.readings[channel] {
            column[*row] = value(*pose) / std;
        }
        column
    }

    /// A term that adds to the readings of a channel, by the slopes of their predictions over time.
    pub fn of_slopes(&self, channel: usize, value: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let mut column = vec![0.0; self.rows];
        let slopes = delayed::slopes(self.session, &self.predictions, &self.readings[channel]);
        for (ReadingRow { row, std, .. }, slopes) in self.readings[channel].iter().zip(slopes) {
            column[*row] = value(slopes) / std;
        }
        column
    }

    /// A term that adds to the coordinate of a joint.
    pub fn coordinate(&self, joint: usize, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut column = self.slopes[joint].clone();
        let mut latest = None;
        for (id, entry) in self.solved.built.rows.iter().zip(&mut column) {
            // Rows of one pose follow each other.
            let of_pose =
                latest.filter(|(pose, _)| *pose == id.pose).map_or_else(|| value(id.pose), |(_, known)| known);
            latest = Some((id.pose, of_pose));
            *entry *= of_pose;
        }
        column
    }

    /// The readings of a channel, table by table in the order in which they were read.
    pub fn readings_in_order(&self, channel: usize) -> Vec<ReadingRow> {
        let mut readings = self.readings[channel].clone();
        readings.sort_by_key(|reading| (self.table(reading.pose), self.places[reading.pose]));
        readings
    }

    /// Whether two poses are of one table, and none of it was read between them.
    pub fn follow_each_other(&self, [before, pose]: [usize; 2]) -> bool {
        self.table(before) == self.table(pose) && self.places_in_table[before] + 1 == self.places_in_table[pose]
    }

    /// By how much the model's reading changes if coordinates go on by so much, rad; joints that slide count nothing.
    pub fn slope_along(&self, ReadingRow { row, std, .. }: ReadingRow, far: &[f64]) -> f64 {
        let of_joint = |(slopes, far): (&Vec<f64>, &f64)| slopes.get(row).map_or(0.0, |slope| slope * std * far);
        self.slopes.iter().zip(far).map(of_joint).sum()
    }

    /// What a channel reads at a pose, in its unit.
    pub fn read_at(&self, pose: usize, channel: usize) -> Option<f64> {
        self.session.reading(ReadingId { pose, channel }).map(|reading| reading.value)
    }

    /// The angle that the sensor shows.
    pub fn angle(&self, joint: usize, pose: usize) -> f64 {
        self.session.joints[joint].of(SensorParameter::PositionGain).nominal * self.session.poses[pose].position[joint]
    }

    /// From which side a joint came, as the order of poses or the session tells it; 0 where neither does.
    pub fn side(&self, joint: usize, pose: usize) -> f64 {
        let sides = self.sides.get(pose).unwrap_or(&self.session.poses[pose].conditions.direction);
        sides.get(joint).copied().unwrap_or(0.0)
    }

    /// A condition of a joint, times what it acts on; zero where it is not known.
    pub fn condition(&self, joint: usize, of: impl Fn(&Pose) -> &Vec<f64>, acts_on: impl Fn(usize) -> f64) -> Vec<f64> {
        let own = |pose: usize| of(&self.session.poses[pose]).get(joint).copied().unwrap_or(0.0);
        self.reading(joint, |pose| own(pose) * acts_on(pose))
    }

    /// A column of a joint's readings, each times what its torque makes of it.
    pub fn times_reading(&self, joint: usize, mut column: Vec<f64>) -> Vec<f64> {
        for ReadingRow { row, pose, .. } in &self.readings[joint] {
            column[*row] *= self.predicted.reading(*pose, joint);
        }
        column
    }

    /// The same, each times what friction of the model makes of it.
    pub fn times_friction(&self, joint: usize, mut column: Vec<f64>) -> Vec<f64> {
        let read = [Need::Direction, Need::Presliding, Need::Velocity];
        let friction = modelled_friction(self.session, self.solved, joint, &read);
        for ReadingRow { row, pose, .. } in &self.readings[joint] {
            column[*row] *= friction.get(*pose).copied().unwrap_or(0.0);
        }
        column
    }

    /// Time (or order) since the first pose of a channel that is of the same group.
    pub fn time_since(&self, channel: usize, group: impl Fn(usize) -> usize) -> Vec<f64> {
        let mut first: BTreeMap<usize, f64> = BTreeMap::new();
        for pose in self.poses(channel) {
            let since = first.entry(group(pose)).or_insert(f64::INFINITY);
            *since = since.min(self.when(pose));
        }
        self.reading(channel, |pose| self.when(pose) - first[&group(pose)])
    }

    /// Time (or order) less its mean over the poses of a channel that are of one group.
    pub fn trend(&self, channel: usize, group: impl Fn(usize) -> usize) -> Vec<f64> {
        let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for pose in self.poses(channel) {
            let (sum, count) = sums.entry(group(pose)).or_default();
            *sum += self.when(pose);
            *count += 1.0;
        }
        self.reading(channel, |pose| {
            let (sum, count) = sums[&group(pose)];
            if count < DRIFTING as f64 { 0.0 } else { self.when(pose) - sum / count }
        })
    }

    /// Columns of each table but the first; none of more than `most`.
    pub fn apart(
        &self,
        tables: &[usize],
        most: usize,
        of: impl Fn(&dyn Fn(usize) -> bool) -> Vec<Vec<f64>>,
    ) -> Vec<Vec<f64>> {
        if tables.len() > most {
            return Vec::new();
        }
        tables.iter().skip(1).flat_map(|table| of(&|pose| self.session.poses[pose].table == *table)).collect()
    }

    /// The file that is farthest from the mean one, and by how much; `coefficients` are those of all tables but the first.
    pub fn farthest(&self, tables: &[usize], coefficients: &[f64]) -> (String, f64) {
        let mean = coefficients.iter().sum::<f64>() / tables.len() as f64;
        let apart =
            tables.iter().zip(std::iter::once(&0.0).chain(coefficients)).map(|(table, own)| (*table, own - mean));
        let (table, size) = apart.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
        (file_name(&self.session.tables[table].path), size)
    }

    /// The rows of some poses; zero in all others.
    pub fn only(&self, column: &[f64], within: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut only = vec![0.0; self.rows];
        for ((id, entry), own) in self.solved.built.rows.iter().zip(column).zip(&mut only) {
            *own = if within(id.pose) { *entry } else { 0.0 };
        }
        only
    }
}
