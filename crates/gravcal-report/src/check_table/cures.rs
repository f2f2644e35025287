//! What cannot be known, and the smallest additions to the session that would determine it.

use gravcal_calibration::check::{CheckReport, Curable, Cure, PredictedStd};
use gravcal_calibration::result::Undetermined;

use crate::sensor_row::shown_unit;
use crate::text::wrapped;
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

/// The first cure of each, with all that it determines, in a line or two. What is not estimated needs none.
pub(super) fn in_short(report: &CheckReport) -> String {
    let held = |name: &String| report.parameters.iter().any(|known| known.name == *name && known.held.is_some());
    let of_held = |open: &Undetermined| !open.parameters.is_empty() && open.parameters.iter().all(held);
    let mut helped: Vec<(String, Vec<&str>)> = Vec::new();
    for Curable { undetermined, cures } in report.undetermined.iter().filter(|open| !of_held(&open.undetermined)) {
        let cure = cures.first().map_or(&undetermined.cure, |cure| &cure.addition);
        match helped.iter_mut().find(|(other, _)| other == cure) {
            Some((_, names)) if names.contains(&undetermined.combination.as_str()) => {}
            Some((_, names)) => names.push(&undetermined.combination),
            None => helped.push((cure.clone(), vec![&undetermined.combination])),
        }
    }
    let heading = if helped.is_empty() { "" } else { "What would determine what is open\n" };
    let lines = helped.iter().map(|(cure, names)| wrapped("  - ", "    ", &format!("{}: {cure}", names.join("; "))));
    heading.to_owned() + &lines.collect::<String>()
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
