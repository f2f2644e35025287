//! The joint problem: all residuals over all unknowns, every reading exactly once.
//!
//! For given gravity, gains, mountings and positions all of it is affine in the biases, the links' masses and moments and
//! the placements of loads that no distance reads: these blocks are marked as linear.

use gravcal_estimation::{
    Block, BlockId, EvaluateError, Factor, Loss, Manifold, Noise, NoiseError, Problem, ProblemBuilder, Values,
};

use super::constraints::{self, constrained};
use super::earlier::with_earlier;
use super::error::PosingError;
use super::factors::add_readings;
use super::placements::{add_placements, distances_left};
use super::position_unknowns::{add_priors, add_unknowns};
use super::readings::Readings;
use super::reference::{reference, with_reference};
use super::sweep_moments::{SweepMoments, by_sweep};
use super::unknowns::{Layout, Unknowns};
use crate::parameter::{Parameter, ParameterId, Quantity};
use crate::residuals::{GravityNorm, LoadDistance, Prior};
use crate::session::{InertiaKnowledge, Knowledge, KnowledgeKind, Session};

/// Centre of mass from which an assumed mass's moment is taken to be uncertain, m: see [`moment_std`].
const TYPICAL_LEVER: f64 = 0.1;

/// Standard deviation of an exact distance that cannot be held by the placements themselves, m.
const EXACT_DISTANCE_STD: f64 = 1e-6;

/// Why links are held where only instruments read: these feel nothing of them.
const NO_TORQUE: &str = "no torque of a joint is read";

/// Why a parameter is held on which no reading that enters depends.
const UNREAD: &str = "no reading depends on it";

/// A posed joint problem.
#[derive(Clone, Debug)]
pub struct JointProblem {
    /// The problem.
    pub problem: Problem,
    /// Its start.
    pub initial: Values,
    /// Its blocks.
    pub layout: Layout,
    /// Pose and channel of each row of a reading; these rows come first.
    pub rows: Vec<(usize, usize)>,
    /// Poses whose readings enter: so many factors come first, one each, in the order of the session.
    pub poses: usize,
    /// How these factors count readings far beyond their noise.
    pub loss: Loss,
}

impl JointProblem {
    /// What the initial values predict of each reading: pose, channel, value in the unit of the reading.
    pub(crate) fn predicted(
        &self,
        session: &Session,
        readings: &Readings,
    ) -> Result<Vec<(usize, usize, f64)>, EvaluateError> {
        let residuals = self.problem.residuals(&self.initial)?;
        let predicted = self.rows.iter().zip(residuals).filter_map(|((pose, channel), residual)| {
            let value = session.reading(*pose, *channel)?.value;
            Some((*pose, *channel, value + readings.std(session, *pose, *channel) * residual))
        });
        Ok(predicted.collect())
    }

    /// The same problem started from elsewhere; that the start makes sense is seen when it is evaluated there.
    pub(super) fn starting_at(&self, session: &Session, readings: &Readings, start: &Unknowns) -> JointProblem {
        let mut builder = ProblemBuilder::new();
        add_unknown_blocks(session, readings, start, &mut builder);
        JointProblem { initial: builder.initial(), ..self.clone() }
    }

    /// The same with its reference about its start.
    pub(super) fn resting_at_start(self) -> JointProblem {
        match self.problem.reference() {
            Some(reference) => {
                let reference = reference.centered_at(&self.initial);
                JointProblem { problem: self.problem.with_reference(reference), ..self }
            }
            None => self,
        }
    }

    /// The same problem with another loss of the readings.
    pub(crate) fn with_loss(&self, loss: Loss) -> Result<JointProblem, PosingError> {
        if loss == self.loss {
            return Ok(self.clone());
        }
        let mut factors = self.problem.factors().to_vec();
        factors[..self.poses].iter_mut().for_each(|factor| factor.loss = loss);
        Ok(JointProblem { problem: self.problem.with_factors(factors)?, loss, ..self.clone() })
    }
}

/// Poses the joint problem with the given readings, from the given start.
///
/// # Errors
/// Where there is nothing to measure or nothing unknown.
pub fn pose(session: &Session, readings: &Readings, start: &Unknowns) -> Result<JointProblem, PosingError> {
    let mut builder = ProblemBuilder::new();
    let layout = add_unknown_blocks(session, readings, start, &mut builder);
    let rows = add_readings(session, readings, &layout, &mut builder)?;
    add_knowledge(session, readings, &layout, &mut builder)?;
    let (problem, initial) = builder.build()?;
    let posed = JointProblem { problem, initial, layout, rows, poses: readings.poses(), loss: Loss::None };
    let posed = with_reference(session, readings, posed);
    match &session.earlier {
        None => Ok(posed),
        Some(earlier) => with_earlier(earlier, posed),
    }
}

/// The same under the session's constraints, from the nearest start that obeys them.
///
/// # Errors
/// As [`pose`].
pub(crate) fn pose_with_constraints(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
) -> Result<JointProblem, PosingError> {
    let mut start = start.clone();
    constraints::respect(session, &mut start);
    constrained(session, pose(session, readings, &start)?)
}

/// The same with the readings alone: no prior and nothing that needs one, no known norm, no known distance. A characteristic
/// that is bent is taken for straight, as it is where a start begins.
///
/// # Errors
/// As [`pose`].
pub(crate) fn pose_readings_alone(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
) -> Result<JointProblem, PosingError> {
    let mut builder = ProblemBuilder::new();
    let layout = add_blocks(session, readings, start, false, &mut builder);
    let rows = add_readings(session, readings, &layout, &mut builder)?;
    let (problem, initial) = builder.build()?;
    let mut nominal = ProblemBuilder::new();
    add_blocks(session, readings, &Unknowns::nominal(session), false, &mut nominal);
    let reference = reference(session, readings, &problem, &layout, nominal.initial());
    let problem = problem.with_reference(reference);
    Ok(JointProblem { problem, initial, layout, rows, poses: readings.poses(), loss: Loss::None })
}

