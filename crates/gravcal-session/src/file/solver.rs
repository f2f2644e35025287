//! `solver = …` and `[solver]`.
//!
//! ```toml
//! solver = "dogleg"
//!
//! [solver]                                   # or with options
//! name = "levenberg-marquardt"
//! max_iterations = 50
//! ```

use std::fmt::{self, Display};

use gravcal_robot_model::session::SolverChoice;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use toml::Table;

use crate::document::{Document, Field, FileError};

const FIELD: &str = "solver";
const NAME: &str = "name";

/// What stands in the session.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Written {
    name: String,
    /// None where only a name stands there.
    options: Option<Table>,
}

impl Written {
    pub fn choice(self, document: &Document) -> SolverChoice {
        SolverChoice::new(self.name, self.options, document.path(), document.text())
    }
}

/// Reads the options of a choice as `seed` wants them.
///
/// # Errors
/// What `seed` refuses, with file, line and field.
pub fn read_solver_options<T>(
    choice: &SolverChoice,
    seed: impl for<'de> DeserializeSeed<'de, Value = T>,
) -> Result<T, FileError> {
    document_of(choice)?.parse_table(FIELD, NAME, seed)
}

/// An error that concerns the name of a choice.
pub fn solver_name_error(choice: &SolverChoice, message: impl Display) -> FileError {
    let field = Field::new(FIELD);
    let field = if choice.is_table() { field.key(NAME) } else { field };
    document_of(choice).map_or_else(|error| error, |document| document.error(&field, message))
}

/// An error that concerns an option of a choice, by the way to it from its key.
pub fn solver_option_error(choice: &SolverChoice, keys: &[String], message: impl Display) -> FileError {
    let field = keys.iter().fold(Field::new(FIELD), |field, key| field.key(key));
    document_of(choice).map_or_else(|error| error, |document| document.error(&field, message))
}

fn document_of(choice: &SolverChoice) -> Result<Document, FileError> {
    let (path, text) = choice.written_in();
    Document::of(path, text.to_owned())
}

/// Read by hand and not by an untagged enum, whose errors neither say what was found nor where.
impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WrittenVisitor)
    }
}

struct WrittenVisitor;

impl<'de> Visitor<'de> for WrittenVisitor {
    type Value = Written;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a solver, or a table with its name and options")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Written, E> {
        Ok(Written { name: name.into(), options: None })
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Written, A::Error> {
        let mut options = Table::deserialize(MapAccessDeserializer::new(map))?;
        match options.remove(NAME) {
            Some(toml::Value::String(name)) => Ok(Written { name, options: Some(options) }),
            Some(other) => Err(A::Error::custom(format!("its name is {other}, not a text"))),
            None => Err(A::Error::missing_field(NAME)),
        }
    }
}
