//! Derivatives, patterns and loads of the pose torque; chains that other residuals are tested with.

use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{
    Attachment, Chain, DhConvention, DhRow, GravityTorque, Joint, JointKind, Link, Mimic, Transform, chain_from_dh,
};
use gravcal_estimation::{
    Batched, Block, BlockId, EvaluateError, Factor, LANES, LocalValues, Loss, Noise, ProblemBuilder, Residual, RowsMut,
    Sphere,
};
use gravcal_recording::Conditions;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::residuals::testing::{check_at_random_points, ids};
use crate::sensors::SensorTerms;
use crate::sensors::testing::{every_term, every_term_of_own_torques};

/// Position readings of a pose of [`some_chain`].
pub const READ_POSITIONS: [f64; 3] = [0.3, 0.2, -0.8];

/// Turning, sliding and turning joint.
pub fn some_chain() -> Chain {
    let row = |i: usize, kind, a, alpha, d| DhRow {
        name: format!("joint{i}"),
        kind,
        a,
        alpha,
        d,
        theta: 0.1,
        limits: None,
        link: Link { name: format!("link{i}"), inertia: None },
    };
    let rows = [
        row(1, JointKind::Revolute, 0.1, 1.2, 0.3),
        row(2, JointKind::Prismatic, 0.2, -0.7, 0.1),
        row(3, JointKind::Revolute, -0.3, 0.4, 0.2),
    ];
    chain_from_dh("base", DhConvention::Standard, &rows).unwrap()
}

/// A trunk with two branches of two joints; the last joint mimics the first of the other branch.
fn branched_chain() -> Chain {
    let joint = |i: usize, kind| Joint {
        name: format!("joint{i}"),
        kind,
        before: Transform::from_xyz_rpy([0.1, 0.3 - 0.1 * i as f64, 0.2], [0.3, 0.2 * i as f64, -0.4]),
        axis: [0.0, 0.6, 0.8],
        after: Transform::about_x(0.5),
        limits: None,
    };
    let mut kinds = [JointKind::Revolute; 5];
    kinds[2] = JointKind::Prismatic;
    let joints = kinds.into_iter().enumerate().map(|(i, kind)| joint(i, kind)).collect();
    let links = (0..5).map(|i| Link { name: format!("link{i}"), inertia: None }).collect();
    let mut attachments = [None, Some(0), Some(1), Some(0), Some(3)].map(|parent| Attachment { parent, mimic: None });
    attachments[4].mimic = Some(Mimic { leader: 1, multiplier: -0.5, offset: 0.2 });
    Chain::branched("base", joints, links, &attachments).unwrap()
}

/// Readings of three of its four joints with a load of unknown mass on the last link, and so many compliances; lengths of the blocks.
fn on_branches(compliances: usize) -> (PoseTorque, Vec<usize>) {
    let lengths = [vec![3], vec![1; 16], vec![4; 5], vec![3, 1], vec![1; compliances]].concat();
    let ids = ids(&lengths);
    let blocks = PoseTorqueBlocks {
        gravity: ids[0],
        sensors: (0..4).map(|j| std::array::from_fn(|k| ids[1 + 4 * j + k])).collect(),
        inertia: ids[17..22].to_vec(),
        terms: Vec::new(),
        compliance: ids[24..].to_vec(),
    };
    let load = CarriedLoad { position: vec![ids[22]], mass: LoadMass::Unknown(ids[23]), link: 4 };
    let model = PoseTorqueModel::new(Arc::new(branched_chain()), &blocks, &SensorTerms::default(), Some(load));
    let readings = vec![(0, 2.0), (1, 1.0), (2, -1.0)];
    (PoseTorque::new(Arc::new(model), vec![0.3, 0.2, -0.8, 0.5], readings), lengths)
}

