//! What all poses with the same load share: chain, unknowns, and which of them each torque depends on.
//!
//! Stored columns, for n joints with a coordinate of their own: gravity 3, all n of `k`, of `b`, of `s`, of `o`, then `(m, h)` of each
//! link, 3 for each part of the load's position, its mass where that is unknown, one for each term of sensors that are not affine, and `c` of each joint where
//! joints give way. A torque depends on its own gain and bias, but on many position sensors: by quantity, what it touches lies
//! together.

use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::BlockId;

use super::terms::Terms;
use crate::parameter::SensorParameter;
use crate::sensors::SensorTerms;

/// Stored columns of gravity.
pub(super) const GRAVITY: usize = 3;
/// Stored columns of one joint's sensors, and of one link's mass and first moment.
const SENSORS: usize = 4;
pub(super) const INERTIA: usize = 4;
/// Numbers of an inertia tensor, and of a link in motion.
pub(super) const TENSOR: usize = 6;
pub(super) const BODY: usize = INERTIA + TENSOR;

/// Blocks of a [`PoseTorque`](super::PoseTorque), shared by all poses.
#[derive(Clone, Debug)]
pub struct PoseTorqueBlocks {
    /// g in base coordinates, m/s².
    pub gravity: BlockId,
    /// `[k, b, s, o]` of each joint.
    pub sensors: Vec<[BlockId; 4]>,
    /// `(m, h_x, h_y, h_z)` of each link.
    pub inertia: Vec<BlockId>,
    /// The parameter of each term of sensors that are not affine.
    pub terms: Vec<BlockId>,
    /// `c` of each joint; empty where none gives way.
    pub compliance: Vec<BlockId>,
}

/// A load that hangs on the robot during a pose.
#[derive(Clone, Debug)]
pub struct CarriedLoad {
    /// Blocks whose sum is its centre of mass in the link's frame, m.
    pub position: Vec<BlockId>,
    /// How heavy it is.
    pub mass: LoadMass,
    /// Index of the link.
    pub link: usize,
}

/// How heavy a load is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadMass {
    /// Exactly so many kg.
    Known(f64),
    /// A block of one number, kg.
    Unknown(BlockId),
}

/// A load at the values of one evaluation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadState {
    /// kg.
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    pub position: [f64; 3],
}

impl CarriedLoad {
    /// Its blocks, in the order in which they are stored.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = BlockId> {
        let mass = match self.mass {
            LoadMass::Known(_) => None,
            LoadMass::Unknown(block) => Some(block),
        };
        self.position.iter().copied().chain(mass)
    }

    /// How many numbers store its position.
    pub(crate) fn position_columns(&self) -> usize {
        3 * self.position.len()
    }

    /// How many numbers store it.
    pub(crate) fn columns(&self) -> usize {
        self.position_columns() + usize::from(matches!(self.mass, LoadMass::Unknown(_)))
    }

    /// It at these numbers, which begin with those that store it.
    pub(crate) fn at(&self, stored: &[f64]) -> LoadState {
        let (parts, rest) = stored.split_at(self.position_columns());
        let mass = match self.mass {
            LoadMass::Known(mass) => mass,
            LoadMass::Unknown(_) => rest[0],
        };
        let (parts, _) = parts.as_chunks::<3>();
        let mut position = [0.0; 3];
        parts.iter().for_each(|part| position.iter_mut().zip(part).for_each(|(sum, r)| *sum += r));
        LoadState { mass, position }
    }
}

/// What all poses with the same load share.
#[derive(Debug)]
pub struct PoseTorqueModel {
    pub(crate) chain: Arc<Chain>,
    pub(crate) blocks: Vec<BlockId>,
    pub(super) load: Option<CarriedLoad>,
    /// `None` where all sensors are affine.
    pub(super) terms: Option<Terms>,
    /// Stored columns before those of the terms.
    pub(super) affine_columns: usize,
    /// All stored columns.
    pub(super) columns: usize,
    /// First stored column of the compliances, where joints give way.
    pub(super) compliance: Option<usize>,
    /// Stored columns that each joint's torque can touch.
    pub(crate) patterns: Vec<Vec<Range<usize>>>,
    /// From the first to the last of the links that each joint's torque can feel.
    pub(super) links: Vec<Range<usize>>,
}

impl PoseTorqueModel {
    /// The chain, its unknowns, what its sensors do beyond gain and bias, and the load it carries.
    pub fn new(
        chain: Arc<Chain>,
        blocks: &PoseTorqueBlocks,
        functions: &SensorTerms,
        load: Option<CarriedLoad>,
    ) -> Self {
        let mut order = vec![blocks.gravity];
        (0..SENSORS).for_each(|quantity| order.extend(blocks.sensors.iter().map(|own| own[quantity])));
        order.extend(&blocks.inertia);
        order.extend(load.iter().flat_map(CarriedLoad::blocks));
        order.extend(&blocks.terms);
        order.extend(&blocks.compliance);
        let joints = chain.joint_count();
        let end = inertia_column(joints, chain.link_count()) + load.as_ref().map_or(0, CarriedLoad::columns);
        let gives_way = !blocks.compliance.is_empty();
        let terms = (!functions.is_empty()).then(|| Terms::new(functions.clone(), joints, end, gives_way));
        let compliance = gives_way.then_some(end + functions.len());
        let affine = |joint| pattern(&chain, compliance.is_some(), joint, end);
        let of_joint = |joint| match &terms {
            None => affine(joint),
            Some(terms) => pattern_with_terms(joint, terms, end + functions.len(), affine),
        };
        let compliances = compliance.map(|column| column..column + joints);
        let patterns =
            (0..joints).map(|joint| joined(of_joint(joint).into_iter().chain(compliances.clone()))).collect();
        let links = (0..joints).map(|joint| links_beyond(&chain, compliance.is_some(), joint)).collect();
        let columns = end + functions.len() + blocks.compliance.len();
        PoseTorqueModel { chain, blocks: order, load, patterns, links, terms, affine_columns: end, columns, compliance }
    }

