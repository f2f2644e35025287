//! Ctrl-C: the first asks the solver to stop after its current iteration, the second ends the program.

use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;
use crate::terminal;

/// What a shell tells of a program that Ctrl-C ended.
const ENDED_BY_INTERRUPT: i32 = 130;

/// Whether someone asked to stop.
#[derive(Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on.
    pub fn listen() -> Result<Interrupt, Failure> {
        let asked = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&asked);
        let handler = move || match is_second(&seen) {
            true => exit(ENDED_BY_INTERRUPT),
            false => terminal::complain("stopping; Ctrl-C once more ends the program at once"),
        };
        ctrlc::set_handler(handler).map_err(|error| Failure::bad_input(&error).about("Ctrl-C"))?;
        Ok(Interrupt(asked))
    }

    /// Whether someone asked to stop.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Set once someone asked to stop.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }
}

/// Notes another interrupt; whether there was one before.
fn is_second(asked: &AtomicBool) -> bool {
    asked.swap(true, Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_asks_and_the_second_ends() {
        let asked = AtomicBool::new(false);
        assert!(!is_second(&asked) && asked.load(Ordering::Relaxed));
        assert!(is_second(&asked));
    }
}
