//! `[[poses]]` that are recordings in motion: their standstills, slow sweeps and windows become poses.

use std::path::Path;
use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_recording::{
    Conditions, Course, Memory, MotionWindow, Part, PoseMapping, ReadError, Rows, StaticPose, Stillness, SweepRule,
    Watched, WindowRule, motion_windows, slow_sweeps, static_poses,
};
use gravcal_robot_model::sensors::SensorTerms;
use gravcal_robot_model::session::{JointPriors, Load, Pose, PoseTable, Searched};

use super::context::SessionError;
use super::poses::{PosesTable, ReadPoses, WrittenTables, count_time_from_first};
use super::swept_speed::MovingArm;
use super::wrapped::within_one_turn;
use crate::document::{Document, FileError};

/// What is looked for in recordings in motion.
pub(super) struct InMotion {
    pub still: Option<Stillness>,
    pub sweeps: Option<SweepRule>,
    pub windows: Option<WindowRule>,
}

impl InMotion {
    /// Whether anything is.
    pub fn is_any(&self) -> bool {
        self.finds_rest() || self.windows.is_some()
    }

    /// Whether standstills or slow sweeps are.
    pub fn finds_rest(&self) -> bool {
        self.still.is_some() || self.sweeps.is_some()
    }
}

/// The recordings of a session, and what they may carry.
pub(super) struct Recordings<'a> {
    pub document: &'a Document,
    pub memory: &'a Memory,
    pub written: WrittenTables<'a>,
    pub chain: &'a Chain,
    pub joints: &'a [JointPriors],
    pub loads: &'a [Load],
    pub terms: &'a SensorTerms,
    /// Told how far each recording is read.
    pub watch: &'a dyn Fn(&Path, f64),
}

impl Recordings<'_> {
    /// Reads all of them. A load that only a recording names is entered in its table.
    pub fn read(
        &self,
        tables: &mut [PoseTable],
        mapping: &PoseMapping,
        motion: &InMotion,
    ) -> Result<ReadPoses, SessionError> {
        let mut all = ReadPoses::none(mapping.torques.len());
        for (index, table) in tables.iter_mut().enumerate() {
            let mut searched = Searched { table: index, ..self.search(index, table, mapping, motion)? };
            // Where a sensor's model tells both ways of a sweep apart, each is a pose of its own.
            let mut poses = searched.poses(self.terms.need_direction());
            searched.remarks.extend(leave_out_unknown_conditions(&mut poses));
            for joint in &self.terms.with_friction() {
                searched.remarks.extend(leave_out_unknown_sides(&mut poses, *joint, mapping));
            }
            let first = all.poses.len();
            all.take(index, table.load, poses);
            all.take_windows(index, table.load, windows(&searched, self.terms));
            if searched.windows.is_some() {
                // Standstills and windows share errors of their time: blocks of seconds hold both.
                let time = |pose: &Pose| pose.conditions.time.unwrap_or(f64::NEG_INFINITY);
                all.poses[first..].sort_by(|a, b| time(a).total_cmp(&time(b)));
            }
            all.searched.push(searched);
        }
        count_time_from_first(&mut all.poses);
        if motion.windows.is_none() {
            all.turns = within_one_turn(&mut all.poses, mapping, &mut all.searched);
        }
        Ok(all)
    }

    /// What one recording holds. A load that only it names is entered in its table.
    fn search(
        &self,
        index: usize,
        table: &mut PoseTable,
        mapping: &PoseMapping,
        motion: &InMotion,
    ) -> Result<Searched, SessionError> {
        let wrong = |error| self.written.wrong(self.document, index, error);
        let rows = self.memory.open_as(&table.path, &mapping.csv).map_err(wrong)?;
        let said = rows.metadata().get("load").cloned();
        drop(rows);
        if let Some(name) = said {
            table.load = Some(self.load(index, &name, table.load)?);
        }
        let part = self.written.iter().nth(index).map_or(Part::default(), PosesTable::part_of_recording);
        let search = Search { path: &table.path, memory: self.memory, mapping, part, watch: self.watch };
        let mut searched = search.run(motion).map_err(wrong)?;
        if searched.found() == 0 {
            let (rejected, clock) = (searched.rejected(), Box::new(searched.clock()));
            return Err(wrong(ReadError::NothingStands { path: table.path.clone(), rejected, clock }));
        }
        self.subtract_speed(table.load, &mut searched);
        Ok(searched)
    }

    /// Takes the torque that the speed of sweeps makes in standing joints from what these read.
    fn subtract_speed(&self, load: Option<usize>, searched: &mut Searched) {
        let Searched { sweeps: Some(sweeps), remarks, .. } = searched else { return };
        let load = load.map(|load| &self.loads[load]);
        let arm = MovingArm::new(self.chain, self.joints, load);
        remarks.extend(arm.and_then(|mut arm| arm.subtract(sweeps)));
    }

    /// The load that a recording names, which must be the one that the session says, if it says any.
    fn load(&self, index: usize, name: &str, said: Option<usize>) -> Result<usize, FileError> {
        let known: Vec<&str> = self.loads.iter().map(|load| load.name.as_str()).collect();
        let field = self.written.field(index).key("load");
        match said {
            Some(said) if known[said] != name => {
                let message = format!("the recording says that it carries `{name}`, not `{}`", known[said]);
                Err(self.document.error(&field, message))
            }
            _ => self.document.lookup(&field, "load", name, &known),
        }
    }
}

