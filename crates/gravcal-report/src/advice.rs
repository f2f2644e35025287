//! What a result comes to, and what a person should do next: the same words wherever it is shown.

use gravcal_calibration::result::{Concern, EstimatorResult, TakenAsExact, UncertaintyResult, Verdict};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::MistakenUnit;

use crate::sensor_row::{is_friction, split_name};

/// Reasons that are told with a verdict.
const CAUSES: usize = 2;

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
    /// Of an estimator that ran. `file`: calibration.json, as the reader would name it in a command.
    pub fn of(result: &EstimatorResult, file: &str) -> Advice {
        match result.verdict {
            Verdict::Failed => failed(result),
            Verdict::PartlyDetermined => partly(result),
            Verdict::Determined => determined(result, file),
        }
    }
}

/// Something that does not fit in words, and what to do about it.
struct Worded {
    what: String,
    steps: Vec<String>,
}

fn determined(result: &EstimatorResult, file: &str) -> Advice {
    let concerns = concerns(result);
    if !concerns.is_empty() {
        let reported: Vec<&str> = concerns.iter().map(|concern| concern.what.as_str()).collect();
        return Advice {
            level: Level::Care,
            headline: "Usable with care: something does not fit",
            why: format!(
                "Everything asked for is determined, but {}.{}",
                reported.join("; and "),
                counted_less(result)
            ),
            steps: concerns.into_iter().flat_map(|concern| concern.steps).collect(),
        };
    }
    let explained = match result.fit.as_ref().and_then(|fit| fit.p_value) {
        Some(p) => format!("the readings are explained as well as their noise allows (p = {})", significant(p, 2)),
        None => "the size of the noise was estimated from the residuals, so χ² cannot test the model".to_owned(),
    };
    Advice {
        level: Level::Good,
        headline: "Determined: these numbers can be used",
        why: format!("Everything asked for is determined, and {explained}.{}", counted_less(result)),
        steps: hangs_most_on(result)
            .into_iter()
            .chain([
                "Look once at the residuals (report.html): they should be a band without a shape.".into(),
                match formats(result) {
                    TABLE => format!("gravcal export {file} --to {TABLE} makes a table of all that the sensors have."),
                    others => format!("gravcal export {file} --to {others} gives the numbers to the driver."),
                },
                "Keep calibration.json: gravcal compare tells later which sensor moved.".into(),
            ])
            .collect(),
    }
}

/// So many are told at once; all stand among the notes, with what to do.
const MOST: usize = 4;

/// Of what the session takes as exact that on which each quantity hangs most.
fn hangs_most_on(result: &EstimatorResult) -> Option<String> {
    let mut taken: Vec<&TakenAsExact> = result.taken_as_exact.iter().collect();
    taken.sort_by(|a, b| b.off_in_std.total_cmp(&a.off_in_std));
    // One of each quantity says more than three of the gains.
    let quantity = |taken: &TakenAsExact| split_name(&taken.parameter).1.to_owned();
    let mut told: Vec<&TakenAsExact> = Vec::new();
    for own in &taken {
        if told.iter().all(|other| quantity(other) != quantity(own)) {
            told.push(own);
        }
    }
    let off = |(place, taken): (usize, &&TakenAsExact)| {
        let (by, in_std) = if place == 0 { ("would be off by", " standard deviations") } else { ("by", "") };
        format!("{} {by} {}{in_std} if {}", taken.parameter, significant(taken.off_in_std, 2), taken.wrong)
    };
    let most: Vec<String> = told.iter().take(MOST).enumerate().map(off).collect();
    let more = taken.len() - most.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    (!most.is_empty()).then(|| format!("Ask what the intervals hang on: {}{more}.", most.join("; ")))
}

/// The format of sensors that no driver's formula holds.
const TABLE: &str = "csv";

