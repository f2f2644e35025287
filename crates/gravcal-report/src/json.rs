//! JSON for people to read and programs to parse.

use serde::Serialize;
use thiserror::Error;

use crate::finite::NotFinite;

/// A value cannot be written as JSON.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JsonError {
    /// A number is infinite, or none at all.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// The value's own refusal.
    #[error("cannot be written as JSON: {0}")]
    Refused(#[from] serde_json::Error),
}

/// Indented JSON with a line break at its end.
pub(crate) fn json(value: &impl Serialize) -> Result<String, JsonError> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// JSON in one line, for programs alone.
pub(crate) fn compact(value: &impl Serialize) -> Result<String, JsonError> {
    Ok(serde_json::to_string(value)?)
}
