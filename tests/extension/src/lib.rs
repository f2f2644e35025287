//! What a crate of one's own adds to gravcal: models of sensors, residuals with unknowns of their own, the program that knows them, a
//! method that minimises, and a manifold.

mod backlash;
mod circle;
mod compensator;
mod dial_gauge;
mod inclinometer;
mod marquardt;
mod ripple;
mod same_height;

use gravcal::calibration::Registry;

pub use backlash::Backlash;
pub use circle::Circle;
pub use compensator::{Compensator, ForceGauge};
pub use dial_gauge::DialGauge;
pub use inclinometer::Inclinometer;
pub use marquardt::{Marquardt, MarquardtFactory};
pub use ripple::Ripple;
pub use same_height::SameHeight;

/// What gravcal knows, and what this crate adds.
pub fn registry() -> Registry {
    Registry::standard()
        .with_sensor_model(Ripple)
        .with_sensor_model(Backlash)
        .with_sensor_model(Compensator)
        .with_residual_model(DialGauge)
        .with_residual_model(Inclinometer)
        .with_residual_model(SameHeight)
        .with_residual_model(ForceGauge)
        .with_solver(MarquardtFactory)
}