/// What can be exported: joints' sensors beyond gain and bias have tables only; friction is no part of a sensor.
fn formats(result: &EstimatorResult) -> &'static str {
    let affine = |quantity: &str| SensorParameter::ALL.iter().any(|known| known.as_str() == quantity);
    let names: Vec<(&str, &str)> = result.parameters.iter().map(|parameter| split_name(&parameter.name)).collect();
    let joints: Vec<&str> = names.iter().filter(|(_, quantity)| affine(quantity)).map(|(joint, _)| *joint).collect();
    let beyond = |quantity: &str| !affine(quantity) && !is_friction(quantity);
    if names.iter().any(|(owner, quantity)| joints.contains(owner) && beyond(quantity)) {
        TABLE
    } else if joints.is_empty() {
        "ros2 (or c, python)"
    } else {
        "ros2 (or c, python; urdf where the robot came as URDF)"
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
    if open.is_empty() {
        return intervals_in_doubt(result);
    }
    let mut steps = likely_causes(result);
    for undetermined in &result.undetermined {
        let asked = undetermined.parameters.iter().any(|name| open.contains(&name.as_str()));
        if asked && !undetermined.cure.is_empty() && !steps.contains(&undetermined.cure) {
            steps.push(undetermined.cure.clone());
        }
    }
    steps.push(
        "Run gravcal check on the session: it tells the smallest additions that would determine the rest.".into(),
    );
    let concerns = concerns(result);
    let reported: String = concerns.iter().map(|concern| format!(" Besides, {}.", concern.what)).collect();
    steps.extend(match concerns.is_empty() {
        true => vec!["Use only what has a number.".into()],
        false => concerns.into_iter().flat_map(|concern| concern.steps).collect(),
    });
    Advice {
        level: Level::Care,
        headline: "Partly determined: do not use what has no number",
        why: format!("The data do not determine {}.{reported}{}", open.join(", "), counted_less(result)),
        steps,
    }
}

/// Everything asked for has a number, and what the residuals say forbids to trust the intervals.
fn intervals_in_doubt(result: &EstimatorResult) -> Advice {
    let concerns = concerns(result);
    if concerns.is_empty() {
        return Advice {
            level: Level::Care,
            headline: "Determined, with a warning",
            why: format!(
                "Everything asked for has a value, but not all of it can be believed.{}",
                counted_less(result)
            ),
            steps: match result.reasons {
                0 => vec!["Look at the warnings at the top; mend the session.".into()],
                _ => likely_causes(result),
            },
        };
    }
    let reported: Vec<&str> = concerns.iter().map(|concern| concern.what.as_str()).collect();
    Advice {
        level: Level::Care,
        headline: "Determined, but intervals cannot be relied on",
        why: format!("Everything asked for has a value, but {}.{}", reported.join("; and "), counted_less(result)),
        steps: likely_causes(result)
            .into_iter()
            .chain(concerns.into_iter().flat_map(|concern| concern.steps))
            .collect(),
    }
}

fn failed(result: &EstimatorResult) -> Advice {
    let mut steps = likely_causes(result);
    if result.termination.starts_with("not converged") {
        steps.push(
            "See with --verbose whether the cost still fell: then allow more iterations; else start nearer, by nominal sensor values \
             and gravity's hemisphere in the session, or try another --solver."
                .into(),
        );
    }
    if result.fit.is_some() {
        steps.push(
            "Look at the residuals (report.html): which joint is far off, and in which poses, tells what is wrong."
                .into(),
        );
    }
    steps.push("Use no number of this result. Mend the session and calibrate again.".into());
    Advice {
        level: Level::Bad,
        headline: "Failed: there is no answer to rely on",
        why: format!("{}.", capital(&result.termination)),
        steps,
    }
}

/// The first of the reasons for the verdict.
fn likely_causes(result: &EstimatorResult) -> Vec<String> {
    result.notes.iter().take(result.reasons.min(CAUSES)).cloned().collect()
}

