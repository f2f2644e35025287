//! The joint problem: all residuals over all unknowns, every torque reading exactly once, as pose torque.
//!
//! For given gravity, torque gains and positions all of it is affine in the torque biases, the links' masses and moments and
//! the placements of loads that no distance reads: these blocks are marked as linear.

use gravcal_estimation::{
    Block, BlockId, Factor, Loss, Manifold, Noise, NoiseError, Problem, ProblemBuilder, ProblemError, Values,
};
use thiserror::Error;

use super::models::Models;
use super::placements::{add_placements, distances_left};
use super::position_unknowns::{Around, add_priors, add_unknowns};
use super::sweep_moments::{SweepMoments, by_sweep};
use super::unknowns::{Layout, Unknowns};
use crate::parameter::{Parameter, ParameterId, Quantity};
use crate::residuals::{GravityNorm, LoadDistance, Prior};
use crate::session::{InertiaKnowledge, Knowledge, KnowledgeKind, Session};

/// Centre of mass from which an assumed mass's moment is taken to be uncertain, m: see [`moment_std`].
const TYPICAL_LEVER: f64 = 0.1;

/// Standard deviation of an exact distance that cannot be held by the placements themselves, m.
const EXACT_DISTANCE_STD: f64 = 1e-6;

/// The joint problem cannot be posed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PosingError {
    /// See [`ProblemError`].
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// See [`NoiseError`].
    #[error(transparent)]
    Noise(#[from] NoiseError),
}

/// Which torque readings enter, and how uncertain they are.
#[derive(Clone, Debug)]
pub struct Readings {
    /// Joints whose torque enters, for each pose of the session.
    pub used: Vec<Vec<usize>>,
    /// Standard deviation, by joint, of readings that state none; unit of the reading.
    pub noise: Vec<f64>,
    /// How readings far beyond that are to be counted. [`pose`] leaves it to `JointProblem::with_loss`: at a start every
    /// reading looks far off.
    pub loss: Loss,
}

impl Readings {
    /// Every torque reading of the session for which `keep(pose, joint)` holds.
    pub fn select(session: &Session, noise: Vec<f64>, keep: impl Fn(usize, usize) -> bool) -> Readings {
        let used = session
            .poses
            .iter()
            .enumerate()
            .map(|(index, pose)| {
                (0..pose.torque.len()).filter(|joint| pose.torque[*joint].is_some() && keep(index, *joint)).collect()
            })
            .collect();
        Readings { used, noise, loss: session.loss }
    }

    /// How many poses have a reading that enters.
    fn poses(&self) -> usize {
        self.used.iter().filter(|used| !used.is_empty()).count()
    }

    /// Standard deviation of one reading, unit of the reading.
    pub fn std(&self, session: &Session, pose: usize, joint: usize) -> f64 {
        session.poses[pose].torque[joint].as_ref().and_then(|r| r.std).unwrap_or(self.noise[joint])
    }
}

/// A posed joint problem.
#[derive(Clone, Debug)]
pub struct JointProblem {
    /// The problem.
    pub problem: Problem,
    /// Its start.
    pub initial: Values,
    /// Its blocks.
    pub layout: Layout,
    /// Pose and joint of each torque row; these rows come first.
    pub rows: Vec<(usize, usize)>,
    /// Poses whose torques enter: so many factors come first, one each, in the order of the session.
    pub poses: usize,
    /// How these factors count readings far beyond their noise.
    pub loss: Loss,
}

impl JointProblem {
    /// The same problem with another loss of the torque readings.
    pub(crate) fn with_loss(&self, loss: Loss) -> Result<JointProblem, PosingError> {
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
    let mut layout = add_blocks(session, readings, start, true, &mut builder);
    layout.position_unknowns = add_unknowns(session, readings, start, &mut builder);
    let rows = add_pose_torques(session, readings, &layout, &mut builder)?;
    add_knowledge(session, readings, &layout, &mut builder)?;
    let (problem, initial) = builder.build()?;
    Ok(JointProblem { problem, initial, layout, rows, poses: readings.poses(), loss: Loss::None })
}

/// The same with the torque readings alone: no prior and nothing that needs one, no known norm, no known distance.
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
    let rows = add_pose_torques(session, readings, &layout, &mut builder)?;
    let (problem, initial) = builder.build()?;
    Ok(JointProblem { problem, initial, layout, rows, poses: readings.poses(), loss: Loss::None })
}

fn add_blocks(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
    exact_distances: bool,
    builder: &mut ProblemBuilder,
) -> Layout {
    let gravity = builder.add_block(gravity_block(session), &start.gravity);
    let mut add = |id| builder.add_block(parameter_block(&session.parameter(id)), &[start.value(id)]);
    let sensors = (0..session.joints.len())
        .map(|joint| Quantity::ALL.map(|quantity| add(ParameterId::Sensor(joint, quantity))))
        .collect();
    let further = (0..session.further.len()).map(|index| add(ParameterId::Further(index))).collect();
    let inertia = session.robot.chain.links().iter().zip(&start.inertia).map(|(link, value)| {
        let mut block =
            Block::vector(link.name.clone(), "kg·m", &["mass", "first_moment.x", "first_moment.y", "first_moment.z"]);
        block.units[0] = "kg".into();
        builder.add_block(block.linear(), value)
    });
    let (inertia, sweep_moments) = if by_sweep(session) {
        let used: Vec<bool> = readings.used.iter().map(|used| !used.is_empty()).collect();
        (Vec::new(), SweepMoments::of(session).add_blocks(session, &used, start, builder))
    } else {
        (inertia.collect(), Vec::new())
    };
    let loads = add_placements(session, &carried(session, readings), start, exact_distances, builder);
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

/// Which loads hang on the robot in a pose that is used.
fn carried(session: &Session, readings: &Readings) -> Vec<bool> {
    let poses = || session.poses.iter().zip(&readings.used).filter(|(_, used)| !used.is_empty());
    (0..session.loads.len()).map(|load| poses().any(|(pose, _)| pose.load == Some(load))).collect()
}

fn add_pose_torques(
    session: &Session,
    readings: &Readings,
    layout: &Layout,
    builder: &mut ProblemBuilder,
) -> Result<Vec<(usize, usize)>, NoiseError> {
    let mut models = Models::new(session, layout);
    let around = Around::new(layout, builder.initial());
    let mut rows = Vec::new();
    for (index, pose) in session.poses.iter().enumerate() {
        let used = &readings.used[index];
        if used.is_empty() {
            continue;
        }
        let values = used.iter().filter_map(|joint| Some((*joint, pose.torque[*joint].as_ref()?.value))).collect();
        let std: Vec<f64> = used.iter().map(|joint| readings.std(session, index, *joint)).collect();
        let residual = around.residual(index, models.residual(session, index, values));
        builder.add_factor(Factor { residual, noise: Noise::independent(&std)?, loss: Loss::None });
        rows.extend(used.iter().map(|joint| (index, *joint)));
    }
    Ok(rows)
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
        if let Knowledge { nominal, kind: KnowledgeKind::Prior { std } } = session.parameter(id).knowledge {
            add_prior(builder, layout.block(id), vec![nominal], &[std])?;
        }
    }
    if let InertiaKnowledge::Model { relative_std } = session.inertia {
        for (link, id) in session.robot.chain.links().iter().zip(&layout.inertia) {
            if let Some(inertia) = &link.inertia {
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
    for index in distances_left(session, &carried(session, readings)) {
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
