//! Which load is attached in a recording: what the command line says, else the recording, else the session that names the recording.

use std::path::{Path, PathBuf};

use gravcal_robot_model::Session;

use crate::failure::Failure;

/// A load, or none, and who says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attached {
    /// Its name.
    pub load: Option<String>,
    said_by: Option<&'static str>,
}

impl Attached {
    /// In `recording`, which says `said` of itself.
    ///
    /// # Errors
    /// Recording and session, or two parts of the recording in the session, disagree.
    pub fn new(
        named: Option<&str>,
        said: Option<&str>,
        session: &Session,
        recording: &Path,
    ) -> Result<Attached, Failure> {
        let loads = loads_in(session, recording);
        let by = |load: Option<&str>, who| Attached { load: load.map(str::to_owned), said_by: Some(who) };
        match (named, said, loads.as_slice()) {
            (Some(name), ..) => Ok(by(Some(name), "--load")),
            (None, Some(name), loads) if loads.iter().all(|load| load.is_none_or(|load| load == name)) => {
                Ok(by(Some(name), "the recording"))
            }
            (None, None, [load]) => Ok(by(*load, "the session")),
            (None, None, []) => Ok(Attached { load: None, said_by: None }),
            (None, ..) => {
                let reported: Vec<&str> =
                    said.into_iter().chain(loads.iter().map(|load| load.unwrap_or("none"))).collect();
                let message = format!(
                    "{}: which load is attached? It is said to be {}",
                    recording.display(),
                    reported.join(" and ")
                );
                Err(Failure::said(message).hint("--load NAME names it"))
            }
        }
    }

    /// Such as `load plate-a, as the session says`.
    pub fn reported(&self) -> String {
        let load = self.load.as_ref().map_or_else(|| "no load".to_owned(), |load| format!("load {load}"));
        match self.said_by {
            Some(who) => format!("{load}, as {who} says"),
            None => "no load is assumed".to_owned(),
        }
    }

    /// What its user should know, where nobody says what is attached.
    pub fn remark(&self) -> Option<String> {
        let remark = "no load is assumed: neither the recording nor a [[poses]] of the session says what is attached; --load NAME names it";
        self.said_by.is_none().then(|| remark.to_owned())
    }
}

/// The loads, each once, of all `[[poses]]` that name the recording or the folder that it is a file of.
fn loads_in<'s>(session: &'s Session, recording: &Path) -> Vec<Option<&'s str>> {
    let resolved = |path: &Path| path.canonicalize().ok();
    let own: Vec<PathBuf> =
        resolved(recording).into_iter().flat_map(|path| [path.clone(), with_folder(path)]).collect();
    let mut loads = Vec::new();
    for table in session.tables.iter().filter(|table| resolved(&table.path).is_some_and(|path| own.contains(&path))) {
        let load = table.load.map(|load| session.loads[load].name.as_str());
        if !loads.contains(&load) {
            loads.push(load);
        }
    }
    loads
}

fn with_folder(path: PathBuf) -> PathBuf {
    path.parent().map_or_else(|| path.clone(), Path::to_owned)
}
