//! Models of sensors beyond gain and bias, each tested against its absence.

use gravcal_calibration::result::{EstimatorResult, SensorModelTest, TestAgainstZero};

use super::shared::{Shared, by_content};
use crate::text::wrapped;
use gravcal_robot_model::number::significant;

const HEADING: &str = "Sensor models, each tested against its absence";
/// A smaller probability is told as smaller.
const SMALL: f64 = 1e-3;

pub(super) fn report(results: &[EstimatorResult]) -> String {
    let models = by_content(results, |result| &result.sensor_models);
    let reported: String = models.iter().map(|shared| report_one(shared, results.len() > 1)).collect();
    if reported.is_empty() { reported } else { format!("{HEADING}\n{reported}") }
}

fn report_one(shared: &Shared<'_, SensorModelTest>, several: bool) -> String {
    let SensorModelTest { joint, model, test, parameters } = shared.item;
    let whose = if several { format!(" ({})", shared.names) } else { String::new() };
    let outcome = match test {
        Some(test) => in_words(test),
        None if parameters.is_empty() => "given as exact, not tested".to_owned(),
        None => "not tested: the data do not determine it".to_owned(),
    };
    wrapped("  ", "    ", &format!("{joint} {model}{whose}: {outcome}"))
}

fn in_words(test: &TestAgainstZero) -> String {
    let freedom: Vec<String> = test.degrees_of_freedom.iter().flatten().map(usize::to_string).collect();
    let (statistic, freedom) = (significant(test.statistic, 4), freedom.join(" and "));
    let consequence = if test.p_value < SMALL {
        "p < 0.001: the readings need it".to_owned()
    } else {
        format!("p = {}", significant(test.p_value, 2))
    };
    format!("{} {statistic}, degrees of freedom {freedom}, {consequence}", test.kind)
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::result::TestKind;

    use super::*;
    use crate::testing::result;

    fn tested(test: Option<TestAgainstZero>) -> SensorModelTest {
        let parameters = vec!["joint2.torque_bias_drift".into()];
        SensorModelTest { joint: "joint2".into(), model: "torque-bias-in-time".into(), parameters, test }
    }

    #[test]
    fn each_is_reported_with_its_test() {
        let test = |kind, statistic, p_value| {
            Some(TestAgainstZero { kind, statistic, degrees_of_freedom: [Some(1), None], p_value })
        };
        let mut joint = result("joint");
        joint.sensor_models = vec![
            tested(test(TestKind::LikelihoodRatio, 1061.2, 0.0)),
            tested(test(TestKind::Wald, 0.5, 0.4795)),
            tested(None),
        ];
        let text = report(&[joint]);
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.starts_with(&format!("{HEADING} joint2 torque-bias-in-time: likelihood ratio 1061,")));
        assert!(text.contains("degrees of freedom 1, p < 0.001: the readings need it"), "{text}");
        assert!(text.contains("Wald 0.5000, degrees of freedom 1, p = 0.48"), "{text}");
        assert!(text.contains("not tested: the data do not determine it"), "{text}");
        assert_eq!(report(&[result("joint")]), "");
    }
}
