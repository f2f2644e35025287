//! Comparisons of simulated calibrations, whose truth is known.

use gravcal_recording::{EarlierParameter, EarlierQuantity};
use gravcal_robot_model::EstimatorName;
use gravcal_session::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;
use rayon::prelude::*;

use super::*;
use crate::result::EstimatorResult;
use crate::testing::sarcos_shoulder;
use crate::{SolveEnvironment, calibrate};

/// What a `calibration.json` says of an answer.
fn earlier(result: &EstimatorResult) -> EarlierEstimate {
    let parameter = |p: &crate::result::ParameterResult| EarlierParameter {
        name: p.name.clone(),
        unit: p.unit.clone(),
        value: p.value,
        held: p.held.clone(),
        std: p.std,
        ci95: p.ci95,
        convention: p.convention.clone().into_owned(),
        nominal: p.nominal,
    };
    let gravity = result.gravity.as_ref().unwrap().vector_m_per_s2;
    let components = ["gravity.x", "gravity.y", "gravity.z"];
    let quantity = |name: &String| {
        let axis = components.iter().position(|axis| axis == name);
        let value = axis.map(|axis| gravity[axis]).or_else(|| result.parameter(name)?.value).unwrap_or(0.0);
        EarlierQuantity { terms: vec![(name.clone(), 1.0)], value }
    };
    EarlierEstimate {
        parameters: result.parameters.iter().map(parameter).collect(),
        gravity: Some(gravity),
        gravity_ci95: None,
        cone95_deg: None,
        quantities: result.covariance.order.iter().map(quantity).collect(),
        covariance: result.covariance.matrix.concat(),
        blocks_left_out: None,
        sandwich_blocks: None,
        doubts: Vec::new(),
        inertias: None,
        payloads: Vec::new(),
    }
}

/// Calibrations of a simulation's trials.
fn calibrations(simulation: &Simulation, trials: std::ops::Range<u64>) -> Vec<EarlierEstimate> {
    let solver = LevenbergMarquardt::default();
    let one = |trial: u64| {
        let answers = calibrate(
            &simulation.session(trial),
            &[EstimatorName::Joint],
            &SolveEnvironment::new(&solver, &|_: &str| {}),
        );
        earlier(&answers[0])
    };
    trials.into_par_iter().map(one).collect()
}

/// A calibration of these torque gains, each uncertain by 3 % together with all others and by a thousandth on its own.
fn of_gains(gains: &[f64]) -> EarlierEstimate {
    let names: Vec<String> = (1..=gains.len()).map(|joint| format!("joint{joint}.torque_gain")).collect();
    let parameter = |(name, value): (&String, &f64)| EarlierParameter {
        name: name.clone(),
        unit: "V/(N·m)".to_owned(),
        value: Some(*value),
        held: None,
        std: Some(0.03),
        ci95: None,
        convention: String::new(),
        nominal: 1.0,
    };
    let quantity = |(name, value): (&String, &f64)| EarlierQuantity { terms: vec![(name.clone(), 1.0)], value: *value };
    let entry = |(i, j): (usize, usize)| 9e-4 + if i == j { 1e-6 } else { 0.0 };
    let places = (0..gains.len()).flat_map(|i| (0..gains.len()).map(move |j| (i, j)));
    EarlierEstimate {
        parameters: names.iter().zip(gains).map(parameter).collect(),
        quantities: names.iter().zip(gains).map(quantity).collect(),
        covariance: places.map(entry).collect(),
        gravity: None,
        gravity_ci95: None,
        cone95_deg: None,
        blocks_left_out: None,
        sandwich_blocks: None,
        doubts: Vec::new(),
        inertias: None,
        payloads: Vec::new(),
    }
}

#[test]
fn a_gain_that_moved_within_an_error_that_all_share_is_named_beside_the_others() {
    let before = of_gains(&[1.0, 1.001, 0.999, 1.0005]);
    let moved = |gains: &[f64]| {
        let compared = compare(&[&before, &of_gains(gains)]).unwrap();
        let of = |sensor: &SensorComparison| {
            assert!(!sensor.test.as_ref().unwrap().corrected_p_value.lt(&SIGNIFICANCE), "by itself it is where it was");
            (sensor.name.clone(), sensor.beside_others.as_ref().unwrap().or.clone())
        };
        compared.moved().map(of).collect::<Vec<_>>()
    };
    assert_eq!(moved(&[1.02, 1.021, 1.019, 1.0205]), [], "all by one scale");
    assert_eq!(moved(&[1.02, 1.021, 1.03, 1.0205]), [("joint3".to_owned(), vec![])]);
    let two = moved(&[1.03, 1.021, 1.0, 1.0205]);
    assert_eq!(two.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["joint1", "joint3"]);
    // Of two gains either may have moved.
    let before = of_gains(&[1.0, 1.0]);
    let compared = compare(&[&before, &of_gains(&[1.0, 1.02])]).unwrap();
    let named: Vec<usize> = compared.moved().map(|sensor| sensor.beside_others.as_ref().unwrap().or.len()).collect();
    assert_eq!(named, [1]);
}

