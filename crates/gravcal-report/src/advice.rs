//! What a result comes to, and what a person should do next: the same words wherever it is shown.

use gravcal_calibration::result::{EstimatorResult, Fit, Verdict};

use crate::number::significant;

/// Below this probability the stated noise and the model do not go together.
const IMPROBABLE: f64 = 1e-3;

/// What a result comes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Advice {
    /// At a glance.
    pub level: Level,
    /// In a few words.
    pub headline: &'static str,
    /// In a sentence.
    pub why: String,
    /// What to do next, one after the other.
    pub steps: Vec<String>,
}

/// Whether a result can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// As it is.
    Good,
    /// Not without thinking.
    Care,
    /// Not at all.
    Bad,
}

impl Advice {
    /// Of an estimator that ran.
    pub fn of(result: &EstimatorResult) -> Advice {
        match result.verdict {
            Verdict::Failed => failed(result),
            Verdict::PartlyDetermined => partly(result),
            Verdict::Determined => match result.fit.as_ref().and_then(misfit) {
                None => determined(result),
                Some(times) => Advice {
                    level: Level::Care,
                    headline: "Usable with care: the model does not explain everything",
                    why: format!(
                        "Everything asked for is determined, but the readings are explained {} times worse than their stated noise \
                         (p < 0.001).",
                        significant(times, 2)
                    ),
                    steps: vec![
                        "Look at the residuals: what depends on the angle is a sensor's or the model's, what depends on time a \
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
}

/// By how much the readings are explained worse than their stated noise, where that is no accident.
fn misfit(fit: &Fit) -> Option<f64> {
    let ratio = fit.median_ratio.unwrap_or_else(|| (fit.chi_squared / fit.degrees_of_freedom.max(1) as f64).sqrt());
    fit.p_value.filter(|p| *p < IMPROBABLE).map(|_| ratio)
}

fn determined(result: &EstimatorResult) -> Advice {
    let explained = match result.fit.as_ref().and_then(|fit| fit.p_value) {
        Some(p) => format!("the readings are explained as well as their noise allows (p = {})", significant(p, 2)),
        None => "the size of the noise was taken from the residuals, so no test says whether the model is right: look at the residuals".to_owned(),
    };
    Advice {
        level: Level::Good,
        headline: "Determined: these numbers can be used",
        why: format!("Everything asked for is determined, and {explained}."),
        steps: vec![
            "Look once at the residuals: they should be a band without a shape, and neighbours should not be alike."
                .into(),
            "Give the numbers to the driver: gravcal export calibration.json --to ros2 (or c, python, urdf).".into(),
            "Keep calibration.json: gravcal compare tells next week which sensor has moved.".into(),
        ],
    }
}

fn partly(result: &EstimatorResult) -> Advice {
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
    Advice {
        level: Level::Care,
        headline: "Partly determined: do not use what has no number",
        why: format!("The data do not determine {}.", open.join(", ")),
        steps,
    }
}

fn failed(result: &EstimatorResult) -> Advice {
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
            "Look at the residuals: the joint that is far off, and the poses where it is, tell what is wrong.".into(),
        );
    }
    steps.push("Mend the session and calibrate again; gravcal check tells whether its poses suffice.".into());
    Advice {
        level: Level::Bad,
        headline: "Failed: there is no answer to rely on",
        why: format!("{}.", capital(&result.termination)),
        steps,
    }
}

/// With a capital letter at its beginning.
pub(crate) fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}
