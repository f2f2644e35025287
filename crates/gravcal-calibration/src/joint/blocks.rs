//! The unknowns as blocks of the joint problem.

use gravcal_estimation::{Block, BlockId, Manifold, ProblemBuilder};
use gravcal_robot_model::parameter::{Parameter, ParameterId, Quantity};
use gravcal_robot_model::session::Session;

use super::at_rest;
use super::placements::add_placements;
use super::position_unknowns::add_unknowns;
use super::problem::JointProblem;
use super::readings::Readings;
use super::sweep_moments::{SweepMoments, by_sweep};
use super::unknowns::{Layout, Unknowns};

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
    let mut further: Vec<BlockId> = Vec::with_capacity(session.further.len());
    for (index, parameter) in session.further.iter().enumerate() {
        further.push(match parameter.same_as {
            Some(same) => further[same],
            None => add(ParameterId::Further(index)),
        });
    }
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
    let tensors = add_tensors(session, readings, start, straight, builder);
    let loads = add_placements(session, &readings.carried(session), start, with_knowledge, builder);
    Layout {
        gravity,
        sensors,
        further,
        inertia,
        tensors,
        sweep_moments,
        loads,
        position_unknowns: Vec::new(),
        at_rest: None,
    }
}

/// The inertia tensors of all links and loads, where the arm moves.
fn add_tensors(
    session: &Session,
    readings: &Readings,
    start: &Unknowns,
    straight: bool,
    builder: &mut ProblemBuilder,
) -> Vec<BlockId> {
    if !session.has_windows() {
        return Vec::new();
    }
    let nominal = Unknowns::nominal(session).tensors;
    let values = if start.tensors.len() == nominal.len() { &start.tensors } else { &nominal };
    let carried = readings.carried(session);
    let links = session.robot.chain.links().iter().map(|link| (link.name.as_str(), true));
    let loads = session.loads.iter().zip(carried).map(|(load, carried)| (load.name.as_str(), carried));
    let bodies: Vec<(String, bool)> =
        links.chain(loads).map(|(name, felt)| (format!("{name}.inertia"), felt)).collect();
    let block = |((name, felt), value): ((String, bool), &[f64; 6])| {
        let block = Block::vector(name, "kg·m²", &["xx", "xy", "yy", "xz", "yz", "zz"]);
        let block = if felt && readings.any_torque(session) { block } else { block.held(NO_TORQUE) };
        builder.add_block(if straight { block.linear() } else { block }, value)
    };
    bodies.into_iter().zip(values).map(block).collect()
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