/// Whether it is known under which conditions a pose was read.
fn has_conditions(pose: &StaticPose) -> bool {
    let Conditions { temperature, further, .. } = &pose.conditions;
    temperature.iter().chain(further).all(|number| number.is_finite())
}

/// Leaves out poses before the first temperature, or the first number of a further column, and says so.
fn leave_out_unknown_conditions(poses: &mut Vec<StaticPose>) -> Option<String> {
    let before = poses.len();
    poses.retain(has_conditions);
    let left_out = before - poses.len();
    (left_out > 0).then(|| {
        format!(
            "{left_out} poses are left out: no temperature, or no number of a further column, came before they ended"
        )
    })
}

/// Leaves out what a joint with friction reads where it is not known from which side it came, such as where a recording begins, and
/// says so. A joint that never moves has friction of one sign, which is a part of its bias.
fn leave_out_unknown_sides(poses: &mut [StaticPose], joint: usize, mapping: &PoseMapping) -> Option<String> {
    let side = |pose: &StaticPose| pose.conditions.direction.get(joint).copied().unwrap_or(0.0);
    if poses.iter().all(|pose| side(pose) == 0.0) {
        return None;
    }
    let unknown = poses.iter_mut().filter(|pose| side(pose) == 0.0 && pose.torque[joint].is_some());
    let left_out = unknown.map(|pose| pose.torque[joint] = None).count();
    let column = &mapping.torques[joint].as_ref()?.0.column;
    (left_out > 0).then(|| {
        format!(
            "{left_out} readings of `{column}` are left out: it is not known from which side the joint had come there, and so which \
             sign its friction has. Move every joint before the first standstill."
        )
    })
}

/// A joint that does not move over this share of a window's weight has friction of unknown sign there.
const RESTS: f64 = 0.25;
/// The same of one that stands there, and does not only turn round: any part of its friction may be left, to either side.
const STANDS: f64 = 0.005;

/// The windows of a recording under known conditions, but for those of a standstill that counts by itself. A joint with friction has no reading where it rests, or,
/// where its friction builds up, as long as it is not known how far.
fn windows<'s>(
    searched: &'s Searched,
    terms: &SensorTerms,
) -> impl Iterator<Item = (StaticPose, Arc<Course>)> + use<'s> {
    let standstills = searched.standstills.iter().flat_map(|found| &found.found);
    let counted: Vec<[f64; 2]> = standstills.map(|found| found.interval).collect();
    let apart = move |window: &&MotionWindow| {
        has_conditions(&window.pose)
            && counted.iter().all(|counted| window.interval[1] <= counted[0] || counted[1] <= window.interval[0])
    };
    let (frictional, followed) = (terms.with_friction(), terms.with_presliding());
    let unknown = move |window: &MotionWindow, joint: usize| match followed.contains(&joint) {
        true => window.pose.conditions.presliding[joint].is_none(),
        false => window.resting[joint] > RESTS || window.standing[joint] > STANDS,
    };
    let reported = move |window: &MotionWindow| {
        let mut means = window.pose.clone();
        frictional.iter().filter(|joint| unknown(window, **joint)).for_each(|joint| means.torque[*joint] = None);
        (means, Arc::clone(&window.course))
    };
    searched.windows.iter().flat_map(|found| &found.found).filter(apart).map(reported)
}

/// What is searched.
struct Search<'a> {
    path: &'a Path,
    memory: &'a Memory,
    mapping: &'a PoseMapping,
    part: Part,
    watch: &'a dyn Fn(&Path, f64),
}

impl Search<'_> {
    /// Standstills and sweeps of one recording; each reads it once.
    fn run(&self, motion: &InMotion) -> Result<Searched, ReadError> {
        let Search { path, memory, mapping, part, .. } = *self;
        let watch = |share: f64| (self.watch)(path, share);
        let rows = || Ok::<_, ReadError>(Watched::new(memory.open_as(path, &mapping.csv)?, &watch));
        let mut searched = Searched { path: path.to_owned(), ..Searched::default() };
        if let Some(still) = motion.still {
            let mut rows = rows()?;
            searched.standstills = Some(static_poses(path, &mut rows, mapping, &Stillness { part, ..still })?);
            (searched.remarks, searched.lost) = (rows.remarks(), rows.lost());
        }
        if let Some(sweeps) = &motion.sweeps {
            let mut rows = rows()?;
            let rule = SweepRule { part, ..sweeps.clone() };
            searched.sweeps = Some(slow_sweeps(path, &mut rows, mapping, &rule)?);
            (searched.remarks, searched.lost) = (rows.remarks(), rows.lost());
        }
        if let Some(windows) = &motion.windows {
            let mut rows = rows()?;
            let rule = WindowRule { part, ..windows.clone() };
            searched.windows = Some(Box::new(motion_windows(path, &mut rows, mapping, &rule)?));
            (searched.remarks, searched.lost) = (rows.remarks(), rows.lost());
        }
        Ok(searched)
    }
}
