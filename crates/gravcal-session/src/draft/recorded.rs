//! What a recording and a robot tell of a session.

use std::path::Path;

use gravcal_recording::{
    ConditionColumn, ConditionColumns, ConditionUnit, CsvWriting, Inspection, MotionSource, PoseMapping,
    PositionColumn, ReadError, ReadingColumn, Row, Rows, Stillness, SweepRule, Sweeps, TimeFound, Travel, WIDEST_BIN,
    Watched, open_as, slow_sweeps, static_poses,
};
use gravcal_robot_model::session::travel::{BIN, STEADY};
use gravcal_robot_model::session::{Joined, Searched};

use super::body::DraftBody;
use super::error::DraftError;
use super::joints::{DraftJoint, MatchedBy, matched};
use super::robot::DraftRobot;
use super::sense::Forces;

/// What is known of a session before anybody says anything but its recording, and perhaps its robot.
#[derive(Debug)]
pub struct Draft<'a> {
    pub(super) recording: &'a Path,
    pub(super) inspection: &'a Inspection,
    pub(super) robot: Option<&'a DraftRobot>,
    pub(super) joints: Vec<DraftJoint>,
    /// Of a wrist sensor that is turned without joints: then there are none.
    pub(super) body: Option<DraftBody>,
    /// How joints of the recording became those of the robot.
    pub(super) by: MatchedBy,
    /// Names of joints of the recording that are none of the robot's.
    pub(super) left_out: Vec<String>,
    /// How the recording is written, as far as it was said.
    pub(super) csv: CsvWriting,
}

/// Where the poses of a recording are.
#[derive(Clone, Debug)]
pub enum DraftPoses {
    /// Each row is one: there is no clock, or rows are long apart.
    Rows {
        /// Why the rows do not look like static poses, and what to do about it, if they do not.
        doubt: Option<String>,
    },
    /// They are found in it.
    Found(Box<Searched>),
}

impl DraftPoses {
    /// What was found, where it was looked for.
    pub fn searched(&self) -> Option<&Searched> {
        match self {
            DraftPoses::Rows { .. } => None,
            DraftPoses::Found(searched) => Some(searched.as_ref()),
        }
    }

    /// Why rows that are taken as poses do not look like such.
    pub fn doubt(&self) -> Option<&str> {
        match self {
            DraftPoses::Rows { doubt } => doubt.as_deref(),
            DraftPoses::Found(_) => None,
        }
    }
}

/// At so many standstills at most one sweep turns.
const TURNING_POINTS: usize = 4;

/// Whether standstills are no more than the places at which sweeps turn, and fewer than the poses that these make.
fn are_where_sweeps_turn(standing: usize, sweeps: &Sweeps) -> bool {
    let poses: usize = sweeps.found.iter().map(|sweep| sweep.bins.len()).sum();
    standing < poses && standing <= TURNING_POINTS * sweeps.found.len()
}

/// What is said of standstills that do not count, since sweeps make more poses.
fn beside_sweeps(standing: usize) -> String {
    format!(
        "the arm also stands {standing} times; sweeps tell more, as friction cancels in the mean of both ways. If these standstills are poses \
         of their own, let [readings.still] take them in place of [readings.sweeps]."
    )
}

/// A table of static poses has rows further apart than this, s.
const ROWS_OF_POSES: f64 = 0.5;

