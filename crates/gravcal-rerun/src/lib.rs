//! A calibration as a recording for [Rerun](https://rerun.io): the arm, the fits, the residuals, the solver's way and the verdict.
//!
//! [`CalibrationRecording`] takes what an estimator was given and what it answered; [`to_rrd`](CalibrationRecording::to_rrd) gives the
//! bytes of a file, [`connect`](CalibrationRecording::connect) and [`spawn`](CalibrationRecording::spawn) show it at once. The recording
//! brings its own layout (a blueprint), whose first page tells the story.
//!
//! **Who should read this.** Who looks for something in a recording, or adds to it. What a calibration is, says `gravcal-calibration`.
//!
//! # Entities
//!
//! `E` is an estimator by its name (`sequential`, `joint`, …), `C` a channel (a joint by its name, for its torque sensor, or an axis of
//! an instrument), `L` a link, `B` the base, `O` and `Q` the owner and the quantity of a parameter (`joint1`, `torque_gain`). Everything about
//! `nominal` is what the deciding estimate predicts with sensors at their nominal values, as in `report.html`.
//!
//! | entity path | content | unit | timeline |
//! |---|---|---|---|
//! | `/verdict` | what was found, and what to do next (Markdown) | – | static |
//! | `/arm/L` | pose of the link's frame in base coordinates, positions calibrated | m | `pose`, `time` |
//! | `/arm/L/body`, `/arm/L/axis` | the link's capsules; the axis of the joint that moves it | m | static |
//! | `/arm/L/load/NAME` | a known load where it is or was found to be, if anything knows it | m | `pose`, while attached |
//! | `/arm/B/body` | from the base to the first joints | m | static |
//! | `/arm/extent` | corners of the space about the arm, not seen | m | static |
//! | `/gravity/nominal`, `/gravity/E` | direction of gravity in base coordinates, drawn to the arm's size | – | static |
//! | `/gravity/E/cone95` | cone that holds the true direction with 95 % probability, true to scale | – | static |
//! | `/readings/C/measured` | readings | of the reading | `pose`, `time` |
//! | `/readings/C/nominal`, `/readings/C/E` | what they were predicted to be | of the reading | `pose`, `time` |
//! | `/readings/C/gravity`, `/readings/C/inertia`, `/readings/C/friction` | of what the deciding estimate makes them, where the arm moved; `friction` is what is left of the prediction without the bias | of the reading | `pose`, `time` |
//! | `/residuals/in_unit/nominal/C`, `/residuals/in_unit/E/C` | prediction less reading | of the reading | `pose`, `time` |
//! | `/residuals/in_std/nominal/C`, `/residuals/in_std/E/C` | the same over the standard deviation that the fit assumed | 1 | `pose`, `time` |
//! | `/spectra/C` | of an arm in motion: amplitudes of the deciding estimate's residuals over frequency (Hz), each that of a sine which would be as strong | of the reading | static |
//! | `/sweeps/frame`, `/sweeps/captions`, `/sweeps/measured`, `/sweeps/nominal`, `/sweeps/E`, `/sweeps/now` | each channel over the angle of the joint that sweeps, of the sweep that the pose is part of; `now` marks the pose | of the picture | `pose` |
//! | `/poses/file`, `/poses/load` | which table the pose stands in, what is attached | – | `pose` |
//! | `/standstills/FILE`, `/slow_sweeps/FILE/COLUMN` | when the arm stood still, or swept slowly, in a recording in motion | – | `time` |
//! | `/trace/E/log10_cost`, `/trace/E/log10_cosine`, `/trace/E/log10_step`, `/trace/E/log10_damping` | the solver's way | 1 | `iteration` |
//! | `/parameters/E/Q/O/value` | parameter after each iteration | of the parameter | `iteration` |
//! | `/parameters/E/Q/O/low`, `/parameters/E/Q/O/high` | ends of its 95 % interval | of the parameter | `iteration` |
//! | `/identifiability/E/singular_values` | log₁₀ of the Jacobian's singular values over the largest | 1 | static |
//! | `/identifiability/E/combinations` | what is undetermined or weak, by name (Markdown) | – | static |
//!
//! | timeline | what it counts |
//! |---|---|
//! | `pose` | poses of the session, from 0 |
//! | `time` | time since the session's first pose, where the session says when poses were read |
//! | `iteration` | iterations of the solver, the start being 0 |
//!
//! A failed estimate has no values, but its residuals are shown: they are what to look at. Coordinates of joints take gain and offset of
//! the position sensor, and no further term of it.
//!
//! # Same input, same recording
//!
//! Nothing in it comes from a clock, and its name from the input: two recordings of one calibration compare equal
//! (`rerun rrd compare --unordered`). Their bytes differ, as Rerun numbers rows and views at random.

mod arm;
mod blueprint;
mod contents;
mod explanation;
mod gravity;
mod identifiability;
mod loads;
mod plot;
mod poses;
mod recording;
mod residuals;
mod series;
mod shape;
mod spectra;
mod style;
mod sweeps;
mod trace;
mod verdict;

#[cfg(test)]
mod read_back;
#[cfg(test)]
mod testing;

pub use contents::CalibrationRecording;
pub use recording::{RecordingError, VIEWER_URL, check_address};
