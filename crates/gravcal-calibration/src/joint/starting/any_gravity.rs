//! The linear part of the joint problem under any gravity, from its normal equations under a few.
//!
//! For given sensors each torque is affine in gravity, so residuals `r` and Jacobian `J` of the linear part are, and its cost `½ rᵀr`, gradient
//! `Jᵀr` and Hessian `JᵀJ` are polynomials of second degree in gravity's components: combinations of ten monomials. To multiply all torque gains by a
//! number is to multiply gravity by it, where the arm stands. [`NODES`] gravities of three magnitudes give the coefficients, and three
//! equations more than unknowns whether it is so: a characteristic that is bent, or friction that goes with the load, is no polynomial.
//!
//! Where the arm moves, inertia's torque is multiplied with the gains, too, and the gravities have one magnitude. Of these one sum of monomials is constant,
//! `x² + y² + z²`, and any of the coefficients that differ by it give the same.

use gravcal_estimation::{Linearization, Problem, Values};
use nalgebra::{DVector, SMatrix, SVector};

use crate::joint::starting::at_distances::{FAINT_DAMPING, KnownLength, Quadratic};
use crate::joint::starting::directions::lattice;

/// Monomials of gravity's components up to second degree.
const MONOMIALS: usize = 10;
/// Gravities under which the normal equations are computed, and their magnitudes in turn, in units of the one that is given: of an arm that stands, and of
/// one that moves.
const NODES: usize = MONOMIALS + 3;
const MAGNITUDES: [f64; 3] = [1.0, 0.5, 2.0];
const ONE_MAGNITUDE: [f64; 1] = [1.0];
/// A smaller singular value of the monomials at the nodes is zero.
const DEPENDENT: f64 = 1e-9;
/// What may be left of an entry beside the polynomial, in its unit: the sums of residuals themselves are rounded at 1e-14 or so.
const ROUNDED: f64 = 1e-10;

/// Normal equations of a linear problem for any gravity.
pub(in crate::joint) struct AnyGravity {
    columns: usize,
    /// Whether all torque gains times a number are gravity times that number.
    scales: bool,
    /// Row by row those of one entry: the cost, the gradient, and the lower triangle of the Hessian row by row.
    coefficients: Vec<[f64; MONOMIALS]>,
}

impl AnyGravity {
    /// From the linear problem at `values_under` of some directions of gravity, with all torque gains times a number; nothing where it cannot be
    /// evaluated or is no polynomial. `stands`: whether the arm does.
    pub fn new(linear: &Problem, stands: bool, values_under: impl Fn([f64; 3], f64) -> Values) -> Option<Self> {
        let magnitudes: &[f64] = if stands { &MAGNITUDES } else { &ONE_MAGNITUDE };
        let nodes: Vec<([f64; 3], f64)> = lattice(NODES).zip(magnitudes.iter().copied().cycle()).collect();
        let functions = SMatrix::<f64, NODES, MONOMIALS>::from_fn(|node, k| {
            let (direction, scale) = nodes[node];
            monomials(direction.map(|c| scale * c))[k]
        });
        let mut entries: Vec<SVector<f64, NODES>> = Vec::new();
        for (node, (direction, scale)) in nodes.into_iter().enumerate() {
            let linearization = linear.linearize(&values_under(direction, scale)).ok()?;
            let found = packed(&*linearization);
            entries.resize(found.len(), SVector::zeros());
            entries.iter_mut().zip(found).for_each(|(entry, value)| entry[node] = value);
        }
        let columns = linear.columns().len();
        let inverse = functions.pseudo_inverse(DEPENDENT).ok()?;
        let fitted: Vec<SVector<f64, MONOMIALS>> = entries.iter().map(|entry| inverse * entry).collect();
        let left = entries.iter().zip(&fitted).map(|(entry, coefficients)| (functions * coefficients - entry).amax());
        let polynomial = left.zip(units(columns, &entries)).all(|(left, unit)| left <= ROUNDED * unit);
        let coefficients = fitted.into_iter().map(|coefficients| coefficients.into()).collect();
        polynomial.then_some(AnyGravity { columns, scales: stands, coefficients })
    }

