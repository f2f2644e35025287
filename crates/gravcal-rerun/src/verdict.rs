//! What was found, and what a person should do next.

use gravcal_calibration::result::EstimatorResult;
use gravcal_report::Advice;
use re_sdk::{RecordingStream, RecordingStreamError};
use re_sdk_types::archetypes::TextDocument;

use crate::contents::CalibrationRecording;

/// Logs the verdict, with the table of all values below it.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    stream.log_static("/verdict", &TextDocument::from_markdown(text(calibration)))
}

fn text(calibration: &CalibrationRecording<'_>) -> String {
    let mut text = calibration.deciding().map_or_else(|| "# No estimator ran\n".into(), reported);
    text += "\nColours: grey is measured, pink what sensors at their nominal values would read, orange sequential, blue joint.\n";
    text + &format!("\n```text\n{}```\n", calibration.table)
}

/// The deciding result.
fn reported(result: &EstimatorResult) -> String {
    let Advice { level: _, headline, why, steps } = Advice::of(result, "calibration.json");
    let mut text = format!("# {headline}\n\n{why}\n\n");
    for step in steps {
        text += &format!("- {step}\n");
    }
    if let Some(gravity) = &result.gravity {
        text += &format!("\nThe direction of gravity is known to ±{:.2}° (95 %). ", gravity.cone95_deg);
    }
    text + &format!(
        "\nDecided by the estimator *{}*: {}; {} iterations.\n",
        result.name, result.termination, result.iterations
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Calibrated;

    #[test]
    fn what_to_do_stands_before_the_table() {
        let mut calibrated = Calibrated::sarcos_shoulder().clone();
        let reported = text(&calibrated.recording());
        assert!(reported.starts_with("# Determined: these numbers can be used\n"), "{reported}");
        assert!(reported.find("gravcal export").unwrap() < reported.find("the table").unwrap(), "{reported}");
        calibrated.results.truncate(1);
        let reported = text(&calibrated.recording());
        assert!(
            reported.starts_with("# Partly determined") && reported.contains("- use the joint estimator"),
            "{reported}"
        );
        calibrated.results.clear();
        assert!(text(&calibrated.recording()).starts_with("# No estimator ran"));
    }
}
