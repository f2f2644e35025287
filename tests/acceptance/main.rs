//! What gravcal promises, tried from outside: the program as a user runs it, on the experiments and on wrong input.

#![allow(clippy::unwrap_used, clippy::panic)] // a helper of a test may fail it

mod experiments;
mod invariants;
mod program;
mod reproducible;
mod wrong_input;
