//! What a session can determine, on one screen.

use std::fmt;

use gravcal_calibration::check::{CheckReport, CheckedParameter, StepReport};
use gravcal_robot_model::number::significant;

use super::{cures, data, in_words, payloads};
use crate::doubts::report_doubts;
use crate::further_parameters::further_parameters;
use crate::joint_table::{Entry, joint_table};
use crate::sensor_row::shown_unit;
use crate::summary::cut_to;
use crate::text::wrapped;

/// Lines at most.
const MOST: usize = 25;

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
        let assumed = match report.assumes_upright {
            true => "Assumed: an upright base, as no [gravity] hemisphere is stated.\n",
            false => "",
        };
        let (table, payloads) = (joint_table(&entries), payloads(report));
        let heading = heading(report.supposed_errors);
        let taken = [assumed, &heading, &table, &payloads, "--full\n"];
        let taken: usize = taken.iter().map(|text| text.lines().count()).sum();
        let steps = if self.steps { unfound(&report.steps) } else { String::new() };
        // In the order in which what is left of the screen goes to them.
        let [verdict, cures, further, steps, data] = cut_to(
            [
                wrapped("", "  ", &format!("Check of {}: {}", self.robot, in_words(report))),
                cures::in_short(report),
                further_parameters(&entries),
                steps,
                data::report(report),
            ],
            MOST.saturating_sub(taken),
        );
        write!(f, "{verdict}{assumed}{heading}{table}{further}{payloads}{cures}{data}{steps}")?;
        f.write_str("--full shows all, with every cure.\n")
    }
}

/// Of the table, with what its numbers allow for.
fn heading(supposed_errors: Option<f64>) -> String {
    let heading = "Standard deviations to expect";
    match supposed_errors {
        None => format!("{heading}\n"),
        Some(share) => {
            let percent = 100.0 * share;
            wrapped(
                "",
                "  ",
                &format!("{heading}, if readings err by {percent} % of a joint's largest torque, beyond noise"),
            )
        }
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
