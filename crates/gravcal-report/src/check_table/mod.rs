//! The table of a check, for people: what a session can and cannot determine, before any solve.

mod cures;
mod data;
mod parameters;
mod steps;
mod summary;

use std::fmt;

use gravcal_calibration::check::CheckReport;

use crate::doubts::report_doubts;
use crate::json::{JsonError, json};
use crate::payload_text::expected;
use crate::text::wrapped;

pub use summary::CheckSummary;

/// What a session can determine, as text of 80 columns.
#[derive(Clone, Copy, Debug)]
pub struct CheckTable<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// What was found.
    pub report: &'a CheckReport,
    /// Whether an estimator is asked for that follows the paper's steps: else nothing is said of sweeps and steps.
    pub steps: bool,
}

impl fmt::Display for CheckTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sections = [
            report_doubts(&self.report.doubts),
            verdict(self.robot, self.report),
            parameters::report(self.report),
            payloads(self.report),
            cures::report(self.report),
            parameters::report_tilts(self.report),
            data::report(self.report),
            if self.steps { data::report_sweeps(self.report) } else { String::new() },
            if self.steps { steps::report(self.report) } else { String::new() },
        ];
        let reported: Vec<String> = sections.into_iter().filter(|section| !section.is_empty()).collect();
        f.write_str(&reported.join("\n"))
    }
}

/// Loads of unknown mass.
fn payloads(report: &CheckReport) -> String {
    report.payloads.iter().map(|payload| wrapped("", "  ", &expected(payload))).collect()
}

/// What a session can determine, for programs.
///
/// # Errors
/// None that is known of.
pub fn check_json(report: &CheckReport) -> Result<String, JsonError> {
    json(report)
}

fn verdict(robot: &str, report: &CheckReport) -> String {
    format!("Check of {robot}\n{}", wrapped("  ", "  ", &in_words(report))) + &wrapped("  ", "  ", &report.judged_at)
}

fn in_words(report: &CheckReport) -> String {
    let parameters = report.parameters.iter().filter(|p| p.asked && !p.determined).map(|p| p.name.clone());
    let loads = report.payloads.iter().filter(|load| load.undetermined.is_some());
    let missing: Vec<String> = parameters.chain(loads.map(|load| format!("load {}", load.load))).collect();
    if report.complete {
        "everything that is asked for can be determined".to_owned()
    } else {
        format!("not everything that is asked for can be determined: not {}", missing.join(", "))
    }
}

#[cfg(test)]
mod tests;
