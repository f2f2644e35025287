//! `[[poses]]`: the tables of static poses.

use std::fs;
use std::path::PathBuf;

use gravcal_kinematics::JointKind;
use gravcal_recording::{PoseMapping, StaticPose, read_poses};
use serde::Deserialize;

use super::{Context, SessionError};
use crate::document::{Document, Field, FileError, OneOrMany};
use crate::session::{Load, Pose, PoseTable};

/// `[[poses]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct PosesTable {
    file: String,
    load: Option<OneOrMany<String>>,
    swept: Option<String>,
    step: Option<u8>,
}

fn field(table: usize) -> Field {
    Field::new("poses").at(table)
}

/// What the `[[poses]]` come to, without opening the files.
pub(super) fn tables(
    context: &Context<'_>,
    loads: &[Load],
    tables: &[PosesTable],
) -> Result<Vec<PoseTable>, FileError> {
    if tables.is_empty() {
        let message = "there are no poses: add [[poses]] with file = \"<a table>.csv\"";
        return Err(context.document.error(&Field::new("poses"), message));
    }
    let tables: Vec<PoseTable> = tables
        .iter()
        .enumerate()
        .map(|(i, written)| table(context, loads, &field(i), written))
        .collect::<Result<_, _>>()?;
    check_read_once(context.document, &tables)?;
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
fn check_read_once(document: &Document, tables: &[PoseTable]) -> Result<(), FileError> {
    let mut seen: Vec<PathBuf> = Vec::new();
    for (place, table) in tables.iter().enumerate() {
        // A file that is not there is told of when it is read.
        let path = fs::canonicalize(&table.path).unwrap_or_else(|_| table.path.clone());
        if let Some(first) = seen.iter().position(|other| *other == path) {
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
}

/// Reads all tables.
pub(super) fn read_all(
    document: &Document,
    written: &[PosesTable],
    tables: &[PoseTable],
    mapping: &PoseMapping,
) -> Result<ReadPoses, SessionError> {
    let none = vec![0; mapping.torques.len()];
    let mut all = ReadPoses { poses: Vec::new(), saturated: none.clone(), in_motion: none };
    for (index, (written, table)) in written.iter().zip(tables).enumerate() {
        let read = read_poses(&table.path, mapping).map_err(|error| {
            let named_by = document.named_by(&field(index).key("file"), &written.file);
            SessionError::Table { error, named_by }
        })?;
        read.poses.iter().flat_map(|pose| &pose.saturated).for_each(|joint| all.saturated[*joint] += 1);
        all.in_motion.iter_mut().zip(&read.in_motion).for_each(|(all, here)| *all += here);
        all.poses.extend(read.poses.into_iter().map(|pose| of_table(index, table.load, pose)));
    }
    count_time_from_first(&mut all.poses);
    Ok(all)
}

/// The clock of a recording may count from any year, of which a drift times the time would leave no digit.
fn count_time_from_first(poses: &mut [Pose]) {
    let first = poses.iter().filter_map(|pose| pose.conditions.time).reduce(f64::min).unwrap_or(0.0);
    poses.iter_mut().filter_map(|pose| pose.conditions.time.as_mut()).for_each(|time| *time -= first);
}

fn of_table(table: usize, load: Option<usize>, pose: StaticPose) -> Pose {
    let StaticPose { line, position, torque, saturated: _, instruments, sweep, conditions, merged: _ } = pose;
    Pose { table, line, sweep_label: sweep, load, position, torque, instruments, conditions }
}
