//! A session to start from, drawn up from a recording and a robot: whatever names, ranges and rates tell, each guess told as one.
//!
//! ```text
//! Inspection ─┬─► joints and their columns ─► PoseMapping ─► standstills ─┬─► text of a session
//! robot file ─┘                                                           │    (what is missing: comments)
//!                          path of the recording ─────────────────────────┘
//! ```

mod joints;
mod poses;
mod robot;
mod text;

use std::path::Path;

use gravcal_recording::{
    ConditionColumn, ConditionColumns, ConditionUnit, CsvWriting, Inspection, MotionSource, PoseMapping, PositionColumn, ReadError,
    ReadingColumn, Stillness, SweepRule, Travel, Watched, open_as, slow_sweeps, static_poses,
};

use super::Searched;
use super::travel::{BIN, STEADY};
use crate::document::FileError;
use joints::DraftJoint;

pub use robot::DraftRobot;

/// Why no session can be drawn up.
#[derive(Debug, thiserror::Error)]
pub enum DraftError {
    /// The robot's file cannot be read.
    #[error(transparent)]
    Robot(#[from] FileError),
    /// It cannot be told which columns are positions.
    #[error(
        "which columns are the joints' positions and torques is not told by their names: expected such as \
         `shoulder.position` and `shoulder.effort`, or `q1_deg` and `tau1_Nm`; the columns are {columns}"
    )]
    NoJoints {
        /// Names of the columns.
        columns: String,
    },
    /// No joint has a torque.
    #[error(
        "no column is a torque reading, as far as names tell, and without torque there is nothing to calibrate; the columns are {columns}"
    )]
    NoTorques {
        /// Names of the columns.
        columns: String,
    },
    /// The robot has joints that the recording has not.
    #[error(
        "of the robot's {joints} joints these are not in the recording: {missing}; the joints whose positions are recorded are \
         {recorded}, and their number does not tell either which is which"
    )]
    OtherJoints {
        /// Names of the robot's joints that are not recorded.
        missing: String,
        /// How many joints the robot has.
        joints: usize,
        /// Names of the recorded ones.
        recorded: String,
    },
}

/// What is known of a session before anybody says anything but its recording, and perhaps its robot.
#[derive(Debug)]
pub struct Draft<'a> {
    recording: &'a Path,
    inspection: &'a Inspection,
    robot: Option<&'a DraftRobot>,
    joints: Vec<DraftJoint>,
    /// Whether joints of the recording became those of the robot by their order, as names do not agree.
    by_order: bool,
    /// Names of joints of the recording that are none of the robot's.
    left_out: Vec<String>,
    /// How the recording is written, as far as it was said.
    csv: CsvWriting,
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
        let columns =
            || inspection.columns.iter().map(|column| format!("`{}`", column.name)).collect::<Vec<_>>().join(", ");
        if found.is_empty() {
            return Err(DraftError::NoJoints { columns: columns() });
        }
        let (joints, by_order) = joints::matched(inspection, &found, robot.map(|robot| &robot.robot))?;
        if joints.iter().all(|joint| joint.torque.is_none()) {
            return Err(DraftError::NoTorques { columns: columns() });
        }
        let is_taken = |name: &String| joints.iter().any(|joint| joint.recorded == *name);
        let left_out = found.into_iter().map(|found| found.name).filter(|name| !is_taken(name)).collect();
        Ok(Draft { recording, inspection, robot, joints, by_order, left_out, csv: CsvWriting::default() })
    }

    /// The same of a recording that, if it is CSV, is said to be written so, as the inspection was told.
    #[must_use]
    pub fn written(self, csv: CsvWriting) -> Draft<'a> {
        Draft { csv, ..self }
    }

    /// Which columns are which readings.
    pub fn mapping(&self) -> PoseMapping {
        let torque = |joint: &DraftJoint| {
            let (column, unit) = joint.torque.clone()?;
            Some((ReadingColumn { column, ..ReadingColumn::default() }, unit))
        };
        let position = |joint: &DraftJoint| PositionColumn { column: joint.position.0.clone(), unit: joint.position.1 };
        PoseMapping {
            positions: self.joints.iter().map(position).collect(),
            torques: self.joints.iter().map(torque).collect(),
            conditions: ConditionColumns {
                time: self.time(),
                velocity: self.velocities().map_or(MotionSource::Unknown, MotionSource::Columns),
                ..ConditionColumns::default()
            },
            csv: self.csv.clone(),
            ..PoseMapping::default()
        }
    }

    /// The standstills of the recording or, where there are none, its slow sweeps, with the columns and units of the draft: those that a
    /// session of it has. `None` where each row is a pose already: there is no clock, or rows are long apart. `watch` is told which share
    /// is read.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub fn search(&self, watch: &dyn Fn(f64)) -> Result<Option<Searched>, ReadError> {
        if self.rows_are_poses() {
            return Ok(None);
        }
        let (path, mapping) = (self.recording, self.mapping());
        let rows = || Ok::<_, ReadError>(Watched::new(open_as(path, &self.csv)?, watch));
        let standstills = static_poses(path, &mut rows()?, &mapping, &Stillness::default())?;
        let rule = self.sweep_rule().filter(|_| standstills.found.is_empty());
        let sweeps = rule.map(|rule| slow_sweeps(path, &mut rows()?, &mapping, &rule)).transpose()?;
        // What was lost has been told by the inspection.
        Ok(Some(Searched { path: path.to_owned(), standstills: Some(standstills), sweeps, remarks: Vec::new() }))
    }

    /// `None` where it is not known how far a joint travels for each count or volt.
    fn sweep_rule(&self) -> Option<SweepRule> {
        let travel: Option<Vec<Travel>> = self.joints.iter().map(DraftJoint::travel).collect();
        Some(SweepRule { bin: BIN, acceleration: STEADY, travel: travel?, ..SweepRule::default() })
    }

    fn rows_are_poses(&self) -> bool {
        self.inspection.time.as_ref().is_none_or(|time| time.interval_s > ROWS_OF_POSES)
    }

    fn time(&self) -> Option<ConditionColumn> {
        let time = self.inspection.time.as_ref()?;
        let unit = ConditionUnit::TIME.into_iter().find(|unit| unit.name == time.unit)?;
        Some(ConditionColumn { column: time.column.clone(), unit })
    }

    /// The columns of the joints' speeds, where all have one.
    fn velocities(&self) -> Option<Vec<ConditionColumn>> {
        let column = |joint: &DraftJoint| {
            let (column, unit) = joint.velocity.clone()?;
            Some(ConditionColumn { column, unit })
        };
        self.joints.iter().map(column).collect()
    }
}

#[cfg(test)]
mod tests;