/// Largest distance of an empirical distribution from the uniform one (Kolmogorov, Smirnov).
fn distance_from_uniform(mut p_values: Vec<f64>) -> f64 {
    p_values.sort_by(f64::total_cmp);
    let count = p_values.len() as f64;
    let of = |(place, p): (usize, &f64)| (p - place as f64 / count).abs().max(((place + 1) as f64 / count - p).abs());
    p_values.iter().enumerate().map(of).fold(0.0, f64::max)
}

#[test]
fn without_a_change_p_values_are_uniform_and_hardly_a_sensor_is_named() {
    const DRAWS: usize = 150;
    let all = calibrations(&sarcos_shoulder(), 0..2 * DRAWS as u64);
    let compared: Vec<Comparison> = all.chunks(2).map(|pair| compare(&[&pair[0], &pair[1]]).unwrap()).collect();
    let names: Vec<&str> = compared[0].sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    let expected = ["gravity", "joint1 torque", "joint1 position", "joint2 torque", "joint2 position", "joint3 torque"];
    assert_eq!(names[..6], expected);
    let freedom: Vec<usize> =
        compared[0].sensors.iter().map(|sensor| sensor.test.as_ref().unwrap().degrees_of_freedom).collect();
    // Offsets of the first and last joint are choices.
    assert_eq!(freedom, [2, 2, 1, 2, 2, 2, 1]);
    // Exceeded with probability 1e-4 by each.
    let limit = 2.23 / (DRAWS as f64).sqrt();
    for (sensor, name) in names.iter().enumerate() {
        let p_values = compared.iter().map(|one| one.sensors[sensor].test.as_ref().unwrap().p_value).collect();
        let distance = distance_from_uniform(p_values);
        assert!(distance < limit, "{name}: {distance}");
    }
    let named = compared.iter().filter(|one| one.moved().next().is_some()).count();
    assert!(named <= 7, "{named} of {DRAWS} name a sensor, where one in a hundred may");
}

#[test]
fn a_moved_gain_is_named_and_nothing_else() {
    let before = sarcos_shoulder();
    let mut after = before.clone();
    after.truth.sensors[1][0] *= 1.05;
    let [before, after] = [calibrations(&before, 0..4), calibrations(&after, 10..12)];
    let comparison = compare(&[&before[0], &after[0]]).unwrap();
    assert_eq!(comparison.moved().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>(), ["joint2 torque"]);
    // Of several calibrations the step is told, too.
    let series = compare(&[&before[0], &before[1], &before[2], &after[0], &after[1]]).unwrap();
    let moved: Vec<&SensorComparison> = series.moved().collect();
    assert_eq!(moved.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>(), ["joint2 torque"]);
    let test = moved[0].test.as_ref().unwrap();
    assert_eq!((test.degrees_of_freedom, test.largest_step.0), (8, 2));
    assert_eq!(moved[0].parameters[0].values.len(), 5);
}

fn reported(sensor: &SensorComparison) -> Vec<String> {
    sensor.left_out.iter().map(LeftOut::to_string).collect()
}

/// Two calibrations: the difference, and the sum of the covariances.
#[test]
fn of_two_it_is_the_test_of_the_difference() {
    let all = calibrations(&sarcos_shoulder(), 0..2);
    let comparison = compare(&[&all[0], &all[1]]).unwrap();
    let sensor = comparison.sensors.iter().find(|sensor| sensor.name == "joint1 position").unwrap();
    let ComparedParameter { values, stds, .. } = &sensor.parameters[0];
    let expected = (values[0] - values[1]).powi(2) / (stds[0].powi(2) + stds[1].powi(2));
    let found = sensor.test.as_ref().unwrap();
    assert!((found.chi_squared / expected - 1.0).abs() < 1e-9);
    assert_eq!(reported(sensor), ["joint1.position_offset is held in calibration 1 (it defines the base frame)"]);
    assert_eq!(comparison.not_seen(), ["joint1.position_offset", "joint3.position_offset"]);
    assert_eq!(comparison.base_frame, ["joint1.position_offset"]);
}

