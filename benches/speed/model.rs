//! Time of the measurement model alone: `PoseTorque` of every pose, without and with its Jacobian.

use gravcal_estimation::{BlockId, LocalValues, RowsMut, Values};

use gravcal_benches::clock::median_seconds;
use gravcal_benches::seven_joints::SevenJoints;

/// Seconds a pose.
pub struct ModelTime {
    pub residual: f64,
    pub jacobian: f64,
}

/// Evaluates every pose at the start.
pub fn time(problem: &SevenJoints) -> Result<ModelTime, String> {
    let (factors, initial) = (problem.built.problem.factors(), &problem.built.initial);
    let mut inputs: Vec<Input> = Vec::new();
    // Poses with the same load follow each other and read the same blocks.
    let mut input_of = Vec::new();
    for factor in factors {
        let blocks = factor.residual.blocks();
        if inputs.last().is_none_or(|input| input.blocks != blocks) {
            inputs.push(Input::gather(blocks, initial));
        }
        input_of.push(inputs.len() - 1);
    }
    let rows = problem.session.joints.len();
    let mut residual = vec![0.0; rows];
    let mut jacobian = vec![0.0; rows * inputs.iter().map(|input| input.values.len()).max().unwrap_or(0)];
    let mut evaluate = |with_jacobian: bool| {
        for (factor, input) in factors.iter().zip(input_of.iter().map(|index| &inputs[*index])) {
            let x = LocalValues::new(&input.values, &input.offsets);
            let rows = with_jacobian.then(|| RowsMut::new(&mut jacobian, input.values.len()));
            factor.residual.evaluate(x, &mut residual, rows).map_err(|e| e.to_string())?;
        }
        Ok::<(), String>(())
    };
    evaluate(true)?;
    let poses = factors.len() as f64;
    Ok(ModelTime {
        residual: median_seconds(|| evaluate(false)) / poses,
        jacobian: median_seconds(|| evaluate(true)) / poses,
    })
}

/// What factors with the same blocks read.
struct Input {
    blocks: Vec<BlockId>,
    values: Vec<f64>,
    offsets: Vec<usize>,
}

impl Input {
    fn gather(blocks: &[BlockId], all: &Values) -> Input {
        let mut input = Input { blocks: blocks.to_vec(), values: Vec::new(), offsets: vec![0] };
        for id in blocks {
            input.values.extend_from_slice(all.get(*id));
            input.offsets.push(input.values.len());
        }
        input
    }
}
