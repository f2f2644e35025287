//! The method that a session chooses. Only its name and the text of its options are kept: what they mean is not known
//! here.
//!
//! ```toml
//! solver = "dogleg"
//!
//! [solver]                                   # or with options
//! name = "levenberg-marquardt"
//! max_iterations = 50
//! ```

use std::fmt::{self, Display};

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use toml::Table;

use crate::document::{Document, Field, FileError};

const FIELD: &str = "solver";
const NAME: &str = "name";

/// A solver by name, with options that only the method itself understands.
#[derive(Clone, Debug)]
pub struct SolverChoice {
    written: Written,
    document: Document,
}

/// What stands in the session.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Written {
    name: String,
    /// None where only a name stands there.
    options: Option<Table>,
}

impl SolverChoice {
    pub(super) fn new(written: Written, document: &Document) -> Self {
        SolverChoice { written, document: document.clone() }
    }

    /// The method's name.
    pub fn name(&self) -> &str {
        &self.written.name
    }

    /// Its options as they stand in the session.
    pub fn options(&self) -> Table {
        self.written.options.clone().unwrap_or_default()
    }

    /// Reads the options as `seed` wants them.
    ///
    /// # Errors
    /// What `seed` refuses, with file, line and field.
    pub fn read_options<T>(&self, seed: impl for<'de> DeserializeSeed<'de, Value = T>) -> Result<T, FileError> {
        self.document.parse_table(FIELD, NAME, seed)
    }

    /// An error that concerns the name.
    pub fn name_error(&self, message: impl Display) -> FileError {
        let field = Field::new(FIELD);
        let field = if self.written.options.is_some() { field.key(NAME) } else { field };
        self.document.error(&field, message)
    }
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
