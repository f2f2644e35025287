//! The state of a run in a file, so that an interrupted solve goes on to the same bits.
//!
//! One JSON document: the values of all blocks, D, the records, and what the method remembers; numbers come back to the
//! last bit. It is written beside its final name and renamed, so that the file is whole whenever the program dies. What is
//! read is held against the problem: a damaged file, another method, other blocks, other fixed values, or another cost at the
//! same values is an error, never a fresh start. Options are not kept: those of the new solve hold.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use argmin::core::checkpointing::{Checkpoint, CheckpointingFrequency};
use argmin::core::{Error, State};
use gravcal_estimation::{Block, BlockId, IterationRecord, Problem, SolveError, Values};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::run::{IterationState, Run};

const FORMAT: &str = "gravcal-checkpoint/1";
/// What to do about a file that is not of this solve.
const CURE: &str = "delete it to start anew, or name another file";

/// The file.
#[derive(Debug, Serialize, Deserialize)]
struct Saved<M> {
    format: String,
    solver: String,
    /// Each block in words: name, numbers, and the values of fixed ones.
    blocks: Vec<String>,
    values: Vec<f64>,
    scaling: Vec<f64>,
    /// Cost, cosine, step and damping of each iteration, the start first.
    records: Vec<[f64; 4]>,
    memory: M,
}

/// The checkpoint of one solve.
#[derive(Clone, Debug)]
pub(crate) struct CheckpointFile {
    path: PathBuf,
    solver: &'static str,
    blocks: Vec<String>,
    ids: Vec<BlockId>,
    initial: Values,
    columns: usize,
}

impl CheckpointFile {
    pub fn new(path: &Path, solver: &'static str, problem: &Problem, initial: &Values) -> Self {
        let ids: Vec<BlockId> = problem.block_ids().collect();
        let blocks = ids.iter().map(|id| in_words(problem.block(*id), initial.get(*id))).collect();
        let columns = problem.columns().len();
        CheckpointFile { path: path.into(), solver, blocks, ids, initial: initial.clone(), columns }
    }

    /// Removes the file, if it was ever written.
    pub fn remove(&self) -> Result<(), SolveError> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(self.error(format!("the solve has ended, but the file cannot be removed: {error}")))
            }
            _ => Ok(()),
        }
    }

    fn error(&self, reason: String) -> SolveError {
        SolveError::Checkpoint { path: self.path.clone(), reason }
    }

    fn write(&self, contents: &[u8]) -> io::Result<()> {
        let mut partial = self.path.clone().into_os_string();
        partial.push(".partial");
        let mut file = File::create(&partial)?;
        file.write_all(contents)?;
        file.sync_all()?;
        fs::rename(&partial, &self.path)
    }

    fn read(&self) -> Result<Option<Vec<u8>>, SolveError> {
        match fs::read(&self.path) {
            Ok(contents) => Ok(Some(contents)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(self.error(format!("cannot be read: {error}"))),
        }
    }

    /// Why a file is not one of this solve, if it is not.
    fn fault<M>(&self, saved: &Saved<M>) -> Option<String> {
        if saved.format != FORMAT {
            return Some(format!("has the format `{}`, not `{FORMAT}`", saved.format));
        }
        if saved.solver != self.solver {
            return Some(format!("is of {}, not of {}", saved.solver, self.solver));
        }
        if saved.blocks.len() != self.blocks.len() {
            return Some(format!("is of a problem with {} blocks, not {}", saved.blocks.len(), self.blocks.len()));
        }
        if let Some((theirs, ours)) = saved.blocks.iter().zip(&self.blocks).find(|(theirs, ours)| theirs != ours) {
            return Some(format!("is of a problem with the block {theirs}, not {ours}"));
        }
        let lengths = (saved.values.len(), saved.scaling.len());
        let whole = lengths == (self.initial.as_slice().len(), self.columns) && !saved.records.is_empty();
        (!whole).then(|| "is damaged: numbers are missing".into())
    }

    fn values(&self, numbers: &[f64]) -> Values {
        let mut values = self.initial.clone();
        let mut rest = numbers;
        for id in &self.ids {
            let (own, others) = rest.split_at(values.get(*id).len());
            values.set(*id, own);
            rest = others;
        }
        values
    }
}

