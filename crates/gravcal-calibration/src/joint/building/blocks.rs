//! The unknowns as blocks of the joint problem.

use gravcal_estimation::{Block, BlockId, ProblemBuilder, Sphere};
use gravcal_robot_model::parameter::{Parameter, ParameterId, SensorParameter};
use gravcal_robot_model::session::{InertiaPrior, Load, Session};

use crate::joint::building::axes;
use crate::joint::building::bent_joints;
use crate::joint::building::lengths;
use crate::joint::building::placements::{add_placements, is_straight};
use crate::joint::building::position_unknowns::add_unknowns;
use crate::joint::building::static_friction;
use crate::joint::building::sweep_moments::{SweepMoments, by_sweep};
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::model_error::at_rest;
use crate::joint::model_error::lasting;
use crate::joint::problem::JointProblem;
use crate::joint::variables::{State, VariableIndex, WithPayload};

/// Why links are fixed where only instruments read: these feel nothing of them.
const NO_TORQUE: &str = "no torque of a joint is read";

/// Why a link is fixed that no pose reads without an unknown load on it; so is the tensor of such a load, and of one that hangs nowhere.
const NEVER_BARE: &str = "no reading tells it by itself";

/// Why a parameter is fixed on which no reading that enters depends.
const UNREAD: &str = "no reading depends on it";

