//! A session: everything that a user says of one calibration, resolved and checked. Inside: SI and radians.

mod channels;
pub(crate) mod compliance;
mod doubts;
mod draft;
mod earlier;
mod file;
mod instrument;
mod knowledge;
pub(crate) mod parameters;
mod repeated;
mod searched;
mod solver;
pub(crate) mod travel;
mod unexplained;
pub(crate) mod units;

use std::path::PathBuf;

use gravcal_estimation::Loss;
use gravcal_kinematics::{Chain, Transform};
use gravcal_recording::{Conditions, Orientation, PoseMapping, PositionUnit, Reading, TorqueUnit};

use crate::parameter::{Parameter, Quantity};
use crate::robot::Robot;
use crate::sensors::SensorTerms;

pub use doubts::MistakenUnit;
pub use draft::{Draft, DraftError, DraftPoses, DraftRobot, RecordedJoints};
pub use earlier::{EarlierCalibration, KnownCombination};
pub use file::SessionError;
pub(crate) use file::{AccelerometerTable, ForceTorqueTable, Instruments, read_instruments};
pub use instrument::{Drift, Instrument, InstrumentKind};
pub use knowledge::{Knowledge, KnowledgeKind};
pub use searched::Searched;
pub use solver::SolverChoice;
pub use unexplained::UnexplainedError;

/// One calibration: the robot, what is known beforehand, and the static poses.
#[derive(Clone, Debug)]
pub struct Session {
    /// The robot.
    pub robot: Robot,
    /// What is known of gravity.
    pub gravity: GravityKnowledge,
    /// What is known of the links' masses and moments.
    pub inertia: InertiaKnowledge,
    /// Known loads, each at one placement.
    pub loads: Vec<Load>,
    /// Known distances between placements.
    pub load_distances: Vec<LoadDistance>,
    /// One for each joint of the chain.
    pub joints: Vec<JointKnowledge>,
    /// What else reads gravity.
    pub instruments: Vec<Instrument>,
    /// What sensors do beyond their affine models.
    pub terms: SensorTerms,
    /// Parameters beyond the four of each joint, those of `terms` first.
    pub further: Vec<Parameter>,
    /// Which columns of tables and recordings are which readings.
    pub readings: PoseMapping,
    /// One for each `[[poses]]`, then one for each `[[validation]]`.
    pub tables: Vec<PoseTable>,
    /// All static poses of all tables of `[[poses]]`, in order.
    pub poses: Vec<Pose>,
    /// Those of `[[validation]]`: they enter no fit, and are predicted by the result.
    pub validation: Vec<Pose>,
    /// How far joints may be from where their position sensors say.
    pub deflection: Deflection,
    /// How many torque readings of each joint were left out because they are at an end of the sensor's range.
    pub saturated: Vec<usize>,
    /// How many torque readings of each joint were left out because the arm or the joint moved otherwise than
    /// `[readings.select]` demands.
    pub in_motion: Vec<usize>,
    /// By pose that was read, whether it repeats an earlier one in every number; empty of poses that were not.
    pub repeated: Vec<bool>,
    /// What of all that can hardly be so, in sentences: units that do not fit, rows of an arm in motion taken as static poses. Empty of
    /// sessions that were not read.
    pub doubts: Vec<String>,
    /// What was found in recordings in motion, where poses come from such, and what was lost of files.
    pub searched: Vec<Searched>,
    /// By channel, errors of readings that their noise does not explain, as said; empty where there are none. See
    /// [`Session::unexplained_errors`].
    pub unexplained: Vec<UnexplainedError>,
    /// How the joint estimator counts torque readings far beyond their noise.
    pub loss: Loss,
    /// Where the joint estimator's standard deviations come from.
    pub uncertainty: UncertaintyChoice,
    /// What the joint estimate must obey.
    pub constraints: Constraints,
    /// What an earlier calibration knows; only the joint estimator heeds it.
    pub earlier: Option<EarlierCalibration>,
    /// Changes to what is asked for.
    pub ask: Ask,
    /// Estimators to run, by name; empty for the default.
    pub estimators: Vec<String>,
    /// The solver with its options, where the session chooses one.
    pub solver: Option<SolverChoice>,
    /// Every file that was read, for the record of where a result comes from.
    pub inputs: Vec<PathBuf>,
}

