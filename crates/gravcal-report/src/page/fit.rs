//! How well the readings are explained, in numbers, and which were hardly counted.

use gravcal_calibration::result::{ActiveConstraint, EstimatorResult, Fit, Outlier};
use maud::{Markup, html};

use super::CalibrationPage;
use crate::advice::capital;
use crate::table::fit::{SMALLER_MODELS, chi_squared, joint_row, prediction, smaller_models, unexplained_error};
use crate::table::inertias::predictions;
use crate::table::residual_tests::in_short;
use gravcal_robot_model::number::significant;

/// Outliers that are named on the page; `calibration.json` names all.
const NAMED: usize = 20;

pub(super) fn section(page: &CalibrationPage<'_>) -> Markup {
    let Some(main) = page.main() else { return html! {} };
    let reported = numbers(main);
    html! {
        @if !reported.is_empty() || !main.active_constraints.is_empty() || !main.outliers.is_empty() {
            section {
                h2 { "How well the readings are explained" }
                @for line in reported { p { (line) } }
                @if let Some(fit) = &main.fit { (joints(fit)) }
                (residual_tests(main))
                (smaller(main))
                (constraints(&main.active_constraints))
                (outliers(&main.outliers))
            }
        }
    }
}

fn numbers(result: &EstimatorResult) -> Vec<String> {
    let fit = result.fit.as_ref();
    let held_out = fit.and_then(|fit| fit.held_out.as_ref());
    let all = fit.map(|fit| format!("{}: {}.", result.name, chi_squared(fit)));
    let consistent = result.consistent_model.as_ref().and_then(|model| model.held_out.as_ref()).zip(held_out);
    let consistent =
        consistent.map(|(model, without)| format!("Consistent inertias, {}.", predictions(model, without)));
    let held_out = held_out.map(|held_out| format!("{}.", prediction(held_out)));
    let joints = fit.into_iter().flat_map(|fit| &fit.joints);
    let unexplained = joints.filter_map(|joint| Some(format!("{}.", unexplained_error(joint, &joint.unexplained?))));
    all.into_iter().chain(held_out).chain(consistent).chain(unexplained).collect()
}

/// Residuals of each joint and axis beside the noise, and of what was held out.
fn joints(fit: &Fit) -> Markup {
    let headings =
        ["", "unit", "readings", "noise", "rms", "largest", "rms, held out", "largest, held out", "of range"];
    let columns = if fit.held_out.is_some() { 9 } else { 6 };
    html! {
        div.wide { table {
            thead { tr { @for heading in &headings[..columns] { th { (heading) } } } }
            tbody { @for joint in &fit.joints { tr {
                @for (place, cell) in joint_row(joint, fit.held_out.as_ref()).iter().enumerate() { td.number[place > 1] { (cell) } }
            } } }
        } }
        @if fit.joints.iter().any(|joint| joint.noise_estimated) { p.small { "~ estimated from the residuals" } }
    }
}

/// What they name; the notes say it in sentences.
fn residual_tests(result: &EstimatorResult) -> Markup {
    let (count, named) = in_short(result);
    html! {
        @if !result.residual_tests.is_empty() {
            h3 { "Tests on residuals" }
            p { (capital(&count)) @if named.is_empty() { "." } @else { ":" } }
            @if !named.is_empty() { ul { @for line in &named { li { (line) } } } }
        }
    }
}

/// What the model gains over smaller ones.
fn smaller(result: &EstimatorResult) -> Markup {
    let rows = result.fit.as_ref().map(smaller_models).unwrap_or_default();
    html! {
        @if let Some((headings, joints)) = rows.split_first() {
            p.small { "The " (SMALLER_MODELS) }
            div.wide { table {
                thead { tr { @for heading in headings { th { (heading) } } } }
                tbody { @for joint in joints { tr {
                    @for (place, cell) in joint.iter().enumerate() { td.number[place > 1] { (cell) } }
                } } }
            } }
        }
    }
}

fn constraints(active: &[ActiveConstraint]) -> Markup {
    html! {
        @if !active.is_empty() {
            h3 { "Constraints on which the estimate leans" }
            ul { @for one in active {
                li {
                    (one.constraint) ": ½ χ² would fall by " (significant(one.multiplier, 2)) " for each " (one.unit)
                    " by which it gives way"
                }
            } }
        }
    }
}

fn outliers(outliers: &[Outlier]) -> Markup {
    html! {
        @if !outliers.is_empty() {
            h3 { "Readings that were counted less than half" }
            ul {
                @for outlier in outliers.iter().take(NAMED) { li { (outlier.to_string()) } }
                @if outliers.len() > NAMED { li { "and " (outliers.len() - NAMED) " more in calibration.json" } }
            }
        }
    }
}
