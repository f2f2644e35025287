//! What a solution leans on, in the constraints' own units.

use gravcal_estimation::{ActiveConstraint, Affine, Constraint, ConstraintKind, Problem, Values};

use super::rows::{Cone, Rows, norm};

/// A dual of a cone's tip is inside the cone by more than this share of itself; one of its side is not.
const INSIDE: f64 = 1e-9;

/// The active constraints, in the problem's order, from the rows leant on and their duals.
pub(crate) fn active_constraints(
    problem: &Problem,
    values: &Values,
    leaning: &[(Rows, Vec<f64>)],
) -> Vec<ActiveConstraint> {
    let mut leaning: Vec<&(Rows, Vec<f64>)> = leaning.iter().collect();
    leaning.sort_by_key(|(rows, _)| rows.place);
    let reported = leaning.into_iter().map(|(rows, dual)| {
        let constraint = &problem.constraints()[rows.constraint];
        ActiveConstraint {
            name: constraint.name.clone(),
            multiplier: match rows.cone {
                // The dual of `f − value` belongs to a value that sinks.
                Cone::Equation => -dual[0],
                Cone::Nonnegative | Cone::SecondOrder => dual[0],
            },
            holds: holds(constraint, values, dual),
        }
    });
    reported.collect()
}

/// The dual of a cone's side is its outward normal, `z₁ (1, −û)`, and keeps its direction where `u` is tiny.
fn holds(constraint: &Constraint, values: &Values, dual: &[f64]) -> Vec<Affine> {
    match &constraint.kind {
        ConstraintKind::Range { function, .. } => vec![function.clone()],
        ConstraintKind::Length { block, length } => {
            let x = values.get(*block).iter().enumerate();
            vec![x.fold(Affine::default(), |f, (i, x)| f.plus(*block, i, x / length))]
        }
        ConstraintKind::Cone { norm_of, at_most } => {
            let functions: Vec<&Affine> = std::iter::once(at_most).chain(norm_of).collect();
            if dual[0] - norm(&dual[1..]) > INSIDE * dual[0] {
                return functions.into_iter().cloned().collect();
            }
            vec![functions.iter().zip(dual).fold(Affine::default(), |sum, (f, z)| add(sum, z / dual[0], f))]
        }
    }
}

fn add(sum: Affine, factor: f64, other: &Affine) -> Affine {
    let added = other.terms.iter().fold(sum, |sum, (id, i, c)| sum.plus(*id, *i, factor * c));
    added.offset(factor * other.constant)
}
