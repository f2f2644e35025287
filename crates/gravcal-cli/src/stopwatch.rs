//! How long the parts of a calibration take.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use gravcal_report::Timing;

/// The parts that are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Reading the session.
    Read,
    /// Finding starting values.
    Start,
    /// Solving.
    Solve,
    /// Judging.
    Judge,
}

impl Phase {
    /// The part to which a stage of the estimators belongs, by the words in which they tell it.
    pub fn of_stage(stage: &str) -> Phase {
        let begins = |words: &[&str]| words.iter().any(|word| stage.starts_with(word));
        if begins(&["starting"]) {
            Phase::Start
        } else if begins(&["judging", "predicting"]) {
            Phase::Judge
        } else {
            Phase::Solve
        }
    }
}

/// Measures how long each phase takes.
#[derive(Debug)]
pub struct Stopwatch(Mutex<State>);

#[derive(Debug)]
struct State {
    phase: Phase,
    since: Instant,
    times: Timing,
}

impl Stopwatch {
    /// Starts with a phase.
    pub fn start(phase: Phase) -> Stopwatch {
        Stopwatch(Mutex::new(State { phase, since: Instant::now(), times: Timing::default() }))
    }

    /// Another phase begins.
    pub fn enter(&self, phase: Phase) {
        let mut state = self.state();
        state.book();
        state.phase = phase;
    }

    /// The times up to now.
    pub fn times(&self) -> Timing {
        let mut state = self.state();
        state.book();
        state.times
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Adds the time since the last booking to the phase in which it was spent.
    fn book(&mut self) {
        let now = Instant::now();
        let spent = now.duration_since(self.since).as_secs_f64() * 1e3;
        self.since = now;
        match self.phase {
            Phase::Read => self.times.read_ms += spent,
            Phase::Start => self.times.start_ms += spent,
            Phase::Solve => self.times.solve_ms += spent,
            Phase::Judge => self.times.judge_ms += spent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;
    use std::time::Duration;

    #[test]
    fn time_goes_to_the_phase_in_which_it_was_spent() {
        let watch = Stopwatch::start(Phase::Read);
        sleep(Duration::from_millis(2));
        watch.enter(Phase::Solve);
        sleep(Duration::from_millis(2));
        let times = watch.times();
        assert!(times.read_ms >= 2.0 && times.solve_ms >= 2.0);
        assert_eq!((times.start_ms, times.judge_ms), (0.0, 0.0));
    }

    #[test]
    fn stages_belong_to_phases() {
        assert_eq!(Phase::of_stage("starting values"), Phase::Start);
        assert_eq!(Phase::of_stage("step 2: gravity"), Phase::Solve);
        assert_eq!(Phase::of_stage("all unknowns together"), Phase::Solve);
        assert_eq!(Phase::of_stage("judging the sequential values on all readings"), Phase::Judge);
        assert_eq!(Phase::of_stage("predicting held-out poses"), Phase::Judge);
    }
}
