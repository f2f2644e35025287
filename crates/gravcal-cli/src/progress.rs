//! A line on a terminal that tells what takes so long, once it does.

use std::io::{IsTerminal, stderr};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

use gravcal_estimation::IterationRecord;
use gravcal_report::plain;
use gravcal_robot_model::{Registry, Session};
use gravcal_session::{SessionError, read_session_watched};
use indicatif::ProgressBar;

use crate::terminal;

/// Nobody needs to be told of what is over before.
const PATIENCE: Duration = Duration::from_secs(1);
/// Between two pictures of the spinner.
const TICK: Duration = Duration::from_millis(100);

/// What the line is told.
#[derive(Debug)]
enum Reported {
    /// Another stage begins.
    Stage(String),
    /// How far it is.
    Iteration(IterationRecord),
}

impl Reported {
    fn text(&self) -> String {
        match self {
            Reported::Stage(stage) => stage.clone(),
            Reported::Iteration(IterationRecord { iteration, cost, cosine, .. }) => {
                format!("  iteration {iteration}, cost {cost:.6e}, largest cosine {cosine:.1e}")
            }
        }
    }
}

/// The line; it is cleared when this is dropped.
#[derive(Debug)]
pub struct Progress {
    /// Takes what is told; `None` where nothing is shown.
    reported: Option<Sender<Reported>>,
    line: Option<JoinHandle<()>>,
    /// Whether everything is told at once in a line of its own, terminal or not.
    in_lines: bool,
}

impl Progress {
    /// Shows nothing if `quiet`, or if nobody looks at a terminal.
    pub fn new(quiet: bool) -> Progress {
        if quiet || !stderr().is_terminal() {
            return Progress { reported: None, line: None, in_lines: false };
        }
        let (sender, reported) = channel();
        Progress { reported: Some(sender), line: Some(spawn(move || show(&reported))), in_lines: false }
    }

    /// Tells every stage and iteration in a line of its own.
    pub fn in_lines() -> Progress {
        Progress { reported: None, line: None, in_lines: true }
    }

    /// Another stage begins.
    pub fn stage(&self, stage: &str) {
        self.report(|| Reported::Stage(plain(stage).into_owned()));
    }

    /// A session is read, of which long recordings are worth a word.
    pub fn read_session(&self, path: &Path, registry: &Registry) -> Result<Session, SessionError> {
        let watch = |recording: &Path, share: f64| {
            self.stage(&format!("reading {}: {:.0} %", recording.display(), 100.0 * share));
        };
        read_session_watched(path, registry, &watch)
    }

    /// The solver has done another iteration.
    pub fn iteration(&self, record: &IterationRecord) {
        self.report(|| Reported::Iteration(*record));
    }

    fn report(&self, reported: impl FnOnce() -> Reported) {
        if self.in_lines {
            terminal::complain(&reported().text());
        } else if let Some(sender) = &self.reported {
            // The receiver ends only after the sender.
            let _ = sender.send(reported());
        }
    }
}

/// What the line says.
#[derive(Debug, Default, PartialEq)]
struct Line {
    stage: String,
    iteration: Option<IterationRecord>,
}

impl Line {
    fn hear(&mut self, reported: Reported) {
        match reported {
            Reported::Stage(stage) => *self = Line { stage, iteration: None },
            Reported::Iteration(record) => self.iteration = Some(record),
        }
    }

    fn text(&self) -> String {
        let Some(IterationRecord { iteration, cost, cosine, .. }) = self.iteration else { return self.stage.clone() };
        format!("{}: iteration {iteration}, cost {cost:.6e}, largest cosine {cosine:.1e}", self.stage)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.reported = None; // hangs up, which ends the thread
        if let Some(line) = self.line.take() {
            let _ = line.join();
        }
    }
}

/// Shows what was told last until the sender hangs up.
fn show(reported: &Receiver<Reported>) {
    let Some(mut line) = line_after_patience(reported) else { return };
    let spinner = ProgressBar::new_spinner().with_message(line.text());
    loop {
        match reported.recv_timeout(TICK) {
            Ok(news) => {
                line.hear(news);
                spinner.set_message(line.text());
            }
            Err(RecvTimeoutError::Timeout) => spinner.tick(),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    spinner.finish_and_clear();
}

/// The line at the end of [`PATIENCE`]; nothing if the sender hung up before.
fn line_after_patience(reported: &Receiver<Reported>) -> Option<Line> {
    let deadline = std::time::Instant::now() + PATIENCE;
    let mut line = Line::default();
    loop {
        let left = deadline.saturating_duration_since(std::time::Instant::now());
        match reported.recv_timeout(left) {
            Ok(news) => line.hear(news),
            Err(RecvTimeoutError::Timeout) => return Some(line),
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECORD: IterationRecord =
        IterationRecord { iteration: 7, cost: 606.53, cosine: 3.2e-5, step: 0.1, damping: 1e-4 };

    #[test]
    fn what_is_over_soon_is_not_shown() {
        let (sender, reported) = channel();
        sender.send(Reported::Stage("solving".to_owned())).unwrap();
        drop(sender);
        assert_eq!(line_after_patience(&reported), None);
    }

    #[test]
    fn after_a_while_the_newest_stage_is_shown() {
        let (sender, reported) = channel();
        for stage in ["starting", "solving"] {
            sender.send(Reported::Stage(stage.to_owned())).unwrap();
        }
        assert_eq!(line_after_patience(&reported).unwrap().text(), "solving");
    }

    #[test]
    fn iterations_are_those_of_their_stage() {
        let mut line = Line::default();
        line.hear(Reported::Stage("solving".to_owned()));
        line.hear(Reported::Iteration(RECORD));
        assert_eq!(line.text(), "solving: iteration 7, cost 6.065300e2, largest cosine 3.2e-5");
        line.hear(Reported::Stage("judging".to_owned()));
        assert_eq!(line.text(), "judging");
    }

    #[test]
    fn quiet_is_quiet() {
        let progress = Progress::new(true);
        progress.stage("solving");
        progress.iteration(&RECORD);
        assert!(progress.line.is_none());
    }
}