#[test]
fn derivatives_on_branches() {
    let (residual, lengths) = on_branches(0);
    check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    assert_rows_within_their_patterns(&residual, &lengths);
    // The sliding joint of one branch: its own sensors, positions of trunk and branch, its link, the load's columns.
    assert_eq!(residual.row_pattern(2).unwrap(), [0..3, 5..6, 9..10, 11..14, 15..18, 27..31, 39..43]);

    let (compliant, lengths) = on_branches(4);
    assert_rows_within_their_patterns(&compliant, &lengths);
    let width: usize = lengths.iter().sum();
    let mut x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
    x[width - 4..].iter_mut().for_each(|c| *c *= 0.01);
    gravcal_estimation::check_derivatives(&compliant, &lengths, &x, 1e-5).unwrap();
}

/// Lengths of the blocks of a chain of three joints with a load, and so many of one number beyond.
pub fn lengths(beyond: usize) -> Vec<usize> {
    [vec![3], vec![1; 12], vec![4, 4, 4, 3, 3, 1], vec![1; beyond]].concat()
}

/// A chain of three joints with a load of unknown mass on the second link; blocks after it are those of the terms, then compliances.
pub fn model_of(chain: Chain, terms: &SensorTerms, ids: &[BlockId]) -> PoseTorqueModel {
    let blocks = PoseTorqueBlocks {
        gravity: ids[0],
        sensors: (0..3).map(|j| std::array::from_fn(|k| ids[1 + 4 * j + k])).collect(),
        inertia: ids[13..16].to_vec(),
        terms: ids[19..19 + terms.len()].to_vec(),
        compliance: ids[19 + terms.len()..].to_vec(),
    };
    let load = CarriedLoad { position: ids[16..18].to_vec(), mass: LoadMass::Unknown(ids[18]), link: 1 };
    PoseTorqueModel::new(Arc::new(chain), &blocks, terms, Some(load))
}

/// Readings of the given joints of [`some_chain`], and the lengths of the blocks.
pub fn loaded(joints: &[usize]) -> (PoseTorque, Vec<usize>) {
    let lengths = lengths(0);
    let model = Arc::new(model_of(some_chain(), &SensorTerms::default(), &ids(&lengths)));
    let readings = joints.iter().map(|joint| (*joint, 2.0)).collect();
    (PoseTorque::new(model, READ_POSITIONS.to_vec(), readings), lengths)
}

#[test]
fn derivatives() {
    let (residual, lengths) = loaded(&[0, 2]);
    check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
}

/// Joints that give way.
fn compliant() -> (PoseTorque, Vec<usize>) {
    let lengths = lengths(3);
    let model = Arc::new(model_of(some_chain(), &SensorTerms::default(), &ids(&lengths)));
    let pose = PoseTorque::new(model, READ_POSITIONS.to_vec(), vec![(0, 2.0), (2, 1.0)]);
    (pose, lengths)
}

#[test]
fn derivatives_of_joints_that_give_way() {
    let (residual, lengths) = compliant();
    let width: usize = lengths.iter().sum();
    let mut random = rand_pcg::Pcg64::seed_from_u64(3);
    for _ in 0..20 {
        let mut x: Vec<f64> = (0..width).map(|_| random.random_range(-1.5..2.5)).collect();
        // Differences are rough where much depends on a number as small as a compliance.
        x[33..].iter_mut().for_each(|c| *c *= 0.02);
        gravcal_estimation::check_derivatives(&residual, &lengths, &x, 1e-5).unwrap();
    }
}

/// A joint rests where its unloaded place and compliance times torque put it.
#[test]
fn joints_rest_where_their_torque_leaves_them() {
    let chain = some_chain();
    let (unloaded, inertia) = ([0.3, 0.2, -0.8], [1.0, 0.1, 0.2, 0.3].repeat(3));
    let (gravity, compliance) = ([1.0, -2.0, -9.0], [0.02, 0.0, 0.03]);
    let (mut coordinates, mut torque) = (unloaded, GravityTorque::new(3, 3));
    compliance::settle(&chain, &mut coordinates, gravity, &inertia, &compliance, &mut torque).unwrap();
    let mut expected = [0.0; 3];
    chain.gravity_torque(&coordinates, gravity, &inertia, &mut expected);
    for joint in 0..3 {
        assert!((torque.torque[joint] - expected[joint]).abs() < 1e-12);
        assert!((coordinates[joint] - unloaded[joint] - compliance[joint] * expected[joint]).abs() < 1e-12);
    }
    let error = compliance::settle(&chain, &mut coordinates, gravity, &inertia, &[f64::NAN; 3], &mut torque);
    assert!(error.unwrap_err().to_string().contains("no rest"));
}

