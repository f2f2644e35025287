//! The linear part of the joint problem under any direction of gravity, from its normal equations under a few.
//!
//! For given sensors each torque is affine in gravity, so residuals `r` and Jacobian `J` of the linear part are, and its cost `½ rᵀr`, gradient
//! `Jᵀr` and Hessian `JᵀJ` are polynomials of second degree in gravity's components. On the sphere of gravities of one magnitude such
//! polynomials are combinations of nine functions, the spherical harmonics up to second degree; [`NODES`] directions give their coefficients, and two
//! equations more than unknowns whether it is so: a characteristic that is bent, or friction that goes with the load, is no polynomial.

use faer::linalg::solvers::{Llt, SolveCore};
use faer::{Conj, Mat, Side};
use gravcal_estimation::{Linearization, Problem, Values};
use nalgebra::{SMatrix, SVector};

use crate::joint::starting::directions::lattice;

/// Damping that leaves combinations without information where they are, and little else, column-relative.
pub(in crate::joint) const FAINT_DAMPING: f64 = 1e-9;
/// Functions of a direction.
const FUNCTIONS: usize = 9;
/// Directions under which the normal equations are computed.
const NODES: usize = FUNCTIONS + 2;
/// What may be left of an entry beside the polynomial, in its unit: the sums of residuals themselves are rounded at 1e-14 or so.
const ROUNDED: f64 = 1e-10;
/// Square of the smallest relative pivot with which a step keeps enough digits for a cost to be compared.
const LEAST_PIVOT: f64 = 1e-11;

/// Normal equations of a linear problem for any direction of gravity.
pub(in crate::joint) struct AnyDirection {
    columns: usize,
    /// Row by row those of one entry: the cost, the gradient, and the lower triangle of the Hessian row by row.
    coefficients: Vec<[f64; FUNCTIONS]>,
}

impl AnyDirection {
    /// From the linear problem at `values_under` of some directions; nothing where it cannot be evaluated or is no polynomial.
    pub fn new(linear: &Problem, values_under: impl Fn([f64; 3]) -> Values) -> Option<Self> {
        let nodes: Vec<[f64; 3]> = lattice(NODES).collect();
        let functions = SMatrix::<f64, NODES, FUNCTIONS>::from_fn(|node, k| harmonics(nodes[node])[k]);
        let mut entries: Vec<SVector<f64, NODES>> = Vec::new();
        for (node, direction) in nodes.into_iter().enumerate() {
            let linearization = linear.linearize(&values_under(direction)).ok()?;
            let found = packed(&*linearization);
            entries.resize(found.len(), SVector::zeros());
            entries.iter_mut().zip(found).for_each(|(entry, value)| entry[node] = value);
        }
        let columns = linear.columns().len();
        let inverse = functions.pseudo_inverse(f64::EPSILON).ok()?;
        let fitted: Vec<SVector<f64, FUNCTIONS>> = entries.iter().map(|entry| inverse * entry).collect();
        let left = entries.iter().zip(&fitted).map(|(entry, coefficients)| (functions * coefficients - entry).amax());
        let polynomial = left.zip(units(columns, &entries)).all(|(left, unit)| left <= ROUNDED * unit);
        let coefficients = fitted.into_iter().map(|coefficients| coefficients.into()).collect();
        polynomial.then_some(AnyDirection { columns, coefficients })
    }

    /// The least cost under a direction; nothing where that takes more digits than the normal equations have.
    pub fn least_cost(&self, direction: [f64; 3]) -> Option<f64> {
        let functions = harmonics(direction);
        let value = |of: &[f64; FUNCTIONS]| of.iter().zip(&functions).map(|(c, f)| c * f).sum::<f64>();
        let entries: Vec<f64> = self.coefficients.iter().map(value).collect();
        let (gradient, hessian) = entries[1..].split_at(self.columns);
        Some(entries[0] - reduction(gradient, hessian)?)
    }
}

/// By how much the cost falls with the faintly damped step; `hessian`: its lower triangle row by row.
fn reduction(gradient: &[f64], hessian: &[f64]) -> Option<f64> {
    let columns = gradient.len();
    let squares: Vec<f64> = (0..columns).map(|row| hessian[place(row, row)]).collect();
    // Columns of zeros stay where they are.
    let scale: Vec<f64> = squares.iter().map(|square| if *square > 0.0 { 1.0 / square.sqrt() } else { 0.0 }).collect();
    let damped = Mat::from_fn(columns, columns, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 1.0 + FAINT_DAMPING,
        std::cmp::Ordering::Greater => hessian[place(i, j)] * scale[i] * scale[j],
    });
    let factor = Llt::new(damped.as_ref(), Side::Lower).ok()?;
    if (0..columns).any(|i| factor.L()[(i, i)].powi(2) <= LEAST_PIVOT) {
        return None;
    }
    let mut step = Mat::from_fn(columns, 1, |i, _| -gradient[i] * scale[i]);
    factor.solve_in_place_with_conj(Conj::No, step.as_mut());
    let along: f64 = (0..columns).map(|i| gradient[i] * scale[i] * step[(i, 0)]).sum();
    let size: f64 = (0..columns).map(|i| step[(i, 0)].powi(2)).sum();
    // −gᵀδ − ½ δᵀHδ with (H + λ) δ = −g.
    Some(-0.5 * along + 0.5 * FAINT_DAMPING * size)
}

