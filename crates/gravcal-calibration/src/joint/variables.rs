//! Which block of a joint problem is which unknown.

use gravcal_estimation::{Block, BlockId, Factor, Noise, NoiseError, ProblemBuilder, Values};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::residuals::Prior;

pub use gravcal_robot_model::State;

use crate::joint::building::static_friction::StaticFriction;

/// The blocks of a joint problem.
#[derive(Clone, Debug)]
pub struct VariableIndex {
    /// Gravity.
    pub gravity: BlockId,
    /// `[k, b, s, o]` of each joint.
    pub sensors: Vec<[BlockId; 4]>,
    /// The further parameters, in the order of [`Session::further`](gravcal_robot_model::Session::further); one that several share more
    /// than once.
    pub further: Vec<BlockId>,
    /// `(m, h)` of each link; empty where moments are described by sweep.
    pub inertia: Vec<BlockId>,
    /// The inertia tensor of each link, then of each load; empty where the arm never moves.
    pub tensors: Vec<BlockId>,
    /// By load: the link with it, where it is unknown and read. Mass and first moment, then the tensor where the arm moves.
    pub with_payloads: Vec<Option<WithPayload>>,
    /// The rotor inertias that there are; they are further parameters, too.
    pub rotors: Vec<BlockId>,
    /// The moments of the sweep description; empty without it.
    pub sweep_moments: Vec<BlockId>,
    /// For each load the blocks whose sum is its position; `None` where no pose that is used carries it.
    pub loads: Vec<Option<Vec<BlockId>>>,
    /// Errors of positions: deflections of sweeps first, then those of single poses.
    pub position_unknowns: Vec<PositionUnknown>,
    /// What static friction adds to what joints read while others sweep, where it is an unknown; unit of the torque reading.
    pub static_friction: Option<StaticFriction>,
    /// What friction leaves at rest, where it is an unknown; unit of the torque reading.
    pub at_rest: Option<OfJoints>,
    /// By how much more that is where a joint carries twice as much as in the mean, where that is an unknown; unit of the torque reading.
    pub growing_friction: Option<OfJoints>,
    /// By stay of a joint that several readings share, the error that lasts through it, where that is an unknown; unit of the torque reading.
    pub lasting: Vec<Option<BlockId>>,
    /// How far joints bend under their torque, where that is an unknown; rad/(N·m).
    pub bending: Option<OfJoints>,
    /// How far joints sit from where the robot's description has them, where that is an unknown.
    pub lengths: Option<JointDisplacements>,
    /// How far the joints' axes are tilted against the robot's description, where that is an unknown.
    pub axes: Option<JointDisplacements>,
}

impl VariableIndex {
    /// Deflections that several poses share.
    fn deflections_of_sweeps(&self) -> impl Iterator<Item = &PositionUnknown> {
        self.position_unknowns.iter().filter(|unknown| unknown.is_hold && unknown.poses.len() > 1)
    }

    /// The blocks of the further parameters, each once.
    pub(crate) fn further_once(&self) -> impl Iterator<Item = BlockId> {
        let is_first = |place: &usize| !self.further[..*place].contains(&self.further[*place]);
        (0..self.further.len()).filter(is_first).map(|place| self.further[place])
    }

    /// The values of one solution; `fallback`: of what has no block.
    pub(crate) fn state(&self, values: &Values, fallback: &State) -> State {
        let vector = |id: BlockId| [values.get(id)[0], values.get(id)[1], values.get(id)[2]];
        let position = |placement: &Placement| {
            let parts: Vec<[f64; 3]> = placement.iter().map(|id| vector(*id)).collect();
            [0, 1, 2].map(|axis| parts.iter().map(|part| part[axis]).sum())
        };
        let inertia = |id: &BlockId| std::array::from_fn(|i| values.get(*id)[i]);
        State {
            gravity: vector(self.gravity),
            sensors: self.sensors.iter().map(|ids| ids.map(|id| values.scalar(id))).collect(),
            further: self.further.iter().map(|id| values.scalar(*id)).collect(),
            inertia: match self.inertia.as_slice() {
                [] => fallback.inertia.clone(),
                links => links.iter().map(inertia).collect(),
            },
            tensors: match self.tensors.as_slice() {
                [] => fallback.tensors.clone(),
                tensors => tensors.iter().map(|id| std::array::from_fn(|i| values.get(*id)[i])).collect(),
            },
            with_payloads: self.bodies_with_payloads(values, fallback),
            sweep_moments: self.sweep_moments.iter().map(|id| values.get(*id).to_vec()).collect(),
            loads: self.loads.iter().zip(&fallback.loads).map(|(p, f)| p.as_ref().map_or(*f, position)).collect(),
            deflections: self.deflections_of_sweeps().map(|u| values.get(u.block).to_vec()).collect(),
            static_friction: self
                .static_friction
                .as_ref()
                .map_or_else(Vec::new, |friction| friction.values(values, self.sensors.len())),
            at_rest: self.by_joint(self.at_rest.as_ref(), values),
            growing_friction: self.by_joint(self.growing_friction.as_ref(), values),
            bending: self.by_joint(self.bending.as_ref(), values),
            lengths: self.lengths.as_ref().map_or_else(Vec::new, |lengths| values.get(lengths.block).to_vec()),
            axes: self.axes.as_ref().map_or_else(Vec::new, |axes| values.get(axes.block).to_vec()),
        }
    }

