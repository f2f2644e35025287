//! Which rows a table of trials holds, and in which order: point by point, trial by trial, estimator by estimator, solver by solver.

use std::path::{Path, PathBuf};

use super::BatchError;
use super::manifest::Manifest;
use super::part::Part;
use super::row::Row;

/// Rows that are still to come in a table.
pub(crate) struct Expected<'a> {
    path: PathBuf,
    manifest: &'a Manifest,
    rows: Box<dyn Iterator<Item = [u64; 4]> + 'a>,
}

impl<'a> Expected<'a> {
    /// Those of a table of some parts.
    pub(super) fn new(path: &Path, manifest: &'a Manifest, parts: impl Iterator<Item = Part> + 'a) -> Expected<'a> {
        let (estimators, solvers) = (manifest.estimators.len() as u64, manifest.solvers.len() as u64);
        let of_part = move |Part { point, trials, .. }: Part| {
            let of_trial = move |trial| {
                (0..estimators)
                    .flat_map(move |estimator| (0..solvers).map(move |solver| [point as u64, trial, estimator, solver]))
            };
            trials.flat_map(of_trial)
        };
        Expected { path: path.to_owned(), manifest, rows: Box::new(parts.flat_map(of_part)) }
    }

    /// Those of the table of a whole study.
    pub(crate) fn whole(path: &Path, manifest: &'a Manifest) -> Expected<'a> {
        Expected::new(path, manifest, manifest.parts().into_iter())
    }

    /// Takes the next row.
    ///
    /// # Errors
    /// Another one is to come.
    pub(crate) fn take(&mut self, row: &Row) -> Result<(), BatchError> {
        let found = [row.point as u64, row.trial, row.estimator as u64, row.solver as u64];
        match self.rows.next() {
            Some(expected) if expected == found => Ok(()),
            Some(expected) => {
                self.refuse(format!("here is {}, expected {}", self.reported(found), self.reported(expected)))
            }
            None => self.refuse(format!("it goes on with {} where it should end", self.reported(found))),
        }
    }

    /// The table has ended.
    ///
    /// # Errors
    /// Another row is to come.
    pub(crate) fn end(mut self) -> Result<(), BatchError> {
        match self.rows.next() {
            None => Ok(()),
            Some(expected) => self.refuse(format!("it ends before {}", self.reported(expected))),
        }
    }

    fn reported(&self, [point, trial, estimator, solver]: [u64; 4]) -> String {
        let Manifest { estimators, solvers, .. } = self.manifest;
        let [estimator, solver] = [(estimators, estimator), (solvers, solver)]
            .map(|(names, place)| names.get(place as usize).map_or("?", String::as_str));
        format!("trial {trial} of point {point} by {estimator}, {solver}")
    }

    fn refuse(&self, what: String) -> Result<(), BatchError> {
        let why = format!("its rows are not those of the study: {what}");
        Err(BatchError::Table { path: self.path.clone(), why })
    }
}
