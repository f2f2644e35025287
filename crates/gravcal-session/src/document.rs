//! TOML files that a user writes: reading them, and saying what is wrong with them where it stands.
//!
//! A [`Document`] keeps the text of the file. What it says is first read by serde into plain structs
//! ([`Document::parse`]); what serde cannot see (a mass below zero, a link that the robot has not) is checked
//! afterwards, and [`Document::error`] finds the line of the field in question. Every path in a document is relative to
//! the document itself.

mod check;
mod environment;
mod field;
mod file_error;
mod names;
mod one_or_many;
mod one_or_named;
mod relative_path;
mod text;
mod toml_document;

pub use field::Field;
pub use file_error::FileError;
pub use one_or_many::OneOrMany;
pub use one_or_named::OneOrNamed;
pub(crate) use relative_path::relative_path;
pub(crate) use text::read_text;
pub use toml_document::Document;
