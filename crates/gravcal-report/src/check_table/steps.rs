//! What the sequential procedure will do with the sweeps.

use gravcal_calibration::check::{CheckReport, StepReport};

use crate::text::wrapped;

pub(super) fn report(report: &CheckReport) -> String {
    if report.steps.is_empty() {
        return format!("Sequential procedure\n{}", wrapped("  ", "    ", NO_SERIAL_CHAIN));
    }
    let reported: String = report.steps.iter().map(|step| wrapped("  ", "    ", &in_words(step))).collect();
    format!("Sequential procedure\n{reported}")
}

const NO_SERIAL_CHAIN: &str = "none: its steps go along one serial chain, and this robot branches, has joints that mimic \
                               others, or has none; use the joint estimator";

fn in_words(step: &StepReport) -> String {
    let StepReport { step, finds, sweeps, problem } = step;
    let plural = if *sweeps == 1 { "" } else { "s" };
    match problem {
        None => format!("step {step} finds {finds} from {sweeps} sweep{plural}"),
        Some(problem) => format!("step {step} cannot find {finds}: {problem}"),
    }
}
