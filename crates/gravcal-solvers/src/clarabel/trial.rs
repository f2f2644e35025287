//! The step that the method tries from one point, and how far that point is from optimal.
//!
//! Constraints enter one by one: the step without any is right if it breaks none; else those that it breaks enter
//! the conic programme, until none of the others is broken. So constraints far away cost nothing, and cost no digits.

use gravcal_estimation::{Linearization, Problem, Values};

use super::model::Model;
use super::programme::{Outcome, solve};
use super::rows::{Cone, Rows, rows};

/// Duals, as cosines, from which on a solution leans on a constraint.
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
    /// Rows on which it leans, over columns, with their duals.
    pub leaning: Vec<(Rows, Vec<f64>)>,
    /// How far the point itself is from optimal: 0 where it is.
    pub cosine: f64,
}

impl Trial {
    /// The step from a point; `leaning`: rows on which the last one leaned, likely to matter again. `None` where the conic programme has no
    /// answer.
    pub fn new(problem: &Problem, point: &mut Point<'_>, damping: &Damping, leaning: &[usize]) -> Option<Trial> {
        let all = rows(problem, &point.values).into_iter().map(Rows::relaxed);
        let matters = |r: &Rows| r.cone == Cone::Equation || leaning.contains(&r.place);
        let (mut entered, mut left): (Vec<Rows>, Vec<Rows>) = all.partition(matters);
        if entered.is_empty() {
            let free = Trial::free(point, damping);
            (entered, left) = left.into_iter().partition(|r| !r.obeyed_by(&free.step));
            if entered.is_empty() {
                return Some(free);
            }
        }
        let model = Model::new(problem, point, damping);
        loop {
            let trial = Trial::constrained(point, &model, &entered)?;
            let (broken, kept): (Vec<Rows>, Vec<Rows>) = left.into_iter().partition(|r| !r.obeyed_by(&trial.step));
            if broken.is_empty() {
                return Some(trial);
            }
            entered.extend(broken);
            left = kept;
        }
    }

    fn free(point: &mut Point<'_>, damping: &Damping) -> Trial {
        let mut step = vec![0.0; damping.scaling.len()];
        let info = point.linearization.damped_step(damping.lambda, &damping.scaling, &mut step);
        let cosine = point.linearization.largest_cosine();
        Trial { step, predicted: info.predicted_reduction, leaning: Vec::new(), cosine }
    }

    fn constrained(point: &Point<'_>, model: &Model, entered: &[Rows]) -> Option<Trial> {
        let linearization = point.linearization.as_ref();
        let rows = model.rows(entered);
        let Outcome::Solved(solution) = solve(&model.quadratic, &rows) else { return None };
        let step = model.step(&solution.point);
        // Duals of the constraints' own rows.
        let rescaled = |(rows, z): (&Rows, &Vec<f64>)| z.iter().map(|z| z * rows.scale * model.energy).collect();
        let duals: Vec<Vec<f64>> = rows.iter().zip(&solution.duals).map(rescaled).collect();
        let leans = |index: &usize| entered[*index].cone == Cone::Equation || solution.duals[*index][0] > LEANING;
        Some(Trial {
            predicted: model.predicted_reduction(linearization, &step),
            leaning: (0..entered.len()).filter(leans).map(|i| (entered[i].clone(), duals[i].clone())).collect(),
            cosine: distance(linearization, entered, &duals),
            step,
        })
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
