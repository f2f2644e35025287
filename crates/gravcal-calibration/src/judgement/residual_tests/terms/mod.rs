//! What a model may lack: terms in families, a file each.
//!
//! A term is looked for by columns: what a unit of each of its coefficients does to the whitened residuals. What is found has a kind, a size and a unit, for
//! programs, and words with a cure, for people; all are in the file of its family. Another term of a family is a variant of its enum; it needs a
//! [`ResidualTestKind`](crate::result::ResidualTestKind), and a line in [`words_of`]. Another family is a file here and a variant of [`Term`].

mod earlier_load;
mod elastic;
mod friction;
mod harmonic;
mod lacked;
mod motion;
mod position_zero;
mod recorder;
mod sensor_gain;
mod sensor_zero;
mod stated;
mod surroundings;
mod term;
mod units;
mod words_of;

#[cfg(test)]
pub use earlier_load::EarlierLoad;
pub use earlier_load::{of_creep, of_hysteresis};
pub use elastic::{Elastic, of_compliance};
pub use friction::{Friction, of_direction};
pub use harmonic::Harmonic;
pub use lacked::Words;
pub use position_zero::PositionZero;
pub use recorder::{Recorder, of_recorder};
pub use sensor_gain::SensorGain;
pub use sensor_zero::SensorZero;
pub use stated::Stated;
pub use surroundings::Surroundings;
pub use term::Term;
pub use words_of::words_of;
