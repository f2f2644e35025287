//! The step that minimises the damped linear model among those that obey the constraints, and how far a point is from
//! optimal.
//!
//! Constraints enter one by one: the step without any is right if it breaks none; else those that it breaks enter
//! the conic programme, until none of the others is broken. So constraints far away cost nothing, and cost no digits.

use gravcal_estimation::Linearization;

use super::model::Model;
use super::programme::{Outcome, solve};
use super::rows::{Cone, Rows, rows};
use crate::Point;

/// Duals, as cosines, from which on a solution leans on a constraint.
const LEANING: f64 = 1e-10;
/// Damping of the step whose duals tell how far a point is from optimal: it is as short as that of steepest descent, and its
/// programme is well conditioned. At an optimum the duals are the same for every damping.
const JUDGING_DAMPING: f64 = 1.0;

/// A step with what it promises.
#[derive(Clone, Debug)]
pub(crate) struct ConstrainedStep {
    /// By columns.
    pub step: Vec<f64>,
    /// Reduction of the cost that the linear model predicts, not counting the damping.
    pub predicted: f64,
    optimality: Optimality,
}

/// How far a point is from optimal, and what holds it.
#[derive(Clone, Debug)]
pub(crate) struct Optimality {
    /// 0 where it is optimal.
    pub cosine: f64,
    /// Rows on which it leans, over columns, with their duals.
    pub leaning: Vec<(Rows, Vec<f64>)>,
}

impl Optimality {
    /// Of a point. Where the conic programme has no answer nothing is known to hold it back.
    pub fn of(point: &mut Point<'_>) -> Optimality {
        let scaling = point.linearization.column_scales();
        let judged = ConstrainedStep::new(point, JUDGING_DAMPING, &scaling).map(|step| step.optimality);
        judged.unwrap_or_else(|| Optimality::unconstrained(point))
    }

    fn unconstrained(point: &Point<'_>) -> Optimality {
        Optimality { cosine: point.linearization.largest_cosine(), leaning: Vec::new() }
    }
}

impl ConstrainedStep {
    /// The step from a point with damping λ in units of `scaling`. `None` where the conic programme has no answer.
    pub fn new(point: &mut Point<'_>, lambda: f64, scaling: &[f64]) -> Option<ConstrainedStep> {
        let all = rows(point.problem, &point.values).into_iter().map(Rows::relaxed);
        let (mut entered, mut left): (Vec<Rows>, Vec<Rows>) = all.partition(|r| r.cone == Cone::Equation);
        if entered.is_empty() {
            let free = ConstrainedStep::free(point, lambda, scaling);
            (entered, left) = left.into_iter().partition(|r| !r.obeyed_by(&free.step));
            if entered.is_empty() {
                return Some(free);
            }
        }
        let model = Model::new(point, lambda, scaling);
        loop {
            let found = ConstrainedStep::within(point, &model, &entered)?;
            let (broken, kept): (Vec<Rows>, Vec<Rows>) = left.into_iter().partition(|r| !r.obeyed_by(&found.step));
            if broken.is_empty() {
                return Some(found);
            }
            entered.extend(broken);
            left = kept;
        }
    }

    fn free(point: &mut Point<'_>, lambda: f64, scaling: &[f64]) -> ConstrainedStep {
        let mut step = vec![0.0; scaling.len()];
        let predicted = point.linearization.damped_step(lambda, scaling, &mut step).predicted_reduction;
        ConstrainedStep { step, predicted, optimality: Optimality::unconstrained(point) }
    }

    fn within(point: &Point<'_>, model: &Model, entered: &[Rows]) -> Option<ConstrainedStep> {
        let linearization = point.linearization.as_ref();
        let rows = model.rows(entered);
        let Outcome::Solved(solution) = solve(&model.quadratic, &rows) else { return None };
        let step = model.step(&solution.point);
        // Duals of the constraints' own rows.
        let rescaled = |(rows, z): (&Rows, &Vec<f64>)| z.iter().map(|z| z * rows.scale * model.energy).collect();
        let duals: Vec<Vec<f64>> = rows.iter().zip(&solution.duals).map(rescaled).collect();
        let leans = |index: &usize| entered[*index].cone == Cone::Equation || solution.duals[*index][0] > LEANING;
        let optimality = Optimality {
            cosine: distance(linearization, entered, &duals),
            leaning: (0..entered.len()).filter(leans).map(|i| (entered[i].clone(), duals[i].clone())).collect(),
        };
        Some(ConstrainedStep { predicted: model.predicted_reduction(linearization, &step), step, optimality })
    }
}

/// Largest cosine between the residual and a column, the constraints' part taken off: `|Jᵀ r − Gᵀ z|` by columns, over the
/// norms of column and residual; or, where that is larger, the share of twice the cost that lies between the point and
/// the constraints that it should touch, `zᵀ s`.
fn distance(linearization: &dyn Linearization, entered: &[Rows], duals: &[Vec<f64>]) -> f64 {
    let (mut gradient, mut apart) = (linearization.gradient().to_vec(), 0.0);
    for (rows, z) in entered.iter().zip(duals) {
        rows.add_transposed(-1.0, z, &mut gradient);
        apart += rows.slack.iter().zip(z).map(|(s, z)| s * z).sum::<f64>().abs();
    }
    let residual = (2.0 * linearization.cost()).sqrt();
    let cosines = gradient.iter().zip(linearization.column_scales()).map(|(g, scale)| g.abs() / (scale * residual));
    cosines.fold(apart / (residual * residual), f64::max)
}
