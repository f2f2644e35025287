//! Runs the sessions of a population on several threads.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use gravcal_calibration::result::Verdict;
use gravcal_solvers::SolverName;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::starts::above_lowest;
use crate::tally::Trial;
use gravcal_benches::population::arm::Arm;
use gravcal_benches::population::calibrate::{Answer, calibrate};
use gravcal_benches::population::draw::{Kind, draw};
use gravcal_benches::population::independent::information;
use gravcal_benches::population::judge::judge;
use gravcal_benches::population::write::{write_session, write_truth};

/// Sessions of one kind.
pub struct Population {
    /// What they are like.
    pub kind: Kind,
    /// Of the random numbers.
    pub seed: u64,
    /// Arms that take turns with random ones.
    pub robots: Vec<Arm>,
    /// Where sessions are kept, if they are.
    pub keep: Option<PathBuf>,
    /// Methods that solve each session; times and errors are those of the first.
    pub methods: Vec<SolverName>,
    /// Random starts that each answer is held against.
    pub starts: u64,
}

impl Population {
    /// Runs these sessions; `watch` is told each as it ends, in any order.
    ///
    /// Each thread has a pool of its own with one thread, so that what rayon does inside a calibration stays there: else a thread that
    /// waits would take up another session, and count its time, too.
    ///
    /// # Errors
    /// Where files cannot be written, or a session cannot be judged.
    pub fn run(
        &self,
        numbers: Range<u64>,
        threads: usize,
        watch: &(dyn Fn(&Trial) + Sync),
    ) -> Result<Vec<Trial>, String> {
        let next = AtomicU64::new(numbers.start);
        let some = || -> Result<Vec<(u64, Trial)>, String> {
            let alone = ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| error.to_string())?;
            let mut trials = Vec::new();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= numbers.end {
                    return Ok(trials);
                }
                let trial = self.trial(number, &alone)?;
                watch(&trial);
                trials.push((number, trial));
            }
        };
        let parts: Vec<Result<_, String>> = std::thread::scope(|scope| {
            let running: Vec<_> = (0..threads).map(|_| scope.spawn(some)).collect();
            running
                .into_iter()
                .map(|thread| thread.join().unwrap_or_else(|_| Err("a thread panicked".into())))
                .collect()
        });
        let mut trials: Vec<(u64, Trial)> =
            parts.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        trials.sort_by_key(|(number, _)| *number);
        Ok(trials.into_iter().map(|(_, trial)| trial).collect())
    }

    fn trial(&self, number: u64, alone: &ThreadPool) -> Result<Trial, String> {
        let truth = draw(self.kind, &self.robots, self.seed, number)?;
        let name = format!("{}-{}-{number}-{}", self.kind.as_str(), self.seed, truth.arm.name);
        let temporary = tempfile::tempdir().map_err(|error| error.to_string())?;
        let folder = self.keep.as_deref().unwrap_or(temporary.path()).join(&name);
        write_session(&truth, &folder)?;
        let information = information(&truth)?;
        if self.keep.is_some() {
            write_truth(&truth, &information, &folder)?;
        }
        let session = folder.join("session.toml");
        let answered = |method: &SolverName| alone.install(|| calibrate(&session, *method));
        let mut answers = self.methods.iter().map(|method| (method, answered(method)));
        let (_, answer) = answers.next().ok_or("no method is chosen")?;
        let mut judged = judge(&truth, &information, &answer);
        let mut failed = usize::from(has_failed(&answer));
        for (method, other) in answers {
            failed += usize::from(has_failed(&other));
            judged.beside(method.as_str(), judge(&truth, &information, &other));
        }
        let result = answer.result.as_ref().ok();
        let above_lowest = match (result, self.starts) {
            (Some(_), 1..) => alone.install(|| above_lowest(&truth, &session, self.starts, number))?,
            _ => None,
        };
        let verdict = result.map(|result| result.verdict);
        Ok(Trial { name, verdict, seconds: answer.seconds, judged, failed, above_lowest })
    }
}

fn has_failed(answer: &Answer) -> bool {
    answer.result.as_ref().is_ok_and(|result| result.verdict == Verdict::Failed)
}
