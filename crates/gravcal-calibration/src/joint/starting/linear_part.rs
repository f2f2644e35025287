//! What is linear in the joint problem, solved for given gravity and sensors.

use std::sync::OnceLock;

use gravcal_estimation::{BlockId, Linearization, Problem, Values};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{JointPriors, LoadDistance, PriorKind, Session};

use nalgebra::{Matrix3xX, Vector3};

use crate::joint::building::build::pose_readings_alone;
use crate::joint::error::BuildError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::problem::JointProblem;
use crate::joint::starting::any_gravity::AnyGravity;
use crate::joint::starting::at_distances::{FAINT_DAMPING, KnownLength, Quadratic};
use crate::joint::variables::State;

/// Nominal torque gains are taken for wrong where they are off by more than this factor, and by lengths only where that
/// lowers the cost by so much.
const FAR_SCALE: f64 = 1.5;
const WORTHWHILE: f64 = 10.0;
/// How often their scale is sought anew.
const SCALINGS: usize = 3;

/// Biases, masses, moments and placements as the unknowns of a linear problem.
pub(in crate::joint) struct LinearPart<'s> {
    session: &'s Session,
    built: JointProblem,
    /// With everything else held.
    linear: Problem,
    /// The same with nominal sensors under any gravity, once that was asked for.
    any_gravity: OnceLock<Option<AnyGravity>>,
}

/// Where a start is looked for.
#[derive(Clone, Copy)]
pub(in crate::joint) enum Candidate<'a> {
    /// At values that were found before.
    Known(&'a State),
    /// At nominal values under a direction of gravity.
    Under([f64; 3]),
}

impl<'s> LinearPart<'s> {
    /// `values`: from where what is linear starts.
    ///
    /// # Errors
    /// Where no problem can be built.
    pub fn new(session: &'s Session, readings: &MeasurementSet, values: &State) -> Result<Self, BuildError> {
        let built = pose_readings_alone(session, readings, values)?;
        let nonlinear: Vec<BlockId> = built.problem.block_ids().filter(|id| !built.problem.block(*id).linear).collect();
        let linear = built.problem.with_fixed(&nonlinear, "given by the candidate");
        Ok(LinearPart { session, built, linear, any_gravity: OnceLock::new() })
    }

