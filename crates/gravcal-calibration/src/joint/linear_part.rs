//! What is linear in the joint problem, solved for given gravity and sensors.

use gravcal_estimation::{BlockId, Problem};
use gravcal_robot_model::parameter::Quantity;
use gravcal_robot_model::session::{JointKnowledge, KnowledgeKind, LoadDistance, Session};

use super::error::PosingError;
use super::posing::pose_readings_alone;
use super::problem::JointProblem;
use super::readings::Readings;
use super::unknowns::Unknowns;

/// Damping that leaves combinations without information where they are, and little else, column-relative.
pub(super) const FAINT_DAMPING: f64 = 1e-9;
/// Nominal torque gains are taken for wrong where they are off by more than this factor, and by lengths only where that
/// lowers the cost by so much.
const FAR_SCALE: f64 = 1.5;
const WORTHWHILE: f64 = 10.0;

/// Biases, masses, moments and placements as the unknowns of a linear problem.
pub(super) struct LinearPart<'s> {
    session: &'s Session,
    posed: JointProblem,
    /// With everything else held.
    linear: Problem,
}

impl<'s> LinearPart<'s> {
    /// `values`: from where what is linear starts.
    ///
    /// # Errors
    /// Where no problem can be posed.
    pub fn new(session: &'s Session, readings: &Readings, values: &Unknowns) -> Result<Self, PosingError> {
        let posed = pose_readings_alone(session, readings, values)?;
        let nonlinear: Vec<BlockId> = posed.problem.block_ids().filter(|id| !posed.problem.block(*id).linear).collect();
        let linear = posed.problem.holding(&nonlinear, "given by the candidate");
        Ok(LinearPart { session, posed, linear })
    }

    pub fn session(&self) -> &'s Session {
        self.session
    }

    /// The least-squares solution for the gravity and the sensors of a candidate; and the cost left.
    pub fn solve(&self, candidate: &Unknowns) -> (f64, Unknowns) {
        let layout = &self.posed.layout;
        let mut values = self.posed.initial.clone();
        values.set(layout.gravity, &candidate.gravity);
        for (ids, sensor) in layout.sensors.iter().zip(&candidate.sensors) {
            ids.iter().zip(sensor).for_each(|(id, value)| values.set(*id, &[*value]));
        }
        layout.further.iter().zip(&candidate.further).for_each(|(id, value)| values.set(*id, &[*value]));
        let Ok(mut linearization) = self.linear.linearize(&values) else { return (f64::INFINITY, candidate.clone()) };
        let scaling = linearization.column_scales();
        let mut step = vec![0.0; scaling.len()];
        let gain = linearization.damped_step(FAINT_DAMPING, &scaling, &mut step).predicted_reduction;
        let solved = self.linear.retract(&values, &step);
        (linearization.cost() - gain, layout.unknowns(&solved, candidate))
    }

    /// The same with torque gains of the size that the loads tell, where the candidate's are far from it.
    pub fn solve_to_scale(&self, candidate: &Unknowns) -> (f64, Unknowns) {
        let (cost, solved) = self.solve(candidate);
        match self.gain_scale(cost, &solved) {
            scale if (1.0 / FAR_SCALE..FAR_SCALE).contains(&scale) => (cost, solved),
            scale => self.solve(&with_gains_times(scale, candidate)),
        }
    }

    /// By what all torque gains are to be multiplied, where none is known beforehand. `one`: the cost left without that.
    ///
    /// With the gains times κ, and masses, moments and placements divided by κ, only what the loads' known masses do on known
    /// lengths changes, linearly in κ. So the cost that the linear problem leaves is a parabola in κ, and three points give its
    /// minimum. Where it is flat (no lengths), the known distance of two placements is the measure: the linear problem, which
    /// does not know it, puts them κ times as far apart.
    fn gain_scale(&self, one: f64, start: &Unknowns) -> f64 {
        let session = self.session;
        let free = |joint: &JointKnowledge| joint.of(Quantity::TorqueGain).kind == KnowledgeKind::Start;
        if session.loads.is_empty() || !session.joints.iter().all(free) {
            return 1.0;
        }
        let [(half, _), (two, _)] = [0.5, 2.0].map(|scale| self.solve(&with_gains_times(scale, start)));
        let slopes = [2.0 * (one - half), two - one];
        let curvature = (slopes[1] - slopes[0]) / 1.5;
        let scale = 1.5 / 2.0 - slopes[0] / (2.0 * curvature);
        let drop = curvature * (scale - 1.0).powi(2);
        if scale > 0.0 && drop > WORTHWHILE {
            return scale;
        }
        let apart = |known: &LoadDistance| {
            let [p, q] = known.between.map(|load| nalgebra::Vector3::from(start.loads[load]));
            (q - p).norm() / known.distance
        };
        session.pair_of_free_placements().map(apart).filter(|scale| *scale > 0.0).unwrap_or(1.0)
    }
}

fn with_gains_times(scale: f64, values: &Unknowns) -> Unknowns {
    let mut scaled = values.clone();
    scaled.sensors.iter_mut().for_each(|sensor| sensor[Quantity::TorqueGain as usize] *= scale);
    scaled
}