pub(super) fn add_unknown_blocks(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
    builder: &mut ProblemBuilder,
) -> Layout {
    let layout = add_blocks(session, readings, start, true, builder);
    Layout { position_unknowns: add_unknowns(session, readings, start, builder), ..layout }
}

fn add_blocks(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
    with_knowledge: bool,
    builder: &mut ProblemBuilder,
) -> Layout {
    let straight = !with_knowledge || session.terms.are_straight();
    let gravity = builder.add_block(gravity_block(session), &start.gravity);
    let unread = if with_knowledge { readings.unread_and_unknown(session) } else { readings.unread(session) };
    let mut add = |id| {
        let block = parameter_block(&session.parameter(id));
        let block = if unread.contains(&id) { block.held(UNREAD) } else { block };
        builder.add_block(block, &[start.value(id)])
    };
    let sensors = (0..session.joints.len())
        .map(|joint| Quantity::ALL.map(|quantity| add(ParameterId::Sensor(joint, quantity))))
        .collect();
    let further = (0..session.further.len()).map(|index| add(ParameterId::Further(index))).collect();
    let inertia = session.robot.chain.links().iter().zip(&start.inertia).map(|(link, value)| {
        let mut block =
            Block::vector(link.name.clone(), "kg·m", &["mass", "first_moment.x", "first_moment.y", "first_moment.z"]);
        block.units[0] = "kg".into();
        let block = if readings.any_torque(session) { block } else { block.held(NO_TORQUE) };
        builder.add_block(if straight { block.linear() } else { block }, value)
    });
    let (inertia, sweep_moments) = if by_sweep(session) {
        let used: Vec<bool> = readings.used.iter().map(|used| !used.is_empty()).collect();
        (Vec::new(), SweepMoments::of(session).add_blocks(session, (&used, straight), start, builder))
    } else {
        (inertia.collect(), Vec::new())
    };
    let loads = add_placements(session, &readings.carried(session), start, with_knowledge, builder);
    Layout { gravity, sensors, further, inertia, sweep_moments, loads, position_unknowns: Vec::new() }
}

fn parameter_block(parameter: &Parameter) -> Block {
    let block = Block::scalar(parameter.name(), parameter.unit.clone());
    let block = if parameter.linear { block.linear() } else { block };
    match parameter.held {
        Some(reason) => block.held(reason),
        None => block,
    }
}

fn gravity_block(session: &Session) -> Block {
    let block = Block::vector("gravity", "m/s²", &["x", "y", "z"]);
    match session.gravity.magnitude_std {
        Some(_) => block,
        None => block.on(Manifold::Sphere { radius: session.gravity.magnitude }),
    }
}

fn add_knowledge(
    session: &Session,
    readings: &Readings,
    layout: &Layout,
    builder: &mut ProblemBuilder,
) -> Result<(), NoiseError> {
    if let Some(std) = session.gravity.magnitude_std {
        let residual = GravityNorm::new(layout.gravity, session.gravity.magnitude);
        builder.add_factor(Factor::new(residual, Noise::independent(&[std])?));
    }
    for id in session.parameters() {
        if let Knowledge { nominal, kind: KnowledgeKind::Prior { std } } = session.knowledge(id) {
            add_prior(builder, layout.block(id), vec![nominal], &[std])?;
        }
    }
    if let InertiaKnowledge::Model { relative_std } = &session.inertia {
        for ((link, id), relative_std) in session.robot.chain.links().iter().zip(&layout.inertia).zip(relative_std) {
            if let (Some(inertia), Some(relative_std)) = (&link.inertia, relative_std) {
                let [x, y, z] = inertia.first_moment;
                let moment = relative_std * moment_std(inertia.mass, [x, y, z]);
                let std = [relative_std * inertia.mass, moment, moment, moment];
                add_prior(builder, *id, vec![inertia.mass, x, y, z], &std)?;
            }
        }
    }
    for (load, placement) in session.loads.iter().zip(&layout.loads) {
        // A load with a position of its own is tied to no other: its placement is one block.
        if let (Some(position), Some(std), Some([id])) = (load.position, load.position_std, placement.as_deref()) {
            add_prior(builder, *id, position.to_vec(), &[std; 3])?;
        }
    }
    add_priors(layout, builder)?;
    for index in distances_left(session, &readings.carried(session)) {
        let known = &session.load_distances[index];
        if let [Some(a), Some(b)] = known.between.map(|load| layout.loads[load].clone()) {
            let residual = LoadDistance::new([a, b], known.distance);
            let std = known.std.unwrap_or(EXACT_DISTANCE_STD);
            builder.add_factor(Factor::new(residual, Noise::independent(&[std])?));
        }
    }
    Ok(())
}

fn add_prior(builder: &mut ProblemBuilder, block: BlockId, expected: Vec<f64>, std: &[f64]) -> Result<(), NoiseError> {
    builder.add_factor(Factor::new(Prior::new(block, expected), Noise::independent(std)?));
    Ok(())
}

/// Size of a first moment for a relative uncertainty, kg·m: that of the moment itself, but at least that of the
/// mass at [`TYPICAL_LEVER`], so that a moment drawn as zero is not taken as exact.
fn moment_std(mass: f64, moment: [f64; 3]) -> f64 {
    let length = moment.iter().map(|c| c * c).sum::<f64>().sqrt();
    length.max(mass * TYPICAL_LEVER)
}
