//! An error as its reader sees it: what, why, and what to do.

use std::borrow::Cow;
use std::error::Error;
use std::fmt;

use crate::exit::Exit;

/// Why the program ends early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// With which code.
    pub exit: Exit,
    message: String,
    causes: Vec<String>,
    hint: Option<String>,
}

impl Failure {
    /// Bad input or usage.
    pub fn bad_input(error: &dyn Error) -> Failure {
        Failure::new(Exit::BadInput, error)
    }

    /// There is no answer to the input.
    pub fn no_convergence(error: &dyn Error) -> Failure {
        Failure::new(Exit::Failed, error)
    }

    /// What was found cannot be printed or shown.
    pub fn not_shown(error: &dyn Error) -> Failure {
        Failure::new(Exit::NotShown, error)
    }

    /// Bad input that no library tells.
    pub fn said(message: impl Into<String>) -> Failure {
        Failure { exit: Exit::BadInput, message: message.into(), causes: Vec::new(), hint: None }
    }

    fn new(exit: Exit, error: &dyn Error) -> Failure {
        Failure { exit, message: error.to_string(), causes: causes(error), hint: None }
    }

    /// With what stands before the message: the file that it is about.
    #[must_use]
    pub fn about(mut self, subject: impl fmt::Display) -> Failure {
        self.message = format!("{subject}: {}", self.message);
        self
    }

    /// With what the user can do.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Failure {
        self.hint = Some(hint.into());
        self
    }
}

/// The chain of causes, without those that the text before them already tells.
fn causes(error: &dyn Error) -> Vec<String> {
    let mut reported = error.to_string();
    let mut causes = Vec::new();
    let mut next = error.source();
    while let Some(cause) = next {
        let text = cause.to_string();
        if !reported.contains(&text) {
            causes.push(text.clone());
            reported = text;
        }
        next = cause.source();
    }
    causes
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", shortened(&self.message))?;
        for cause in &self.causes {
            write!(f, "\n  cause: {}", shortened(cause))?;
        }
        match &self.hint {
            Some(hint) => write!(f, "\nhint: {}", shortened(hint)),
            None => Ok(()),
        }
    }
}

/// Characters of a text at its beginning and at its end that are told of a long one: place and cause stand first, what to do last.
const TOLD: [usize; 2] = [1500, 500];

/// A text that may quote whatever stands in a file, no longer than anyone reads.
fn shortened(text: &str) -> Cow<'_, str> {
    let [begin, end] = TOLD;
    let cut = |count: usize| text.char_indices().nth(count).map(|(place, _)| place);
    let from_end = text.char_indices().rev().nth(end - 1).map(|(place, _)| place);
    match (cut(begin), cut(begin + end), from_end) {
        (Some(begin), Some(_), Some(end)) => {
            let left_out = text[begin..end].chars().count();
            format!("{} … ({left_out} characters left out) … {}", &text[..begin], &text[end..]).into()
        }
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error with causes below it, told or not in its own text.
    #[derive(Debug)]
    struct Chain(&'static str, Option<Box<Chain>>);

    impl fmt::Display for Chain {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.0)
        }
    }

    impl Error for Chain {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            self.1.as_deref().map(|cause| cause as _)
        }
    }

    fn chain(texts: &[&'static str]) -> Chain {
        let below = (texts.len() > 1).then(|| Box::new(chain(&texts[1..])));
        Chain(texts[0], below)
    }

    #[test]
    fn every_cause_is_reported_once() {
        let error = chain(&["joint: singular", "singular", "no pose", "disk full"]);
        assert_eq!(
            Failure::bad_input(&error).to_string(),
            "error: joint: singular\n  cause: no pose\n  cause: disk full"
        );
    }

    #[test]
    fn of_a_message_without_end_beginning_and_end_are_reported() {
        let long = format!("session.toml:3: found `{}`, expected a number", "é".repeat(1 << 22));
        let reported = Failure::said(&long).hint("write a number").to_string();
        assert!(reported.chars().count() < 2200, "{}", reported.len());
        assert!(
            reported.starts_with("error: session.toml:3: found `é")
                && reported.ends_with("expected a number\nhint: write a number")
        );
        let most = "é".repeat(2000);
        assert_eq!(shortened(&most), most);
        assert!(shortened(&format!("{most}é")).contains("(1 characters left out)"));
    }

    #[test]
    fn subject_and_hint_stand_around_the_message() {
        let failure = Failure::bad_input(&chain(&["unknown solver"])).about("a/session.toml").hint("choose one");
        assert_eq!(failure.to_string(), "error: a/session.toml: unknown solver\nhint: choose one");
        assert_eq!(failure.exit, Exit::BadInput);
    }
}
