//! Every parameter with its interval, against its nominal value.

use gravcal_calibration::result::{EstimatorResult, ParameterResult, Verdict};
use maud::{Markup, html};

use super::CalibrationPage;
use crate::payload_text::found;
use crate::sensor_row::{shown_unit, split_name};
use gravcal_robot_model::number::{measured, shortest};

pub(super) fn section(page: &CalibrationPage<'_>) -> Markup {
    let Some(main) = page.main() else { return html! {} };
    let others: Vec<&EstimatorResult> = page.results.iter().filter(|other| other.name != main.name).collect();
    html! {
        section {
            h2 { "Parameters" }
            p.small {
                "reading = torque_gain · torque + torque_bias; coordinate = position_gain · reading + position_offset. Bars: 95 % interval by the "
                (main.name) " estimator, each on its own scale; the tick is the nominal value."
                @if let Some(uncertainty) = &main.uncertainty { " Standard deviations are " (uncertainty.to_string()) "." }
            }
            div.wide { table {
                thead { tr {
                    th { "parameter" } th { "unit" } th.number { "nominal" } th.number { (main.name) " estimator" } th { "95 % interval" }
                    @for other in &others { th.number { (other.name) " estimator" } }
                } }
                @for rows in by_owner(&main.parameters) {
                    tbody {
                        @for parameter in rows { (row(main, parameter, &others)) }
                    }
                }
            } }
            (payloads(main))
        }
    }
}

/// Loads of unknown mass, a sentence each.
fn payloads(main: &EstimatorResult) -> Markup {
    html! {
        @if !main.payloads.is_empty() {
            h3 { "Loads of unknown mass" }
            p.small { "Value ± standard deviation, in the frame of the link that carries each." }
            ul { @for payload in &main.payloads { li { (found(payload)) } } }
        }
    }
}

/// Neighbours of one joint or instrument.
fn by_owner(parameters: &[ParameterResult]) -> impl Iterator<Item = &[ParameterResult]> {
    parameters.chunk_by(|a, b| split_name(&a.name).0 == split_name(&b.name).0)
}

fn row(main: &EstimatorResult, parameter: &ParameterResult, others: &[&EstimatorResult]) -> Markup {
    let (unit, factor) = shown_unit(&parameter.unit);
    html! {
        tr {
            td { (parameter.name) }
            td { (unit) }
            td.number { (shortest(factor * parameter.nominal)) }
            (value(main, Some(parameter), factor))
            td { @if parameter.held.is_none() { (bar(parameter)) } }
            @for other in others { (value(other, other.parameter(&parameter.name), factor)) }
        }
    }
}

/// What an estimator says of it; one that failed says nothing.
fn value(result: &EstimatorResult, parameter: Option<&ParameterResult>, factor: f64) -> Markup {
    let Some(parameter) = parameter else { return html! { td {} } };
    match (&parameter.held, parameter.value, parameter.std) {
        (Some(why), value, _) => {
            let value = shortest(factor * value.unwrap_or(parameter.nominal));
            html! { td.number.held title=(why) { (value) " fixed" } }
        }
        (None, Some(value), Some(std)) => {
            let (value, std) = measured(factor * value, factor * std);
            html! { td.number { (value) " ± " (std) } }
        }
        (None, _, _) if result.verdict == Verdict::Failed => html! { td.number.held { "withheld" } },
        (None, _, _) if parameter.asked => html! { td.number.open { "undetermined" } },
        (None, _, _) => html! { td.number { "undetermined" } },
    }
}

/// Interval and nominal value on a line, as SVG.
fn bar(parameter: &ParameterResult) -> Markup {
    let (Some([low, high]), Some(value)) = (parameter.ci95, parameter.value) else { return html! {} };
    let (least, most) = (low.min(parameter.nominal), high.max(parameter.nominal));
    let span = if most > least { most - least } else { 1.0 };
    let x = |at: f64| format!("{:.1}", 6.0 + 148.0 * (at - least) / span);
    let label = format!("{} to {}, nominal {}", shortest(low), shortest(high), shortest(parameter.nominal));
    html! {
        svg.bar viewBox="0 0 160 16" width="160" height="16" role="img" aria-label=(label) {
            line.axis x1="2" x2="158" y1="8" y2="8" {}
            line.nominal x1=(x(parameter.nominal)) x2=(x(parameter.nominal)) y1="1" y2="15" {}
            line.interval x1=(x(low)) x2=(x(high)) y1="8" y2="8" {}
            circle.value cx=(x(value)) cy="8" r="3.5" {}
        }
    }
}
