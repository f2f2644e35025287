//! Results for the tests of this crate.

use gravcal_calibration::result::{
    EstimatorResult, Fit, GravityResult, HeldOut, JointFit, NoiseSource, ParameterResult, UncertaintyResult, Verdict,
};
use gravcal_robot_model::parameter::SensorParameter;

/// A determined result without parameters and fit.
pub fn result(name: &str) -> EstimatorResult {
    EstimatorResult {
        iterations: 6,
        gravity: Some(GravityResult {
            vector_m_per_s2: [-3.4312, -5.9411, -7.0009],
            std_m_per_s2: [0.0031, 0.0029, 0.0027],
            ci95_m_per_s2: [[-3.4373, -3.4251], [-5.9468, -5.9354], [-7.0062, -6.9956]],
            cone95_deg: 0.0532,
            asked: true,
        }),
        uncertainty: Some(UncertaintyResult::Noise { source: NoiseSource::Stated, widened_by: None }),
        ..EstimatorResult::blank(name, Verdict::Determined, "converged: steps too small to matter (1.0e-12)")
    }
}

/// A parameter with a value.
pub fn determined(name: &str, unit: &str, value: f64, std: f64) -> ParameterResult {
    let quantity = SensorParameter::ALL.into_iter().find(|q| name.ends_with(q.as_str()));
    ParameterResult {
        name: name.into(),
        unit: unit.into(),
        convention: quantity.map_or("", SensorParameter::convention).into(),
        value: Some(value),
        std: Some(std),
        ci95: Some([value - 1.96 * std, value + 1.96 * std]),
        determined: true,
        held: None,
        asked: true,
        nominal: 0.0,
    }
}

/// A parameter that is asked for and has no value.
pub fn undetermined(name: &str) -> ParameterResult {
    ParameterResult { value: None, std: None, ci95: None, determined: false, ..determined(name, "1", 0.0, 0.0) }
}

/// A parameter that is fixed at 0 and not asked for.
pub fn held(name: &str, reason: &str) -> ParameterResult {
    ParameterResult { held: Some(reason.into()), asked: false, ..determined(name, "rad", 0.0, 0.0) }
}

/// Residuals in counts.
pub fn joint_fit(joint: &str) -> JointFit {
    JointFit {
        joint: joint.into(),
        unit: "count".into(),
        readings: 37,
        rms: 0.791,
        largest: 2.12,
        noise_std: 0.8,
        noise_estimated: false,
        unexplained: None,
        lasting_std: None,
        range: 456.0,
    }
}

/// A fit of one joint with held-out poses.
pub fn fit() -> Fit {
    Fit {
        chi_squared: 101.3,
        degrees_of_freedom: 95,
        p_value: Some(0.31),
        times_noise: Some(1.03),
        median_ratio: None,
        joints: vec![joint_fit("joint1")],
        held_out_missing: None,
        held_out: Some(HeldOut {
            poses: 4,
            stretches: 2,
            files: Vec::new(),
            chi_squared: 9.1,
            readings: 8,
            joints: vec![JointFit { rms: 0.912, largest: 1.43, readings: 4, ..joint_fit("joint1") }],
        }),
        smaller_models: Vec::new(),
        residuals: Vec::new(),
    }
}
