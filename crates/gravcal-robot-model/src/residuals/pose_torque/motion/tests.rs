//! Derivatives of windows, and windows that stand.

use gravcal_estimation::BlockId;
use gravcal_recording::MotionSample;

use super::super::PoseTorque;
use super::super::tests::{assert_rows_within_their_patterns, model_of, some_chain};
use super::*;
use crate::residuals::testing::{check_at_random_points, ids};
use crate::sensors::SensorTerms;
use crate::sensors::testing::every_torque_term;

const POSITIONS: [f64; 3] = [0.3, 0.2, -0.8];

/// A window of three samples; standing, where the arm does not move.
fn course(moving: f64) -> Arc<Course> {
    let sample = |shift: f64| MotionSample {
        time: shift,
        position: POSITIONS.iter().map(|q| q + moving * shift).collect(),
        velocity: [1.3, -0.4, 0.9].map(|v| moving * (v + shift)).to_vec(),
        acceleration: [-2.0, 1.1, 0.6].map(|a| moving * (a - shift)).to_vec(),
    };
    Arc::new(Course::of(&[(0.25, -0.1), (0.5, 0.0), (0.25, 0.1)].map(|(weight, shift)| (weight, sample(shift)))))
}

/// A chain of three joints with a load on the second link; lengths of its blocks and their ids.
fn model(terms: &SensorTerms) -> (Arc<PoseTorqueModel>, Vec<usize>, Vec<BlockId>) {
    let lengths = [vec![3], vec![1; 12], vec![4, 4, 4, 3, 3, 1], vec![1; terms.len()], vec![6; 4], vec![1; 2]].concat();
    let ids = ids(&lengths);
    let first = 19 + terms.len();
    (Arc::new(model_of(some_chain(), terms, &ids[..first])), lengths, ids[first..].to_vec())
}

/// The first joint and the last have a rotor.
fn rotors(blocks: &[BlockId]) -> [Option<BlockId>; 3] {
    [Some(blocks[4]), None, Some(blocks[5])]
}

fn window(terms: &SensorTerms, moving: f64) -> (MotionTorque, Arc<PoseTorqueModel>, Vec<usize>) {
    let (pose, lengths, tensors) = model(terms);
    let model = MotionTorqueModel::new(Arc::clone(&pose), &tensors[..3], Some(tensors[3]), &rotors(&tensors));
    let conditions = Conditions {
        time: Some(1.3),
        temperature: vec![24.0, 26.0, 29.0],
        velocity: vec![0.3, -0.2, 0.4],
        acceleration: vec![0.1; 3],
        direction: vec![0.6, -1.0, 0.0],
        presliding: Vec::new(),
        further: Vec::new(),
    };
    let readings = vec![(0, 2.0), (1, 1.0), (2, -1.0)];
    (MotionTorque::new(Arc::new(model), course(moving), readings, conditions), pose, lengths)
}

#[test]
fn derivatives() {
    let (residual, _, lengths) = window(&SensorTerms::default(), 1.0);
    check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
}

#[test]
fn derivatives_with_terms_of_torque_sensors() {
    let terms = every_torque_term();
    let (residual, _, lengths) = window(&terms, 1.0);
    check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    assert_rows_within_their_patterns(&residual, &lengths);
}

#[test]
fn a_window_that_stands_reads_its_static_pose() {
    let (residual, pose, lengths) = window(&SensorTerms::default(), 0.0);
    let still = PoseTorque::new(pose, POSITIONS.to_vec(), vec![(0, 2.0), (1, 1.0), (2, -1.0)]);
    let width: usize = lengths.iter().sum();
    let x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
    let read = |residual: &dyn Residual, x: &[f64]| {
        let mut read = vec![0.0; 3];
        residual.evaluate(LocalValues::new(x, &[]), &mut read, None).unwrap();
        read
    };
    let (moving, standing) = (read(&residual, &x), read(&still, &x[..width - 26]));
    for (a, b) in moving.iter().zip(&standing) {
        assert!((a - b).abs() < 1e-12, "{moving:?} {standing:?}");
    }
}

