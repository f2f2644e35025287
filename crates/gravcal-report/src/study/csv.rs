//! Every measure as a row: for programs, and for figures of one's own.

use gravcal_study::measures::Measure;

use super::StudyReport;

/// `measures.csv`. Empty cells are what there is no number for.
pub(super) fn csv(report: &StudyReport<'_>) -> String {
    let manifest = report.manifest;
    let axes = manifest.axes.iter().map(|axis| quoted(&axis.name));
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
    let mut text = axes.chain(fixed.map(str::to_owned)).collect::<Vec<_>>().join(",") + "\n";
    for series in report.series {
        let places = manifest.axes.iter().zip(&manifest.points[series.point].places);
        let labels: Vec<String> = places.map(|(axis, place)| quoted(&axis.labels[*place])).collect();
        for ((name, unit), quantity) in manifest.quantities.iter().zip(&series.quantities) {
            let mut cells = labels.clone();
            cells.extend([
                quoted(&manifest.estimators[series.estimator]),
                quoted(&manifest.solvers[series.solver]),
                quoted(name),
                quoted(unit),
                series.trials.to_string(),
            ]);
            cells.extend(series.outcomes.map(|count| count.to_string()));
            cells.extend([number(series.iterations.value), quantity.estimates.to_string()]);
            let pairs = [quantity.bias, quantity.rms, quantity.ratio, quantity.nees, quantity.coverage];
            cells.extend(pairs.iter().flat_map(|Measure { value, error }| [number(*value), number(*error)]));
            cells.push(number(quantity.bound));
            text.push_str(&(cells.join(",") + "\n"));
        }
    }
    text
}

fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
