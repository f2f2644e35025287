//! What the constrained method promises.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used, clippy::panic)]

mod build;
mod by_hand;
mod hock_schittkowski;
mod iterates;
mod length;
mod optimality;
mod refused;
