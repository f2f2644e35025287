//! Residuals of one's own as factors of the joint problem, a row each: see [`gravcal_robot_model::residual_models`].
//!
//! A row enters with the poses that it ties together: where readings of any of them are left out of a fit, it is, too.

use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::{BlockId, EvaluateError, Factor, Loss, Noise, NoiseError, ProblemBuilder};
use gravcal_robot_model::residual_models::{ResidualInUse, Tie};
use gravcal_robot_model::residuals::{ModelledResidual, ModelledScene, PositionTerms};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::building::factors::once;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::solved::Solved;
use crate::joint::variables::VariableIndex;

/// Adds the rows of all residuals; gives the residual of each.
pub(in crate::joint) fn add_residuals(
    session: &Session,
    readings: &MeasurementSet,
    variables: &VariableIndex,
    builder: &mut ProblemBuilder,
) -> Result<Vec<usize>, NoiseError> {
    let mut rows = Vec::new();
    let chain = Arc::new(session.robot.chain.clone());
    for (index, residual) in session.residuals.iter().enumerate() {
        let residual = Arc::new(residual.clone());
        let enters = |tie: &Tie| tie.poses.iter().all(|pose| readings.enters(session, *pose));
        let ties: Vec<Tie> = residual.ties(&session.poses).into_iter().filter(enters).collect();
        // Errors of single poses' positions would tie all rows of one factor together.
        let is_one = residual.is_batched() && variables.position_unknowns.is_empty();
        for ties in ties.chunks(if is_one { ties.len().max(1) } else { 1 }) {
            let std: Vec<f64> = ties.iter().map(|tie| tie.std).collect();
            let own = Rows::new(session, variables, &residual, builder).of(&chain, &residual, ties);
            let residual = once(Arc::new(own), builder);
            builder.add_factor(Factor { residual, noise: Noise::independent(&std)?, loss: Loss::None });
            rows.extend(ties.iter().map(|_| index));
        }
    }
    Ok(rows)
}

impl MeasurementSet {
    /// Whether a pose takes part: where any reading of it enters, or where it has none that could be left out.
    fn enters(&self, session: &Session, pose: usize) -> bool {
        let is_read = |channel| session.reading(ReadingId { pose, channel }).is_some();
        !self.used[pose].is_empty() || !(0..session.channel_count()).any(is_read)
    }
}

/// Rows that are being put together: their blocks, and the stored columns of these.
struct Rows<'a> {
    session: &'a Session,
    variables: &'a VariableIndex,
    builder: &'a ProblemBuilder,
    blocks: Vec<BlockId>,
    columns: usize,
    /// First column of gain and offset of each joint that is seen.
    joints: Vec<(usize, usize)>,
    /// First column of the parameters of position sensors beyond these, and of the residual's own.
    terms: usize,
    own: usize,
}

impl<'a> Rows<'a> {
    fn new(
        session: &'a Session,
        variables: &'a VariableIndex,
        residual: &ResidualInUse,
        builder: &'a ProblemBuilder,
    ) -> Rows<'a> {
        let empty =
            Rows { session, variables, builder, blocks: Vec::new(), columns: 0, joints: Vec::new(), terms: 0, own: 0 };
        let mut row = empty;
        if residual.sees.sees_gravity() {
            row.add(variables.gravity);
        }
        for joint in residual.sees.joints() {
            let [_, _, gain, offset] = variables.sensors[*joint];
            let first = row.add(gain);
            row.add(offset);
            row.joints.push((*joint, first));
        }
        row.terms = row.columns;
        for term in session.terms.of_positions().filter(|term| residual.sees.joints().contains(&term.joint)) {
            variables.further[term.places.clone()].iter().for_each(|id| _ = row.add(*id));
        }
        row.own = row.columns;
        residual.places.iter().for_each(|place| _ = row.add(variables.further[*place]));
        row
    }

    /// The first column of a block that is added.
    fn add(&mut self, id: BlockId) -> usize {
        let first = self.columns;
        self.blocks.push(id);
        self.columns += self.builder.block(id).len();
        first
    }

    fn of(mut self, chain: &Arc<Chain>, residual: &Arc<ResidualInUse>, ties: &[Tie]) -> ModelledResidual {
        let row = |tie: &Tie| (tie.clone(), tie.poses.iter().map(|pose| self.scene(residual, *pose)).collect());
        let rows = ties.iter().map(row).collect();
        let Rows { blocks, own, .. } = self;
        ModelledResidual::new((Arc::clone(chain), Arc::clone(residual)), rows, (blocks, own))
    }

    fn scene(&mut self, residual: &ResidualInUse, pose: usize) -> ModelledScene {
        let read = &self.session.poses[pose];
        let mut coordinates = Vec::new();
        for (joint, gain) in &self.joints {
            coordinates.extend([(*joint, *gain, read.position[*joint]), (*joint, gain + 1, 1.0)]);
        }
        let variables = self.variables;
        for unknown in variables.position_unknowns.iter().filter(|unknown| unknown.poses.contains(&pose)) {
            let first = self.add(unknown.block);
            let seen = unknown.joints.iter().zip(first..).filter(|(joint, _)| residual.sees.joints().contains(joint));
            coordinates.extend(seen.map(|(joint, column)| (*joint, column, 1.0)));
        }
        let terms = self.session.terms.of_positions().filter(|term| residual.sees.joints().contains(&term.joint));
        let terms = PositionTerms::new(self.terms, terms, read.position.clone(), read.conditions.clone());
        ModelledScene { position: read.position.clone(), conditions: read.conditions.clone(), coordinates, terms }
    }
}

/// How well each residual is explained.
pub(in crate::joint) fn notes(session: &Session, solved: &Solved) -> Result<Vec<String>, EvaluateError> {
    let built = &solved.built;
    if built.modelled.is_empty() {
        return Ok(Vec::new());
    }
    let whitened = built.problem.residuals(&solved.estimate.values)?;
    let note = |(index, residual): (usize, &ResidualInUse)| {
        let rows = built.modelled.iter().zip(&whitened[built.rows.len()..]).filter(|(own, _)| **own == index);
        let sizes: Vec<f64> = rows.map(|(_, size)| size.abs()).collect();
        let count = sizes.len();
        let rms = (sizes.iter().map(|size| size * size).sum::<f64>() / count as f64).sqrt();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let ResidualInUse { name, model, .. } = residual;
        let named = if name == model { name.clone() } else { format!("{name} ({model})") };
        match count {
            0 => format!("Residual {named}: it takes part in no pose that entered."),
            _ => format!(
                "Residual {named}: {count} rows, {rms:.2} standard deviations root mean square, {largest:.2} the largest."
            ),
        }
    };
    Ok(session.residuals.iter().enumerate().map(note).collect())
}
