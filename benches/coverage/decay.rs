//! The nonlinear problem of the simulation: `y = a exp(−b t) + c`, recorded several times from start to end.

use gravcal_estimation::{
    Block, BlockId, EvaluateError, Factor, LocalValues, Loss, Noise, Problem, ProblemBuilder, Residual, RowsMut, Values,
};

use crate::simulate::Failure;

/// Names of the parameters.
pub const NAMES: [&str; 3] = ["a", "b", "c"];
/// Their true values.
pub const TRUTH: [f64; 3] = [2.0, 1.0, 0.5];
/// The last time of a recording; the first is zero.
const DURATION: f64 = 4.0;
/// Standard deviation that is stated for every sample.
pub const NOISE: f64 = 0.05;

/// One sample.
#[derive(Debug)]
struct Sample {
    blocks: [BlockId; 3],
    time: f64,
    reading: f64,
}

impl Residual for Sample {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let [a, b, c] = [0, 1, 2].map(|i| x.scalar(i));
        let decay = (-b * self.time).exp();
        residual[0] = a * decay + c - self.reading;
        if let Some(mut rows) = jacobian {
            rows.row(0).copy_from_slice(&[decay, -a * self.time * decay, 1.0]);
        }
        Ok(())
    }
}

/// Time of a sample, of which there are `each` in a recording.
pub fn time(sample: usize, each: usize) -> f64 {
    DURATION * (sample % each) as f64 / (each as f64 - 1.0)
}

/// The problem with these errors of its readings, `each` in a recording, and its start at the truth.
pub fn problem(errors: &[f64], each: usize, loss: Loss) -> Result<(Problem, Values), Failure> {
    let mut builder = ProblemBuilder::new();
    let blocks = [0, 1, 2].map(|i| builder.add_block(Block::scalar(NAMES[i], ""), &[TRUTH[i]]));
    for (sample, error) in errors.iter().enumerate() {
        let time = time(sample, each);
        let reading = TRUTH[0] * (-TRUTH[1] * time).exp() + TRUTH[2] + error;
        let factor = Factor::new(Sample { blocks, time, reading }, Noise::independent(&[NOISE])?);
        builder.add_factor(factor.with_loss(loss));
    }
    Ok(builder.build()?)
}