impl<'a> Draft<'a> {
    /// # Errors
    /// Names do not tell which columns are what, or robot and recording have different joints.
    pub fn new(
        recording: &'a Path,
        inspection: &'a Inspection,
        robot: Option<&'a DraftRobot>,
    ) -> Result<Draft<'a>, DraftError> {
        let found = inspection.joints();
        let body =
            DraftBody::find(inspection).filter(|_| robot.is_none() && found.iter().all(|joint| joint.torque.is_none()));
        if body.is_some() {
            let (joints, by, left_out) =
                (Vec::new(), MatchedBy::Name, found.into_iter().map(|found| found.name).collect());
            return Ok(Draft { recording, inspection, robot, joints, body, by, left_out, csv: CsvWriting::default() });
        }
        let columns =
            || inspection.columns.iter().map(|column| format!("`{}`", column.name)).collect::<Vec<_>>().join(", ");
        if found.is_empty() {
            return Err(DraftError::NoJoints { columns: columns() });
        }
        let (joints, by) = matched(inspection, &found, robot.map(|robot| &robot.robot))?;
        if joints.iter().all(|joint| joint.torque.is_none()) {
            return Err(DraftError::NoTorques { columns: columns() });
        }
        let is_taken = |name: &String| joints.iter().any(|joint| joint.recorded == *name);
        let left_out = found.into_iter().map(|found| found.name).filter(|name| !is_taken(name)).collect();
        Ok(Draft { recording, inspection, robot, joints, body, by, left_out, csv: CsvWriting::default() })
    }

    /// The same of a recording that, if it is CSV, is said to be written so, as the inspection was told.
    #[must_use]
    pub fn written(self, csv: CsvWriting) -> Draft<'a> {
        Draft { csv, ..self }
    }

    /// The same with what the forces of a wrist sensor say of signs, for which the recording is read; of joints nothing is read. `watch`
    /// is told which share is read.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub fn looked_at(mut self, watch: &dyn Fn(f64)) -> Result<Draft<'a>, ReadError> {
        if let Some(body) = &mut self.body {
            let mut forces = Forces::default();
            let columns = body.oriented_by.iter().chain(body.axes[..3].iter().map(|(column, _)| column));
            each_row(self.recording, &self.csv, columns, watch, |cells| {
                if let Some((orientation, force)) = cells.split_last_chunk()
                    && let Ok(rotation) = body.form.rotation(orientation)
                {
                    forces.take(&rotation, *force);
                }
            })?;
            body.sense = forces.sense();
        }
        Ok(self)
    }

    /// Which columns are which readings.
    pub fn mapping(&self) -> PoseMapping {
        let torque = |joint: &DraftJoint| {
            let (column, unit) = joint.torque.clone()?;
            Some((ReadingColumn { column, ..ReadingColumn::default() }, unit))
        };
        let position = |joint: &DraftJoint| PositionColumn::new(&joint.position.0, joint.position.1);
        PoseMapping {
            positions: self.joints.iter().map(position).collect(),
            torques: self.joints.iter().map(torque).collect(),
            orientation: self.body.as_ref().map(DraftBody::orientation),
            instruments: self.body.as_ref().map_or_else(Vec::new, DraftBody::instruments),
            conditions: ConditionColumns {
                time: self.time(),
                velocity: self.velocities().map_or(MotionSource::Unknown, MotionSource::Columns),
                ..ConditionColumns::default()
            },
            csv: self.csv.clone(),
            ..PoseMapping::default()
        }
    }

    /// The standstills of the recording, or its slow sweeps where these make more poses (an arm that sweeps stands where it turns), with the
    /// columns and units of the draft: those that a session of it has. Or each row is a pose already: there is no clock, or rows are long apart.
    /// `watch` is told which share is read.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub fn search(&self, watch: &dyn Fn(f64)) -> Result<DraftPoses, ReadError> {
        if self.body.is_some() {
            return Ok(DraftPoses::Rows { doubt: self.doubt_of_body() });
        }
        if self.rows_are_poses() {
            return Ok(DraftPoses::Rows { doubt: self.doubt(watch)? });
        }
        let (path, mapping) = (self.recording, self.mapping());
        let rows = || Ok::<_, ReadError>(Watched::new(open_as(path, &self.csv)?, watch));
        let standstills = static_poses(path, &mut rows()?, &mapping, &Stillness::default())?;
        let standing = standstills.found.len();
        let sweeps = self.sweep_rule().map(|rule| slow_sweeps(path, &mut rows()?, &mapping, &rule)).transpose();
        // What cannot be searched for sweeps is a recording of standstills, if it holds some.
        let sweeps = if standing > 0 { sweeps.unwrap_or(None) } else { sweeps? };
        let sweeps = sweeps.filter(|sweeps| standing == 0 || are_where_sweeps_turn(standing, sweeps));
        let standstills = Some(standstills).filter(|_| standing == 0 || sweeps.is_none());
        // What was lost has been told by the inspection.
        let remarks = standstills.is_none().then(|| beside_sweeps(standing)).into_iter().collect();
        Ok(DraftPoses::Found(Box::new(Searched {
            path: path.to_owned(),
            standstills,
            sweeps,
            remarks,
            ..Searched::default()
        })))
    }

    /// Why rows do not look like static poses, if they do not.
    fn doubt(&self, watch: &dyn Fn(f64)) -> Result<Option<String>, ReadError> {
        let scales: Vec<f64> = self.joints.iter().map(DraftJoint::scale).collect();
        let ranges = self.joints.iter().zip(&scales).map(|(joint, scale)| scale * (joint.reach[1] - joint.reach[0]));
        let mut joined = Joined::new(ranges);
        each_row(self.recording, &self.csv, self.joints.iter().map(|joint| &joint.position.0), watch, |cells| {
            let positions: Vec<f64> = cells.iter().zip(&scales).map(|(cell, scale)| scale * cell).collect();
            joined.take(&positions);
        })?;
        Ok(joined.report(self.recording, self.time().is_some()))
    }

    /// Poses are not looked for in what a wrist sensor reads.
    fn doubt_of_body(&self) -> Option<String> {
        let interval = self.inspection.time.as_ref().filter(|_| !self.rows_are_poses())?.interval_s;
        Some(format!(
            "Rows are {interval:.3} s apart, and each is taken as a static pose. Where the sensor moves in between, or stands for many rows, \
             make one row of each standstill: its means."
        ))
    }

    /// `None` where it is not known how far a joint travels for each count or volt.
    fn sweep_rule(&self) -> Option<SweepRule> {
        let travel: Option<Vec<Travel>> = self.joints.iter().map(DraftJoint::travel).collect();
        Some(SweepRule { bin: BIN, widest: WIDEST_BIN, acceleration: STEADY, travel: travel?, ..SweepRule::default() })
    }

    fn rows_are_poses(&self) -> bool {
        // A clock that stands is none.
        let is_slow = |interval: f64| interval == 0.0 || interval > ROWS_OF_POSES;
        self.inspection.time.as_ref().is_none_or(|time| is_slow(time.interval_s))
    }

    /// Whether positions and torques are those of different topics, each with rows of its own.
    pub(super) fn is_in_rows_apart(&self) -> bool {
        // Of `/arm/js:shoulder.position` the topic; columns of one topic, or of no bag, have none in common names.
        let topic = |column: &str| {
            column.split_once(':').map(|(topic, _)| topic.to_owned()).filter(|topic| topic.starts_with('/'))
        };
        let apart = |joint: &DraftJoint| {
            joint.torque.as_ref().is_none_or(|(torque, _)| topic(torque) != topic(&joint.position.0))
        };
        self.joints.iter().all(apart)
    }

    pub(super) fn time(&self) -> Option<ConditionColumn> {
        // A clock that stands tells nothing of poses.
        let stands = |time: &TimeFound| self.rows_are_poses() && (time.stands() || time.interval_s == 0.0);
        let time = self.inspection.time.as_ref().filter(|time| !stands(time))?;
        let unit = ConditionUnit::TIME.into_iter().find(|unit| unit.name == time.unit)?;
        Some(ConditionColumn { column: time.column.clone(), unit })
    }

    /// The columns of the joints' speeds, where all have one.
    pub(super) fn velocities(&self) -> Option<Vec<ConditionColumn>> {
        let column = |joint: &DraftJoint| {
            let (column, unit) = joint.velocity.clone()?;
            Some(ConditionColumn { column, unit })
        };
        self.joints.iter().map(column).collect()
    }
}

/// What each row of a recording says in these columns; what it does not say is not a number.
fn each_row<'c>(
    recording: &Path,
    csv: &CsvWriting,
    columns: impl Iterator<Item = &'c String>,
    watch: &dyn Fn(f64),
    mut take: impl FnMut(&[f64]),
) -> Result<(), ReadError> {
    let columns: Vec<&String> = columns.collect();
    let mut rows = Watched::new(open_as(recording, csv)?, watch);
    let (mut row, mut known, mut places) = (Row::default(), 0, Vec::new());
    while rows.read(&mut row)? {
        if rows.columns().len() != known {
            known = rows.columns().len();
            places = columns.iter().map(|column| rows.columns().iter().position(|name| name == *column)).collect();
        }
        let cell = |place: &Option<usize>| place.map_or(f64::NAN, |place| row.cells[place]);
        take(&places.iter().map(cell).collect::<Vec<f64>>());
    }
    Ok(())
}
