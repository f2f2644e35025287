//! The verdicts in words, before any number.

use gravcal_calibration::result::{EstimatorResult, Verdict};

use crate::advice::Advice;
use crate::text::{width, wrapped};

pub(super) fn report(robot: &str, results: &[EstimatorResult]) -> String {
    if results.is_empty() {
        return format!("Calibration of {robot}: no estimator ran\n");
    }
    let widest = results.iter().map(|result| width(&result.name)).max().unwrap_or(0);
    let mut text = format!("Calibration of {robot}\n");
    for result in results {
        let indent = " ".repeat(widest + 4);
        let first = format!("  {:<widest$}  ", result.name);
        text += &wrapped(&first, &indent, &in_words(result));
        text += &wrapped(&indent, &indent, &ending(result));
    }
    text
}

fn in_words(result: &EstimatorResult) -> String {
    match result.verdict {
        Verdict::Determined => "determined: everything that is asked for".to_owned(),
        Verdict::PartlyDetermined if missing(result).is_empty() => {
            let headline = Advice::of(result, "").headline;
            headline.replacen("Determined", "determined", 1)
        }
        Verdict::PartlyDetermined => format!("partly determined: not {}", missing(result).join(", ")),
        Verdict::Failed => "failed: no answer to rely on".to_owned(),
    }
}

/// What is asked for and not determined. Of gravity a result says only that it is not there.
fn missing(result: &EstimatorResult) -> Vec<&str> {
    let gravity = result.gravity.is_none().then_some("gravity");
    let parameters = result.parameters.iter().filter(|p| p.asked && !p.determined).map(|p| p.name.as_str());
    gravity.into_iter().chain(parameters).collect()
}

fn ending(result: &EstimatorResult) -> String {
    let plural = if result.iterations == 1 { "" } else { "s" };
    format!("{}; {} iteration{plural}", result.termination, result.iterations)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{result, undetermined};

    #[test]
    fn names_what_is_missing() {
        let mut partly = result("joint");
        partly.verdict = Verdict::PartlyDetermined;
        partly.gravity = None;
        let mut not_asked = undetermined("joint2.position_offset");
        not_asked.asked = false;
        partly.parameters = vec![undetermined("joint1.torque_gain"), not_asked];
        assert_eq!(
            report("arm", &[partly]),
            "Calibration of arm\n\
             \x20 joint  partly determined: not gravity, joint1.torque_gain\n\
             \x20        converged: steps too small to matter (1.0e-12); 6 iterations\n"
        );
    }

    #[test]
    fn a_failure_is_called_one() {
        let mut failed = result("joint");
        failed.verdict = Verdict::Failed;
        failed.termination = "not converged after 1 iteration".into();
        failed.iterations = 1;
        assert!(report("arm", &[failed]).contains("failed: no answer to rely on\n"));
    }
}