fn concerns(result: &EstimatorResult) -> Vec<Worded> {
    let from_scatter = !matches!(result.uncertainty, None | Some(UncertaintyResult::Noise { .. }));
    result.concerns.iter().map(|concern| worded(concern, from_scatter)).collect()
}

/// `from_scatter`: whether standard deviations are from the scatter of the data already.
fn worded(concern: &Concern, from_scatter: bool) -> Worded {
    match concern {
        Concern::Misfit { times_noise } => misfit(*times_noise, from_scatter),
        Concern::NoiseStatedTooLarge { times_noise } => Worded {
            what: format!("the residuals are only {} times as large as the stated noise makes them (p > 0.999)", significant(*times_noise, 2)),
            steps: vec![
                "State the noise that the readings have, or none, which takes it from the residuals; then calibrate again."
                    .into(),
            ],
        },
        Concern::ResidualShape { tests } => Worded {
            what: format!("the residuals show what the model lacks: {}", tests.join(", ")),
            steps: vec![
                "Read the notes on these residuals (report.html, or --full): each says what the model lacks and how to mend it.".into(),
            ],
        },
        Concern::OneSidedApproach { joints } => Worded {
            what: format!(
                "the torque bias of each joint that came to its poses from one side ({}) holds what friction leaves at rest, if there is any",
                joints.join(", ")
            ),
            steps: vec![
                "Come to the same poses from both sides, and say from which (direction in [readings]); without friction all is well.".into(),
            ],
        },
        Concern::FarPositionGain { parameter, ratio } => far_gain(split_name(parameter).0, parameter, *ratio),
    }
}

/// The readings are explained worse than their stated noise, and that is no accident.
fn misfit(times_noise: f64, from_scatter: bool) -> Worded {
    let until_then =
        "Until then take standard deviations from the scatter of the data: [uncertainty] kind = \"jackknife\".";
    let steps = [
        "Look at the residuals: what depends on the angle is a sensor's or the model's, what depends on time a drift, single points are bad rows.",
        "Let sensor_models in the session's [[joint]] say what is seen, or [loss] count outliers less; then calibrate again.",
    ];
    Worded {
        what: format!(
            "the readings are explained {} times worse than their stated noise (p < 0.001)",
            significant(times_noise, 2)
        ),
        steps: steps.into_iter().chain((!from_scatter).then_some(until_then)).map(str::to_owned).collect(),
    }
}

/// A position gain that no sensor has.
fn far_gain(joint: &str, name: &str, ratio: f64) -> Worded {
    let mistaken =
        MistakenUnit::of_gain(ratio).map_or_else(String::new, |unit| format!(": the readings {}", unit.reported()));
    Worded {
        what: format!("{name} is {} times its nominal value{mistaken}", significant(ratio, 3)),
        steps: vec![format!(
            "Check the unit of {joint}'s positions in the session, and its nominal gain; then calibrate again."
        )],
    }
}

/// A sentence on what a loss counted less.
fn counted_less(result: &EstimatorResult) -> String {
    match (&result.loss, result.outliers.len()) {
        (Some(loss), count) if count > 0 => {
            format!(" The {} loss counted {count} readings less than half; report.html names them.", loss.kind)
        }
        _ => String::new(),
    }
}