impl Session {
    /// A session without loads and poses, that asks for everything and chooses nothing; `joints`: one for each of the chain.
    pub fn new(robot: Robot, gravity: GravityKnowledge, joints: Vec<JointKnowledge>) -> Session {
        Session {
            robot,
            gravity,
            inertia: InertiaKnowledge::Unknown,
            loads: Vec::new(),
            load_distances: Vec::new(),
            saturated: vec![0; joints.len()],
            in_motion: vec![0; joints.len()],
            searched: Vec::new(),
            repeated: Vec::new(),
            doubts: Vec::new(),
            joints,
            instruments: Vec::new(),
            terms: SensorTerms::default(),
            further: Vec::new(),
            readings: PoseMapping::default(),
            tables: Vec::new(),
            poses: Vec::new(),
            validation: Vec::new(),
            deflection: Deflection::default(),
            unexplained: Vec::new(),
            loss: Loss::None,
            uncertainty: UncertaintyChoice::default(),
            constraints: Constraints::default(),
            earlier: None,
            ask: Ask::default(),
            estimators: Vec::new(),
            solver: None,
            inputs: Vec::new(),
        }
    }

    /// Two placements a known distance apart, neither of which is known by itself.
    pub(crate) fn pair_of_free_placements(&self) -> Option<&LoadDistance> {
        let free = |load: &usize| self.loads[*load].position.is_none();
        self.load_distances.iter().find(|known| known.between.iter().all(free))
    }

    /// How many torque readings of each joint are left where others were left out by motion.
    pub(crate) fn selection_note(&self) -> Option<String> {
        if self.in_motion.iter().all(|count| *count == 0) {
            return None;
        }
        let left = |joint: usize| self.poses.iter().filter(|pose| pose.torque[joint].is_some()).count();
        let names = self.robot.chain.joints().iter().map(|joint| joint.name.as_str());
        let told: Vec<String> = names
            .zip(&self.in_motion)
            .enumerate()
            .map(|(joint, (name, out))| format!("{name} {} of {}", left(joint), left(joint) + out))
            .collect();
        Some(format!("Torque readings left by the limits of motion (readings.select): {}.", told.join(", ")))
    }
}

/// What is known of gravity beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityKnowledge {
    /// ‖g‖, m/s².
    pub magnitude: f64,
    /// Standard deviation of the magnitude, m/s²; `None` where it is taken as exact (gravity on the sphere).
    pub magnitude_std: Option<f64>,
    /// Rough direction of gravity in base coordinates, of unit length: settles the sign. `None`: it is sought everywhere.
    pub hemisphere: Option<[f64; 3]>,
}

impl GravityKnowledge {
    /// Gravity as it is assumed before anything is estimated: along the declared direction, or that of an upright base.
    pub(crate) fn assumed(&self) -> [f64; 3] {
        self.hemisphere.unwrap_or([0.0, 0.0, -1.0]).map(|component| self.magnitude * component)
    }
}

/// What is known of the links' masses and first moments.
#[derive(Clone, Debug, PartialEq)]
pub enum InertiaKnowledge {
    /// Nothing: the robot's values are only a start.
    Unknown,
    /// The robot's values of some links, as a prior.
    Model {
        /// Standard deviation relative to each value, by link, for example 0.1; `None`: nothing is known of the link.
        relative_std: Vec<Option<f64>>,
    },
    /// Nothing, and lengths are not used either: what hangs beyond each joint has a moment of its own in each sweep.
    Sweep,
}

/// A load of known mass at one placement.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Name.
    pub name: String,
    /// kg.
    pub mass: f64,
    /// Index of the link that carries it.
    pub link: usize,
    /// Its centre of mass in the link's frame, m, where known.
    pub position: Option<[f64; 3]>,
    /// Standard deviation of each component of `position`, m; `None` with a position: exact.
    pub position_std: Option<f64>,
}

/// A known distance between the centres of mass of two placements.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadDistance {
    /// Indices of the loads; both on one link.
    pub between: [usize; 2],
    /// m.
    pub distance: f64,
    /// Standard deviation, m; `None`: exact.
    pub std: Option<f64>,
}

/// What is known of one joint's sensors beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct JointKnowledge {
    /// Unit of the torque reading; `None` where the joint has no torque sensor.
    pub torque_unit: Option<TorqueUnit>,
    /// Whether the session says which way the torque sensor reads; where not, it is looked for.
    pub torque_sign_declared: bool,
    /// Unit of the position reading.
    pub position_unit: PositionUnit,
    /// Knowledge of each parameter, in the order of [`Quantity::ALL`].
    pub parameters: [Knowledge; 4],
}

impl JointKnowledge {
    /// What is known of one parameter of the joint.
    pub fn of(&self, quantity: Quantity) -> Knowledge {
        self.parameters[quantity as usize]
    }
}

/// One `[[poses]]` or `[[validation]]` of the session.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTable {
    /// The file.
    pub path: PathBuf,
    /// Index of the load attached, if any.
    pub load: Option<usize>,
    /// Index of the swept joint, where declared.
    pub swept: Option<usize>,
    /// The step of the sequential procedure that may read its sweeps; `None`: every step that can.
    pub step: Option<u8>,
}

