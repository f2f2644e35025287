//! Tables for a paper or a README, one for each point.

use gravcal_study::measures::{Measure, QuantityMeasures};

use super::StudyReport;
use super::text::heading;
use gravcal_robot_model::number::{measured, significant};

pub(super) fn markdown(report: &StudyReport<'_>) -> String {
    let manifest = report.manifest;
    let mut text = String::new();
    for point in 0..manifest.points.len() {
        if manifest.points.len() > 1 {
            text.push_str(&format!("## {}\n\n", manifest.reported(point)));
        }
        let names: Vec<String> = report.at(point).map(|series| report.name(series)).collect();
        report.at(point).for_each(|series| text.push_str(&format!("- {}\n", heading(report, series))));
        text.push_str("\nrms error (over its Cramér-Rao bound; share of 95 % intervals that hold the truth):\n\n");
        text.push_str(&line(["".to_owned(), "unit".to_owned()].into_iter().chain(names.iter().cloned())));
        text.push_str(&line(
            ["---".to_owned(), "---".to_owned()].into_iter().chain(names.iter().map(|_| "---:".to_owned())),
        ));
        for (place, (name, unit)) in manifest.quantities.iter().enumerate() {
            let cells = report.at(point).map(|series| cell(&series.quantities[place]));
            text.push_str(&line([name.clone(), unit.clone()].into_iter().chain(cells)));
        }
        text.push('\n');
    }
    text
}

fn line(cells: impl Iterator<Item = String>) -> String {
    let cells: Vec<String> = cells.collect();
    format!("| {} |\n", cells.join(" | "))
}

/// Rms error with its ratio to the bound and the coverage.
pub(super) fn cell(quantity: &QuantityMeasures) -> String {
    if quantity.estimates == 0 {
        return "no estimate".to_owned();
    }
    let rounded = |measure: Measure| measured(measure.value, measure.error).0;
    let ratio = if quantity.ratio.value.is_nan() { "no bound".to_owned() } else { rounded(quantity.ratio) };
    format!("{} ({ratio}; {})", significant(quantity.rms.value, 3), rounded(quantity.coverage))
}
