//! What it comes to, and what to do.

use gravcal_calibration::result::{EstimatorResult, Fit, Verdict};
use maud::{Markup, html};

use super::CalibrationPage;
use crate::number::{measured, significant};

/// Below this probability the stated noise and the model do not go together.
const IMPROBABLE: f64 = 1e-3;

/// How the page begins.
struct Told {
    class: &'static str,
    headline: &'static str,
    why: String,
    steps: Vec<String>,
}

pub(super) fn section(page: &CalibrationPage<'_>) -> Markup {
    let Some(main) = page.main() else { return html! { section.verdict { h2 { "No estimator ran" } } } };
    let Told { class, headline, why, steps } = tell(main);
    html! {
        section class=(format!("verdict {class}")) {
            h2 { (headline) }
            p { (why) }
            h3 { "What to do" }
            ol { @for step in &steps { li { (step) } } }
            (gravity(main))
            (others(page, main))
        }
    }
}

fn tell(result: &EstimatorResult) -> Told {
    match result.verdict {
        Verdict::Failed => failed(result),
        Verdict::PartlyDetermined => partly(result),
        Verdict::Determined => match result.fit.as_ref().and_then(misfit) {
            None => determined(result),
            Some(times) => Told {
                class: "partly",
                headline: "Usable with care: the model does not explain everything",
                why: format!(
                    "Everything asked for is determined, but the readings are explained {} times worse than their stated noise \
                     (p < 0.001).",
                    significant(times, 2)
                ),
                steps: vec![
                    "Look at the residuals below: what depends on the angle is a sensor's or the model's, what depends on time a \
                     drift, single points are bad rows."
                        .into(),
                    "Let sensor_models in the session's [[joint]] say what is seen, or [loss] count outliers less; then calibrate \
                     again."
                        .into(),
                    "Until then take standard deviations from the scatter of the data: [uncertainty] kind = \"sandwich\".".into(),
                ],
            },
        },
    }
}

/// By how much the readings are explained worse than their stated noise, where that is no accident.
fn misfit(fit: &Fit) -> Option<f64> {
    let ratio = fit.median_ratio.unwrap_or_else(|| (fit.chi_squared / fit.degrees_of_freedom.max(1) as f64).sqrt());
    fit.p_value.filter(|p| *p < IMPROBABLE).map(|_| ratio)
}

fn determined(result: &EstimatorResult) -> Told {
    let explained = match result.fit.as_ref().and_then(|fit| fit.p_value) {
        Some(p) => format!("the readings are explained as well as their noise allows (p = {})", significant(p, 2)),
        None => "the size of the noise was taken from the residuals, so no test says whether the model is right: look at what is below".to_owned(),
    };
    Told {
        class: "determined",
        headline: "Determined: these numbers can be used",
        why: format!("Everything asked for is determined, and {explained}."),
        steps: vec![
            "Look once at the residuals below: they should be a band without a shape, and neighbours should not be alike.".into(),
            "Give the numbers to the driver: gravcal export calibration.json --to ros2 (or c, python, urdf).".into(),
            "Keep calibration.json: gravcal compare tells next week which sensor has moved.".into(),
        ],
    }
}

fn partly(result: &EstimatorResult) -> Told {
    let open: Vec<&str> = result
        .parameters
        .iter()
        .filter(|parameter| parameter.asked && !parameter.determined)
        .map(|parameter| parameter.name.as_str())
        .chain(result.gravity.is_none().then_some("gravity"))
        .collect();
    let mut steps: Vec<String> = Vec::new();
    for undetermined in &result.undetermined {
        let asked = undetermined.parameters.iter().any(|name| open.contains(&name.as_str()));
        if asked && !undetermined.cure.is_empty() && !steps.contains(&undetermined.cure) {
            steps.push(undetermined.cure.clone());
        }
    }
    steps.push(
        "Run gravcal check on the session: it tells the smallest additions that would determine the rest.".into(),
    );
    steps.push("Use the numbers that are there; what has none, has none.".into());
    Told {
        class: "partly",
        headline: "Partly determined: do not use what has no number",
        why: format!("The data do not determine {}.", open.join(", ")),
        steps,
    }
}

fn failed(result: &EstimatorResult) -> Told {
    let mut steps: Vec<String> = vec!["Use none of these numbers.".into()];
    steps.extend(
        result
            .notes
            .iter()
            .filter(|note| note.starts_with("What to look at") || note.starts_with("The torque sensor"))
            .cloned(),
    );
    if result.fit.is_some() {
        steps.push(
            "Look at the residuals below: the joint that is far off, and the poses where it is, tell what is wrong."
                .into(),
        );
    }
    steps.push("Mend the session and calibrate again; gravcal check tells whether its poses suffice.".into());
    Told {
        class: "failed",
        headline: "Failed: there is no answer to rely on",
        why: format!("{}.", capital(&result.termination)),
        steps,
    }
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

fn gravity(result: &EstimatorResult) -> Markup {
    let Some(gravity) = &result.gravity else { return html! {} };
    let [x, y, z] = gravity.vector_m_per_s2;
    let tilt = x.hypot(y).atan2(-z).to_degrees();
    let (tilt, cone) = measured(tilt, gravity.cone95_deg);
    let component = |axis: usize| {
        let (value, std) = measured(gravity.vector_m_per_s2[axis], gravity.std_m_per_s2[axis]);
        format!("{value} ± {std}")
    };
    html! {
        p.gravity {
            "Gravity in base coordinates: " b { "(" (component(0)) ", " (component(1)) ", " (component(2)) ") m/s²" }
            ". The base is tilted by " b { (tilt) "°" } "; the true direction is within " (cone) "° with 95 % probability."
        }
    }
}

/// The other estimators in a line each.
fn others(page: &CalibrationPage<'_>, main: &EstimatorResult) -> Markup {
    let told = |result: &EstimatorResult| match result.verdict {
        Verdict::Determined => "determined",
        Verdict::PartlyDetermined => "partly determined",
        Verdict::Failed => "failed",
    };
    html! {
        p.small {
            "Decided by the estimator " b { (main.name) } ": " (main.termination) "; " (main.iterations) " iterations."
            @for other in page.results.iter().filter(|other| other.name != main.name) {
                " " (capital(&other.name)) ": " (told(other)) "."
            }
        }
    }
}