    /// The least cost under a direction of gravity, with all torque gains times `scale`, where these lengths are kept, and the step to it; nothing
    /// where that takes more digits than the normal equations have, or these are of another scale.
    pub fn least(&self, direction: [f64; 3], scale: f64, lengths: &[KnownLength]) -> Option<(f64, DVector<f64>)> {
        if scale != 1.0 && !self.scales {
            return None;
        }
        let functions = monomials(direction.map(|c| scale * c));
        let value = |of: &[f64; MONOMIALS]| of.iter().zip(&functions).map(|(c, f)| c * f).sum::<f64>();
        let entries: Vec<f64> = self.coefficients.iter().map(value).collect();
        let (gradient, hessian) = entries[1..].split_at(self.columns);
        let free = Quadratic::minimised(gradient, |i, j| hessian[place(i, j)], FAINT_DAMPING)
            .filter(Quadratic::keeps_digits)?;
        let Quadratic { step, reduction, .. } = lengths.iter().fold(free, Quadratic::keeping);
        Some((entries[0] - reduction, step))
    }
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

fn monomials([x, y, z]: [f64; 3]) -> [f64; MONOMIALS] {
    [1.0, x, y, z, x * y, y * z, z * x, x * x, y * y, z * z]
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{
        Block, BlockId, EvaluateError, Factor, LocalValues, Noise, ProblemBuilder, Residual, RowsMut,
    };

    use super::*;

    /// A pendulum's torque `k (h · (p × g) + h a) + b − y` at one place `p`, of moment `h`, gain `k` and bias `b`; friction goes with its size, and it is
    /// accelerated by `a`.
    #[derive(Debug)]
    struct Pendulum {
        blocks: [BlockId; 4],
        place: [f64; 3],
        reading: f64,
        friction: f64,
        acceleration: f64,
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
            let (gravity, moment, bias, gain) = (x.block(0), x.scalar(1), x.scalar(2), x.scalar(3));
            let along: f64 = self.place.iter().zip(gravity).map(|(p, g)| p * g).sum();
            let slope = gain * (along + self.friction * along.abs() + self.acceleration);
            residual[0] = moment * slope + bias - self.reading;
            if let Some(mut rows) = jacobian {
                rows.row(0)[x.column(1)] = slope;
                rows.row(0)[x.column(2)] = 1.0;
            }
            Ok(())
        }
    }

    /// Pendulums with gravity and gain held, and their values under a direction of gravity with the gain times a number. `accelerated`: by how much at most.
    fn linear(friction: f64, accelerated: f64) -> (Problem, impl Fn([f64; 3], f64) -> Values) {
        let mut builder = ProblemBuilder::new();
        let gravity = builder.add_block(Block::vector("gravity", "m/s²", &["x", "y", "z"]).fixed("given"), &[0.0; 3]);
        let [moment, bias] = ["moment", "bias"].map(|name| builder.add_block(Block::scalar(name, "N·m"), &[0.3]));
        let gain = builder.add_block(Block::scalar("gain", "1").fixed("given"), &[1.0]);
        for place in lattice(20) {
            let (reading, acceleration) = ((37.0 * place[0]).sin(), accelerated * (11.0 * place[1]).cos());
            let blocks = [gravity, moment, bias, gain];
            let residual = Pendulum { blocks, place, reading, friction, acceleration };
            builder.add_factor(Factor::new(residual, Noise::independent(&[0.1]).unwrap()));
        }
        let (problem, initial) = builder.build().unwrap();
        let under = move |direction: [f64; 3], scale: f64| {
            let mut values = initial.clone();
            values.set(gravity, &direction.map(|c| 9.81 * c));
            values.set(gain, &[scale]);
            values
        };
        (problem, under)
    }

    /// Whether the least cost under any gravity, with gains times each of these numbers in turn, is that of the problem itself.
    fn assert_is_of_the_problem(
        any: &AnyGravity,
        problem: &Problem,
        under: impl Fn([f64; 3], f64) -> Values,
        scales: &[f64],
    ) {
        for (direction, scale) in lattice(50).zip(scales.iter().copied().cycle()) {
            let mut linearization = problem.linearize(&under(direction, scale)).unwrap();
            let (scaling, mut step) = (linearization.column_scales(), vec![0.0; 2]);
            let fall = linearization.damped_step(FAINT_DAMPING, &scaling, &mut step).predicted_reduction;
            let (least, to_least) = any.least(direction, scale, &[]).unwrap();
            let cost = linearization.cost() - fall;
            assert!((cost - least).abs() < 1e-10 * linearization.cost(), "{cost} {least}");
            assert!(step.iter().zip(&to_least).all(|(a, b)| (a - b).abs() < 1e-8 * (1.0 + b.abs())), "{step:?}");
        }
    }

    #[test]
    fn the_least_cost_under_any_gravity_is_that_of_the_problem_itself() {
        let (problem, under) = linear(0.0, 0.0);
        let any = AnyGravity::new(&problem, true, &under).unwrap();
        assert_is_of_the_problem(&any, &problem, under, &[0.3, 1.0, 3.0]);
    }

    /// Gains are multiplied with the torque of inertia, too, which gravity is not.
    #[test]
    fn of_what_moves_it_is_so_for_the_gains_that_are_given() {
        let (problem, under) = linear(0.0, 4.0);
        assert!(AnyGravity::new(&problem, true, &under).is_none());
        let any = AnyGravity::new(&problem, false, &under).unwrap();
        assert!(any.least([0.0, 0.0, 1.0], 0.5, &[]).is_none());
        assert_is_of_the_problem(&any, &problem, under, &[1.0]);
    }

    #[test]
    fn what_goes_with_the_size_of_a_torque_is_no_polynomial() {
        let (problem, under) = linear(0.1, 0.0);
        assert!(AnyGravity::new(&problem, true, &under).is_none());
        assert!(AnyGravity::new(&problem, false, &under).is_none());
    }
}
