//! What is wrong with a file that a user wrote, and where.

use std::fmt;
use std::path::{Path, PathBuf};

use super::field::Field;

/// Something is wrong with a file.
///
/// Shown as `session.toml:12: load[1].mass_kg: -1.7 is not a mass: expected a positive number of kg`, with further
/// lines where another file named this one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    path: PathBuf,
    line: Option<usize>,
    field: Option<String>,
    message: String,
    note: Option<String>,
}

impl FileError {
    /// An error that concerns the whole file.
    pub(crate) fn new(path: &Path, message: impl fmt::Display) -> FileError {
        FileError { path: path.to_owned(), line: None, field: None, message: message.to_string(), note: None }
    }

    /// The same, in a line (counted from 1).
    pub(crate) fn at_line(self, line: usize) -> FileError {
        FileError { line: Some(line), ..self }
    }

    /// The same, in a field.
    pub(crate) fn in_field(self, field: &Field) -> FileError {
        FileError { field: Some(field.to_string()), ..self }
    }

    /// The same, with lines to follow the message.
    #[must_use]
    pub fn with_note(self, note: String) -> FileError {
        FileError { note: Some(note), ..self }
    }

    /// The same without a line: where the text is not that of the file.
    #[must_use]
    pub fn without_line(self) -> FileError {
        FileError { line: None, ..self }
    }

    /// The file, as it was named by whoever asked to read it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The line, counted from 1; `None` where the whole file is meant.
    pub fn line(&self) -> Option<usize> {
        self.line
    }

    /// The field, such as `load[1].mass_kg` (lists are counted from 0); `None` where none is meant.
    pub fn field(&self) -> Option<&str> {
        self.field.as_deref()
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(field) = &self.field {
            write!(f, ": {field}")?;
        }
        write!(f, ": {}", self.message)?;
        match &self.note {
            Some(note) => write!(f, "\n  {note}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for FileError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_is_shown() {
        let error = FileError::new(Path::new("a.toml"), "is wrong");
        assert_eq!(error.to_string(), "a.toml: is wrong");
        let error = error.at_line(3).in_field(&Field::new("x")).with_note("named by b.toml".into());
        assert_eq!(error.to_string(), "a.toml:3: x: is wrong\n  named by b.toml");
        assert_eq!((error.path(), error.line(), error.field()), (Path::new("a.toml"), Some(3), Some("x")));
    }
}