    /// Ten numbers of each link with an unknown load; what is not read as the fallback has it.
    fn bodies_with_payloads(&self, values: &Values, fallback: &State) -> Vec<[f64; 10]> {
        let mut bodies = fallback.with_payloads.clone();
        let unknown = self.with_payloads.iter().flatten();
        for WithPayload { index, moments, tensor } in unknown {
            let Some(body) = bodies.get_mut(*index) else { continue };
            body[..4].copy_from_slice(values.get(*moments));
            if let Some(tensor) = tensor {
                body[4..].copy_from_slice(values.get(*tensor));
            }
        }
        bodies
    }

    /// The numbers of all joints, zero of those that have none; empty where none has.
    fn by_joint(&self, unknown: Option<&OfJoints>, values: &Values) -> Vec<f64> {
        unknown.map_or_else(Vec::new, |unknown| unknown.by_joint(values, self.sensors.len()))
    }

    /// The block of a parameter.
    pub fn block(&self, id: ParameterId) -> BlockId {
        match id {
            ParameterId::Sensor(joint, quantity) => self.sensors[joint][quantity as usize],
            ParameterId::Further(index) => self.further[index],
        }
    }
}

/// A link with an unknown load.
#[derive(Clone, Copy, Debug)]
pub struct WithPayload {
    /// Among the unknown loads.
    pub index: usize,
    /// Mass and first moment.
    pub moments: BlockId,
    /// About the link's origin, where the arm moves.
    pub tensor: Option<BlockId>,
}

/// The blocks whose sum is a load's position.
pub(crate) type Placement = Vec<BlockId>;

/// An unknown error of the positions of some joints, shared by some poses.
#[derive(Clone, Debug)]
pub struct PositionUnknown {
    /// One number for each of `joints`, rad (m for a joint that slides).
    pub block: BlockId,
    /// The joints that may be elsewhere.
    pub joints: Vec<usize>,
    /// How far, before any torque is read: one standard deviation each.
    pub std: Vec<f64>,
    /// The poses that share it.
    pub poses: Vec<usize>,
    /// Whether it is that of a hold, and not of a single pose's readings.
    pub is_hold: bool,
}

/// How far joints are from where the robot's description has them, on the links that they hang on: how far aside, or how far tilted.
#[derive(Clone, Debug)]
pub struct JointDisplacements {
    /// As many numbers for each of `links`: aside m, along the three axes of the link that its joint hangs on; tilted rad, about two axes across its own.
    pub block: BlockId,
    /// The links that these joints move.
    pub links: Vec<usize>,
    /// How many numbers each has.
    pub each: usize,
    /// One standard deviation of each number, m or rad.
    pub std: f64,
}

impl JointDisplacements {
    /// How many numbers there are.
    pub fn numbers(&self) -> usize {
        self.each * self.links.len()
    }

    /// The link whose joint a number is of, and which number of it.
    pub fn link_of(&self, number: usize) -> (usize, usize) {
        (self.links[number / self.each], number % self.each)
    }
}

/// A number of some joints that no one declares and that errors of the model call for: friction that is left at rest, how far joints bend.
#[derive(Clone, Debug)]
pub struct OfJoints {
    /// One number for each of `joints`.
    pub block: BlockId,
    /// The joints that have it.
    pub joints: Vec<usize>,
    /// One standard deviation each, before any torque is read.
    pub std: Vec<f64>,
}

impl OfJoints {
    /// Adds the unknown of all joints whose standard deviation is positive, from where `start` has it, by joint; nothing where there are none.
    pub(super) fn add(
        block: impl FnOnce(&[usize]) -> Block,
        std: &[f64],
        start: &[f64],
        builder: &mut ProblemBuilder,
    ) -> Option<OfJoints> {
        let all = std.iter().copied().enumerate();
        let (joints, std): (Vec<usize>, Vec<f64>) = all.filter(|(_, std)| *std > 0.0).unzip();
        if joints.is_empty() {
            return None;
        }
        let start: Vec<f64> = joints.iter().map(|joint| start.get(*joint).copied().unwrap_or(0.0)).collect();
        let block = builder.add_block(block(&joints), &start);
        Some(OfJoints { block, joints, std })
    }

    /// Adds what is known of it beforehand: zero, give or take its standard deviations.
    pub(super) fn add_prior(&self, builder: &mut ProblemBuilder) -> Result<(), NoiseError> {
        let prior = Prior::new(self.block, vec![0.0; self.std.len()]);
        builder.add_factor(Factor::new(prior, Noise::independent(&self.std)?));
        Ok(())
    }

    /// Place of a joint's number in the block.
    pub(super) fn place(&self, joint: usize) -> Option<usize> {
        self.joints.iter().position(|other| *other == joint)
    }

    pub(super) fn by_joint(&self, values: &Values, joints: usize) -> Vec<f64> {
        let mut of_joints = vec![0.0; joints];
        self.joints.iter().zip(values.get(self.block)).for_each(|(joint, value)| of_joints[*joint] = *value);
        of_joints
    }
}
