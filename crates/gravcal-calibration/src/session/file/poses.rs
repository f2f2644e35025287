//! `[[poses]]`: the tables of static poses.

use std::fs;
use std::path::PathBuf;

use gravcal_kinematics::JointKind;
use gravcal_recording::{Part, PoseMapping, ReadError, StaticPose, read_part};
use serde::Deserialize;

use super::{Context, SessionError};
use crate::document::{Document, Field, FileError, OneOrMany};
use crate::session::{Load, Pose, PoseTable, Searched};

/// `[[poses]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct PosesTable {
    pub(super) file: String,
    load: Option<OneOrMany<String>>,
    swept: Option<String>,
    step: Option<u8>,
    from_s: Option<f64>,
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

pub(super) fn field(table: usize) -> Field {
    Field::new("poses").at(table)
}

/// What the `[[poses]]` come to, without opening the files; `clock`: whether they have one.
pub(super) fn tables(
    context: &Context<'_>,
    loads: &[Load],
    tables: &[PosesTable],
    clock: bool,
) -> Result<Vec<PoseTable>, FileError> {
    if tables.is_empty() {
        let message = "there are no poses: add [[poses]] with file = \"<a table>.csv\"";
        return Err(context.document.error(&Field::new("poses"), message));
    }
    for (index, written) in tables.iter().enumerate() {
        check_part(context.document, &field(index), written, clock)?;
    }
    let parts: Vec<[f64; 2]> = tables.iter().map(PosesTable::part).collect();
    let tables: Vec<PoseTable> = tables
        .iter()
        .enumerate()
        .map(|(i, written)| table(context, loads, &field(i), written))
        .collect::<Result<_, _>>()?;
    check_read_once(context.document, &tables, &parts)?;
    Ok(tables)
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
fn check_read_once(document: &Document, tables: &[PoseTable], parts: &[[f64; 2]]) -> Result<(), FileError> {
    let mut seen: Vec<PathBuf> = Vec::new();
    for (place, table) in tables.iter().enumerate() {
        // A file that is not there is told of when it is read.
        let path = fs::canonicalize(&table.path).unwrap_or_else(|_| table.path.clone());
        let [from, until] = parts[place];
        let same = |other: &(&PathBuf, &[f64; 2])| *other.0 == path && from < other.1[1] && other.1[0] < until;
        if let Some(first) = seen.iter().zip(parts).position(|other| same(&other)) {
            let message = format!("this table is already {}: every reading may enter once only", field(first));
            return Err(document.error(&field(place).key("file"), message));
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
}

impl ReadPoses {
    pub fn none(joints: usize) -> ReadPoses {
        let (poses, searched) = (Vec::new(), Vec::new());
        ReadPoses { poses, saturated: vec![0; joints], in_motion: vec![0; joints], searched }
    }

    /// Poses of the table with this index.
    pub fn take(&mut self, table: usize, load: Option<usize>, poses: impl IntoIterator<Item = StaticPose>) {
        for pose in poses {
            pose.saturated.iter().for_each(|joint| self.saturated[*joint] += 1);
            self.poses.push(of_table(table, load, pose));
        }
    }
}

/// What is wrong with a table, and where the session names it.
pub(super) fn in_table(document: &Document, index: usize, written: &PosesTable, error: ReadError) -> SessionError {
    SessionError::Table { error, named_by: document.named_by(&field(index).key("file"), &written.file) }
}

/// Reads all tables.
pub(super) fn read_all(
    document: &Document,
    written: &[PosesTable],
    tables: &[PoseTable],
    mapping: &PoseMapping,
) -> Result<ReadPoses, SessionError> {
    let mut all = ReadPoses::none(mapping.torques.len());
    for (index, (written, table)) in written.iter().zip(tables).enumerate() {
        let read = read_part(&table.path, mapping, written.part_of_recording());
        let read = read.map_err(|error| in_table(document, index, written, error))?;
        all.in_motion.iter_mut().zip(&read.in_motion).for_each(|(all, here)| *all += here);
        if !read.remarks.is_empty() {
            all.searched.push(Searched {
                path: table.path.clone(),
                standstills: None,
                sweeps: None,
                remarks: read.remarks,
            });
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
    let StaticPose { line, position, torque, saturated: _, instruments, sweep, conditions, merged: _ } = pose;
    Pose { table, line, sweep_label: sweep, load, position, torque, instruments, conditions }
}
