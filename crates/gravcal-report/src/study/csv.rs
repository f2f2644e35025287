//! Every measure as a row: for programs, and for figures of one's own.

use gravcal_study::measures::Measure;

use super::StudyReport;
use crate::spreadsheet::text_cell;

/// `measures.csv`. Empty cells are what there is no number for; an axis that bears the name of another column is `varied NAME`.
///
/// # Errors
/// As the writer of CSV says; none in memory.
pub(super) fn csv(report: &StudyReport<'_>) -> Result<String, csv::Error> {
    let manifest = report.manifest;
    let fixed = [
        "estimator",
        "solver",
        "quantity",
        "unit",
        "trials",
        "determined",
        "partly_determined",
        "failed",
        "iterations",
        "estimates",
        "bias",
        "bias_error",
        "rms",
        "rms_error",
        "rms_over_bound",
        "rms_over_bound_error",
        "nees",
        "nees_error",
        "coverage",
        "coverage_error",
        "bound",
    ];
    let mut table = csv::Writer::from_writer(Vec::new());
    let axes = manifest.axes.iter().map(|axis| match axis.name.as_str() {
        name if fixed.contains(&name) => format!("varied {name}"),
        name => name.to_owned(),
    });
    table.write_record(axes.map(|name| text_cell(&name).into_owned()).chain(fixed.map(str::to_owned)))?;
    for series in report.series {
        let places = manifest.axes.iter().zip(&manifest.points[series.point]);
        let labels: Vec<String> = places.map(|(axis, place)| text_cell(&axis.labels[*place]).into_owned()).collect();
        for ((name, unit), quantity) in manifest.quantities.iter().zip(&series.quantities) {
            let mut cells = labels.clone();
            let (estimator, solver) = (&manifest.estimators[series.estimator], &manifest.solvers[series.solver]);
            cells.extend([estimator, solver, name, unit].map(|text| text_cell(text).into_owned()));
            cells.push(series.trials.to_string());
            cells.extend(series.outcomes.map(|count| count.to_string()));
            cells.extend([number(series.iterations.value), quantity.estimates.to_string()]);
            let pairs = [quantity.bias, quantity.rms, quantity.ratio, quantity.nees, quantity.coverage];
            cells.extend(pairs.iter().flat_map(|Measure { value, error }| [number(*value), number(*error)]));
            cells.push(number(quantity.bound));
            table.write_record(cells)?;
        }
    }
    let bytes = table.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}
