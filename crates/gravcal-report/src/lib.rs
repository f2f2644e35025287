//! Results for people and programs: tables and calibration files.
//!
//! An estimator's answer is a value ([`EstimatorResult`](gravcal_calibration::result::EstimatorResult)); this crate
//! gives it its outward forms:
//!
//! | form | for | here |
//! |---|---|---|
//! | the terminal | people | [`CalibrationSummary`], one screen |
//! | `table.txt` | people | [`CalibrationTable`], a value with `Display`, 80 columns wide |
//! | `calibration.json` | programs | [`CalibrationFile`]: the answers and where they come from |
//! | `report.html` | people who decide | [`CalibrationPage`]: one file without any request to a network |
//! | `timing.json` | people who wonder | [`Timing`], apart from the results, whose bytes are compared |
//!
//! [`Advice`] is what the page says first, for whoever shows a result elsewhere;
//! [`OutputFolder`] puts the four in place without overwriting other results. [`CheckTable`] and
//! [`check_json`] tell what a session can determine, before any solve.
//!
//! **Conventions.** Files hold SI units and radians. Tables show angles' offsets in degrees, and say so.
//!
//! **What this crate does not do.** It prints nothing, reads no clock, and knows neither solvers nor how a session
//! is written down.

mod advice;
mod calibration_file;
mod check_table;
pub mod comparison;
mod doubts;
pub mod export;
mod finite;
mod footnotes;
mod further_parameters;
mod grid;
mod joint_table;
mod json;
mod motion_spectra;
mod output;
mod page;
mod payload_text;
mod provenance;
mod sensor_row;
mod spectrum;
mod spreadsheet;
pub mod study;
mod summary;
mod table;
mod text;
mod timing;
mod undetermined;

#[cfg(test)]
mod testing;

pub use advice::{Advice, Level};
pub use calibration_file::{CalibrationFile, FORMAT};
pub use check_table::{CheckSummary, CheckTable, check_json};
pub use doubts::{report_doubts, report_further_doubts};
pub use finite::NotFinite;
pub use json::JsonError;
pub use motion_spectra::{MotionSpectra, motion_spectra};
pub use output::{Contents, OutputError, OutputFolder, Written};
pub use page::CalibrationPage;
pub use provenance::{Input, Options, Provenance};
pub use summary::CalibrationSummary;
pub use table::CalibrationTable;
pub use text::plain;
pub use timing::Timing;
