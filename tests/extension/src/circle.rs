//! A manifold of one's own: an angle that has no end, as a point of the unit circle.
//!
//! ```text
//!     x = (cos φ, sin φ),    x ⊞ d = (cos(φ + d), sin(φ + d)),    ∂x/∂d = (−sin φ, cos φ)
//! ```
//!
//! No value is the last before a whole turn, so that a method that begins anywhere gets to the phase of a wave, never to that of a turn
//! later.

use gravcal::estimation::Manifold;

/// Angles, stored as cosine and sine. One tangent coordinate, rad.
#[derive(Clone, Copy, Debug)]
pub struct Circle;

impl Manifold for Circle {
    fn name(&self) -> &str {
        "circle"
    }

    fn tangent_dimension(&self, _stored: usize) -> usize {
        1
    }

    fn retract(&self, x: &mut [f64], step: &[f64]) {
        let (sine, cosine) = step[0].sin_cos();
        let moved = [cosine * x[0] - sine * x[1], sine * x[0] + cosine * x[1]];
        let length = moved[0].hypot(moved[1]);
        x.iter_mut().zip(moved).for_each(|(x, moved)| *x = moved / length);
    }

    fn basis(&self, x: &[f64], basis: &mut [f64]) {
        basis.copy_from_slice(&[-x[1], x[0]]);
    }

    fn check(&self, x: &[f64]) -> Result<(), String> {
        match x {
            [cosine, sine] if (cosine.hypot(*sine) - 1.0).abs() < 1e-9 => Ok(()),
            _ => Err("is no angle: that takes its cosine and its sine".into()),
        }
    }

    fn radian(&self) -> Option<f64> {
        Some(1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use gravcal::estimation::{
        Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, Problem,
        ProblemBuilder, RankAnalysis, SolveContext, Solver, Values, check_manifold,
    };
    use gravcal::solvers::SolverName;

    use super::*;
    use crate::Marquardt;

    const NOISE: f64 = 0.01;
    const READINGS: usize = 24;

    /// Amplitude and phase of a ripple: `a cos(3 q − φ)`, less a reading.
    #[derive(Debug)]
    struct Wave {
        blocks: [BlockId; 2],
        position: f64,
        reading: f64,
    }

    impl Formula for Wave {
        fn blocks(&self) -> &[BlockId] {
            &self.blocks
        }

        fn len(&self) -> usize {
            1
        }

        fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            let (sine, cosine) = (3.0 * self.position).sin_cos();
            let phase = x.block(1);
            residual[0] = (phase[0] * cosine + phase[1] * sine) * x.scalar(0) - self.reading;
            Ok(())
        }
    }

    /// At even distances over a turn, with errors that are no such wave.
    fn readings() -> impl Iterator<Item = (f64, f64)> {
        (0..READINGS).map(|k| {
            let position = TAU * k as f64 / READINGS as f64;
            (position, 0.7 * (3.0 * position - 2.9).cos() + NOISE * (k as f64 * 0.37).sin())
        })
    }

    fn problem(start: f64) -> (Problem, Values, [BlockId; 2]) {
        let mut builder = ProblemBuilder::new();
        let amplitude = builder.add_block(Block::scalar("amplitude", "N·m"), &[1.0]);
        let phase = Block::vector("phase", "", &["cos", "sin"]).on(Circle);
        let blocks = [amplitude, builder.add_block(phase, &[start.cos(), start.sin()])];
        for (position, reading) in readings() {
            let wave = Automatic(Wave { blocks, position, reading });
            builder.add_factor(Factor::new(wave, Noise::independent(&[NOISE]).unwrap()));
        }
        let (problem, start) = builder.build().unwrap();
        (problem, start, blocks)
    }

    #[test]
    fn the_basis_is_the_slope_of_a_step() {
        for angle in [0.0, 1.0, 3.14, -2.0_f64] {
            check_manifold(&Circle, &[angle.cos(), angle.sin()], 1e-9).unwrap();
        }
    }

    /// Cosine and sine are linear by themselves: `(2/n) Σ y cos 3q`, and the same with the sine.
    #[test]
    fn the_phase_of_a_wave_is_found_as_in_closed_form_by_methods_of_both_crates() {
        let mean = |of: fn(f64) -> f64| {
            2.0 / READINGS as f64 * readings().map(|(position, y)| y * of(3.0 * position)).sum::<f64>()
        };
        let (cosine, sine) = (mean(f64::cos), mean(f64::sin));
        let (expected, height) = (sine.atan2(cosine), sine.hypot(cosine));
        let (problem, start, [amplitude, phase]) = problem(1.5);
        let methods: [Box<dyn Solver>; 2] = [SolverName::LevenbergMarquardt.build(), Box::new(Marquardt::default())];
        for method in methods {
            let estimate = method.solve(&problem, &start, &mut SolveContext::default()).unwrap();
            let [x, y] = estimate.values.get(phase) else { panic!() };
            assert!((y.atan2(*x) - expected).abs() < 1e-7, "{}: {x} {y}", method.name());
            assert!((estimate.values.scalar(amplitude) - height).abs() < 1e-7);
            let column = problem.columns_of(phase).start;
            let std = RankAnalysis::of(&problem, &estimate).unwrap().covariance().std(column);
            assert!((std / (NOISE / height * (2.0 / READINGS as f64).sqrt()) - 1.0).abs() < 1e-6, "{std} rad");
        }
    }

    #[test]
    fn what_is_no_angle_is_refused_by_name() {
        let mut builder = ProblemBuilder::new();
        builder.add_block(Block::vector("phase", "", &["cos", "sin"]).on(Circle), &[1.0, 1.0]);
        let error = builder.build().unwrap_err().to_string();
        assert_eq!(error, "the initial value [1.0, 1.0] of `phase` is no angle: that takes its cosine and its sine");
    }
}
