//! What is printed. Colours are for terminals only, and not where `NO_COLOR` is set (`anstream` decides). Names may hold anything, but a
//! terminal is told no control characters of theirs.

use std::io::{self, ErrorKind, IsTerminal, Write};

use anstyle::{AnsiColor, Style};
use gravcal_report::plain;

use crate::failure::Failure;

const GOOD: Style = AnsiColor::Green.on_default().bold();
const CARE: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();

/// Words that decide, as tables and errors write them.
const MARKS: [(&str, Style); 10] = [
    ("  determined:", GOOD),
    ("  partly determined", CARE),
    ("  failed:", BAD),
    ("undetermined", CARE),
    ("Nothing moved", GOOD),
    ("Nothing that can be compared moved", CARE),
    ("Moved:", BAD),
    ("Warning:", CARE),
    ("error:", BAD),
    ("note:", CARE),
];

/// Prints a table, with colours where a terminal shows it. A reader who has seen enough (`gravcal … | head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    put(&mut anstream::stdout().lock(), &painted(&plain(text)))
}

/// Prints what programs read: to a program every byte.
pub fn print_exactly(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.is_terminal() {
        true => put(&mut stdout, &plain(text)),
        false => put(&mut stdout, text),
    }
}

fn put(stdout: &mut dyn Write, text: &str) -> Result<(), Failure> {
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::not_shown(&error).about("what was found cannot be printed (results in files are complete)"))
        }
        _ => Ok(()),
    }
}

/// Tells an error. Where even that is not possible, the exit code must do.
pub fn complain(text: &str) {
    let _: io::Result<()> = writeln!(anstream::stderr(), "{}", painted(&plain(text)));
}

/// The text with [`MARKS`] in their colours.
fn painted(text: &str) -> String {
    MARKS.iter().fold(text.to_owned(), |text, (mark, style)| text.replace(mark, &format!("{style}{mark}{style:#}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_decide_are_coloured_and_nothing_else_changes() {
        let text = "  joint  determined: everything\n  other  partly determined: not x\n  torque_gain  undetermined\n";
        let reported = painted(text);
        assert!(reported.contains(&format!("{GOOD}  determined:{GOOD:#} everything")), "{reported:?}");
        assert_eq!(anstream::adapter::strip_str(&reported).to_string(), text);
    }
}
