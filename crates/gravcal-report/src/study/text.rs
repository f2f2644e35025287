//! The report as text, within 80 columns where names allow.

use gravcal_study::batch::Outcome;
use gravcal_study::measures::{Measure, QuantityMeasures, Series};

use super::StudyReport;
use crate::grid::{Cell, Grid, Side};
use gravcal_robot_model::number::{measured, significant};

const EXPLAINED: &str = "\
rms: root mean square error, in the unit. over bound: the same over the
Cramér-Rao bound of the readings that the estimator uses. in 95 %: share of the
95 % intervals that hold the truth. After ±: Monte-Carlo standard error.
measures.csv has more.
";

pub(super) fn text(report: &StudyReport<'_>) -> String {
    let manifest = report.manifest;
    let (points, trials) = (manifest.points.len(), manifest.trials);
    let each = if points == 1 { String::new() } else { format!(" at each of {points} points") };
    let mut text = format!("{trials} trials{each}\n{EXPLAINED}");
    for point in 0..points {
        if points > 1 {
            text.push_str(&format!("\n{}\n", manifest.reported(point)));
        }
        for series in report.at(point) {
            text.push('\n');
            text.push_str(&of_series(report, series));
        }
        text.push_str(&comparison(report, point));
    }
    text
}

/// `sequential: determined 100 %, 12.3 iterations`.
pub(super) fn heading(report: &StudyReport<'_>, series: &Series) -> String {
    let shares = Outcome::ALL.into_iter().filter(|outcome| series.outcomes[*outcome as usize] > 0);
    let reported: Vec<String> = shares.map(|outcome| format!("{outcome} {}", percent(series.share(outcome)))).collect();
    let iterations = significant(series.iterations.value, 3);
    format!("{}: {}; {iterations} iterations", report.name(series), reported.join(", "))
}

fn percent(share: f64) -> String {
    format!("{} %", gravcal_robot_model::number::shortest(100.0 * share))
}

fn of_series(report: &StudyReport<'_>, series: &Series) -> String {
    let mut grid = Grid::new(vec![Side::Left, Side::Left, Side::Right, Side::Right, Side::Right]);
    let head = ["", "unit", "rms", "over bound", "in 95 %"];
    grid.row(head.map(Cell::text).into());
    for ((name, unit), quantity) in report.manifest.quantities.iter().zip(&series.quantities) {
        grid.row(cells(name, unit, quantity));
    }
    let mut text = format!("{}\n{}", heading(report, series), grid.lines("  "));
    for (reason, count) in series.reasons.iter().take(5) {
        text.push_str(&format!("  failed {count} times: {reason}\n"));
    }
    text
}

fn cells(name: &str, unit: &str, quantity: &QuantityMeasures) -> Vec<Cell> {
    if quantity.estimates == 0 {
        return vec![Cell::text(name), Cell::text(unit), Cell::text("no estimate")];
    }
    vec![
        Cell::text(name),
        Cell::text(unit),
        Cell::text(significant(quantity.rms.value, 3)),
        number(quantity.ratio),
        number(quantity.coverage),
    ]
}

fn number(measure: Measure) -> Cell {
    match measure.value {
        value if value.is_nan() => Cell::empty(),
        value if measure.error > 0.0 => {
            let (value, error) = measured(value, measure.error);
            Cell::Measured(value, error)
        }
        value => Cell::Value(significant(value, 3)),
    }
}

/// Errors over those of the last estimator.
fn comparison(report: &StudyReport<'_>, point: usize) -> String {
    let Some(reference) = report.reference(point) else { return String::new() };
    let others: Vec<String> = report.others(point).map(|series| report.name(series)).collect();
    let mut grid = Grid::new([vec![Side::Left], vec![Side::Right; others.len()]].concat());
    grid.row(std::iter::once(String::new()).chain(others).map(Cell::text).collect());
    for compared in report.compared(point) {
        let name = &report.manifest.quantities[compared.quantity].0;
        let ratios = compared
            .ratios
            .iter()
            .map(|ratio| if ratio.is_nan() { Cell::text("-") } else { Cell::text(significant(*ratio, 3)) });
        grid.row(std::iter::once(Cell::text(name.clone())).chain(ratios).collect());
    }
    format!("\nrms error over that of {}\n{}", report.name(reference), grid.lines("  "))
}
