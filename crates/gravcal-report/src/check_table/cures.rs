//! What cannot be known, and the smallest additions to the session that would determine it.

use gravcal_calibration::check::{CheckReport, Curable, Cure, PredictedStd};

use crate::sensor_row::shown_unit;
use crate::undetermined::{Entry, report_undetermined};
use gravcal_robot_model::number::significant;

/// Of a cure of more parameters than these only their number is told; the JSON has them all.
const LISTED: usize = 2;

pub(super) fn report(report: &CheckReport) -> String {
    if report.undetermined.is_empty() {
        return String::new();
    }
    let entries: Vec<Entry<'_>> = report.undetermined.iter().map(entry).collect();
    format!("Undetermined by the joint estimator, cures in the order of effort\n{}", report_undetermined(&entries))
}

fn entry(curable: &Curable) -> Entry<'_> {
    let undetermined = &curable.undetermined;
    let cures = match curable.cures.is_empty() {
        true => vec![format!("none was found among single additions and pairs; as a rule: {}", undetermined.cure)],
        false => curable.cures.iter().map(in_words).collect(),
    };
    Entry { undetermined, whose: None, cures }
}

fn in_words(cure: &Cure) -> String {
    let Cure { addition, predicted } = cure;
    let stds: Vec<String> = predicted.iter().filter_map(std).collect();
    match stds.len() {
        0 => addition.clone(),
        1..=LISTED => format!("{addition}: {}", stds.join(", ")),
        more => format!("{addition}: {}, … ({more} in all)", stds[..LISTED].join(", ")),
    }
}

/// `joint1.torque_gain ± 0.012 count/(N·m)`.
fn std(predicted: &PredictedStd) -> Option<String> {
    let (unit, factor) = shown_unit(&predicted.unit);
    Some(format!("{} ± {} {unit}", predicted.name, significant(predicted.std? * factor, 2)))
}
