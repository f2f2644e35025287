//! `[[poses]]`: the tables of static poses, and `[[validation]]`: those that enter no fit.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_recording::{Course, Memory, Part, PoseMapping, ReadError, StaticPose};
use gravcal_robot_model::session::{InertiaPrior, Load, Pose, PoseTable, Searched};
use serde::Deserialize;

use super::context::{Context, SessionError};
use crate::document::{Document, Field, FileError, OneOrMany};

/// `[[poses]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct PosesTable {
    /// The file. `${NAME:-default}` is replaced by the environment.
    ///
    /// Example: `file = "${DATA:-.}/poses-a.csv"`
    pub(super) file: String,
    /// The load that is attached.
    ///
    /// Default: nothing.
    /// Example: `load = "plate-a"`
    load: Option<OneOrMany<String>>,
    /// The joint that sweeps.
    ///
    /// Default: found by movement.
    /// Example: `swept = "shoulder"`
    swept: Option<String>,
    /// The step of the sequential estimator that reads the table.
    ///
    /// Unit: none.
    /// Default: found.
    /// Example: `step = 2`
    step: Option<u8>,
    /// Where the part that counts begins, after the first row. Needs a clock.
    ///
    /// Default: the beginning.
    /// Example: `from_s = 10`
    from_s: Option<f64>,
    /// Where it ends.
    ///
    /// Default: the end.
    /// Example: `until_s = 95`
    until_s: Option<f64>,
}

impl PosesTable {
    pub(super) fn part_of_recording(&self) -> Part {
        Part { from: self.from_s, until: self.until_s }
    }

    /// Its ends, s.
    fn part(&self) -> [f64; 2] {
        [self.from_s.unwrap_or(f64::NEG_INFINITY), self.until_s.unwrap_or(f64::INFINITY)]
    }
}

/// A part is one of a recording with a clock, and not empty.
fn check_part(document: &Document, field: &Field, written: &PosesTable, clock: bool) -> Result<(), FileError> {
    let parts = [("from_s", written.from_s), ("until_s", written.until_s)];
    if let Some((key, _)) = parts.iter().find(|(_, part)| part.is_some() && !clock) {
        let message = "a part is told by the recording's clock, and no column is said to be one: add readings.time = { column = \"…\", \
                       unit = \"s\" } (or [readings.still] or [readings.sweeps], where the column is time_s), or delete this";
        return Err(document.error(&field.key(key), message));
    }
    let [from, until] = written.part();
    if from < until { Ok(()) } else { Err(document.error(&field.key("until_s"), "expected a time after from_s")) }
}

/// All tables as they are written: first those that are fitted.
#[derive(Clone, Copy)]
pub(super) struct WrittenTables<'a> {
    pub poses: &'a [PosesTable],
    pub validation: &'a [PosesTable],
}

impl<'a> WrittenTables<'a> {
    pub fn iter(self) -> impl Iterator<Item = &'a PosesTable> {
        self.poses.iter().chain(self.validation)
    }

    /// Where the table with this index stands.
    pub fn field(self, table: usize) -> Field {
        match table.checked_sub(self.poses.len()) {
            None => Field::new("poses").at(table),
            Some(table) => Field::new("validation").at(table),
        }
    }

    /// What is wrong with a table, and where the session names it.
    pub fn wrong(self, document: &Document, table: usize, error: ReadError) -> SessionError {
        let written = self.iter().nth(table).map_or("", |written| &written.file);
        SessionError::Table { error, named_by: document.named_by(&self.field(table).key("file"), written) }
    }
}