/// The same with every sensor model on every joint that can have it; the lengths of its blocks.
fn with_all_terms(compliances: usize) -> (PoseTorque, Vec<usize>) {
    with_terms(&every_term(), compliances)
}

fn with_terms(terms: &SensorTerms, compliances: usize) -> (PoseTorque, Vec<usize>) {
    let lengths = lengths(terms.len() + compliances);
    let model = Arc::new(model_of(some_chain(), terms, &ids(&lengths)));
    let conditions = Conditions {
        time: Some(1.3),
        temperature: vec![24.0, 26.0, 29.0],
        velocity: vec![0.3, -0.2, 0.4],
        acceleration: Vec::new(),
        direction: vec![1.0, -1.0, 0.0],
        presliding: Vec::new(),
        further: Vec::new(),
    };
    let readings = vec![(0, 2.0), (1, 2.0), (2, 2.0)];
    (PoseTorque::new(model, READ_POSITIONS.to_vec(), readings).under(conditions), lengths)
}

#[test]
fn derivatives_with_every_term() {
    let (residual, lengths) = with_all_terms(0);
    check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
}

#[test]
fn joints_that_give_way_go_with_every_term() {
    let (residual, lengths) = with_all_terms(3);
    assert_rows_within_their_patterns(&residual, &lengths);
    let width: usize = lengths.iter().sum();
    let mut x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
    x[width - 3..].iter_mut().for_each(|c| *c *= 0.01);
    gravcal_estimation::check_derivatives(&residual, &lengths, &x, 1e-5).unwrap();
}

#[test]
fn rows_with_terms_touch_only_the_columns_of_their_pattern() {
    let (residual, lengths) = with_all_terms(0);
    assert_rows_within_their_patterns(&residual, &lengths);
}

#[test]
fn rows_touch_only_the_columns_of_their_pattern() {
    let (residual, _) = compliant();
    assert_eq!(residual.row_pattern(0).unwrap(), [0..4, 6..7, 9..37]);
    let (residual, lengths) = loaded(&[0, 1, 2]);
    assert_eq!(residual.row_pattern(0).unwrap(), [0..4, 6..7, 9..34]);
    assert_eq!(residual.row_pattern(1).unwrap(), [0..3, 4..5, 7..8, 9..15, 19..34]);
    assert_eq!(residual.row_pattern(2).unwrap(), [0..3, 5..6, 8..15, 23..34]);
    assert_rows_within_their_patterns(&residual, &lengths);
}

pub fn assert_rows_within_their_patterns(residual: &dyn Residual, lengths: &[usize]) {
    let offsets: Vec<usize> = (0..=lengths.len()).map(|blocks| lengths[..blocks].iter().sum()).collect();
    let width: usize = lengths.iter().sum();
    // Small, so that joints that give way find a rest.
    let x: Vec<f64> = (0..width).map(|k| 0.2 + 0.1 * (k as f64).sin()).collect();
    let (mut values, mut jacobian) = ([0.0; 3], vec![0.0; 3 * width]);
    let rows = RowsMut::new(&mut jacobian, width);
    residual.evaluate(LocalValues::new(&x, &offsets), &mut values, Some(rows)).unwrap();
    for (row, entries) in jacobian.chunks(width).enumerate() {
        let pattern = residual.row_pattern(row).unwrap();
        let touched = entries.iter().enumerate().filter(|(_, entry)| **entry != 0.0);
        touched.for_each(|(column, _)| assert!(pattern.iter().any(|range| range.contains(&column)), "{row}, {column}"));
    }
}