#[test]
fn what_cannot_be_compared_is_reported() {
    let all = calibrations(&sarcos_shoulder(), 0..2);
    assert_eq!(compare(&[&all[0]]), Err(ComparisonError::One));
    let mut other = all[1].clone();
    other.parameters.retain(|parameter| parameter.name != "joint1.torque_gain");
    other.parameters.iter_mut().find(|parameter| parameter.name == "joint1.torque_bias").unwrap().value = None;
    other.gravity = None;
    let comparison = compare(&[&all[0], &other]).unwrap();
    assert_eq!(reported(&comparison.sensors[0]), ["gravity is not determined in calibration 2"]);
    let expected =
        ["joint1.torque_gain is not in calibration 2", "joint1.torque_bias is not determined in calibration 2"];
    assert_eq!(
        (reported(&comparison.sensors[1]), &comparison.sensors[1].test),
        (expected.map(str::to_owned).into(), &None)
    );
    let mut volts = all[1].clone();
    volts.parameters[0].unit = "V/(N·m)".into();
    let error = compare(&[&all[0], &volts]).unwrap_err().to_string();
    assert!(error.starts_with("joint1.torque_gain is in count/(N·m) in one and in V/(N·m) in the other"), "{error}");
    let mut nothing = other.clone();
    nothing.parameters.iter_mut().for_each(|parameter| parameter.value = None);
    assert_eq!(compare(&[&nothing, &nothing]), Err(ComparisonError::NothingInCommon));
    let none = EarlierEstimate { parameters: Vec::new(), ..all[0].clone() };
    assert_eq!(compare(&[&all[0], &none]), Err(ComparisonError::NoSensorInCommon));
}

#[test]
fn what_only_one_calibration_has_is_reported_whichever_it_is() {
    let all = calibrations(&sarcos_shoulder(), 0..2);
    let mut fewer = all[1].clone();
    let gone = |name: &str| name.starts_with("joint2.torque_") || name == "joint3.torque_bias";
    fewer.parameters.retain(|parameter| !gone(&parameter.name));
    for (pair, lacking) in [([&all[0], &fewer], 2), ([&fewer, &all[0]], 1)] {
        let comparison = compare(&pair).unwrap();
        let of = |name: &str| comparison.sensors.iter().find(|sensor| sensor.name == name).unwrap();
        assert_eq!(reported(of("joint2 torque")), [format!("joint2 torque is not in calibration {lacking}")]);
        assert!(!of("joint2 torque").in_all && of("joint3 torque").in_all);
        assert_eq!(of("joint3 torque").models_differ_in, ["joint3.torque_bias"]);
        let mut not_seen = comparison.not_seen();
        not_seen.sort_unstable();
        let expected = ["joint1.position_offset", "joint2 torque", "joint3.position_offset", "joint3.torque_bias"];
        assert_eq!(not_seen, expected);
    }
}

#[test]
fn a_covariance_that_cannot_be_inverted_is_reported_and_not_compared() {
    let all = calibrations(&sarcos_shoulder(), 0..2);
    let place = |name: &str| all[1].quantities.iter().position(|quantity| quantity.terms[0].0 == name).unwrap();
    let (gain, bias) = (place("joint2.torque_gain"), place("joint2.torque_bias"));
    let size = all[1].quantities.len();
    for value in [-1.0, 0.0, f64::NAN] {
        let mut broken = all[1].clone();
        broken.covariance[gain * (size + 1)] = value;
        let comparison = compare(&[&all[0], &broken]).unwrap();
        let sensor = comparison.sensors.iter().find(|sensor| sensor.name == "joint2 torque").unwrap();
        let why = "is not compared: its sensor's covariance in calibration 2 is not positive definite";
        assert_eq!(reported(sensor), ["gain", "bias"].map(|what| format!("joint2.torque_{what} {why}")));
        assert!(sensor.test.is_none() && sensor.parameters.is_empty() && comparison.not_seen().len() == 4);
    }
    let mut singular = all[1].clone();
    for (i, j) in [(gain, gain), (gain, bias), (bias, gain), (bias, bias)] {
        singular.covariance[i * size + j] = 1.0;
    }
    let comparison = compare(&[&singular, &all[0]]).unwrap();
    assert!(comparison.not_seen().contains(&"joint2.torque_bias"));
}

#[test]
fn a_torque_sensor_that_is_not_there_cannot_move() {
    let mut all = calibrations(&sarcos_shoulder(), 0..2);
    for calibration in &mut all {
        for parameter in &mut calibration.parameters {
            if parameter.name.starts_with("joint2.torque_") {
                parameter.held = Some(gravcal_robot_model::session::NO_TORQUE_SENSOR.to_owned());
            }
        }
    }
    let comparison = compare(&[&all[0], &all[1]]).unwrap();
    assert_eq!(comparison.not_seen(), ["joint1.position_offset", "joint3.position_offset"]);
}

#[test]
fn holm_counts_the_smallest_most() {
    let test = |p_value| {
        Some(HomogeneityTest {
            chi_squared: 0.0,
            degrees_of_freedom: 1,
            p_value,
            corrected_p_value: p_value,
            moved: false,
            largest_step: (0, 0.0),
        })
    };
    let sensor = |p| SensorComparison {
        name: String::new(),
        parameters: vec![],
        left_out: vec![],
        in_all: true,
        models_differ_in: vec![],
        test: test(p),
        beside_others: None,
    };
    let mut sensors = [0.04, 0.002, 0.03].map(sensor);
    correct(&mut sensors);
    let corrected = sensors.map(|sensor| sensor.test.map(|test| (test.corrected_p_value, test.moved)).unwrap());
    assert_eq!(corrected, [(0.06, false), (0.006, true), (0.06, false)]);
}