    pub fn session(&self) -> &'s Session {
        self.session
    }

    /// The least-squares solution for the gravity and the sensors of a candidate, with known distances of placements kept; and the cost left.
    pub fn solve(&self, candidate: &State) -> (f64, State) {
        let values = self.values(candidate);
        if self.session.load_distances.is_empty() {
            return self.solve_from(&values, candidate);
        }
        let Ok(linearization) = self.linear.linearize(&values) else { return (f64::INFINITY, candidate.clone()) };
        let Some(quadratic) = quadratic(&*linearization) else { return self.solve_from(&values, candidate) };
        let quadratic = self.known_lengths(&values).iter().fold(quadratic, Quadratic::keeping);
        let solved = self.linear.retract(&values, quadratic.step.as_slice());
        (linearization.cost() - quadratic.reduction, self.built.variables.state(&solved, candidate))
    }

    /// The same with all torque gains of a candidate times a number, with known distances of placements or without.
    fn solve_at(&self, candidate: Candidate<'_>, scale: f64, with_distances: bool) -> (f64, State) {
        let state = with_gains_times(scale, &self.state_of(candidate));
        let values = self.values(&state);
        if let Candidate::Under(direction) = candidate {
            let lengths = if with_distances { self.known_lengths(&values) } else { Vec::new() };
            if let Some((cost, step)) = self.any_gravity().and_then(|any| any.least(direction, scale, &lengths)) {
                let solved = self.linear.retract(&values, step.as_slice());
                return (cost, self.built.variables.state(&solved, &state));
            }
        }
        if with_distances { self.solve(&state) } else { self.solve_from(&values, &state) }
    }

    /// The least cost for nominal sensors under a direction of gravity.
    pub fn least_cost(&self, direction: [f64; 3]) -> f64 {
        self.solve_at(Candidate::Under(direction), 1.0, true).0
    }

    fn state_of(&self, candidate: Candidate<'_>) -> State {
        let magnitude = self.session.gravity.magnitude;
        match candidate {
            Candidate::Known(known) => known.clone(),
            Candidate::Under(direction) => {
                State { gravity: direction.map(|c| magnitude * c), ..State::nominal(self.session) }
            }
        }
    }

    /// Nominal sensors under any gravity, where the linear part is a polynomial of that.
    fn any_gravity(&self) -> Option<&AnyGravity> {
        let under = |direction, scale| with_gains_times(scale, &self.state_of(Candidate::Under(direction)));
        let stands = !self.session.has_windows();
        let make = || AnyGravity::new(&self.linear, stands, |direction, scale| self.values(&under(direction, scale)));
        self.any_gravity.get_or_init(make).as_ref()
    }

    fn solve_from(&self, values: &Values, candidate: &State) -> (f64, State) {
        let Ok(mut linearization) = self.linear.linearize(values) else { return (f64::INFINITY, candidate.clone()) };
        let scaling = linearization.column_scales();
        let mut step = vec![0.0; scaling.len()];
        let gain = linearization.damped_step(FAINT_DAMPING, &scaling, &mut step).predicted_reduction;
        let solved = self.linear.retract(values, &step);
        (linearization.cost() - gain, self.built.variables.state(&solved, candidate))
    }

    /// Gravity and sensors of a candidate; the rest from where what is linear starts.
    fn values(&self, candidate: &State) -> Values {
        let variables = &self.built.variables;
        let mut values = self.built.initial.clone();
        values.set(variables.gravity, &candidate.gravity);
        for (ids, sensor) in variables.sensors.iter().zip(&candidate.sensors) {
            ids.iter().zip(sensor).for_each(|(id, value)| values.set(*id, &[*value]));
        }
        variables.further.iter().zip(&candidate.further).for_each(|(id, value)| values.set(*id, &[*value]));
        values
    }

    /// How known distances of placements depend on the columns of the linear problem.
    fn known_lengths(&self, values: &Values) -> Vec<KnownLength> {
        self.session.load_distances.iter().filter_map(|known| self.known_length(known, values)).collect()
    }

    /// How the difference of two placements depends on the columns of the linear problem; nothing where one of them is not carried.
    fn known_length(&self, known: &LoadDistance, values: &Values) -> Option<KnownLength> {
        let [from, to] = known.between.map(|load| self.built.variables.loads[load].as_deref());
        let (mut difference, mut by_step) = (Vector3::zeros(), Matrix3xX::zeros(self.linear.columns().len()));
        for (placement, sign) in [(from?, -1.0), (to?, 1.0)] {
            for block in placement {
                difference += sign * Vector3::from_column_slice(values.get(*block));
                self.linear.columns_of(*block).zip(0..3).for_each(|(column, axis)| by_step[(axis, column)] += sign);
            }
        }
        Some(KnownLength { difference, by_step, length: known.distance })
    }

    /// What suits a candidate best, with torque gains of the size that the loads tell, where its own are far from it.
    ///
    /// Placements that the readings hardly tell may lie anywhere, and tell a scale that nothing else bears out: the cost at known distances
    /// decides.
    pub fn solve_to_scale(&self, candidate: Candidate<'_>) -> (f64, State) {
        let (mut scale, mut least) = (1.0, self.solve_at(candidate, 1.0, true).0);
        for _ in 0..SCALINGS {
            let before = least;
            for factor in self.gain_scales(candidate, scale) {
                let (cost, _) = self.solve_at(candidate, factor * scale, true);
                if cost < least {
                    (scale, least) = (factor * scale, cost);
                }
            }
            if least == before {
                break;
            }
        }
        // From where a fit may start, to the last digit: along what is hardly known a polynomial has fewer.
        self.solve(&with_gains_times(scale, &self.state_of(candidate)))
    }

    /// By what all torque gains, a candidate's but for a factor, may have to be multiplied, where none is known beforehand and they are far off.
    ///
    /// With the gains times κ, and masses, moments and placements divided by κ, only what the loads' known masses do on known
    /// lengths changes, linearly in κ. So the cost that the linear problem leaves is a parabola in κ, and three points give its
    /// minimum. Where it is flat (no lengths), the known distance of two placements is the measure: the linear problem, which
    /// does not know it, puts them κ times as far apart.
    fn gain_scales(&self, candidate: Candidate<'_>, before: f64) -> Vec<f64> {
        let session = self.session;
        let free = |joint: &JointPriors| joint.of(SensorParameter::TorqueGain).kind == PriorKind::Flat;
        if session.loads.is_empty() || !session.joints.iter().all(free) {
            return Vec::new();
        }
        let [(one, found), (half, _), (two, _)] =
            [1.0, 0.5, 2.0].map(|scale| self.solve_at(candidate, scale * before, false));
        let slopes = [2.0 * (one - half), two - one];
        let curvature = (slopes[1] - slopes[0]) / 1.5;
        let scale = 1.5 / 2.0 - slopes[0] / (2.0 * curvature);
        let of_lengths = (curvature * (scale - 1.0).powi(2) > WORTHWHILE).then_some(scale);
        let apart = |known: &LoadDistance| {
            let [p, q] = known.between.map(|load| Vector3::from(found.loads[load]));
            (q - p).norm() / known.distance
        };
        let of_distance = session.pair_of_free_placements().map(apart);
        let is_far = |scale: &f64| *scale > 0.0 && scale.is_finite() && !(1.0 / FAR_SCALE..FAR_SCALE).contains(scale);
        of_lengths.into_iter().chain(of_distance).filter(is_far).collect()
    }
}

