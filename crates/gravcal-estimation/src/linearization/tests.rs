//! All forms of one linearization against each other, with and without eliminated blocks.

use std::ops::Range;

use super::{Linearization, Normal, Orthogonal};
use crate::testing::Line;
use crate::{
    Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, LocalValues, Loss, Noise, Number, Problem,
    ProblemBuilder, Residual, Rotation, RowsMut, Sphere, Values,
};

/// Two readings of a pose whose angle is only known to be near `angle`: `a sin φ + v·(φ, 1, 0)` and
/// `b cos φ + v·(0, 0, 1)` with `φ = angle + e`, and the error's two components `e = e_0 + e_1`.
#[derive(Debug)]
struct Reading {
    blocks: Vec<BlockId>,
    pattern: [Vec<Range<usize>>; 2],
    angle: f64,
    readings: [f64; 2],
}

impl Residual for Reading {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        2
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.pattern[row])
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let (a, b, v, e) = (x.scalar(0), x.scalar(1), x.block(2), x.block(3));
        let angle = self.angle + e[0] + e[1];
        residual[0] = a * angle.sin() + v[0] * angle + v[1] - self.readings[0];
        residual[1] = b * angle.cos() + v[2] - self.readings[1];
        if let Some(mut rows) = jacobian {
            let slope = a * angle.cos() + v[0];
            rows.row(0).copy_from_slice(&[angle.sin(), 0.0, angle, 1.0, 0.0, slope, slope]);
            let slope = -b * angle.sin();
            rows.row(1).copy_from_slice(&[0.0, angle.cos(), 0.0, 0.0, 1.0, slope, slope]);
        }
        Ok(())
    }
}

/// A block of two near zero.
#[derive(Debug)]
struct NearZero(BlockId);

impl Residual for NearZero {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.0)
    }

    fn len(&self) -> usize {
        2
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        residual.copy_from_slice(x.block(0));
        if let Some(mut rows) = jacobian {
            rows.row(0)[0] = 1.0;
            rows.row(1)[1] = 1.0;
        }
        Ok(())
    }
}

/// `poses` poses with two kinds of noise and a loss; errors of the angle marked eliminated or not.
pub(crate) fn problem(poses: usize, eliminated: bool) -> (Problem, Values) {
    let mut builder = ProblemBuilder::new();
    let a = builder.add_block(Block::scalar("a", ""), &[1.3]);
    let v = Block::vector("v", "", &["x", "y", "z"]).on(Sphere { radius: 2.0 });
    let v = builder.add_block(v, &[2.0 / 3.0, -4.0 / 3.0, 4.0 / 3.0]);
    let b = builder.add_block(Block::scalar("b", ""), &[0.4]);
    for pose in 0..poses {
        let angle = 0.37 * pose as f64;
        let error = Block::vector(format!("error{pose}"), "rad", &["x", "y"]);
        let error = builder.add_block(if eliminated { error.eliminated() } else { error }, &[0.01, -0.02]);
        let noise = if pose % 3 == 0 {
            Noise::correlated(&[0.04, 0.01, 0.01, 0.09], 2).unwrap()
        } else {
            Noise::independent(&[0.2, 0.3]).unwrap()
        };
        let reading = Reading {
            blocks: vec![a, b, v, error],
            pattern: [vec![0..1, 2..4, 5..7], vec![1..2, 4..7]],
            angle,
            readings: [angle.sin() + 0.2 * angle - 1.0 + 0.1 * (7.0 * angle).sin(), 0.5 * angle.cos()],
        };
        builder.add_factor(Factor::new(reading, noise).with_loss(Loss::Cauchy(2.0)));
        builder.add_factor(Factor::new(NearZero(error), Noise::independent(&[0.1, 0.1]).unwrap()));
    }
    builder.build().unwrap()
}

fn assert_close(a: &[f64], b: &[f64], what: &str) {
    let scale = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-10 * scale, "{what}: {a} and {b}");
    }
}

