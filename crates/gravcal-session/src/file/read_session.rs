//! From `session.toml` and all that it names to a session.

use std::iter;
use std::path::{Path, PathBuf};

use gravcal_recording::{InputRole, Memory};
use gravcal_robot_model::Registry;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{Deflection, InputFile, Pose, PoseTable, Session};

use super::context::{Context, SessionError};
use super::declared::Declared;
use super::poses::{ReadPoses, WrittenTables};
use super::session_table::SessionTable;
use super::{
    deflection, inertia, loads, missing_noise, model_derivatives, motion, orientation, poses, prior, residuals,
    single_poses, uncertainty, unexplained,
};
use crate::document::{Document, Field, FileError};
use crate::robot_file::{RobotSource, resolve_robot};

/// Reads `session.toml` and everything it names.
///
/// # Errors
/// Names the file, the line and the field.
pub fn read_session(path: &Path) -> Result<Session, SessionError> {
    read_session_with(path, &Registry::standard())
}

/// The same; `registry` says what may be named, such as sensor models of one's own.
///
/// # Errors
/// As [`read_session`].
pub fn read_session_with(path: &Path, registry: &Registry) -> Result<Session, SessionError> {
    read_session_watched(path, registry, &|_, _| {})
}

/// The same; `watch` is told which recording in motion is being read, and which share of it is, as these may be long.
///
/// # Errors
/// As [`read_session`].
pub fn read_session_watched(
    path: &Path,
    registry: &Registry,
    watch: &dyn Fn(&Path, f64),
) -> Result<Session, SessionError> {
    read(&Document::read(path)?, registry, &Memory::default(), watch)
}

/// The same from a document, which may be another text than that of the file.
///
/// # Errors
/// As for [`read_session`].
pub fn read_session_document(document: &Document, registry: &Registry) -> Result<Session, SessionError> {
    read(document, registry, &Memory::default(), &|_, _| {})
}

/// The same from a document and recordings in memory, which it names as it would name files in its folder. Of these only what is a
/// file is among the [`inputs`](Session::inputs).
///
/// # Errors
/// As for [`read_session`].
pub fn read_session_in_memory(
    document: &Document,
    registry: &Registry,
    memory: &Memory,
    watch: &dyn Fn(&Path, f64),
) -> Result<Session, SessionError> {
    let session = read(document, registry, memory, watch)?;
    let is_file = |input: &&InputFile| input.role != InputRole::Session && !memory.holds(&input.path);
    Ok(Session { inputs: session.inputs.iter().filter(is_file).cloned().collect(), ..session })
}

/// Reads a session and everything it names. What `session.toml` says is checked before any table is opened.
/// `watch` is told how far each recording in motion is read.
fn read(
    document: &Document,
    registry: &Registry,
    memory: &Memory,
    watch: &dyn Fn(&Path, f64),
) -> Result<Session, SessionError> {
    let written: SessionTable = document.parse()?;
    orientation::check_robot(document, written.robot.as_ref(), &written.readings)?;
    let (robot, robot_path) = robot(document, written.robot.as_ref())?;
    let context = Context::new(document, &robot, robot_path.as_deref().unwrap_or(document.path()));

    let declared = Declared::resolve(&context, registry, &written)?;
    let all = WrittenTables { poses: &written.poses, validation: &written.validation };
    let mut tables = poses::tables(&context, &declared.loads, all, declared.has_clock())?;
    let read = declared.read_poses(&context, (memory, watch), all, &mut tables)?;
    poses::check_validation(document, all, (&declared.loads, &declared.inertia), &tables)?;
    let ReadPoses { poses, saturated, in_motion, searched, turns } = read;
    let (poses, validation) = poses.into_iter().partition(|pose: &Pose| pose.table < all.poses.len());
    let poses = checked(document, poses)?;
    let uncertainty = uncertainty::resolve(&context, &written.uncertainty, &poses)?;
    let inputs = inputs(document.path(), robot_path.as_deref(), &tables);

    let (unexplained, finds_rest) = (declared.unexplained.clone(), declared.motion.finds_rest());
    let session = Session {
        tables,
        poses,
        validation,
        saturated,
        in_motion,
        searched,
        turns,
        uncertainty,
        inputs,
        ..declared.session(&context, &written)
    };
    let deflection = Deflection { rounding_std: deflection::rounding_std(&session), ..session.deflection.clone() };
    let static_friction = session.find_static_friction();
    let session = without_friction_in_validation(Session { deflection, static_friction, ..session });
    let session = match &written.prior {
        None => session,
        Some(prior) => prior::resolve(&context, prior, (all, memory), session)?,
    };
    check(&context, &session)?;
    let session = unexplained::resolve(document, &unexplained, finds_rest && !session.has_windows(), session)?;
    Ok(Session { repeated: session.find_repeated(), doubts: session.find_doubts(), ..session })
}

