//! The table of a calibration, for people: verdict, values side by side, what is undetermined and its cure, fit, notes.

mod constraints;
pub(crate) mod fit;
pub(crate) mod inertias;
mod payloads;
mod positions;
pub(crate) mod residual_tests;
mod sensor_models;
mod shared;
mod values;
mod verdict;

use std::fmt;

use gravcal_calibration::result::EstimatorResult;

use crate::doubts::report_doubts;
use crate::text::{plain, wrapped};
use crate::undetermined::{Entry, report_undetermined};
use shared::{Shared, by_content};

/// The answers of the estimators side by side, as text of 80 columns.
///
/// ```
/// let results = []; // what `gravcal_calibration::calibrate` returned
/// let table = gravcal_report::CalibrationTable { robot: "my-arm", doubts: &[], results: &results };
/// assert_eq!(table.to_string(), "Calibration of my-arm: no estimator ran\n");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CalibrationTable<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// What can hardly be so of what the session says, before anything is solved and by what came out.
    pub doubts: &'a [String],
    /// What the estimators answered.
    pub results: &'a [EstimatorResult],
}

impl fmt::Display for CalibrationTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sections = [
            report_doubts(self.doubts),
            verdict::report(self.robot, self.results),
            values::report(self.results),
            sensor_models::report(self.results),
            undetermined(self.results),
            constraints::report(self.results),
            positions::report(self.results),
            fit::report(self.results),
            payloads::report(self.results),
            inertias::report(self.results),
            residual_tests::report(self.results),
            notes(self.results),
        ];
        let reported: Vec<String> = sections.into_iter().filter(|section| !section.is_empty()).collect();
        f.write_str(&plain(&reported.join("\n")))
    }
}

fn undetermined(results: &[EstimatorResult]) -> String {
    let several = results.len() > 1;
    let shared = by_content(results, |result| &result.undetermined).into_iter();
    let entries: Vec<Entry<'_>> =
        shared.map(|shared| Entry::of(shared.item, several.then_some(shared.names))).collect();
    under("Undetermined", report_undetermined(&entries))
}

fn notes(results: &[EstimatorResult]) -> String {
    let report = |note: &Shared<'_, String>| {
        let whose = if note.everyone { String::new() } else { format!("{}: ", note.names) };
        wrapped("  - ", "    ", &format!("{whose}{}", note.item))
    };
    under("Notes", by_content(results, |result| &result.notes).iter().map(report).collect())
}

/// A section, or nothing where there is nothing to say.
fn under(heading: &str, lines: String) -> String {
    if lines.is_empty() { lines } else { format!("{heading}\n{lines}") }
}

#[cfg(test)]
mod tests;