pub(in crate::joint) fn add_unknown_blocks(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> VariableIndex {
    let variables = add_blocks(session, readings, start, true, builder);
    let position_unknowns = add_unknowns(session, readings, start, builder);
    let static_friction = static_friction::add_unknown(session, start, builder);
    let [at_rest, growing_friction] = at_rest::add_unknowns(session, readings, start, builder);
    let lasting = lasting::add_unknowns(session, readings, builder);
    let bending = bent_joints::add_unknown(session, readings, start, builder);
    let lengths = lengths::add_unknown(session, readings, start, builder);
    let axes = axes::add_unknown(session, readings, start, builder);
    VariableIndex {
        position_unknowns,
        static_friction,
        at_rest,
        growing_friction,
        lasting,
        bending,
        lengths,
        axes,
        ..variables
    }
}

pub(in crate::joint) fn add_blocks(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    with_prior: bool,
    builder: &mut ProblemBuilder,
) -> VariableIndex {
    let straight = !with_prior || is_straight(session);
    let gravity = builder.add_block(gravity_block(session), &start.gravity);
    let unread = if with_prior { readings.unread_and_unknown(session) } else { readings.unread(session) };
    let mut add = |id| {
        let parameter = session.parameter(id);
        // A rotor is a part of the torque, as links are; a load's mass is multiplied with its placement.
        let of_torque = matches!(id, ParameterId::Further(index) if session.rotor_of(index).is_some());
        let linear = parameter.linear && (straight || !of_torque);
        let block = parameter_block(&Parameter { linear, ..parameter });
        let block = if unread.contains(&id) { block.fixed(UNREAD) } else { block };
        builder.add_block(block, &[start.value(id)])
    };
    let sensors = (0..session.joints.len())
        .map(|joint| SensorParameter::ALL.map(|quantity| add(ParameterId::Sensor(joint, quantity))))
        .collect();
    let mut further: Vec<BlockId> = Vec::with_capacity(session.further.len());
    for (index, parameter) in session.further.iter().enumerate() {
        further.push(match parameter.same_as {
            Some(same) => further[same],
            None => add(ParameterId::Further(index)),
        });
    }
    let links = session.robot.chain.links().iter().zip(&start.inertia).enumerate();
    let inertia = links.map(|(index, (link, value))| {
        let mut block =
            Block::vector(link.name.clone(), "kg·m", &["mass", "first_moment.x", "first_moment.y", "first_moment.z"]);
        block.units[0] = "kg".into();
        let block = if readings.any_torque(session) { block } else { block.fixed(NO_TORQUE) };
        let block = if never_bare(session, readings, index) { block.fixed(NEVER_BARE) } else { block };
        builder.add_block(if straight { block.linear() } else { block }, value)
    });
    let (inertia, sweep_moments) = if by_sweep(session) {
        let used: Vec<bool> = readings.used.iter().map(|used| !used.is_empty()).collect();
        (Vec::new(), SweepMoments::of(session).add_blocks(session, (&used, straight), start, builder))
    } else {
        (inertia.collect(), Vec::new())
    };
    let tensors = add_tensors(session, readings, start, straight, builder);
    let with_payloads = add_with_payloads(session, readings, start, straight, builder);
    let known = |(load, carried): (&Load, bool)| carried && !load.is_unknown();
    let carried: Vec<bool> = session.loads.iter().zip(readings.carried(session)).map(known).collect();
    let loads = add_placements(session, &carried, start, with_prior, builder);
    let rotors = session.rotors.iter().flatten().map(|place| further[*place]).collect();
    VariableIndex {
        gravity,
        sensors,
        further,
        inertia,
        tensors,
        with_payloads,
        rotors,
        sweep_moments,
        loads,
        position_unknowns: Vec::new(),
        static_friction: None,
        at_rest: None,
        growing_friction: None,
        lasting: Vec::new(),
        bending: None,
        lengths: None,
        axes: None,
    }
}

/// The inertia tensors of all links and loads, where the arm moves.
fn add_tensors(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    straight: bool,
    builder: &mut ProblemBuilder,
) -> Vec<BlockId> {
    if !session.has_windows() {
        return Vec::new();
    }
    let nominal = State::nominal(session).tensors;
    let values = if start.tensors.len() == nominal.len() { &start.tensors } else { &nominal };
    let moved = readings.moved(session);
    let links = session.robot.chain.links().iter().enumerate();
    let links = links.map(|(index, link)| (link.name.as_str(), moves_bare(session, readings, index)));
    let loads = session.loads.iter().zip(moved);
    let loads = loads.map(|(load, moved)| (load.name.as_str(), moved && !load.is_unknown()));
    let bodies: Vec<(String, bool)> =
        links.chain(loads).map(|(name, felt)| (format!("{name}.inertia"), felt)).collect();
    let block = |((name, felt), value): ((String, bool), &[f64; 6])| {
        let block = tensor_block(name);
        let block = match (felt, readings.any_torque(session)) {
            (true, true) => block,
            (false, true) => block.fixed(NEVER_BARE),
            (_, false) => block.fixed(NO_TORQUE),
        };
        builder.add_block(if straight { block.linear() } else { block }, value)
    };
    bodies.into_iter().zip(values).map(block).collect()
}

fn tensor_block(name: String) -> Block {
    Block::vector(name, "kg·m²", &["xx", "xy", "yy", "xz", "yz", "zz"])
}

/// Links with loads of unknown mass, by load: bodies of their own.
fn add_with_payloads(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    straight: bool,
    builder: &mut ProblemBuilder,
) -> Vec<Option<WithPayload>> {
    let (carried, moved) = (readings.carried(session), readings.moved(session));
    let unknown = (0..session.loads.len()).filter(|load| session.loads[*load].is_unknown());
    let mut all = vec![None; session.loads.len()];
    let nominal = State::nominal(session).with_payloads;
    for (index, load) in unknown.enumerate().filter(|(_, load)| carried[*load]) {
        let body = start.with_payloads.get(index).unwrap_or(&nominal[index]);
        let link = &session.robot.chain.links()[session.loads[load].link].name;
        let name = format!("{link}+{}", session.loads[load].name);
        let mut add = |block: Block, value: &[f64]| {
            let block = if readings.any_torque(session) { block } else { block.fixed(NO_TORQUE) };
            builder.add_block(if straight { block.linear() } else { block }, value)
        };
        let mut block =
            Block::vector(name.clone(), "kg·m", &["mass", "first_moment.x", "first_moment.y", "first_moment.z"]);
        block.units[0] = "kg".into();
        let moments = add(block, &body[..4]);
        let tensor = moved[load].then(|| add(tensor_block(format!("{name}.inertia")), &body[4..]));
        all[load] = Some(WithPayload { index, moments, tensor });
    }
    all
}

/// Whether every pose that enters carries an unknown load on this link, so that the link by itself is read in none.
fn never_bare(session: &Session, readings: &MeasurementSet, link: usize) -> bool {
    if !session.loads.iter().any(|load| load.is_unknown() && load.link == link) {
        return false;
    }
    let joints = session.joints.len();
    let mut read = session.poses.iter().zip(&readings.used);
    !known_by_file(session, link)
        && !read.any(|(pose, used)| {
            let bare = |load: usize| !(session.loads[load].is_unknown() && session.loads[load].link == link);
            pose.load.is_none_or(bare) && used.iter().any(|channel| *channel < joints)
        })
}

/// Whether a pose in motion shows a link's tensor without an unknown load on it, or the robot's file tells it.
fn moves_bare(session: &Session, readings: &MeasurementSet, link: usize) -> bool {
    let on_it = |load: usize| session.loads[load].is_unknown() && session.loads[load].link == link;
    !(0..session.loads.len()).any(on_it)
        || known_by_file(session, link)
        || readings.moving(session).any(|pose| !pose.load.is_some_and(on_it))
}

fn known_by_file(session: &Session, link: usize) -> bool {
    matches!(&session.inertia, InertiaPrior::Model { relative_std } if relative_std[link].is_some())
}

fn parameter_block(parameter: &Parameter) -> Block {
    let block = Block::scalar(parameter.name(), parameter.unit.clone());
    let block = if parameter.linear { block.linear() } else { block };
    match parameter.fixed {
        Some(reason) => block.fixed(reason),
        None => block,
    }
}

fn gravity_block(session: &Session) -> Block {
    let block = Block::vector("gravity", "m/s²", &["x", "y", "z"]);
    match session.gravity.magnitude_std {
        Some(_) => block,
        None => block.on(Sphere { radius: session.gravity.magnitude }),
    }
}

impl JointProblem {
    /// The same problem started from elsewhere; that the start makes sense is seen when it is evaluated there.
    pub(in crate::joint) fn starting_at(&self, session: &Session, start: &State) -> JointProblem {
        let mut builder = ProblemBuilder::new();
        add_unknown_blocks(session, self.readings(), start, &mut builder);
        let mut elsewhere = self.clone();
        elsewhere.initial = builder.initial();
        elsewhere
    }
}
