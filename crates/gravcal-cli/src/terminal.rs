//! What is printed.

use std::io::{self, ErrorKind, Write};

use crate::failure::Failure;

/// Prints results. A reader who has seen enough (`gravcal … | head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::bad_input(&error).about("results cannot be printed"))
        }
        _ => Ok(()),
    }
}

/// Tells an error. Where even that is not possible, the exit code must do.
pub fn complain(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}
