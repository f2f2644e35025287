//! Of what the readings of an arm in motion are made: gravity, inertia, and what sensors add.
//!
//! ```text
//!     y = k τ + b + …,     τ = (∂τ/∂g) g + τ_inertia          torque is linear in gravity
//! ```
//!
//! so that the derivatives by `k` and by `g` are all that is needed.

use gravcal_estimation::{BlockId, EvaluateError, Factor, LocalValues, RowsMut, Values};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::Solved;
use crate::result::{ReadingResidual, TorqueParts};

/// By row of the readings; nothing of those of standing poses.
pub(crate) fn torque_parts(session: &Session, solved: &Solved) -> Result<Vec<Option<TorqueParts>>, EvaluateError> {
    let (problem, rows) = (&solved.built.problem, &solved.built.rows);
    let mut parts = vec![None; rows.len()];
    for (index, factor) in problem.factors().iter().enumerate() {
        let own = problem.rows_of(index);
        let Some(read) = rows.get(own.clone()) else { break };
        if read.iter().any(|id| session.poses[id.pose].course.is_some()) {
            let derivatives = Derivatives::of(factor, &solved.estimate.values)?;
            for (row, (ReadingId { channel, .. }, reported)) in read.iter().zip(&mut parts[own]).enumerate() {
                *reported = (*channel < session.joints.len()).then(|| of_joint(solved, &derivatives, row, *channel));
            }
        }
    }
    Ok(parts)
}

/// Keeps the parts that the readings determine: how gravity and inertia share a torque is open where gravity is, and where gravity's part
/// lies where the joint's bias is. `bias`: whether that of a joint is determined.
pub(crate) fn keep_determined(residuals: &mut [ReadingResidual], gravity: bool, bias: impl Fn(usize) -> bool) {
    for row in residuals {
        row.torque = row.torque.filter(|_| gravity && bias(row.id.channel));
    }
}

fn of_joint(solved: &Solved, derivatives: &Derivatives<'_>, row: usize, joint: usize) -> TorqueParts {
    let (variables, values) = (&solved.built.variables, &solved.estimate.values);
    let [gain, bias] = [SensorParameter::TorqueGain, SensorParameter::TorqueBias]
        .map(|quantity| variables.sensors[joint][quantity as usize]);
    let times = |block: BlockId| {
        let by = derivatives.by(row, block).iter().zip(values.get(block));
        by.map(|(slope, value)| slope * value).sum::<f64>()
    };
    let gravity = times(variables.gravity);
    TorqueParts { gravity, inertia: times(gain) - gravity, bias: values.scalar(bias) }
}

/// The derivatives of one residual by the numbers that store its blocks.
struct Derivatives<'a> {
    blocks: &'a [BlockId],
    starts: Vec<usize>,
    entries: Vec<f64>,
}

impl<'a> Derivatives<'a> {
    fn of(factor: &'a Factor, values: &Values) -> Result<Self, EvaluateError> {
        let blocks = factor.residual.blocks();
        let mut starts = vec![0];
        let mut x = Vec::new();
        for block in blocks {
            x.extend_from_slice(values.get(*block));
            starts.push(x.len());
        }
        // Entries outside of a row's pattern are not written.
        let (mut residual, mut entries) =
            (vec![0.0; factor.residual.len()], vec![0.0; factor.residual.len() * x.len()]);
        let into = RowsMut::new(&mut entries, x.len());
        factor.residual.evaluate(LocalValues::new(&x, &starts), &mut residual, Some(into))?;
        Ok(Derivatives { blocks, starts, entries })
    }

    /// By the numbers of one block; none where the residual does not depend on it.
    fn by(&self, row: usize, block: BlockId) -> &[f64] {
        let width = self.starts[self.blocks.len()];
        let Some(place) = self.blocks.iter().position(|other| *other == block) else { return &[] };
        &self.entries[row * width..][self.starts[place]..self.starts[place + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_part_is_reported_that_rests_on_what_is_open() {
        let parts = TorqueParts { gravity: 3.0, inertia: 2.0, bias: 1.0 };
        let row = |channel: usize| ReadingResidual {
            id: ReadingId { pose: 0, channel },
            residual: 0.0,
            nominal_residual: 0.0,
            std: 1.0,
            weight: 1.0,
            torque: Some(parts),
        };
        let reported = |gravity: bool| {
            let mut rows = [row(0), row(1)];
            keep_determined(&mut rows, gravity, |joint| joint == 1);
            rows.map(|row| row.torque.is_some())
        };
        assert_eq!((reported(true), reported(false)), ([false, true], [false, false]));
    }
}
