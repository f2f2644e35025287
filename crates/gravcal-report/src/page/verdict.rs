//! What it comes to, and what to do.

use gravcal_calibration::result::{EstimatorResult, Verdict};
use gravcal_recording::counted;
use maud::{Markup, html};

use super::CalibrationPage;
use crate::advice::{Advice, Level, capital};
use gravcal_robot_model::number::measured;

pub(super) fn section(page: &CalibrationPage<'_>) -> Markup {
    let Some(main) = page.main() else { return html! { section.verdict { h2 { "No estimator ran" } } } };
    let Advice { level, headline, why, steps } = Advice::of(main, "calibration.json");
    let class = match level {
        Level::Good => "determined",
        Level::Care => "partly",
        Level::Bad => "failed",
    };
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
    let reported = |result: &EstimatorResult| match result.verdict {
        Verdict::Determined => "determined",
        Verdict::PartlyDetermined => "partly determined",
        Verdict::Failed => "failed",
    };
    html! {
        p.small {
            "Decided by the estimator " b { (main.name) } ": " (main.termination) "; " (counted(main.iterations as u64, ["iteration", "iterations"])) "."
            @for other in page.results.iter().filter(|other| other.name != main.name) {
                " " (capital(&other.name)) ": " (reported(other)) "."
            }
        }
    }
}
