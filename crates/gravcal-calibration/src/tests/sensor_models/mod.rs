//! What each model of a sensor is for: its readings contradict affine sensors, and the model finds the truth.

mod crosstalk;
mod drift;
mod formula;
mod friction;
mod harmonics;
mod polynomial;
mod saturation;
