//! A line on a terminal that tells what takes so long, once it does.

use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

use indicatif::ProgressBar;

/// Nobody needs to be told of what is over before.
const PATIENCE: Duration = Duration::from_secs(1);
/// Between two pictures of the spinner.
const TICK: Duration = Duration::from_millis(100);

/// The line; it is cleared when this is dropped.
#[derive(Debug)]
pub struct Progress {
    /// Takes the stages; `None` where nothing is shown.
    stages: Option<Sender<String>>,
    line: Option<JoinHandle<()>>,
}

impl Progress {
    /// Shows nothing if `quiet`, or if nobody looks at a terminal.
    pub fn new(quiet: bool) -> Progress {
        if quiet || !stderr().is_terminal() {
            return Progress { stages: None, line: None };
        }
        let (stages, told) = channel();
        Progress { stages: Some(stages), line: Some(spawn(move || show(&told))) }
    }

    /// Another stage begins.
    pub fn stage(&self, stage: &str) {
        if let Some(stages) = &self.stages {
            // The receiver ends only after the sender.
            let _ = stages.send(stage.to_owned());
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.stages = None; // hangs up, which ends the thread
        if let Some(line) = self.line.take() {
            let _ = line.join();
        }
    }
}

/// Shows the newest stage until the sender hangs up.
fn show(stages: &Receiver<String>) {
    let Some(stage) = newest_after_patience(stages) else { return };
    let spinner = ProgressBar::new_spinner().with_message(stage);
    loop {
        match stages.recv_timeout(TICK) {
            Ok(stage) => spinner.set_message(stage),
            Err(RecvTimeoutError::Timeout) => spinner.tick(),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    spinner.finish_and_clear();
}

/// The stage at the end of [`PATIENCE`]; nothing if the sender hung up before.
fn newest_after_patience(stages: &Receiver<String>) -> Option<String> {
    let deadline = std::time::Instant::now() + PATIENCE;
    let mut newest = String::new();
    loop {
        let left = deadline.saturating_duration_since(std::time::Instant::now());
        match stages.recv_timeout(left) {
            Ok(stage) => newest = stage,
            Err(RecvTimeoutError::Timeout) => return Some(newest),
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_over_soon_is_not_shown() {
        let (stages, told) = channel();
        stages.send("solving".to_owned()).unwrap();
        drop(stages);
        assert_eq!(newest_after_patience(&told), None);
    }

    #[test]
    fn after_a_while_the_newest_stage_is_shown() {
        let (stages, told) = channel();
        for stage in ["starting", "solving"] {
            stages.send(stage.to_owned()).unwrap();
        }
        assert_eq!(newest_after_patience(&told).as_deref(), Some("solving"));
    }

    #[test]
    fn quiet_is_quiet() {
        let progress = Progress::new(true);
        progress.stage("solving");
        assert!(progress.line.is_none());
    }
}
