//! Simulated sessions with known truth, and what judges their answers without code that is judged.

pub mod arm;
pub mod arms;
pub mod calibrate;
pub mod draw;
pub mod independent;
pub mod judge;
pub mod model;
pub mod poor;
pub mod statics;
#[cfg(test)]
mod tests;
pub mod truth;
pub mod write;
