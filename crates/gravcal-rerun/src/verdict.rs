//! What was found, and what a person should do next.

use std::collections::BTreeSet;

use gravcal_calibration::result::{EstimatorResult, Fit, Undetermined, Verdict};
use re_sdk::{RecordingStream, RecordingStreamError};
use re_sdk_types::archetypes::TextDocument;

use crate::recording::CalibrationRecording;

/// Logs the verdict, with the table of all values below it.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    stream.log_static("/verdict", &TextDocument::from_markdown(text(calibration)))
}

fn text(calibration: &CalibrationRecording<'_>) -> String {
    let mut text = calibration.deciding().map_or_else(|| "## Nothing ran\n".into(), told);
    for other in calibration.results.iter().filter(|other| calibration.deciding().is_none_or(|d| d.name != other.name))
    {
        text += &format!("\n*{}*: {}. {}.\n", other.name, in_words(other.verdict), other.termination);
    }
    text += "\nGrey: measured. Pink: nominal sensors, before the calibration. Blue: joint. Orange: sequential.\n";
    text + &format!("\n```text\n{}```\n", calibration.table)
}

/// The deciding result.
fn told(result: &EstimatorResult) -> String {
    let mut text = format!("## {}: {}\n\n{}\n", result.name, in_words(result.verdict), next(result));
    if let Some(gravity) = &result.gravity {
        text += &format!("- gravity known to ±{:.2}° (95 %)\n", gravity.cone95_deg);
    }
    text += &result.fit.as_ref().map_or_else(String::new, fit);
    text + &format!("- {}, {} iterations\n", result.termination, result.iterations)
}

fn in_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Determined => "everything asked for is determined",
        Verdict::PartlyDetermined => "partly determined",
        Verdict::Failed => "no answer to rely on",
    }
}

/// What to do next.
fn next(result: &EstimatorResult) -> String {
    match result.verdict {
        Verdict::Determined => "**Next**: `gravcal apply` gives recordings with true torques and angles.\n".into(),
        Verdict::PartlyDetermined => {
            let open: Vec<&Undetermined> = result.undetermined.iter().filter(|one| is_asked(result, one)).collect();
            let names: Vec<String> = open.iter().map(|one| format!("- undetermined: {}\n", one.combination)).collect();
            let cures: BTreeSet<&str> =
                open.iter().map(|one| one.cure.as_str()).filter(|cure| !cure.is_empty()).collect();
            let cures: Vec<String> = cures.into_iter().map(|cure| format!("- **next**: {cure}\n")).collect();
            names.concat() + &cures.concat()
        }
        Verdict::Failed => {
            let notes: Vec<String> = result.notes.iter().map(|note| format!("- {note}\n")).collect();
            format!("**Next**: find what is wrong; the residuals show where.\n{}", notes.concat())
        }
    }
}

/// Whether anything of it was asked for.
fn is_asked(result: &EstimatorResult, one: &Undetermined) -> bool {
    let asked = |name: &String| result.parameter(name).is_none_or(|parameter| parameter.asked);
    one.parameters.iter().any(asked)
}

fn fit(fit: &Fit) -> String {
    let p = match fit.p_value {
        None => "noise estimated from the residuals".into(),
        Some(p) if p < 1e-3 => "p < 0.001: model and stated noise do not explain the readings".into(),
        Some(p) => format!("p = {p:.2}"),
    };
    format!("- χ² {:.0} for {} degrees of freedom, {p}\n", fit.chi_squared, fit.degrees_of_freedom)
}