/// A rotor adds its inertia times the mean acceleration, before the sensor's gain.
#[test]
fn a_rotor_is_a_part_of_its_joints_torque() {
    let (residual, _, lengths) = window(&SensorTerms::default(), 1.0);
    let width: usize = lengths.iter().sum();
    let x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
    let read = |x: &[f64]| {
        let mut read = vec![0.0; 3];
        residual.evaluate(LocalValues::new(x, &[]), &mut read, None).unwrap();
        read
    };
    let mut without = x.clone();
    without[width - 2..].fill(0.0);
    let (with, without) = (read(&x), read(&without));
    let of = |joint, quantity| x[sensor_column(3, quantity, joint)];
    // The samples' accelerations are even about those of the middle one.
    for (joint, (rotor, acceleration)) in
        [(x[width - 2], -2.0), (0.0, 1.1), (x[width - 1], 0.6)].into_iter().enumerate()
    {
        let expected =
            of(joint, SensorParameter::TorqueGain) * rotor * of(joint, SensorParameter::PositionGain) * acceleration;
        assert!((with[joint] - without[joint] - expected).abs() < 1e-12, "{joint}: {with:?} {without:?} {expected}");
    }
}

/// Where positions are fixed, readings and the other derivatives are those that are found without knowing so.
#[test]
fn held_positions_change_nothing() {
    let terms = every_torque_term();
    let (free, _, lengths) = window(&terms, 1.0);
    let width: usize = lengths.iter().sum();
    let offsets: Vec<usize> = (0..=lengths.len()).map(|blocks| lengths[..blocks].iter().sum()).collect();
    let x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
    let column = |quantity, joint| sensor_column(3, quantity, joint);
    let of = |joint| {
        [SensorParameter::PositionGain, SensorParameter::PositionOffset].map(|quantity| x[column(quantity, joint)])
    };
    let (pose, _, tensors) = model(&terms);
    let known = MotionTorqueModel::new(pose, &tensors[..3], Some(tensors[3]), &rotors(&tensors))
        .at_positions(Some((0..3).map(of).collect()));
    let held = MotionTorque::new(Arc::new(known), course(1.0), free.readings.clone(), free.conditions.clone());
    let read = |residual: &MotionTorque| {
        let (mut read, mut jacobian) = (vec![0.0; 3], vec![0.0; 3 * width]);
        let rows = RowsMut::new(&mut jacobian, width);
        residual.evaluate(LocalValues::new(&x, &offsets), &mut read, Some(rows)).unwrap();
        (read, jacobian)
    };
    let ((a, by_a), (b, by_b)) = (read(&free), read(&held));
    let of_positions = column(SensorParameter::PositionGain, 0)..inertia_column(3, 0);
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() < 1e-10, "{a} {b}");
    }
    for (place, (a, b)) in by_a.iter().zip(&by_b).enumerate() {
        assert!(of_positions.contains(&(place % width)) || (a - b).abs() < 1e-10, "{place}: {a} {b}");
    }
}

/// What is kept with a course is of one arm and one set of sensors: another does not get it.
#[test]
fn regressors_that_are_kept_are_those_of_the_same_positions() {
    let (chain, course) = (Arc::new(some_chain()), course(1.0));
    let [here, elsewhere] = [0.0, 0.2].map(|offset| vec![[1.01, offset]; 3]);
    let first = Regressors::kept(&chain, &course, &here);
    assert!(Arc::ptr_eq(&first, &Regressors::kept(&Arc::new((*chain).clone()), &course, &here)));
    assert!(!Arc::ptr_eq(&first, &Regressors::kept(&chain, &course, &elsewhere)));
    let moved = Regressors::kept(&Arc::new(chain.without_lengths()), &course, &here);
    assert!(!Arc::ptr_eq(&first, &moved));
}
