//! The method that a session chooses. Only its name and the text of its options are kept: what they mean is not known
//! here.

use std::path::{Path, PathBuf};

use toml::Table;

/// A solver by name, with options that only the method itself understands.
#[derive(Clone, Debug)]
pub struct SolverChoice {
    name: String,
    /// None where only a name stands there.
    options: Option<Table>,
    path: PathBuf,
    text: String,
}

impl SolverChoice {
    /// The method of this name. `options`: none where only a name stands there; `path` and `text`: what it stands in, for messages.
    pub fn new(name: String, options: Option<Table>, path: &Path, text: &str) -> Self {
        SolverChoice { name, options, path: path.to_owned(), text: text.to_owned() }
    }

    /// The method's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its options as they stand in the session.
    pub fn options(&self) -> Table {
        self.options.clone().unwrap_or_default()
    }

    /// Whether it is written as a table, and not as a name alone.
    pub fn is_table(&self) -> bool {
        self.options.is_some()
    }

    /// Path and text of what it stands in.
    pub fn written_in(&self) -> (&Path, &str) {
        (&self.path, &self.text)
    }
}