/// Four poses of the branches, a load of unknown mass on one of them: no joint mimics another.
fn on_plain_branches() -> Vec<PoseTorque> {
    let joints = 4;
    let lengths = [vec![3], vec![1; 16], vec![4; 4], vec![3, 1]].concat();
    let ids = ids(&lengths);
    let blocks = PoseTorqueBlocks {
        gravity: ids[0],
        sensors: (0..joints).map(|j| std::array::from_fn(|k| ids[1 + 4 * j + k])).collect(),
        inertia: ids[17..21].to_vec(),
        terms: Vec::new(),
        compliance: Vec::new(),
    };
    let branched = branched_chain();
    let attachments = [None, Some(0), Some(1), Some(0)].map(|parent| Attachment { parent, mimic: None });
    let movers = branched.movers()[..joints].to_vec();
    let chain = Chain::branched("base", movers, branched.links()[..joints].to_vec(), &attachments).unwrap();
    let load = CarriedLoad { position: vec![ids[21]], mass: LoadMass::Unknown(ids[22]), link: 2 };
    let model = Arc::new(PoseTorqueModel::new(Arc::new(chain), &blocks, &SensorTerms::default(), Some(load)));
    let pose = |shift: f64| {
        let position = READ_POSITIONS.iter().chain(&[0.5]).map(|q| q + shift).collect();
        PoseTorque::new(Arc::clone(&model), position, vec![(0, 2.0 + shift), (3, 1.0), (2, shift)])
    };
    [0.0, 0.3, -0.4, 1.0].map(pose).to_vec()
}

/// Whether these are evaluated in a batch; if so, to the bits that each has alone.
fn are_evaluated_in_batch(poses: &[PoseTorque], x: &[f64]) -> bool {
    let all: [&PoseTorque; LANES] = std::array::from_fn(|lane| &poses[lane]);
    let offsets = [0, x.len()];
    let rows = poses[0].len();
    // What was there before is not to be read.
    let (mut residual, mut jacobian) = (vec![[f64::NAN; LANES]; rows], vec![[f64::NAN; LANES]; rows * x.len()]);
    if !PoseTorque::evaluate_batch(all, [LocalValues::new(x, &offsets); LANES], &mut residual, Some(&mut jacobian)) {
        return false;
    }
    let mut without = vec![[f64::NAN; LANES]; rows];
    assert!(PoseTorque::evaluate_batch(all, [LocalValues::new(x, &offsets); LANES], &mut without, None));
    assert_eq!(residual, without);
    for (lane, pose) in poses.iter().enumerate() {
        let (mut alone, mut entries) = (vec![0.0; rows], vec![0.0; rows * x.len()]);
        let into = RowsMut::new(&mut entries, x.len());
        pose.evaluate(LocalValues::new(x, &offsets), &mut alone, Some(into)).unwrap();
        for row in 0..rows {
            assert_eq!(residual[row][lane], alone[row]);
            for column in pose.row_pattern(row).unwrap().iter().cloned().flatten() {
                let at = row * x.len() + column;
                assert_eq!(jacobian[at][lane], entries[at], "pose {lane}, row {row}, column {column}");
            }
        }
    }
    true
}

