//! The convex programme behind consistent inertias.
//!
//! ```text
//!     minimise over π   ½ dᵀ A d + bᵀ d + Σ_k γ_k [ tr(P0_k⁻¹ P_k) − log det P_k ],      d = π − π̂
//! ```
//!
//! `A` and `b` are what the readings say of the links' parameters, `P_k(π)` the pseudo-inertia of link k, `P0_k` the assumed one. The
//! bracket is least at `P0_k`, and infinite where `P_k` is no body's (Lee, Wensing and Park, *IEEE T-RO* 36, 2020, the entropic
//! divergence; Rucker and Wensing, *IEEE RA-L* 7, 2022). Damped Newton steps, shortened until they stay a body's and lower the cost; the
//! weight follows down from a large one, as the minimum is near `P0` there.

use gravcal_dynamics::BodyInertia;
use nalgebra::{DMatrix, DVector, Matrix4};

/// Numbers of a body.
pub(super) const BODY: usize = 10;
/// Weight from which γ follows down, and by how much at a time.
const FIRST_WEIGHT: f64 = 10.0;
const SHRINKING: f64 = 0.1;
/// Steps for one weight at most.
const STEPS: usize = 100;
/// The cost can fall by no more than this any longer: the end.
const SETTLED: f64 = 1e-14;
/// Share of the slope by which a step must lower the cost, and how far it is shortened at most.
const SUFFICIENT: f64 = 1e-4;
const SHORTEST: f64 = 1e-12;

/// What is assumed of a link.
#[derive(Clone, Debug)]
pub(super) struct Assumed {
    /// A body, not a flat one.
    pub body: BodyInertia,
    /// γ.
    pub weight: f64,
}

/// The programme; all lists over the links' parameters, ten a link.
#[derive(Clone, Debug)]
pub(super) struct Programme {
    /// A.
    pub information: DMatrix<f64>,
    /// b.
    pub slope: DVector<f64>,
    /// π̂.
    pub around: DVector<f64>,
    /// By link.
    pub assumed: Vec<Assumed>,
}

/// Derivative of the pseudo-inertia by each of the ten numbers.
fn directions() -> [Matrix4<f64>; BODY] {
    std::array::from_fn(|i| pseudo(&std::array::from_fn(|j| f64::from(i == j))))
}

fn pseudo(parameters: &[f64; BODY]) -> Matrix4<f64> {
    Matrix4::from(BodyInertia::from_parameters(*parameters).pseudo_inertia())
}

/// `log det P`; nothing where P is no body's.
fn log_determinant(parameters: &[f64; BODY]) -> Option<f64> {
    let root = pseudo(parameters).cholesky()?;
    Some(2.0 * root.l_dirty().diagonal().iter().map(|entry| entry.ln()).sum::<f64>())
}

impl Programme {
    /// The minimum; nothing where it was not reached.
    pub fn solve(&self) -> Option<DVector<f64>> {
        let start = self.assumed.iter().flat_map(|assumed| assumed.body.parameters());
        let mut at = DVector::from_iterator(self.around.len(), start);
        let last = self.assumed.iter().map(|assumed| assumed.weight).fold(f64::INFINITY, f64::min);
        let mut least = f64::max(FIRST_WEIGHT, last);
        loop {
            at = self.with_weights_of_at_least(least).settled(at)?;
            if least <= last {
                return Some(at);
            }
            least = f64::max(SHRINKING * least, last);
        }
    }

    fn with_weights_of_at_least(&self, least: f64) -> Programme {
        let heavier = |assumed: &Assumed| Assumed { weight: assumed.weight.max(least), ..assumed.clone() };
        Programme { assumed: self.assumed.iter().map(heavier).collect(), ..self.clone() }
    }

    fn settled(&self, mut at: DVector<f64>) -> Option<DVector<f64>> {
        let mut cost = self.cost(&at)?;
        for _ in 0..STEPS {
            let (gradient, step) = (self.gradient(&at), self.step(&at)?);
            let slope = gradient.dot(&step);
            if -slope <= SETTLED * (1.0 + cost.abs()) {
                return Some(at);
            }
            let mut share = 1.0;
            let (next, lower) = loop {
                let next = &at + &step * share;
                if let Some(lower) = self.cost(&next).filter(|lower| *lower <= cost + SUFFICIENT * share * slope) {
                    break (next, lower);
                }
                share *= 0.5;
                if share < SHORTEST {
                    // Rounding: the cost falls no further.
                    return (-slope <= SETTLED.sqrt() * (1.0 + cost.abs())).then_some(at);
                }
            };
            (at, cost) = (next, lower);
        }
        None
    }

    /// Nothing where a link is no body.
    pub fn cost(&self, at: &DVector<f64>) -> Option<f64> {
        let d = at - &self.around;
        let mut cost = 0.5 * d.dot(&(&self.information * &d)) + self.slope.dot(&d);
        for (assumed, own) in self.links(at) {
            let expected = pseudo(&assumed.body.parameters()).cholesky()?;
            let trace = expected.solve(&pseudo(own)).trace();
            cost += assumed.weight * (trace - log_determinant(own)?);
        }
        Some(cost)
    }