/// What the tables come to, without opening the files; `clock`: whether they have one.
pub(super) fn tables(
    context: &Context<'_>,
    loads: &[Load],
    all: WrittenTables<'_>,
    clock: bool,
) -> Result<Vec<PoseTable>, FileError> {
    if all.poses.is_empty() {
        let message = "there are no poses: add [[poses]] with file = \"<a table>.csv\"";
        return Err(context.document.error(&Field::new("poses"), message));
    }
    for (index, written) in all.iter().enumerate() {
        check_part(context.document, &all.field(index), written, clock)?;
    }
    if let Some(table) = all.validation.iter().position(|written| written.step.is_some()) {
        let field = Field::new("validation").at(table).key("step");
        return Err(context.document.error(&field, "no step reads what enters no fit: delete this"));
    }
    let parts: Vec<[f64; 2]> = all.iter().map(PosesTable::part).collect();
    let tables: Vec<PoseTable> = all
        .iter()
        .enumerate()
        .map(|(i, written)| table(context, loads, &all.field(i), written))
        .collect::<Result<_, _>>()?;
    check_read_once(context.document, all, &tables, &parts)?;
    Ok(tables)
}

/// What is to be predicted must not rest on what nothing fitted tells.
pub(super) fn check_validation(
    document: &Document,
    all: WrittenTables<'_>,
    (loads, inertia): (&[Load], &InertiaPrior),
    tables: &[PoseTable],
) -> Result<(), FileError> {
    if *inertia == InertiaPrior::Sweep && !all.validation.is_empty() {
        let message = "moments are described by sweep, and other sweeps have others, so nothing can be predicted: write \
                       description = \"link\" in [inertia], or delete this";
        return Err(document.error(&Field::new("validation").at(0), message));
    }
    let (fitted, others) = tables.split_at(all.poses.len());
    for (place, table) in others.iter().enumerate() {
        let unknown = |load: &usize| loads[*load].position.is_none() && fitted.iter().all(|f| f.load != Some(*load));
        if let Some(load) = table.load.filter(unknown) {
            let message = format!(
                "where the load `{}` hangs no table of [[poses]] tells, so nothing can be predicted: state its position_m, or \
                 use it in [[poses]], too",
                loads[load].name
            );
            return Err(document.error(&Field::new("validation").at(place).key("load"), message));
        }
    }
    Ok(())
}

fn table(context: &Context<'_>, loads: &[Load], field: &Field, written: &PosesTable) -> Result<PoseTable, FileError> {
    let document = context.document;
    let load = written.load.as_ref().map(|name| load(document, loads, &field.key("load"), name));
    let swept = written.swept.as_ref().map(|name| swept(context, &field.key("swept"), name));
    if let Some(step) = written.step.filter(|step| !(1..=3).contains(step)) {
        let message = format!("the sequential procedure has the steps 1, 2 and 3, not {step}");
        return Err(document.error(&field.key("step"), message));
    }
    Ok(PoseTable {
        path: document.resolve_path(&field.key("file"), &written.file)?,
        load: load.transpose()?,
        swept: swept.transpose()?,
        step: written.step,
    })
}

fn load(document: &Document, loads: &[Load], field: &Field, written: &OneOrMany<String>) -> Result<usize, FileError> {
    let names: Vec<&str> = loads.iter().map(|load| load.name.as_str()).collect();
    match written {
        OneOrMany::One(name) => document.lookup(field, "load", name, &names),
        OneOrMany::Many(list) if let [name] = list.as_slice() => document.lookup(field, "load", name, &names),
        OneOrMany::Many(_) => Err(document.error(
            field,
            "a pose carries one load: describe bodies on one link as one load (their masses together, at their common \
             centre of mass), and record loads on different links one after the other, in tables of their own",
        )),
    }
}

fn swept(context: &Context<'_>, field: &Field, name: &str) -> Result<usize, FileError> {
    let joint = context.document.lookup(field, "joint", name, &context.joint_names)?;
    match context.robot.chain.joints()[joint].kind {
        JointKind::Revolute => Ok(joint),
        JointKind::Prismatic => {
            let message = format!("joint `{name}` is prismatic, and only a joint that turns can be swept: delete this");
            Err(context.document.error(field, message))
        }
    }
}