    /// Whether all sensors are affine, and no joint gives way.
    pub(super) fn is_affine(&self) -> bool {
        self.terms.is_none() && self.compliance.is_none()
    }

    /// Whether poses can be evaluated in a batch: no joint gives way or mimics another, and each sensor reads its own joint's torque alone.
    pub(super) fn goes_in_batch(&self) -> bool {
        // Where joints mimic others, rows are sums.
        let direct = self.chain.joint_count() == self.chain.link_count() && self.compliance.is_none();
        direct && self.terms.as_ref().is_none_or(Terms::read_own_torques)
    }

    /// Indices of the links' blocks.
    pub(crate) fn inertia_blocks(&self) -> Range<usize> {
        let first = 1 + SENSORS * self.chain.joint_count();
        first..first + self.chain.link_count()
    }

    /// How many numbers store a block.
    pub(crate) fn stored_length(&self, block: usize) -> usize {
        match block {
            0 => GRAVITY,
            _ if block < self.inertia_blocks().start => 1,
            _ if block < self.inertia_blocks().end => INERTIA,
            _ if block < self.inertia_blocks().end + self.load.as_ref().map_or(0, |load| load.position.len()) => 3,
            _ => 1,
        }
    }
}

/// Stored column of one parameter of a joint's sensors, for so many joints; with `joint == joints`, the end of its like.
pub(super) fn sensor_column(joints: usize, quantity: SensorParameter, joint: usize) -> usize {
    GRAVITY + joints * quantity as usize + joint
}

/// First stored column of a link's mass and moment; with `link` the number of links, of the load's position.
pub(super) fn inertia_column(joints: usize, link: usize) -> usize {
    GRAVITY + SENSORS * joints + INERTIA * link
}

/// Columns up to `end` that a joint's torque can touch: its own gain and bias but not the others', positions of joints with
/// which it moves something, links that it moves. A joint that gives way under what hangs beyond it moves what hangs beyond
/// all others.
fn pattern(chain: &Chain, gives_way: bool, joint: usize, end: usize) -> Vec<Range<usize>> {
    let joints = chain.joint_count();
    let column = |quantity, joint| {
        let column = sensor_column(joints, quantity, joint);
        column..column + 1
    };
    let own = [SensorParameter::TorqueGain, SensorParameter::TorqueBias].map(|quantity| column(quantity, joint));
    let meeting = |quantity| {
        let others = (0..joints).filter(|other| gives_way || chain.meet(joint, *other));
        others.map(move |other| column(quantity, other))
    };
    let positions = meeting(SensorParameter::PositionGain).chain(meeting(SensorParameter::PositionOffset));
    let links = (0..chain.link_count()).filter(|link| gives_way || chain.moves(joint, *link));
    let links = links.map(|link| inertia_column(joints, link)..inertia_column(joints, link + 1));
    let load = inertia_column(joints, chain.link_count())..end;
    joined(std::iter::once(0..GRAVITY).chain(own).chain(positions).chain(links).chain(std::iter::once(load)))
}

/// The same links as a range.
fn links_beyond(chain: &Chain, gives_way: bool, joint: usize) -> Range<usize> {
    let felt = |link: &usize| gives_way || chain.moves(joint, *link);
    let first = (0..chain.link_count()).find(felt).unwrap_or(0);
    let last = (0..chain.link_count()).rfind(felt).unwrap_or(0);
    first..last + 1
}

/// Ranges in order, those that meet as one.
pub(crate) fn joined(ranges: impl Iterator<Item = Range<usize>>) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => joined.push(range),
        }
    }
    joined
}

/// The same with the joint's terms: a torque that the sensor reads besides its own has the columns of that, but for the
/// other sensor's gain and bias.
fn pattern_with_terms(
    joint: usize,
    terms: &Terms,
    width: usize,
    affine: impl Fn(usize) -> Vec<Range<usize>>,
) -> Vec<Range<usize>> {
    let joints = terms.joints;
    let mut touched = vec![false; width];
    for source in terms.torques(joint).iter().copied().filter(|source| *source != joint) {
        affine(source).into_iter().flatten().for_each(|column| touched[column] = true);
        for quantity in [SensorParameter::TorqueGain, SensorParameter::TorqueBias] {
            touched[sensor_column(joints, quantity, source)] = false;
        }
    }
    for moved in terms.coordinates(joint) {
        for quantity in [SensorParameter::PositionGain, SensorParameter::PositionOffset] {
            touched[sensor_column(joints, quantity, *moved)] = true;
        }
    }
    affine(joint).into_iter().flatten().chain(terms.columns(joint)).for_each(|column| touched[column] = true);
    joined((0..width).filter(|column| touched[*column]).map(|column| column..column + 1))
}

/// `sum += weight · terms`, entry by entry.
pub(super) fn add(sum: &mut [f64], weight: f64, terms: &[f64]) {
    sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
}