/// With a capital letter at its beginning.
pub(crate) fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::result::TakenAsExact;

    use super::*;
    use crate::testing::{determined, result};

    const FILE: &str = "arm/calibration.json";

    fn with(concerns: Vec<Concern>) -> EstimatorResult {
        let parameters = vec![determined("joint1.position_gain", "rad/rad", 1.01, 0.001)];
        EstimatorResult { parameters, concerns, ..result("joint") }
    }

    #[test]
    fn what_does_not_fit_is_reported_whatever_else_is() {
        let advice = Advice::of(&with(Vec::new()), FILE);
        assert_eq!((advice.level, advice.headline), (Level::Good, "Determined: these numbers can be used"));
        assert!(advice.steps[1].contains("gravcal export arm/calibration.json --to ros2"));
        let too_good = Advice::of(&with(vec![Concern::NoiseStatedTooLarge { times_noise: 0.5 }]), FILE);
        assert!(
            too_good.level == Level::Care && too_good.why.contains("only 0.50 times as large as the stated noise"),
            "{too_good:?}"
        );
        let mut partly = with(vec![Concern::Misfit { times_noise: 1.7 }]);
        partly.verdict = Verdict::PartlyDetermined;
        let doubted = Advice::of(&partly, FILE);
        assert_eq!((doubted.level, doubted.headline), (Level::Care, "Determined, but intervals cannot be relied on"));
        partly.parameters[0].determined = false;
        let partly = Advice::of(&partly, FILE);
        assert!(partly.why.contains("Besides, the readings are explained 1.7 times worse"), "{partly:?}");
        let shape = with(vec![Concern::ResidualShape { tests: vec!["joint1 (trend)".into()] }]);
        assert!(Advice::of(&shape, FILE).why.contains("what the model lacks: joint1 (trend)"));
    }

    /// What intervals hang on most is told beside numbers that can be used, and no other way of being wrong.
    #[test]
    fn what_is_taken_as_exact_is_told_first() {
        let exact = |parameter: &str, off_in_std: f64| TakenAsExact {
            wrong: "each joint were 1 mm aside".into(),
            parameter: parameter.into(),
            off_in_std,
            cure: "state it".into(),
        };
        let taken_as_exact = vec![
            exact("a.torque_gain", 3.0),
            exact("b.torque_gain", 18.2),
            exact("gravity", 4.0),
            exact("a.position_offset", 5.0),
            exact("a.torque_bias", 2.5),
        ];
        let advice = Advice::of(&EstimatorResult { taken_as_exact, ..with(Vec::new()) }, FILE);
        assert_eq!(
            advice.steps[0],
            "Ask what the intervals hang on: b.torque_gain would be off by 18 standard deviations if each joint were 1 mm aside; \
             a.position_offset by 5.0 if each joint were 1 mm aside; gravity by 4.0 if each joint were 1 mm aside; \
             a.torque_bias by 2.5 if each joint were 1 mm aside; and 1 more."
        );
    }

    #[test]
    fn joints_that_came_from_one_side_are_a_concern() {
        let one_sided = Concern::OneSidedApproach { joints: vec!["shoulder".into(), "elbow".into()] };
        let advice = Advice::of(&with(vec![one_sided]), FILE);
        assert_eq!(advice.level, Level::Care);
        assert!(advice.why.contains("came to its poses from one side (shoulder, elbow)"), "{}", advice.why);
        assert!(advice.steps.iter().any(|step| step.contains("direction in [readings]")), "{:?}", advice.steps);
    }

    #[test]
    fn a_wrong_unit_of_positions_is_reported() {
        let parameter = "joint1.position_gain".to_owned();
        let advice = Advice::of(&with(vec![Concern::FarPositionGain { parameter, ratio: 57.2 }]), FILE);
        assert_eq!(advice.level, Level::Care);
        assert!(advice.why.contains("joint1.position_gain is 57.2 times its nominal value"), "{}", advice.why);
        assert!(advice.why.contains("the readings look like rad, and are declared as deg"), "{}", advice.why);
    }

    #[test]
    fn no_convergence_has_its_own_advice() {
        let mut stopped = with(Vec::new());
        (stopped.verdict, stopped.termination) = (Verdict::Failed, "not converged after 2 iterations".into());
        assert!(Advice::of(&stopped, FILE).steps[0].contains("allow more iterations"));
    }

    #[test]
    fn sensors_beyond_gain_and_bias_are_exported_as_a_table() {
        let mut beyond = with(Vec::new());
        beyond.parameters.push(determined("joint1.torque_gain_2", "count/(N·m)^2", 0.1, 0.001));
        assert!(Advice::of(&beyond, FILE).steps[1].contains("--to csv"));
    }
}
