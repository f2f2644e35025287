//! `study.html`: the tables and figures of a study in one file.

use maud::{Markup, PreEscaped, html};

use super::StudyReport;
use super::markdown::cell;
use super::text::heading;
use crate::page::document;

/// With the figures as SVG.
pub(super) fn page(report: &StudyReport<'_>, figures: &[(String, String)]) -> String {
    let manifest = report.manifest;
    let body = html! {
        h1 { "Study" }
        section.verdict {
            p { (manifest.trials) " trials" @if manifest.points.len() > 1 { " at each of " (manifest.points.len()) " points" } ": " (manifest.estimators.join(", ")) "." }
            p.small {
                "Errors are root mean squares; after them their ratio to the Cramér-Rao bound of the readings that the estimator uses, and the share "
                "of the 95 % intervals that hold the truth. measures.csv beside this file has more."
            }
        }
        @for (name, svg) in figures {
            figure aria-label=(name) { (PreEscaped(svg)) }
        }
        @for point in 0..manifest.points.len() { (of_point(report, point)) }
    };
    document("Study", &body, None)
}

fn of_point(report: &StudyReport<'_>, point: usize) -> Markup {
    let manifest = report.manifest;
    html! {
        section {
            @if manifest.points.len() > 1 { h2 { (manifest.told(point)) } }
            ul { @for series in report.at(point) { li { (heading(report, series)) } } }
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
        }
    }
}