/// The cost at the saved values is not the one that was saved with them.
pub(crate) fn other_cost(path: &Path, here: f64, then: f64) -> SolveError {
    let reason =
        format!("is of a problem with other readings: the cost at its values was {then:e} and is {here:e}; {CURE}");
    SolveError::Checkpoint { path: path.into(), reason }
}

fn record((iteration, [cost, cosine, step, damping]): (usize, [f64; 4])) -> IterationRecord {
    IterationRecord { iteration, cost, cosine, step, damping }
}

fn in_words(block: &Block, value: &[f64]) -> String {
    match block.fixed {
        Some(_) => format!("`{}` held at {value:?}", block.name),
        None => format!("`{}` of {} numbers", block.name, block.len()),
    }
}

impl<'p, M: Default + Serialize + DeserializeOwned> Checkpoint<Run<'p, M>, IterationState> for CheckpointFile {
    fn save(&self, run: &Run<'p, M>, _: &IterationState) -> Result<(), Error> {
        let Some(point) = &run.point else { return Ok(()) };
        let saved = Saved {
            format: FORMAT.into(),
            solver: self.solver.into(),
            blocks: self.blocks.clone(),
            values: point.values.as_slice().to_vec(),
            scaling: point.scaling.clone(),
            records: run.records.iter().map(|r| [r.cost, r.cosine, r.step, r.damping]).collect(),
            memory: &run.memory,
        };
        let written = serde_json::to_vec(&saved).map_err(io::Error::from).and_then(|contents| self.write(&contents));
        written.map_err(|error| Error::from(self.error(format!("cannot be written: {error}"))))
    }

    fn load(&self) -> Result<Option<(Run<'p, M>, IterationState)>, Error> {
        let Some(contents) = self.read()? else { return Ok(None) };
        let saved: Saved<M> =
            serde_json::from_slice(&contents).map_err(|error| self.error(format!("is damaged: {error}; {CURE}")))?;
        if let Some(fault) = self.fault(&saved) {
            return Err(self.error(format!("{fault}; {CURE}")).into());
        }
        let mut state = IterationState::new().max_iters(u64::MAX);
        state.iter = saved.records.len() as u64; // not the start: argmin does not call `init` again
        let run = Run {
            records: saved.records.into_iter().enumerate().map(record).collect(),
            restored: Some((self.values(&saved.values), saved.scaling)),
            memory: saved.memory,
            ..Run::default()
        };
        Ok(Some((run, state)))
    }

    fn frequency(&self) -> CheckpointingFrequency {
        CheckpointingFrequency::Always
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use gravcal_estimation::{Constraint, Estimate, IterationRecord, SolveContext, Termination};

    use super::*;
    use crate::SolverName;
    use crate::testing::{DESCENTS, built, decay, far_decay, linear, scalar};

    /// Solves the decay, with a checkpoint, until a record after which someone asks to stop.
    fn solve(solver: SolverName, path: &Path, last: usize) -> Result<Estimate, SolveError> {
        let (problem, initial) = far_decay();
        let stop = AtomicBool::new(false);
        let mut observer = |record: &IterationRecord| stop.store(record.iteration >= last, Ordering::Relaxed);
        let mut context = SolveContext { observer: Some(&mut observer), stop: Some(&stop), checkpoint: Some(path) };
        solver.build().solve(&problem, &initial, &mut context)
    }

    fn bits(estimate: &Estimate) -> (Vec<u64>, u64) {
        (estimate.values.as_slice().iter().map(|v| v.to_bits()).collect(), estimate.cost.to_bits())
    }

    #[test]
    fn an_interrupted_solve_goes_on_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("solve.json");
        for solver in DESCENTS {
            let whole = solve(solver, &path, usize::MAX).unwrap();
            assert!(whole.termination.converged() && !path.exists(), "{solver}: {}", whole.termination);
            for last in [0, 1, 5] {
                let part = solve(solver, &path, last).unwrap();
                assert_eq!((part.termination, part.iterations.len()), (Termination::Stopped, last + 1), "{solver}");
                assert!(path.exists());
                let rest = solve(solver, &path, usize::MAX).unwrap();
                assert_eq!(bits(&rest), bits(&whole), "{solver}, stopped after {last}");
                assert_eq!((rest.termination, &rest.iterations), (whole.termination, &whole.iterations));
                assert!(!path.exists());
            }
        }
    }

