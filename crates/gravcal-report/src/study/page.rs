//! `study.html`: what a study found, its figures and tables, in one file.

use gravcal_study::measures::{QuantityMeasures, Series};
use maud::{Markup, PreEscaped, html};

use super::StudyReport;
use super::markdown::cell;
use super::text::heading;
use crate::page::document;
use gravcal_robot_model::number::significant;

/// With the figures as SVG.
pub(super) fn page(report: &StudyReport<'_>, figures: &[(String, String)]) -> String {
    let manifest = report.manifest;
    let title = title(report);
    let body = html! {
        h1 { (title) }
        section.verdict {
            p { (manifest.trials) " trials" @if manifest.points.len() > 1 { " at each of " (manifest.points.len()) " points" } "." }
            @if manifest.points.len() == 1 { ul { @for series in report.at(0) { li { (finding(report, series)) } } } }
            p.small {
                "Errors are root mean squares; after them their ratio to the Cramér-Rao bound of the readings that the estimator uses, and the share "
                "of the 95 % intervals that hold the truth. measures.csv beside this file has more."
            }
        }
        @for (name, svg) in figures {
            figure aria-label=(name) { (PreEscaped(svg)) }
        }
        @for point in 0..manifest.points.len() { (of_point(report, point)) }
        section {
            h2 { "Where it comes from" }
            p {
                "gravcal " (manifest.gravcal) "; solver " (manifest.solvers.join(", ")) "; SHA-256 of all that the results depend on: "
                span.hash { (manifest.fingerprint) }
            }
        }
    };
    document(&title, &body, None)
}

/// `Study of sequential and joint over noise`.
fn title(report: &StudyReport<'_>) -> String {
    let axes: Vec<&str> = report.manifest.axes.iter().map(|axis| axis.name.as_str()).collect();
    let over = if axes.is_empty() { String::new() } else { format!(" over {}", axes.join(" and ")) };
    format!("Study of {}{over}", report.manifest.estimators.join(", "))
}

/// `joint: determined 100 %, …; errors 0.98 to 1.02 of the bound, 94.1 to 95.8 % of the 95 % intervals hold the truth`.
fn finding(report: &StudyReport<'_>, series: &Series) -> String {
    let (told, silent): (Vec<_>, Vec<_>) =
        report.manifest.quantities.iter().zip(&series.quantities).partition(|(_, quantity)| quantity.estimates > 0);
    let range = |of: fn(&QuantityMeasures) -> f64| {
        let values = told.iter().map(|(_, quantity)| of(quantity)).filter(|value| value.is_finite());
        values.fold(None, |range: Option<[f64; 2]>, value| {
            Some(range.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
        })
    };
    let mut text = heading(report, series);
    if let Some([low, high]) = range(|quantity| quantity.ratio.value) {
        text += &format!("; errors {} to {} of the bound", significant(low, 3), significant(high, 3));
    }
    if let Some([low, high]) = range(|quantity| 100.0 * quantity.coverage.value) {
        let (low, high) = (significant(low, 3), significant(high, 3));
        text += &format!("; {low} to {high} % of the 95 % intervals hold the truth");
    }
    if !silent.is_empty() {
        let names: Vec<&str> = silent.iter().map(|((name, _), _)| name.as_str()).collect();
        text += &format!("; no estimate of {}", names.join(", "));
    }
    text
}

fn of_point(report: &StudyReport<'_>, point: usize) -> Markup {
    let manifest = report.manifest;
    html! {
        section {
            h2 { @if manifest.points.len() > 1 { (manifest.told(point)) } @else { "Errors" } }
            @if manifest.points.len() > 1 { ul { @for series in report.at(point) { li { (finding(report, series)) } } } }
            div.wide { table {
                thead { tr {
                    th { "quantity" } th { "unit" }
                    @for series in report.at(point) { th.number { (report.name(series)) } }
                } }
                tbody { @for (place, (name, unit)) in manifest.quantities.iter().enumerate() {
                    tr {
                        td { (name) } td { (unit) }
                        @for series in report.at(point) { td.number { (cell(&series.quantities[place])) } }
                    }
                } }
            } }
            (comparison(report, point))
        }
    }
}

/// Errors over those of the last estimator.
fn comparison(report: &StudyReport<'_>, point: usize) -> Markup {
    let Some(reference) = report.reference(point) else { return html! {} };
    html! {
        h3 { "rms error over that of " (report.name(reference)) }
        div.wide { table {
            thead { tr {
                th { "quantity" }
                @for series in report.at(point).filter(|series| *series != reference) { th.number { (report.name(series)) } }
            } }
            tbody { @for compared in report.compared(point) {
                tr {
                    td { (manifest_name(report, compared.quantity)) }
                    @for ratio in &compared.ratios {
                        td.number { @if ratio.is_nan() { "–" } @else { (significant(*ratio, 3)) } }
                    }
                }
            } }
        } }
    }
}

fn manifest_name<'a>(report: &StudyReport<'a>, quantity: usize) -> &'a str {
    &report.manifest.quantities[quantity].0
}