    fn links<'a>(&'a self, at: &'a DVector<f64>) -> impl Iterator<Item = (&'a Assumed, &'a [f64; BODY])> {
        let (bodies, _) = at.as_slice().as_chunks::<BODY>();
        self.assumed.iter().zip(bodies)
    }

    pub fn gradient(&self, at: &DVector<f64>) -> DVector<f64> {
        let mut gradient = &self.information * (at - &self.around) + &self.slope;
        let along = directions();
        for (link, (assumed, own)) in self.links(at).enumerate() {
            let [expected, own] = [assumed.body.parameters(), *own].map(|body| inverse(&body));
            for (i, along) in along.iter().enumerate() {
                gradient[BODY * link + i] += assumed.weight * ((expected - own) * along).trace();
            }
        }
        gradient
    }

    /// Newton's step. Columns are scaled to one curvature, so that units do not matter.
    fn step(&self, at: &DVector<f64>) -> Option<DVector<f64>> {
        let mut curvature = self.information.clone();
        let along = directions();
        for (link, (assumed, own)) in self.links(at).enumerate() {
            let own = inverse(own);
            let turned = along.map(|along| own * along);
            for i in 0..BODY {
                for j in 0..BODY {
                    curvature[(BODY * link + i, BODY * link + j)] += assumed.weight * (turned[i] * turned[j]).trace();
                }
            }
        }
        let scale = curvature.diagonal().map(|entry| 1.0 / entry.sqrt());
        let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| curvature[(i, j)] * scale[i] * scale[j]);
        let downward = -self.gradient(at).component_mul(&scale);
        Some(scaled.cholesky()?.solve(&downward).component_mul(&scale))
    }
}

/// P⁻¹; all zero where there is none, which no point of the programme has.
fn inverse(parameters: &[f64; BODY]) -> Matrix4<f64> {
    pseudo(parameters).cholesky().map_or_else(Matrix4::zeros, |root| root.inverse())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    /// Masses at some places: certainly a body.
    fn of_points(random: &mut Pcg64) -> BodyInertia {
        let point = |random: &mut Pcg64| {
            let place = std::array::from_fn(|_| random.random_range(-0.2..0.2));
            BodyInertia::about_center(random.random_range(0.2..1.0), place, [0.0; 6])
        };
        (0..12).map(|_| point(random)).fold(BodyInertia::default(), |sum, point| sum + point)
    }

    /// Readings of `rows` random combinations of the parameters of some bodies, each with unit noise `errors` times.
    fn programme(truth: &[BodyInertia], rows: usize, firmness: f64, error: f64, relative_std: f64) -> Programme {
        let mut random = Pcg64::seed_from_u64(5);
        let size = BODY * truth.len();
        let true_values = DVector::from_iterator(size, truth.iter().flat_map(|body| body.parameters()));
        let root = DMatrix::from_fn(rows, size, |_, _| firmness * random.random_range(-1.0..1.0));
        let around = true_values.map(|value| value * (1.0 + error * random.random_range(-1.0..1.0)));
        let assumed = truth.iter().map(|_| Assumed { body: of_points(&mut random), weight: relative_std.powi(-2) });
        let assumed = assumed.collect();
        let slope = DVector::zeros(size);
        Programme { information: root.transpose() * root, slope, around, assumed }
    }

    fn bodies() -> [BodyInertia; 3] {
        let mut random = Pcg64::seed_from_u64(17);
        std::array::from_fn(|_| of_points(&mut random))
    }

    /// Whether a body has these numbers, by eigenvalues and by the principal moments about the centre of mass.
    fn assert_bodies(found: &DVector<f64>) {
        for own in found.as_slice().as_chunks::<BODY>().0 {
            assert!(pseudo(own).symmetric_eigenvalues().min() > 0.0, "{own:?}");
            let body = BodyInertia::from_parameters(*own);
            let [xx, xy, yy, xz, yz, zz] = body.tensor_about_center();
            let moments = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
            let largest = moments.max();
            assert!(body.mass > 0.0 && moments.min() > 0.0 && largest < moments.sum() - largest, "{own:?}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_cost_and_vanishes_at_the_minimum() {
        let programme = programme(&bodies(), 40, 30.0, 0.3, 0.3);
        let start = programme.assumed.iter().flat_map(|assumed| assumed.body.parameters());
        let at = DVector::from_iterator(programme.around.len(), start);
        let gradient = programme.gradient(&at);
        for i in 0..at.len() {
            let step = 1e-6 * (1.0 + at[i].abs());
            let cost = |by: f64| {
                let mut moved = at.clone();
                moved[i] += by;
                programme.cost(&moved).unwrap()
            };
            let difference = (cost(step) - cost(-step)) / (2.0 * step);
            assert!(
                (difference - gradient[i]).abs() < 1e-6 * (1.0 + gradient[i].abs()),
                "{i}: {difference} {gradient}"
            );
        }
        let found = programme.solve().unwrap();
        assert_bodies(&found);
        let (there, lower) = (programme.gradient(&found), programme.cost(&found).unwrap());
        assert!(there.norm() < 1e-6 * gradient.norm(), "{}", there.norm() / gradient.norm());
        // No neighbour is lower, in whatever direction.
        let mut random = Pcg64::seed_from_u64(9);
        for _ in 0..200 {
            let off = found.map(|value| value + 1e-4 * random.random_range(-1.0..1.0));
            assert!(programme.cost(&off).is_none_or(|cost| cost > lower), "{off}");
        }
    }

    #[test]
    fn what_many_exact_readings_tell_is_found_whatever_was_assumed() {
        let truth = bodies();
        let found = programme(&truth, 60, 1e6, 0.0, 0.3).solve().unwrap();
        let expected = truth.iter().flat_map(|body| body.parameters());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found}");
    }

    #[test]
    fn where_nothing_is_read_what_was_assumed_stays() {
        let programme = programme(&bodies(), 1, 0.0, 0.3, 0.7);
        let found = programme.solve().unwrap();
        let assumed = programme.assumed.iter().flat_map(|assumed| assumed.body.parameters());
        assert!(found.iter().zip(assumed).all(|(a, b)| (a - b).abs() < 1e-9), "{found}");
    }
}