/// One static pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Index into [`Session::tables`].
    pub table: usize,
    /// Line of the file.
    pub line: u64,
    /// Label of the declared sweep, where a column gives one.
    pub sweep_label: Option<String>,
    /// Index of the load attached, if any.
    pub load: Option<usize>,
    /// Position readings (rad, m, or the sensor's own unit).
    pub position: Vec<f64>,
    /// Rotation of the body that carries the instruments in the base's frame, where there are no joints.
    pub orientation: Option<Orientation>,
    /// Torque readings, absent where missing or unusable.
    pub torque: Vec<Option<Reading>>,
    /// Readings of the axes of all instruments, absent where missing or unusable.
    pub instruments: Vec<Option<Reading>>,
    /// Under which conditions they were read; time counts from the session's first pose.
    pub conditions: Conditions,
}

impl Pose {
    /// Frames of all links in the base's, at these coordinates of the joints (rad or m), or as a body without joints stood.
    pub fn link_frames(&self, chain: &Chain, coordinates: &[f64]) -> Vec<Transform> {
        let frames = chain.forward(coordinates);
        // What was read is a rotation.
        let turned = self.orientation.and_then(|rotation| Transform::from_rotation(rotation, [0.0; 3]).ok());
        match turned {
            None => frames,
            Some(turned) => frames.iter().map(|frame| turned.compose(frame)).collect(),
        }
    }
}

/// How far joints may be from where their position sensors say, before any torque is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deflection {
    /// Standard deviation of the deflection of each joint that stands, the same in all poses of a sweep, rad.
    pub hold_std: Option<f64>,
    /// Standard deviation of the deflection of each joint that stands, another in each pose, rad.
    pub pose_std: Option<f64>,
    /// Standard deviation of each joint's position reading, unit of the reading; 0 (or missing) where taken as exact.
    pub reading_std: Vec<f64>,
    /// Place of the first joint's compliance in [`Session::further`], where joints give way; see
    /// [`Session::let_joints_give_way`].
    pub compliance: Option<usize>,
}

/// Where the joint estimator's standard deviations come from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum UncertaintyChoice {
    /// From the noise of the readings: the model holds. Where the readings contradict that, the larger of it, widened, and of what
    /// leaving out blocks of neighbouring poses tells.
    #[default]
    Noise,
    /// From what the estimate would be without each of some blocks of poses, which may share errors of the model.
    Jackknife {
        /// Which.
        blocks: PoseBlocks,
    },
    /// From the scatter of blocks of neighbouring poses, which may share errors of the model.
    Sandwich {
        /// Poses in a block, at least.
        block_poses: usize,
    },
    /// From solving again with such blocks drawn at random.
    Bootstrap {
        /// Poses in a block, at least.
        block_poses: usize,
        /// How often.
        replicates: usize,
        /// Which random numbers.
        seed: u64,
    },
}

/// Which poses may share an error of the model. Those of different tables never do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PoseBlocks {
    /// Neighbouring ones, as many as their residuals say.
    #[default]
    Found,
    /// So many neighbouring ones, at least.
    Poses(usize),
    /// Neighbouring ones within so many seconds.
    Seconds(f64),
    /// Those of one sweep; each of no sweep is alone.
    Sweeps,
    /// Neighbouring ones in which every joint stands as in the first: the same pose, come to from different sides.
    Pairs,
}

/// What the joint estimate must obey, whatever the readings say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constraints {
    /// Whether no link's mass may be negative.
    pub positive_masses: bool,
    /// Largest distance, m, of a link's centre of mass from the origin of its frame, by link; links beyond the end have none.
    pub center_of_mass_within: Vec<Option<f64>>,
    /// Largest difference of a torque gain from its nominal value, as a share of that.
    pub torque_gains_within: Option<f64>,
}

impl Constraints {
    /// Whether nothing is demanded.
    pub fn is_empty(&self) -> bool {
        let radii = self.center_of_mass_within.iter().any(Option::is_some);
        !(self.positive_masses || radii || self.torque_gains_within.is_some())
    }

    /// Largest distance of a link's centre of mass from its frame's origin, m.
    pub(crate) fn radius(&self, link: usize) -> Option<f64> {
        self.center_of_mass_within.get(link).copied().flatten()
    }
}

/// Changes to what is asked for; names such as `joint1.torque_gain`, `gravity`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ask {
    /// Asked for besides the default.
    pub add: Vec<String>,
    /// Not asked for.
    pub drop: Vec<String>,
}

/// Why gain and bias of a torque that is not read are held.
pub const NO_TORQUE_SENSOR: &str = "the joint has no torque sensor";
/// Why the offset of the joint on which all others hang is held.
pub const BASE_FRAME_CHOICE: &str = "it defines the base frame";
/// Why the offset of a last joint is held.
pub const LAST_FRAME_CHOICE: &str = "a choice of the last link's frame";