fn assert_same(one: &mut dyn Linearization, other: &mut dyn Linearization) {
    assert_close(&[one.cost()], &[other.cost()], "cost");
    assert_close(one.gradient(), other.gradient(), "gradient");
    assert_close(one.column_norms(), other.column_norms(), "norms");
    assert_close(&one.hessian(), &other.hessian(), "Hessian");
    let scaling = one.column_scales();
    let columns = scaling.len();
    let v: Vec<f64> = (0..columns).map(|j| (j as f64).sin()).collect();
    assert_close(&[one.image_norm_squared(&v)], &[other.image_norm_squared(&v)], "image");
    for lambda in [1.0, 1e-3, 1e-8] {
        let (mut a, mut b) = (vec![0.0; columns], vec![0.0; columns]);
        let (one, other) = (one.damped_step(lambda, &scaling, &mut a), other.damped_step(lambda, &scaling, &mut b));
        assert_close(&a, &b, "step");
        assert_close(&[one.predicted_reduction], &[other.predicted_reduction], "prediction");
    }
}

#[test]
fn normal_equations_and_orthogonal_factorization_agree_with_and_without_elimination() {
    let (eliminated, values) = problem(700, true);
    let (plain, _) = problem(700, false);
    assert_eq!(eliminated.structure().components.len(), 700);
    assert!(eliminated.structure().chunks.len() > 1);
    let (short, short_values) = problem(40, false);
    let (short_eliminated, _) = problem(40, true);
    let mut reference = Orthogonal::new(&short, &short_values).unwrap();
    assert_same(&mut reference, &mut Normal::new(&short, &short_values).unwrap());
    assert_same(&mut reference, &mut Normal::new(&short_eliminated, &short_values).unwrap());
    assert_same(&mut reference, &mut Orthogonal::new(&short_eliminated, &short_values).unwrap());
    let mut reference = Normal::new(&plain, &values).unwrap();
    assert_same(&mut reference, &mut Normal::new(&eliminated, &values).unwrap());
    assert_same(&mut reference, &mut Orthogonal::new(&eliminated, &values).unwrap());
}

/// `Rᵀ v` of a pose that is turned by `R`, times a gain, less what `v` is for the gain of one.
#[derive(Debug)]
struct Turned {
    blocks: [BlockId; 3],
}

impl Formula for Turned {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        3
    }

    fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        let (gain, v) = (x.scalar(0), x.block(1));
        let [w, a, b, c] = [0, 1, 2, 3].map(|k| x.block(2)[k]);
        let turned = [
            (w * w + a * a - b * b - c * c) * v[0] + ((a * b + w * c) * v[1] + (a * c - w * b) * v[2]) * 2.0,
            (w * w - a * a + b * b - c * c) * v[1] + ((a * b - w * c) * v[0] + (b * c + w * a) * v[2]) * 2.0,
            (w * w - a * a - b * b + c * c) * v[2] + ((a * c + w * b) * v[0] + (b * c - w * a) * v[1]) * 2.0,
        ];
        (0..3).for_each(|row| residual[row] = gain * turned[row] - self.blocks[2].index() as f64 * 0.1);
        Ok(())
    }
}

/// Poses that are turned by rotations near none, marked eliminated or not.
fn turned_poses(poses: usize, eliminated: bool) -> (Problem, Values) {
    let mut builder = ProblemBuilder::new();
    let gain = builder.add_block(Block::scalar("gain", ""), &[1.1]);
    let v = Block::vector("v", "", &["x", "y", "z"]).on(Sphere { radius: 3.0 });
    let v = builder.add_block(v, &[1.0, -2.0, 2.0]);
    for pose in 0..poses {
        let rotation = Block::vector(format!("pose{pose}"), "", &["w", "x", "y", "z"]).on(Rotation);
        let rotation = if eliminated { rotation.eliminated() } else { rotation };
        let angle = 0.3 * pose as f64;
        let rotation = builder.add_block(rotation, &[angle.cos(), 0.6 * angle.sin(), 0.0, 0.8 * angle.sin()]);
        let noise = Noise::independent(&[0.1, 0.2, 0.1]).unwrap();
        builder.add_factor(Factor::new(Automatic(Turned { blocks: [gain, v, rotation] }), noise));
        for (component, reading) in [1.0, 0.0, 0.0, 0.0].into_iter().enumerate() {
            let mut coefficients = [0.0; 4];
            coefficients[component] = 1.0;
            let known = Line::new(&[rotation], &coefficients, reading);
            builder.add_factor(Factor::new(known, Noise::independent(&[0.3]).unwrap()));
        }
    }
    builder.build().unwrap()
}