fn with_gains_times(scale: f64, values: &State) -> State {
    let mut scaled = values.clone();
    scaled.sensors.iter_mut().for_each(|sensor| sensor[SensorParameter::TorqueGain as usize] *= scale);
    scaled
}

/// The cost of a linear problem, minimised; nothing where that needs more digits than there are.
fn quadratic(linearization: &dyn Linearization) -> Option<Quadratic> {
    let (gradient, hessian) = (linearization.gradient(), linearization.hessian());
    Quadratic::minimised(gradient, |i, j| hessian[i * gradient.len() + j], FAINT_DAMPING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::starting::directions::directions;
    use crate::joint::{Signals, select};
    use crate::testing::sarcos_shoulder;

    #[test]
    fn placements_start_at_their_known_distance_and_explain_the_readings() {
        let simulation = sarcos_shoulder();
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let part = LinearPart::new(&session, &readings, &State::nominal(&session)).unwrap();
        let (cost, found) = part.solve(&simulation.truth);
        let [a, b] = [0, 1].map(|load| Vector3::from(found.loads[load]));
        assert!(((b - a).norm() - session.load_distances[0].distance).abs() < 1e-9);
        // Gravity and sensors are true: noise alone is left, ½ a reading.
        let per_reading = cost / readings.count() as f64;
        assert!((0.4..0.6).contains(&per_reading), "{per_reading}");
        let (anywhere, free) = part.solve_from(&part.values(&simulation.truth), &simulation.truth);
        assert!(anywhere <= cost && free.loads != found.loads);
    }

    #[test]
    fn nominal_sensors_under_any_gravity_end_where_the_problem_itself_does() {
        let session = sarcos_shoulder().session(0);
        let part = LinearPart::new(&session, &select(&session, Signals::All), &State::nominal(&session)).unwrap();
        assert!(part.any_gravity().is_some());
        for (direction, scale) in
            directions(session.gravity.hemisphere).step_by(7).zip([1.0, 0.4, 2.5].into_iter().cycle())
        {
            let candidate = Candidate::Under(direction);
            let (cost, found) = part.solve_at(candidate, scale, true);
            let (expected, itself) = part.solve(&with_gains_times(scale, &part.state_of(candidate)));
            assert!((cost - expected).abs() < 1e-8 * expected, "{cost} {expected}");
            for (load, its) in found.loads.iter().zip(&itself.loads) {
                assert!((Vector3::from(*load) - Vector3::from(*its)).norm() < 1e-5, "{load:?} {its:?}");
            }
        }
    }

    #[test]
    fn gains_that_start_half_as_large_are_brought_to_scale() {
        let simulation = sarcos_shoulder();
        let session = simulation.session(0);
        let part = LinearPart::new(&session, &select(&session, Signals::All), &State::nominal(&session)).unwrap();
        let (_, found) = part.solve_to_scale(Candidate::Known(&with_gains_times(0.5, &simulation.truth)));
        let ratio = found.sensors[0][0] / simulation.truth.sensors[0][0];
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }
}
