//! What the data determine, in words.

use gravcal_calibration::result::{EstimatorResult, Undetermined};
use maud::{Markup, html};

use super::CalibrationPage;
use gravcal_robot_model::number::significant;

pub(super) fn section(page: &CalibrationPage<'_>) -> Markup {
    let Some(main) = page.main() else { return html! {} };
    html! {
        section {
            h2 { "What the data determine" }
            @if !main.undetermined.iter().any(|open| is_asked(main, open)) {
                p { "Nothing that was asked for is left open." }
            }
            @for result in std::iter::once(main).chain(page.results.iter().filter(|other| other.name != main.name)) {
                (undetermined(result))
            }
            @if !main.weak.is_empty() {
                h3 { "Known far worse than the rest" }
                ul { @for weak in &main.weak { li { (weak.combination) ": " (significant(weak.times_worse, 2)) " times worse" } } }
            }
            @if !main.held.is_empty() {
                h3 { "Fixed: not estimated" }
                ul { @for held in &main.held { li { (held.name) ": " (held.why) } } }
            }
            @if !main.sensor_models.is_empty() {
                h3 { "Sensors beyond gain and bias, each tested against its absence" }
                ul { @for model in &main.sensor_models {
                    li {
                        (model.joint) ", " (model.model) ": "
                        @match &model.test {
                            Some(test) => { (test.kind.to_string()) ", p = " (significant(test.p_value, 2)) }
                            None => { "not determined" }
                        }
                    }
                } }
            }
        }
    }
}

/// Whether something that was asked for hangs on it; what names no parameter does.
fn is_asked(result: &EstimatorResult, open: &Undetermined) -> bool {
    let asked =
        |name: &String| result.parameter(name).is_some_and(|parameter| parameter.asked && !parameter.determined);
    open.parameters.is_empty() || open.parameters.iter().any(asked)
}

fn undetermined(result: &EstimatorResult) -> Markup {
    let (asked, other): (Vec<&Undetermined>, Vec<&Undetermined>) =
        result.undetermined.iter().partition(|open| is_asked(result, open));
    html! {
        (listed(&format!("Not determined by {}", result.name), &asked))
        (listed(&format!("Not asked for, and not determined by {}", result.name), &other))
    }
}

fn listed(heading: &str, undetermined: &[&Undetermined]) -> Markup {
    html! {
        @if !undetermined.is_empty() {
            h3 { (heading) }
            dl {
                @for open in undetermined {
                    dt { (open.combination) }
                    dd { (open.why) @if !open.cure.is_empty() { " " br; "Cure: " (open.cure) } }
                }
            }
        }
    }
}