#[test]
fn poses_are_evaluated_in_batch_to_the_bits_that_each_has_alone() {
    let numbers = |width: usize| (0..width).map(|k| 0.5 + (k as f64).sin()).collect::<Vec<f64>>();
    let (one, lengths) = loaded(&[0, 2]);
    let x = numbers(lengths.iter().sum());
    let other = PoseTorque { position: vec![-1.2, 0.4, 2.2], ..one.clone() };
    // They are not where the processor has no vector instructions of so many lanes.
    let have_lanes = are_evaluated_in_batch(&[one.clone(), other.clone(), other.clone(), one.clone()], &x);
    let branches = on_plain_branches();
    let width = branches[0].model.affine_columns;
    assert_eq!(are_evaluated_in_batch(&branches, &numbers(width)), have_lanes);
    let (with_terms, lengths) = with_terms(&every_term_of_own_torques(), 0);
    let read = Conditions { time: Some(-2.0), direction: vec![-1.0; 3], ..with_terms.conditions.clone() };
    let other = PoseTorque { position: vec![-0.2, 0.4, 0.7], conditions: read, ..with_terms.clone() };
    let four = [with_terms.clone(), other.clone(), with_terms, other];
    assert_eq!(are_evaluated_in_batch(&four, &numbers(lengths.iter().sum())), have_lanes);

    let other_joints = PoseTorque { readings: vec![(0, 2.0), (1, 1.0)], ..one.clone() };
    assert!(!are_evaluated_in_batch(&[one.clone(), other_joints, one.clone(), one.clone()], &x));
    let (alike_but_of_another_model, _) = loaded(&[0, 2]);
    assert!(!are_evaluated_in_batch(&[one.clone(), one.clone(), one, alike_but_of_another_model], &x));
    for (pose, lengths) in [compliant(), with_all_terms(0), on_branches(0)] {
        assert!(!are_evaluated_in_batch(&vec![pose; 4], &numbers(lengths.iter().sum())));
    }
}

/// Hides from the problem that it could be evaluated in a batch with others.
#[derive(Debug)]
struct Alone(PoseTorque);

impl Residual for Alone {
    fn blocks(&self) -> &[BlockId] {
        self.0.blocks()
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        self.0.row_pattern(row)
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        self.0.evaluate(x, residual, jacobian)
    }
}

/// Nineteen poses: four times four at once, and three. The rows of a pose touch different columns here; of rows that touch the same, those
/// of one pose do not follow each other in a batch, and sums differ in their last digits.
#[test]
fn sums_over_poses_in_lanes_have_the_bits_of_those_one_by_one() {
    let linearized = |alone: bool, loss: Loss| {
        let (pose, lengths) = loaded(&[0, 2]);
        let mut builder = ProblemBuilder::new();
        for (index, length) in lengths.iter().enumerate() {
            let name = format!("block {index}");
            let (block, start): (Block, Vec<f64>) = match (index, *length) {
                (0, _) => {
                    let gravity: Vec<f64> = vec![1.0, -2.0, -2.0];
                    (Block::vector(name, "m/s²", &["x", "y", "z"]).on(Sphere { radius: 3.0 }), gravity)
                }
                (_, 1) => (Block::scalar(name, ""), vec![0.5 + 0.1 * index as f64]),
                (_, length) => (Block::vector(name, "", &vec!["part"; length]), vec![0.3; length]),
            };
            builder.add_block(block, &start);
        }
        for k in 0..19 {
            let position = pose.position.iter().map(|q| q + 0.3 * f64::from(k)).collect();
            let readings = vec![(0, f64::from(k)), (2, 1.0)];
            let one = PoseTorque { position, readings, ..pose.clone() };
            let noise = Noise::independent(&[0.5 + f64::from(k), 2.0]).unwrap();
            let factor = if alone { Factor::new(Alone(one), noise) } else { Factor::new(one, noise) };
            builder.add_factor(factor.with_loss(loss));
        }
        let (problem, values) = builder.build().unwrap();
        let linear = problem.linearize(&values).unwrap();
        (linear.cost(), linear.gradient().to_vec(), linear.hessian(), problem.residuals(&values).unwrap())
    };
    for loss in [Loss::None, Loss::Huber(1.3)] {
        let [(cost, gradient, hessian, residuals), one_by_one] = [false, true].map(|alone| linearized(alone, loss));
        assert!(gradient == one_by_one.1 && hessian == one_by_one.2 && residuals == one_by_one.3, "{loss:?}");
        // The cost is summed by fours first.
        assert!((cost / one_by_one.0 - 1.0).abs() < 1e-14, "{loss:?}");
    }
}
