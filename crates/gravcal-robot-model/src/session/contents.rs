//! What a session holds.

use std::path::{Path, PathBuf};

use gravcal_estimation::Loss;
use gravcal_recording::{InputRole, PoseMapping};

use super::choices::{Ask, Constraints, Deflection, UncertaintyChoice, UnexplainedError};
use super::earlier::EarlierCalibration;
use super::input_file::InputFile;
use super::instrument::AuxiliarySensor;
use super::known::{GravityPrior, InertiaPrior, JointPriors, Load, LoadDistance};
use super::pose::{Pose, PoseTable};
use super::searched::Searched;
use super::solver::SolverChoice;
use crate::parameter::Parameter;
use crate::residual_models::ResidualInUse;
use crate::robot::Robot;
use crate::sensors::SensorTerms;

/// One calibration: the robot, what is known beforehand, and the static poses.
#[derive(Clone, Debug)]
pub struct Session {
    /// The robot.
    pub robot: Robot,
    /// What is known of gravity.
    pub gravity: GravityPrior,
    /// What is known of the links' masses and moments.
    pub inertia: InertiaPrior,
    /// How far the joints may sit from where the robot's description says, on the links that they hang on, one standard deviation along each axis, m;
    /// `None`: exact.
    pub length_std: Option<f64>,
    /// How far the joints' axes may be tilted against the robot's description, one standard deviation about each of two axes across their own, rad; `None`:
    /// exact.
    pub axis_std: Option<f64>,
    /// Known loads, each at one placement.
    pub loads: Vec<Load>,
    /// Known distances between placements.
    pub load_distances: Vec<LoadDistance>,
    /// One for each joint of the chain.
    pub joints: Vec<JointPriors>,
    /// What else reads gravity.
    pub instruments: Vec<AuxiliarySensor>,
    /// What sensors do beyond their affine models.
    pub terms: SensorTerms,
    /// What else was observed, by models of anyone's; only the joint estimator heeds it.
    pub residuals: Vec<ResidualInUse>,
    /// Parameters beyond the four of each joint, those of `terms` first.
    pub further: Vec<Parameter>,
    /// By joint, the place of its rotor inertia in `further`, where it has one; empty where none has. See
    /// [`Session::set_rotor_inertia`].
    pub rotors: Vec<Option<usize>>,
    /// By load, the place of its mass in `further`, where it was weighed with an error; shorter than the loads where the rest are exact.
    pub load_masses: Vec<Option<usize>>,
    /// Which columns of tables and recordings are which readings.
    pub readings: PoseMapping,
    /// One for each `[[poses]]`, then one for each `[[validation]]`.
    pub tables: Vec<PoseTable>,
    /// All static poses of all tables of `[[poses]]`, in order.
    pub poses: Vec<Pose>,
    /// Those of `[[validation]]`: they enter no fit, and are predicted by the result.
    pub validation: Vec<Pose>,
    /// By joint, where the turn begins within which its angles are taken, rad; nothing of one whose angles count as they are recorded. Empty where none is cut.
    pub turns: Vec<Option<f64>>,
    /// How far joints may be from where their position sensors say.
    pub deflection: Deflection,
    /// Static friction of each joint in recorded slow sweeps, as these show it, in the unit of its torque reading: what the joint reads while others
    /// sweep is off by some of it, the same all through a sweep. 0 of a joint that shows none; empty where nothing sweeps.
    pub static_friction: Vec<f64>,
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
    pub inputs: Vec<InputFile>,
}

impl Session {
    /// A session without loads and poses, that asks for everything and chooses nothing; `joints`: one for each of the chain.
    pub fn new(robot: Robot, gravity: GravityPrior, joints: Vec<JointPriors>) -> Session {
        Session {
            robot,
            gravity,
            inertia: InertiaPrior::Unknown,
            length_std: None,
            axis_std: None,
            loads: Vec::new(),
            load_distances: Vec::new(),
            saturated: vec![0; joints.len()],
            in_motion: vec![0; joints.len()],
            searched: Vec::new(),
            turns: Vec::new(),
            repeated: Vec::new(),
            doubts: Vec::new(),
            joints,
            instruments: Vec::new(),
            terms: SensorTerms::default(),
            residuals: Vec::new(),
            further: Vec::new(),
            rotors: Vec::new(),
            load_masses: Vec::new(),
            readings: PoseMapping::default(),
            tables: Vec::new(),
            poses: Vec::new(),
            validation: Vec::new(),
            deflection: Deflection::default(),
            static_friction: Vec::new(),
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

    /// The file that describes the robot, where one was read.
    pub fn robot_file(&self) -> Option<&Path> {
        self.inputs.iter().find(|input| input.role == InputRole::Robot).map(|input| input.path.as_path())
    }

    /// The paths of all files that were read.
    pub fn input_paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.inputs.iter().map(|input| &input.path)
    }

    /// Whether any of its poses is a window of an arm in motion, so that links' inertia tensors are unknown, too.
    pub fn has_windows(&self) -> bool {
        self.poses.iter().chain(&self.validation).any(|pose| pose.course.is_some())
    }

    /// Two placements a known distance apart, neither of which is known by itself.
    pub fn pair_of_free_placements(&self) -> Option<&LoadDistance> {
        let free = |load: &usize| self.loads[*load].position.is_none();
        self.load_distances.iter().find(|known| known.between.iter().all(free))
    }

    /// How many torque readings of each joint are left where others were left out by motion.
    pub fn selection_note(&self) -> Option<String> {
        if self.in_motion.iter().all(|count| *count == 0) {
            return None;
        }
        let left = |joint: usize| self.poses.iter().filter(|pose| pose.torque[joint].is_some()).count();
        let names = self.robot.chain.joints().iter().map(|joint| joint.name.as_str());
        let reported: Vec<String> = names
            .zip(&self.in_motion)
            .enumerate()
            .map(|(joint, (name, out))| format!("{name} {} of {}", left(joint), left(joint) + out))
            .collect();
        Some(format!("Torque readings left by the limits of motion (readings.select): {}.", reported.join(", ")))
    }
}
