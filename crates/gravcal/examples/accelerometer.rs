//! Another sensor: an accelerometer laid on each of its six sides. Three gains and three biases, by the part of gravcal that knows no
//! robot.
//!
//! ```text
//!     reading = gain · a + bias,   a = ±9.80665 m/s² along the axis that is upright, 0 along the others
//! ```
//!
//! ```sh
//! cargo run --release -p gravcal --example accelerometer
//! ```

use std::error::Error;

use gravcal::estimation::statistics::{NoiseScale, Solution};
use gravcal::estimation::{
    Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, ProblemBuilder,
    RankAnalysis, SolveContext, Uncertainty,
};
use gravcal::solvers::SolverName;

const GRAVITY: f64 = 9.80665;

/// One reading of one axis.
#[derive(Debug)]
struct Axis {
    /// Gain and bias.
    blocks: [BlockId; 2],
    /// Specific force along the axis, m/s².
    sensed: f64,
    /// In g.
    reading: f64,
}

impl Formula for Axis {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        residual[0] = x.scalar(0) * self.sensed + x.scalar(1) - self.reading;
        Ok(())
    }
}

/// What the sensor reads on each side, g: gains 1.02, 0.99 and 1.005 of 1/9.80665, biases 0.01, −0.02 and 0.005, noise of 1 mg.
const READINGS: [[f64; 3]; 6] = [
    [1.0305, -0.0193, 0.0042],
    [-1.0094, -0.0207, 0.0061],
    [0.0113, 0.9702, 0.0044],
    [0.0096, -1.0112, 0.0057],
    [0.0089, -0.0195, 1.0091],
    [0.0108, -0.0204, -1.0008],
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut builder = ProblemBuilder::new();
    let mut axes = Vec::new();
    for name in ["x", "y", "z"] {
        let gain = builder.add_block(Block::scalar(format!("{name}.gain"), "g/(m/s²)"), &[0.1]);
        let bias = builder.add_block(Block::scalar(format!("{name}.bias"), "g"), &[0.0]);
        axes.push([gain, bias]);
    }
    for (side, readings) in READINGS.iter().enumerate() {
        for (axis, reading) in readings.iter().enumerate() {
            let upwards = if side % 2 == 0 { GRAVITY } else { -GRAVITY };
            let sensed = if side / 2 == axis { upwards } else { 0.0 };
            let formula = Axis { blocks: axes[axis], sensed, reading: *reading };
            builder.add_factor(Factor::new(Automatic(formula), Noise::independent(&[0.001])?));
        }
    }
    let (problem, start) = builder.build()?;
    let estimate = SolverName::LevenbergMarquardt.build().solve(&problem, &start, &mut SolveContext::default())?;
    let analysis = RankAnalysis::of(&problem, &estimate)?;
    let solution = Solution { problem: &problem, values: &estimate.values, analysis: &analysis };
    let uncertainty = Uncertainty::from_noise(&solution, NoiseScale::Stated)?;

    for (axis, truth) in axes.iter().zip([[1.02 / GRAVITY, 0.01], [0.99 / GRAVITY, -0.02], [1.005 / GRAVITY, 0.005]]) {
        for ((block, unit), truth) in axis.iter().zip(["g/(m/s²)", "g"]).zip(truth) {
            let value = estimate.values.scalar(*block);
            let std = uncertainty.covariance().std(problem.columns_of(*block).start);
            println!("{:<8} {value:>9.6} ± {std:.6} {unit}", problem.block(*block).name);
            assert!((value - truth).abs() < 4.0 * std, "{value} is not {truth}");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
