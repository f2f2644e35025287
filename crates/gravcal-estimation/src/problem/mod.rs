//! The problem: blocks and factors, immutable once built. It only holds and evaluates; solving is elsewhere.

mod assembled;
mod basis;
mod builder;
mod check;
mod evaluate;
mod kinds;
mod offsets;
mod structure;

pub use assembled::{Column, Problem};
pub use builder::ProblemBuilder;
pub use check::ProblemError;
pub(crate) use evaluate::Rows;
pub(crate) use kinds::{Kind, RowPlace, Run, Slot};
pub(crate) use structure::{Chunk, Component, Piece, Place};