#[test]
fn a_rotation_of_each_pose_is_eliminated_as_any_other_block() {
    let (plain, values) = turned_poses(9, false);
    let (eliminated, _) = turned_poses(9, true);
    assert_eq!((eliminated.structure().components.len(), plain.columns().len()), (9, 1 + 2 + 9 * 3));
    let mut reference = Orthogonal::new(&plain, &values).unwrap();
    assert_same(&mut reference, &mut Normal::new(&plain, &values).unwrap());
    assert_same(&mut reference, &mut Normal::new(&eliminated, &values).unwrap());
    assert_same(&mut reference, &mut Orthogonal::new(&eliminated, &values).unwrap());
}

#[test]
fn the_gradient_is_the_slope_of_the_cost() {
    let (problem, values) = problem(9, true);
    let columns = problem.columns().len();
    let linearization = Normal::new(&problem, &values).unwrap();
    let h = 1e-5;
    for column in 0..columns {
        let cost = |sign: f64| {
            let mut step = vec![0.0; columns];
            step[column] = sign * h;
            problem.cost(&problem.retract(&values, &step)).unwrap()
        };
        let slope = (cost(1.0) - cost(-1.0)) / (2.0 * h);
        assert!((linearization.gradient()[column] - slope).abs() < 1e-6, "column {column}");
    }
}

#[test]
fn the_same_bits_on_one_thread_and_on_three() {
    let (problem, values) = problem(2000, true);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut linearization = Normal::new(&problem, &values).unwrap();
            let mut step = vec![0.0; problem.columns().len()];
            let scaling = linearization.column_scales();
            linearization.damped_step(1e-4, &scaling, &mut step);
            let mut exact = vec![0.0; step.len()];
            Orthogonal::new(&problem, &values).unwrap().damped_step(1e-4, &scaling, &mut exact);
            (linearization.gradient().to_vec(), step, exact)
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_value_that_is_not_finite_is_reported_with_its_factor() {
    let (problem, values) = problem(700, true);
    let mut broken = values.clone();
    broken.set(problem.find("error413").unwrap(), &[f64::NAN, 0.0]);
    let error = Normal::new(&problem, &broken).err().unwrap().to_string();
    assert!(error.starts_with("factor 826: row 0 gives NaN at a = [1.3], b = [0.4], v ="), "{error}");
    assert!(Orthogonal::new(&problem, &broken).is_err());
}

/// `a sin t + b t`, of columns that differ by what `scale` says.
fn scaled(scale: [f64; 2], units: [&str; 2], start: [f64; 2]) -> (Problem, Values) {
    let mut builder = ProblemBuilder::new();
    let blocks: Vec<BlockId> =
        (0..2).map(|i| builder.add_block(Block::scalar(["a", "b"][i], units[i]), &[start[i]])).collect();
    for t in [1.0_f64, 2.0, 3.0, 4.0] {
        let line = Line::new(&blocks, &[scale[0] * t.sin(), scale[1] * t], 1.0);
        builder.add_factor(Factor::new(line, Noise::independent(&[1.0]).unwrap()));
    }
    builder.build().unwrap()
}

#[test]
fn rounding_is_distinguished_from_a_small_column_by_the_size_of_its_block_or_by_its_unit() {
    let small = |scale: [f64; 2], units: [&str; 2], start: [f64; 2]| {
        let (problem, values) = scaled(scale, units, start);
        let orthogonal = Orthogonal::new(&problem, &values).unwrap().column_norms()[0];
        let normal = Normal::new(&problem, &values).unwrap().column_norms()[0];
        assert_eq!(orthogonal > 0.0, normal > 0.0);
        orthogonal > 0.0
    };
    for other in [1e-7, 1.0, 1e13, 1e20] {
        let scale = [1e-20, other];
        assert!(small(scale, ["", ""], [0.0; 2]), "a pure number at zero has no size");
        assert!(small(scale, ["V", "F"], [0.0; 2]) && small(scale, ["V", "F"], [0.0, 1.0]), "nor has another unit");
        assert!(!small(scale, ["V", "V"], [0.0; 2]), "in one unit both do what the other does");
        assert!(!small(scale, ["V", "F"], [1.0; 2]), "and so they do where their sizes are known");
        assert!(small(scale, ["V", "F"], [1e20, 1.0 / other]));
    }
}
