//! What a crate of one's own adds to gravcal: models of sensors, the program that knows them, and a method that minimises.

mod backlash;
mod marquardt;
mod ripple;

use gravcal::calibration::Registry;

pub use backlash::Backlash;
pub use marquardt::Marquardt;
pub use ripple::Ripple;

/// What gravcal knows, and what this crate adds.
pub fn registry() -> Registry {
    Registry::standard().with_sensor_model(Ripple).with_sensor_model(Backlash)
}
