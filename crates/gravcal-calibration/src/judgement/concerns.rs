//! What does not fit in a result although there are values: one rule for page, table, terminal and scripts.

use gravcal_identification::Explained;
use gravcal_robot_model::parameter::SensorParameter;

use crate::result::{Concern, EstimatorResult, Fit, ParameterResult};

/// A position gain this far from its nominal value, as a share of it, is no matter of calibration.
const FAR: f64 = 0.3;

/// What does not fit in a result.
pub(crate) fn concerns(result: &EstimatorResult) -> Vec<Concern> {
    let of_fit = result.fit.as_ref().and_then(of_fit);
    let shape = of_residuals(result);
    let gains = result.parameters.iter().filter_map(far_position_gain);
    of_fit.into_iter().chain(shape).chain(gains).collect()
}

fn of_fit(fit: &Fit) -> Option<Concern> {
    let Fit { chi_squared, degrees_of_freedom, p_value, median_ratio, times_noise, .. } = *fit;
    let times_noise = times_noise.unwrap_or(1.0);
    let explained = Explained { chi_squared, degrees_of_freedom, p_value, median_ratio, times_noise };
    let misfit = explained.misfit().map(|times_noise| Concern::Misfit { times_noise });
    misfit.or_else(|| explained.too_well().map(|times_noise| Concern::NoiseStatedTooLarge { times_noise }))
}

fn of_residuals(result: &EstimatorResult) -> Option<Concern> {
    let spoilt = result.residual_tests.iter().filter(|test| test.named && test.spoils_intervals);
    let tests: Vec<String> = spoilt.map(|test| format!("{} ({})", test.channel, test.kind)).collect();
    (!tests.is_empty()).then_some(Concern::ResidualShape { tests })
}

fn far_position_gain(parameter: &ParameterResult) -> Option<Concern> {
    let is_gain = parameter.name.rsplit('.').next() == Some(SensorParameter::PositionGain.as_str());
    let value = parameter.value.filter(|_| is_gain && parameter.held.is_none())?;
    let ratio = (value / parameter.nominal).abs();
    let far = (ratio - 1.0).abs() > FAR;
    far.then(|| Concern::FarPositionGain { parameter: parameter.name.clone(), ratio })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::Verdict;

    fn with(parameter: &str, value: Option<f64>, p_value: f64, chi_squared: f64) -> Vec<Concern> {
        let parameter = ParameterResult {
            name: parameter.to_owned(),
            unit: String::new(),
            convention: "".into(),
            value,
            std: None,
            ci95: None,
            determined: value.is_some(),
            held: None,
            asked: true,
            nominal: 2.0,
        };
        let fit = Fit {
            chi_squared,
            degrees_of_freedom: 100,
            p_value: Some(p_value),
            times_noise: Some((chi_squared / 100.0).sqrt()),
            median_ratio: None,
            joints: Vec::new(),
            held_out: None,
            held_out_missing: None,
            smaller_models: Vec::new(),
            residuals: Vec::new(),
        };
        let blank = EstimatorResult::blank("joint", Verdict::Determined, String::new());
        concerns(&EstimatorResult { parameters: vec![parameter], fit: Some(fit), ..blank })
    }

    #[test]
    fn residuals_beyond_chance_are_a_concern_both_ways() {
        assert_eq!(with("a.torque_gain", Some(9.0), 0.5, 100.0), []);
        assert_eq!(with("a.torque_gain", None, 0.002, 140.0), []);
        assert_eq!(with("a.torque_gain", None, 1e-9, 400.0), [Concern::Misfit { times_noise: 2.0 }]);
        assert_eq!(with("a.torque_gain", None, 0.9999, 49.0), [Concern::NoiseStatedTooLarge { times_noise: 0.7 }]);
        assert_eq!(with("a.torque_gain", None, 0.9999, 81.0), [], "a tenth is no matter");
    }

    #[test]
    fn a_position_gain_far_from_its_nominal_value_is_a_concern() {
        let ratio = |value: f64| match &with("a.position_gain", Some(value), 0.5, 100.0)[..] {
            [] => None,
            [Concern::FarPositionGain { parameter, ratio }] if parameter == "a.position_gain" => Some(*ratio),
            other => panic!("{other:?}"),
        };
        assert_eq!([2.58, 1.42, -2.5].map(ratio), [None; 3]);
        assert_eq!([2.62, 1.38, -3.0].map(ratio), [Some(1.31), Some(0.69), Some(1.5)]);
        assert_eq!(with("a.position_gain", None, 0.5, 100.0), []);
    }
}
