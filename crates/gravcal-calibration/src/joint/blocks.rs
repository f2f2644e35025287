//! The unknowns as blocks of the joint problem.

use gravcal_estimation::{Block, Manifold, ProblemBuilder};

use super::at_rest;
use super::placements::add_placements;
use super::position_unknowns::add_unknowns;
use super::problem::JointProblem;
use super::readings::Readings;
use super::sweep_moments::{SweepMoments, by_sweep};
use super::unknowns::{Layout, Unknowns};
use crate::parameter::{Parameter, ParameterId, Quantity};
use crate::session::Session;

/// Why links are held where only instruments read: these feel nothing of them.
const NO_TORQUE: &str = "no torque of a joint is read";

/// Why a parameter is held on which no reading that enters depends.
const UNREAD: &str = "no reading depends on it";

pub(super) fn add_unknown_blocks(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
    builder: &mut ProblemBuilder,
) -> Layout {
    let layout = add_blocks(session, readings, start, true, builder);
    let position_unknowns = add_unknowns(session, readings, start, builder);
    Layout { position_unknowns, at_rest: at_rest::add_unknown(session, readings, start, builder), ..layout }
}

pub(super) fn add_blocks(
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
    Layout { gravity, sensors, further, inertia, sweep_moments, loads, position_unknowns: Vec::new(), at_rest: None }
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

impl JointProblem {
    /// The same problem started from elsewhere; that the start makes sense is seen when it is evaluated there.
    pub(super) fn starting_at(&self, session: &Session, readings: &Readings, start: &Unknowns) -> JointProblem {
        let mut builder = ProblemBuilder::new();
        add_unknown_blocks(session, readings, start, &mut builder);
        JointProblem { initial: builder.initial(), ..self.clone() }
    }
}
