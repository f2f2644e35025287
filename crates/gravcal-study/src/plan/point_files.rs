//! What one point of the grid simulates, and what the estimators are told: the simulation with the changes of the point, and the
//! session that such a simulation writes, with changes too.

use std::path::{Path, PathBuf};

use gravcal_recording::{InputRole, LARGEST_DOCUMENT, read_whole};
use gravcal_robot_model::Registry;
use gravcal_robot_model::session::{InputFile, Session};
use gravcal_session::document::{Document, Field, FileError};
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_session::{SessionError, read_session_document};
use sha2::{Digest, Sha256};
use toml::{Table, Value};

use super::StudyError;
use super::change::Change;

/// Fields that begin so are those of the session.
const SESSION: &str = "session.";

/// Makes simulation and session of one point.
pub(super) struct PointFiles<'a> {
    /// `study.toml`.
    pub document: &'a Document,
    pub registry: &'a Registry,
    /// Where the simulation is.
    pub path: &'a Path,
    /// The simulation without changes.
    pub base: &'a Table,
    pub changes: &'a [&'a Change],
    /// What is chosen at the point; nothing where nothing is varied.
    pub reported: &'a str,
}

impl PointFiles<'_> {
    /// What they are is counted in the hash.
    pub fn make(&self, hash: &mut Sha256) -> Result<(Simulation, Session), StudyError> {
        let mut table = self.base.clone();
        self.change(&mut table, false)?;
        let text = toml::to_string(&table).map_err(|error| self.refused(error))?;
        let simulation =
            Document::of(self.path, text.clone()).and_then(|document| Simulation::of(&document, self.registry));
        let simulation = simulation.map_err(|error| StudyError::Simulation {
            error: Box::new(error.without_line()),
            point: self.changed_at(),
        })?;
        if simulation.motion.is_some() {
            let error = self.refused("a study draws static poses, and this simulation makes recordings: add [[change]] field = \"recording\", drop = true");
            return Err(error.into());
        }
        hash.update(&text);
        let session = self.session(&simulation, hash)?;
        // The texts of the simulation and of the session, with their changes, are counted already.
        let all = simulation.template.inputs.iter().chain(&session.inputs);
        for InputFile { path, .. } in all.filter(|input| input.role != InputRole::Session) {
            let contents = read_whole(path, LARGEST_DOCUMENT);
            hash.update(contents.map_err(|cause| self.refused(format!("{}: {cause}", path.display())))?);
        }
        Ok((simulation, session))
    }

    fn refused(&self, message: impl std::fmt::Display) -> FileError {
        self.reported_at_point(self.document.error(&Field::new("simulation"), message))
    }

    /// With which changes something does not fit.
    fn changed_at(&self) -> String {
        let study = self.document.path().display();
        format!("with the changes of {study}{}{}", if self.reported.is_empty() { "" } else { ", " }, self.reported)
    }

    fn reported_at_point(&self, error: FileError) -> FileError {
        if self.reported.is_empty() { error } else { error.with_note(self.reported.to_owned()) }
    }

    fn change(&self, table: &mut Table, of_session: bool) -> Result<(), FileError> {
        for change in self.changes {
            let own = change.field.strip_prefix(SESSION);
            let applies = match own {
                Some(own) => of_session.then(|| Change { field: own.to_owned(), ..(*change).clone() }),
                None => (!of_session).then(|| (*change).clone()),
            };
            if let Some(change) = applies {
                change.make(table).map_err(|why| {
                    let what = format!("{why} in the {}", if of_session { "session" } else { "simulation" });
                    self.reported_at_point(self.document.error(&change.said, what))
                })?;
            }
        }
        Ok(())
    }

    /// The session as a user would have it: written for a first trial, changed, and read.
    fn session(&self, simulation: &Simulation, hash: &mut Sha256) -> Result<Session, StudyError> {
        let folder = tempfile::tempdir()?;
        let files = write_session(simulation, 0, folder.path(), false)?;
        let mut table: Table = Document::read(&files[0])?.parse()?;
        let robot = table.get("robot").cloned();
        self.change(&mut table, true)?;
        let mut said = table.clone();
        if table.get("robot") == robot.as_ref() {
            // What it holds counts, and not where this folder lies.
            said.remove("robot");
            table.get_mut("robot").into_iter().for_each(|robot| seen_from_anywhere(robot, folder.path()));
        }
        hash.update(toml::to_string(&said).map_err(|error| self.refused(error))?);
        if let Some(Value::Array(poses)) = table.get_mut("poses") {
            let files = poses.iter_mut().filter_map(|poses| poses.get_mut("file"));
            files.for_each(|file| seen_from_anywhere(file, folder.path()));
        }
        let absolute = toml::to_string(&table).map_err(|error| self.refused(error))?;
        let place = self.document.path().with_file_name("session.toml");
        let session = Document::of(&place, absolute)
            .map_err(SessionError::from)
            .and_then(|document| read_session_document(&document, self.registry));
        let mut session = session
            .map_err(|error| StudyError::Session { error: Box::new(without_line(error)), point: self.changed_at() })?;
        if let Some(residual) = session.residuals.first() {
            let name = &residual.name;
            return Err(self
                .refused(format!("simulations do not draw what the residual {name} observes: leave [[residual]] away"))
                .into());
        }
        let expected: usize = simulation.runs.iter().map(|run| run.poses()).sum();
        if session.poses.len() != expected {
            let found = session.poses.len();
            return Err(self
                .refused(format!("the session leaves out poses ({found} of {expected}): a study uses all"))
                .into());
        }
        session.inputs.retain(|input| !input.path.starts_with(folder.path()));
        Ok(session)
    }
}

/// The same without the line, which is that of a text that stands in no file.
fn without_line(error: SessionError) -> SessionError {
    match error {
        SessionError::File(error) => SessionError::File(error.without_line()),
        error @ SessionError::Table { .. } => error,
    }
}

/// A path relative to `folder`, as text or as the `urdf` of a table, becomes absolute.
fn seen_from_anywhere(written: &mut Value, folder: &Path) {
    match written {
        Value::String(path) => *path = absolute(folder.join(&path)),
        Value::Table(table) => {
            if let Some(Value::String(path)) = table.get_mut("urdf") {
                *path = absolute(folder.join(&path));
            }
        }
        _ => {}
    }
}

fn absolute(path: PathBuf) -> String {
    path.canonicalize().unwrap_or(path).to_string_lossy().into_owned()
}
