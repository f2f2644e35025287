//! `study.html`: what a study found, its figures and tables, in one file.

use gravcal_study::measures::Series;
use maud::{Markup, PreEscaped, html};

use super::StudyReport;
use super::markdown::cell;
use super::ranges::{Range, coverage, over_bound};
use super::text::heading;
use crate::page::document;
use gravcal_robot_model::number::significant;

/// With the figures as SVG.
pub(super) fn page(report: &StudyReport<'_>, figures: &[(String, String)]) -> String {
    let manifest = report.manifest;
    let title = report.title();
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

/// `joint: determined 100 %, …; errors 0.98 to 1.02 of the bound, 94.1 to 95.8 % of the 95 % intervals hold the truth`.
fn finding(report: &StudyReport<'_>, series: &Series) -> String {
    let quantities = report.manifest.quantities.iter().zip(&series.quantities);
    let silent: Vec<&str> =
        quantities.filter(|(_, quantity)| quantity.estimates == 0).map(|((name, _), _)| name.as_str()).collect();
    let mut text = heading(report, series);
    if let Some(range) = Range::over_quantities([series].into_iter(), over_bound) {
        text += &format!("; errors {} of the bound", range.reported());
    }
    if let Some(range) = Range::over_quantities([series].into_iter(), coverage) {
        text += &format!("; {} % of the 95 % intervals hold the truth", range.reported());
    }
    if !silent.is_empty() {
        text += &format!("; no estimate of {}", silent.join(", "));
    }
    text
}

fn of_point(report: &StudyReport<'_>, point: usize) -> Markup {
    let manifest = report.manifest;
    html! {
        section {
            h2 { @if manifest.points.len() > 1 { (manifest.reported(point)) } @else { "Errors" } }
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
                @for series in report.others(point) { th.number { (report.name(series)) } }
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