/// The same readings twice would be twice as certain as they are.
fn check_read_once(
    document: &Document,
    all: WrittenTables<'_>,
    tables: &[PoseTable],
    parts: &[[f64; 2]],
) -> Result<(), FileError> {
    let mut seen: Vec<PathBuf> = Vec::new();
    for (place, table) in tables.iter().enumerate() {
        // A file that is not there is told of when it is read.
        let path = fs::canonicalize(&table.path).unwrap_or_else(|_| table.path.clone());
        let [from, until] = parts[place];
        let same = |other: &(&PathBuf, &[f64; 2])| *other.0 == path && from < other.1[1] && other.1[0] < until;
        if let Some(first) = seen.iter().zip(parts).position(|other| same(&other)) {
            let message = format!("this table is already {}: every reading may enter once only", all.field(first));
            return Err(document.error(&all.field(place).key("file"), message));
        }
        seen.push(path);
    }
    Ok(())
}

/// The poses of all tables, in order, and how many torque readings of each joint are none.
pub(super) struct ReadPoses {
    pub poses: Vec<Pose>,
    pub saturated: Vec<usize>,
    pub in_motion: Vec<usize>,
    /// What was found in recordings in motion, and what was lost of files.
    pub searched: Vec<Searched>,
    /// See [`Session::turns`](gravcal_robot_model::session::Session::turns).
    pub turns: Vec<Option<f64>>,
}

impl ReadPoses {
    pub fn none(joints: usize) -> ReadPoses {
        let (poses, searched) = (Vec::new(), Vec::new());
        ReadPoses { poses, saturated: vec![0; joints], in_motion: vec![0; joints], searched, turns: Vec::new() }
    }

    /// Poses of the table with this index.
    pub fn take(&mut self, table: usize, load: Option<usize>, poses: impl IntoIterator<Item = StaticPose>) {
        for pose in poses {
            pose.saturated.iter().for_each(|joint| self.saturated[*joint] += 1);
            self.poses.push(of_table(table, load, pose));
        }
    }

    /// Windows of the same.
    pub fn take_windows(
        &mut self,
        table: usize,
        load: Option<usize>,
        windows: impl IntoIterator<Item = (StaticPose, Arc<Course>)>,
    ) {
        for (means, course) in windows {
            self.take(table, load, [means]);
            if let Some(window) = self.poses.last_mut() {
                window.course = Some(course);
            }
        }
    }
}

/// Reads all tables.
pub(super) fn read_all(
    document: &Document,
    memory: &Memory,
    written: WrittenTables<'_>,
    tables: &[PoseTable],
    mapping: &PoseMapping,
) -> Result<ReadPoses, SessionError> {
    let mut all = ReadPoses::none(mapping.torques.len());
    for (index, (table, from)) in tables.iter().zip(written.iter()).enumerate() {
        let read = memory.read_part(&table.path, mapping, from.part_of_recording());
        let read = read.map_err(|error| written.wrong(document, index, error))?;
        all.in_motion.iter_mut().zip(&read.in_motion).for_each(|(all, here)| *all += here);
        if !read.remarks.is_empty() {
            let path = table.path.clone();
            all.searched.push(Searched { table: index, path, remarks: read.remarks, ..Searched::default() });
        }
        all.take(index, table.load, read.poses);
    }
    count_time_from_first(&mut all.poses);
    Ok(all)
}

/// The clock of a recording may count from any year, of which a drift times the time would leave no digit.
pub(super) fn count_time_from_first(poses: &mut [Pose]) {
    let first = poses.iter().filter_map(|pose| pose.conditions.time).reduce(f64::min).unwrap_or(0.0);
    poses.iter_mut().filter_map(|pose| pose.conditions.time.as_mut()).for_each(|time| *time -= first);
}

fn of_table(table: usize, load: Option<usize>, pose: StaticPose) -> Pose {
    let StaticPose { line, position, orientation, torque, saturated: _, instruments, sweep, conditions, merged: _ } =
        pose;
    Pose { table, line, sweep_label: sweep, load, position, orientation, torque, instruments, conditions, course: None }
}