/// Cost, gradient and the lower triangle of the Hessian.
fn packed(linearization: &dyn Linearization) -> Vec<f64> {
    let (gradient, hessian) = (linearization.gradient(), linearization.hessian());
    let rows = (0..gradient.len()).map(|row| &hessian[row * gradient.len()..][..=row]);
    [linearization.cost()].into_iter().chain(gradient.iter().copied()).chain(rows.flatten().copied()).collect()
}

/// Where an entry of the lower triangle stands among its own.
fn place(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// What each entry is measured by: products of the columns' and the residual's largest norms.
fn units(columns: usize, entries: &[SVector<f64, NODES>]) -> impl Iterator<Item = f64> {
    let residual = (2.0 * entries[0].amax()).sqrt();
    let norms: Vec<f64> = (0..columns).map(|row| entries[1 + columns + place(row, row)].amax().sqrt()).collect();
    let hessian = (0..columns).flat_map(|row| (0..=row).map(move |column| (row, column)));
    let hessian: Vec<f64> = hessian.map(|(row, column)| norms[row] * norms[column]).collect();
    let gradient = norms.into_iter().map(move |norm| norm * residual);
    [residual * residual].into_iter().chain(gradient).chain(hessian)
}

/// The real spherical harmonics up to second degree, but for constant factors.
fn harmonics([x, y, z]: [f64; 3]) -> [f64; FUNCTIONS] {
    [1.0, x, y, z, x * y, y * z, z * x, x * x - y * y, 3.0 * z * z - 1.0]
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{
        Block, BlockId, EvaluateError, Factor, LocalValues, Noise, ProblemBuilder, Residual, RowsMut,
    };

    use super::*;

    /// A pendulum's torque `h · (p × g) + b − y` at one place `p`, of moment `h` and bias `b`; friction goes with its size.
    #[derive(Debug)]
    struct Pendulum {
        blocks: [BlockId; 3],
        place: [f64; 3],
        reading: f64,
        friction: f64,
    }

    impl Residual for Pendulum {
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
            let (gravity, moment, bias) = (x.block(0), x.scalar(1), x.scalar(2));
            let along: f64 = self.place.iter().zip(gravity).map(|(p, g)| p * g).sum();
            let slope = along + self.friction * along.abs();
            residual[0] = moment * slope + bias - self.reading;
            if let Some(mut rows) = jacobian {
                rows.row(0)[x.column(1)] = slope;
                rows.row(0)[x.column(2)] = 1.0;
            }
            Ok(())
        }
    }

    /// With gravity held; the block of gravity, and a start.
    fn linear(friction: f64) -> (Problem, BlockId, Values) {
        let mut builder = ProblemBuilder::new();
        let gravity = builder.add_block(Block::vector("gravity", "m/s²", &["x", "y", "z"]).fixed("given"), &[0.0; 3]);
        let [moment, bias] = ["moment", "bias"].map(|name| builder.add_block(Block::scalar(name, "N·m"), &[0.3]));
        for place in lattice(20) {
            let reading = (37.0 * place[0]).sin();
            let residual = Pendulum { blocks: [gravity, moment, bias], place, reading, friction };
            builder.add_factor(Factor::new(residual, Noise::independent(&[0.1]).unwrap()));
        }
        let (problem, initial) = builder.build().unwrap();
        (problem, gravity, initial)
    }

    fn under(gravity: BlockId, initial: &Values) -> impl Fn([f64; 3]) -> Values {
        let initial = initial.clone();
        move |direction| {
            let mut values = initial.clone();
            values.set(gravity, &direction.map(|c| 9.81 * c));
            values
        }
    }

    #[test]
    fn the_least_cost_under_any_direction_is_that_of_the_problem_itself() {
        let (problem, gravity, initial) = linear(0.0);
        let any = AnyDirection::new(&problem, under(gravity, &initial)).unwrap();
        for direction in lattice(50) {
            let mut linearization = problem.linearize(&under(gravity, &initial)(direction)).unwrap();
            let (scaling, mut step) = (linearization.column_scales(), vec![0.0; 2]);
            let fall = linearization.damped_step(FAINT_DAMPING, &scaling, &mut step).predicted_reduction;
            let (cost, least) = (linearization.cost() - fall, any.least_cost(direction).unwrap());
            assert!((cost - least).abs() < 1e-10 * linearization.cost(), "{cost} {least}");
        }
    }

    #[test]
    fn what_goes_with_the_size_of_a_torque_is_no_polynomial() {
        let (problem, gravity, initial) = linear(0.1);
        assert!(AnyDirection::new(&problem, under(gravity, &initial)).is_none());
    }

    #[test]
    fn a_column_of_zeros_and_columns_that_are_one_leave_the_cost_finite() {
        let one = reduction(&[2.0, 0.0], &[4.0, 0.0, 0.0]).unwrap();
        assert!((one - 0.5).abs() < 1e-8);
        let twice = reduction(&[2.0, 2.0], &[4.0, 4.0, 4.0]).unwrap();
        assert!((twice - 0.5).abs() < 1e-8);
    }
}
