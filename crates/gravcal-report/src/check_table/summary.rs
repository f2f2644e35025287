//! What a session can determine, on one screen.

use std::fmt;

use gravcal_calibration::check::{CheckReport, CheckedParameter, StepReport};
use gravcal_robot_model::number::significant;

use super::{cures, data, in_words, payloads};
use crate::doubts::report_doubts;
use crate::further_parameters::further_parameters;
use crate::joint_table::{Entry, joint_table};
use crate::sensor_row::shown_unit;
use crate::summary::first_lines;
use crate::text::wrapped;

/// Lines at most of the verdict, of parameters beyond the four of each joint, of cures, of the data, and of the paper's steps.
const LINES: [usize; 5] = [3, 3, 6, 2, 2];

/// What a session can and cannot determine, in at most 25 lines of 80 columns for seven joints, doubts aside.
#[derive(Clone, Copy, Debug)]
pub struct CheckSummary<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// What was found.
    pub report: &'a CheckReport,
    /// Whether an estimator is asked for that follows the paper's steps: else nothing is said of them.
    pub steps: bool,
}

impl fmt::Display for CheckSummary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [verdict, further, cures, data, steps] = LINES;
        let report = self.report;
        let entries: Vec<Entry<'_>> = report
            .parameters
            .iter()
            .map(|parameter| Entry { name: &parameter.name, unit: &parameter.unit, cell: std(parameter) })
            .collect();
        let doubts = report_doubts(&report.doubts);
        if !doubts.is_empty() {
            writeln!(f, "{doubts}")?;
        }
        f.write_str(&first_lines(
            &wrapped("", "  ", &format!("Check of {}: {}", self.robot, in_words(report))),
            verdict,
        ))?;
        if report.assumes_upright {
            f.write_str("Assumed: an upright base, as no [gravity] hemisphere is stated.\n")?;
        }
        f.write_str("Standard deviations to expect\n")?;
        f.write_str(&joint_table(&entries))?;
        f.write_str(&first_lines(&further_parameters(&entries), further))?;
        f.write_str(&payloads(report))?;
        f.write_str(&first_lines(&cures::report(report), cures))?;
        f.write_str(&first_lines(&data::report(report), data))?;
        if self.steps {
            f.write_str(&first_lines(&unfound(&report.steps), steps))?;
        }
        f.write_str("--full shows all, with every cure.\n")
    }
}

fn std(parameter: &CheckedParameter) -> String {
    let factor = shown_unit(&parameter.unit).1;
    match (&parameter.held, parameter.predicted_std) {
        (Some(_), _) => Entry::FIXED.to_owned(),
        (None, _) if !parameter.determined => "open".to_owned(),
        (None, Some(std)) => significant(std * factor, 2),
        (None, None) => "determined".to_owned(),
    }
}

/// What the paper's steps cannot find.
fn unfound(steps: &[StepReport]) -> String {
    let finds: Vec<&str> = steps.iter().filter(|step| step.problem.is_some()).map(|step| step.finds.as_str()).collect();
    match (steps.is_empty(), finds.is_empty()) {
        (true, _) => "The sequential estimator is for serial chains only.\n".to_owned(),
        (_, true) => "The sequential estimator finds everything that its steps can.\n".to_owned(),
        _ => wrapped("", "  ", &format!("The sequential estimator cannot find {}", finds.join("; "))),
    }
}
