//! The step that the method tries from one point, and how far that point is from optimal.
//!
//! Constraints enter one by one: the step without any is right if it breaks none; else those that it breaks enter
//! the conic programme, until none of the others is broken. So constraints far away cost nothing, and cost no digits.

use gravcal_estimation::{Linearization, Problem, Values};

use super::model::Model;
use super::programme::{Outcome, Solution, solve};
use super::rows::{Cone, Rows, rows};

/// Duals, relative to the residual, from which on a solution leans on a constraint.
const LEANING: f64 = 1e-10;

/// A linearized point.
pub(super) struct Point<'p> {
    pub values: Values,
    pub linearization: Box<dyn Linearization + 'p>,
}

/// λ and D.
#[derive(Clone, Debug)]
pub(super) struct Damping {
    pub lambda: f64,
    pub scaling: Vec<f64>,
}

/// A step with what it promises.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// By columns.
    pub step: Vec<f64>,
    /// Reduction of the cost that the linear model predicts, not counting the damping.
    pub predicted: f64,
    /// Constraints on which it leans, with the cost's fall for each unit by which they give way.
    pub active: Vec<(usize, f64)>,
    /// How far the point itself is from optimal: 0 where it is.
    pub cosine: f64,
}

impl Trial {
    /// The step from a point; `leaning`: constraints that are likely to matter. `None` where the conic programme has no
    /// answer.
    pub fn new(problem: &Problem, point: &mut Point<'_>, damping: &Damping, leaning: &[usize]) -> Option<Trial> {
        let all = rows(problem, &point.values).into_iter().map(Rows::relaxed);
        let matters = |r: &Rows| r.cone == Cone::Equation || leaning.contains(&r.constraint);
        let (mut entered, mut left): (Vec<Rows>, Vec<Rows>) = all.partition(matters);
        let mut trial = if entered.is_empty() { Trial::free(point, damping) } else { None };
        loop {
            trial = match trial {
                Some(trial) => {
                    let (kept, broken): (Vec<Rows>, Vec<Rows>) =
                        left.into_iter().partition(|r| r.obeyed_by(&trial.step));
                    if broken.is_empty() {
                        return Some(trial);
                    }
                    entered.extend(broken);
                    left = kept;
                    None
                }
                None => Some(Trial::constrained(problem, point, damping, &entered)?),
            };
        }
    }

    fn free(point: &mut Point<'_>, damping: &Damping) -> Option<Trial> {
        let mut step = vec![0.0; damping.scaling.len()];
        let info = point.linearization.damped_step(damping.lambda, &damping.scaling, &mut step);
        let cosine = point.linearization.largest_cosine();
        Some(Trial { step, predicted: info.predicted_reduction, active: Vec::new(), cosine })
    }

    fn constrained(problem: &Problem, point: &Point<'_>, damping: &Damping, entered: &[Rows]) -> Option<Trial> {
        let linearization = point.linearization.as_ref();
        let model = Model::new(problem, point, &damping.scaling, damping.lambda);
        let entered: Vec<Rows> = entered.iter().map(|r| r.in_units(&model.units)).collect();
        let Outcome::Solved(solution) = solve(&model.quadratic, &entered) else { return None };
        let step: Vec<f64> = solution.step.iter().zip(&model.units).map(|(w, unit)| w * unit).collect();
        Some(Trial {
            predicted: model.predicted_reduction(linearization, &step),
            active: active(&model, &entered, &solution.duals),
            cosine: distance(linearization, damping, &model, &entered, &solution),
            step,
        })
    }
}

/// Multipliers in the constraints' own units.
fn active(model: &Model, entered: &[Rows], duals: &[Vec<f64>]) -> Vec<(usize, f64)> {
    let mut active: Vec<(usize, f64)> = Vec::new();
    for (rows, dual) in entered.iter().zip(duals) {
        let fall = dual[0] * rows.scale * model.energy;
        // The dual of `f − value` belongs to a value that sinks.
        match rows.cone {
            Cone::Equation => active.push((rows.constraint, -fall)),
            _ if dual[0] > LEANING => active.push((rows.constraint, fall)),
            _ => {}
        }
    }
    active.sort_by_key(|(constraint, _)| *constraint);
    active
}

/// Largest cosine between the residual and a column, the constraints' part taken off: `|Jᵀ r − Gᵀ z|` by columns, over the
/// norms of column and residual; or, where that is larger, the share of twice the cost that lies between the point and
/// the constraints that it should touch, `zᵀ s`.
fn distance(
    linearization: &dyn Linearization,
    damping: &Damping,
    model: &Model,
    entered: &[Rows],
    solution: &Solution,
) -> f64 {
    let mut gradient = model.quadratic.slope.clone();
    let mut apart = 0.0;
    for (rows, z) in entered.iter().zip(&solution.duals) {
        rows.add_transposed(-1.0, z, &mut gradient);
        apart += rows.slack.iter().zip(z).map(|(s, z)| s * z).sum::<f64>().abs();
    }
    let scales = linearization.column_scales();
    let cosines = gradient.iter().zip(&damping.scaling).zip(&scales).map(|((g, d), scale)| (g * d / scale).abs());
    cosines.fold(apart / (1.0 + damping.lambda), f64::max)
}