    #[test]
    fn a_constrained_solve_goes_on_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("solve.json");
        let (problem, initial) = far_decay();
        let rate = problem.find("rate").unwrap();
        let bound = Constraint::bound("the rate is at least 0.9", rate, 0, 0.9, f64::INFINITY);
        let problem = problem.with_constraints(vec![bound]).unwrap();
        let solve = |last: usize| {
            let stop = AtomicBool::new(false);
            let mut observer = |record: &IterationRecord| stop.store(record.iteration >= last, Ordering::Relaxed);
            let mut context =
                SolveContext { observer: Some(&mut observer), stop: Some(&stop), checkpoint: Some(&path) };
            SolverName::Clarabel.build().solve(&problem, &initial, &mut context).unwrap()
        };
        let whole = solve(usize::MAX);
        assert!(whole.termination.converged() && whole.active.len() == 1 && !path.exists());
        for last in [0, 1, 4] {
            assert_eq!(solve(last).termination, Termination::Stopped);
            assert!(path.exists());
            let rest = solve(usize::MAX);
            assert_eq!((bits(&rest), &rest.iterations, &rest.active), (bits(&whole), &whole.iterations, &whole.active));
        }
    }

    #[test]
    fn a_file_that_is_not_of_this_solve_is_an_error_that_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("solve.json");
        let solver = SolverName::LevenbergMarquardt;
        solve(solver, &path, 3).unwrap();
        let whole = fs::read_to_string(&path).unwrap();
        let refused = |contents: &str, reported: &str| {
            fs::write(&path, contents).unwrap();
            let error = solve(solver, &path, usize::MAX).unwrap_err().to_string();
            let expected = ["solve.json", reported, "; delete it to start anew, or name another file"];
            assert!(expected.iter().all(|text| error.contains(text)), "{error}");
            assert_eq!(fs::read_to_string(&path).unwrap(), contents, "the file was touched");
        };
        refused(&whole[..whole.len() / 2], "is damaged: EOF while parsing");
        refused(&whole.replace("\"values\":[", "\"values\":[1.0,"), "is damaged: numbers are missing");
        refused(&whole.replace("checkpoint/1", "checkpoint/9"), "has the format `gravcal-checkpoint/9`");
        refused(&whole.replace("levenberg-marquardt", "dogleg"), "is of dogleg, not of levenberg-marquardt");
        refused(&whole.replace("`rate`", "`speed`"), "with the block `speed` of 1 numbers, not `rate` of 1 numbers");
        fs::write(&path, &whole).unwrap();
        assert!(solve(solver, &path, usize::MAX).is_ok());
    }

    #[test]
    fn other_readings_are_another_problem() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("solve.json");
        solve(SolverName::Dogleg, &path, 3).unwrap();
        let blocks = vec![scalar("rate", 2.0), linear("amplitude", 9.0), linear("level", -4.0)];
        let (other, initial) = built(blocks, 14, |x, r, j| {
            let (mut rows, mut columns) = ([0.0; 15], [0.0; 45]);
            decay(x, &mut rows, &mut columns)?;
            r.copy_from_slice(&rows[..14]);
            j.copy_from_slice(&columns[..42]);
            Ok(())
        });
        let mut context = SolveContext { checkpoint: Some(&path), ..SolveContext::default() };
        let error = SolverName::Dogleg.build().solve(&other, &initial, &mut context).unwrap_err().to_string();
        assert!(error.contains("is of a problem with other readings: the cost at its values was"), "{error}");
    }

    #[test]
    fn what_cannot_be_written_is_an_error() {
        let error = solve(SolverName::GaussNewton, Path::new("/no/such/folder/solve.json"), 9).unwrap_err();
        assert!(error.to_string().starts_with("the checkpoint /no/such/folder/solve.json cannot be written: "));
    }
}