/// The robot, with the path of its file; without one a body that stands as the tables say.
fn robot(document: &Document, source: Option<&RobotSource>) -> Result<(Robot, Option<PathBuf>), FileError> {
    let read = source.map(|source| resolve_robot(document, &Field::new("robot"), source)).transpose()?;
    Ok(match read {
        Some((robot, path)) => (robot, Some(path)),
        None => (orientation::free_body(), None),
    })
}

/// What friction leaves in a standing joint is an unknown of each sweep, which nothing predicts in recordings that enter no fit.
fn without_friction_in_validation(mut session: Session) -> Session {
    let mut validation = std::mem::take(&mut session.validation);
    for pose in &mut validation {
        let Some(swept) = session.swept_in_recording(pose) else { continue };
        let sticks = |joint: usize| joint != swept && session.static_friction.get(joint).is_some_and(|f| *f > 0.0);
        pose.torque.iter_mut().enumerate().filter(|(joint, _)| sticks(*joint)).for_each(|(_, torque)| *torque = None);
    }
    Session { validation, ..session }
}

/// The poses that enter, where anything is read in any of them.
fn checked(document: &Document, mut poses: Vec<Pose>) -> Result<Vec<Pose>, FileError> {
    missing_noise::fill_in(&mut poses);
    motion::count_alike(&mut poses);
    if poses.iter().all(|pose| pose.torque.iter().chain(&pose.instruments).all(Option::is_none)) {
        let in_motion = poses.iter().any(|pose| pose.course.is_some());
        let or = match in_motion {
            true => {
                ", or of a joint that hardly moves as its positions are declared (are they in rad where readings.position says deg?)"
            }
            false => "",
        };
        let message = format!(
            "no table has a usable torque reading: every torque cell is empty, marked unusable, saturated, or in a row that \
             lacks an angle (angles and torques must stand in one row){or}"
        );
        return Err(document.error(&Field::new("readings").key("torque"), &message));
    }
    Ok(poses)
}

/// What the sections of a session say together must go with its poses.
fn check(context: &Context<'_>, session: &Session) -> Result<(), FileError> {
    inertia::check_displacements(context.document, session)?;
    inertia::check_sweeps(context.document, session)?;
    uncertainty::check_blocks(context.document, session)?;
    loads::check_unknown(context.document, session)?;
    motion::check(context, session)?;
    single_poses::check_single_poses(context.document, session)?;
    deflection::check_instruments(context.document, session)?;
    model_derivatives::check(context.document, session)?;
    residuals::check(context.document, session)
}

fn inputs(session: &Path, robot: Option<&Path>, tables: &[PoseTable]) -> Vec<InputFile> {
    let described = iter::once((InputRole::Session, session)).chain(robot.map(|path| (InputRole::Robot, path)));
    let recorded = tables.iter().map(|table| (InputRole::Recording, table.path.as_path()));
    described.chain(recorded).map(|(role, path)| InputFile::new(role, path)).collect()
}
