//! What tests on residuals name, and how many there were. The notes say it in sentences.

use gravcal_calibration::result::{EstimatorResult, ResidualTest};

use crate::text::wrapped;
use gravcal_robot_model::number::significant;

const HEADING: &str = "Tests on residuals";

pub(super) fn report(results: &[EstimatorResult]) -> String {
    let tested = results.iter().filter(|result| !result.residual_tests.is_empty());
    let reported: String = tested.map(|result| report_one(result, results.len() > 1)).collect();
    if reported.is_empty() { reported } else { format!("{HEADING}\n{reported}") }
}

fn report_one(result: &EstimatorResult, several: bool) -> String {
    let whose = if several { format!("{}: ", result.name) } else { String::new() };
    let (count, named) = in_short(result);
    std::iter::once(format!("{whose}{count}")).chain(named).map(|line| wrapped("  ", "    ", &line)).collect()
}

/// How many there were, and what they name, a line each.
pub(crate) fn in_short(result: &EstimatorResult) -> (String, Vec<String>) {
    let named: Vec<String> = result.residual_tests.iter().filter(|test| test.named).map(in_words).collect();
    let all = result.residual_tests.len();
    let count = match named.is_empty() {
        true => format!("none of {all} names anything that the model lacks"),
        false => format!("{} of {all} name what the model lacks", named.len()),
    };
    (count, named)
}

fn in_words(test: &ResidualTest) -> String {
    let ResidualTest { channel, kind, size, unit, corrected_p_value, .. } = test;
    let size = format!("{} {unit}", significant(*size, 2));
    let p = match *corrected_p_value < 1e-3 {
        true => "p < 0.001".to_owned(),
        false => format!("p = {}", significant(*corrected_p_value, 2)),
    };
    format!("{channel} {kind}: {}, {p}", size.trim_end())
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::result::ResidualTestKind;

    use super::*;
    use crate::testing::result;

    #[test]
    fn what_is_named_is_reported_and_the_rest_counted() {
        let test = |kind, size, unit: &str, named| ResidualTest {
            channel: "joint3".into(),
            kind,
            statistic: 30.0,
            degrees_of_freedom: [1.0, 80.0],
            blocks: None,
            p_value: 1e-7,
            corrected_p_value: if named { 1e-5 } else { 0.3 },
            size,
            unit: unit.into(),
            in_noise: 0.6,
            named,
            spoils_intervals: named,
        };
        let mut joint = result("joint");
        assert_eq!(report(&[joint.clone()]), "");
        joint.residual_tests = vec![test(ResidualTestKind::Neighbours, 0.01, "", false)];
        let in_one_line = report(&[joint.clone()]).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(in_one_line.contains("none of 1 names anything"), "{in_one_line}");
        joint.residual_tests.insert(0, test(ResidualTestKind::Acceleration, 0.4, "N·m/(rad/s²)", true));
        let text = report(&[joint]);
        assert!(
            text.contains("1 of 2 name") && text.contains("joint3 acceleration: 0.40 N·m/(rad/s²), p < 0.001"),
            "{text}"
        );
    }
}
