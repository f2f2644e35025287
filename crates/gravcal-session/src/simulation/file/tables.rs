//! What `simulation.toml` may hold.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::document::OneOrMany;
use crate::robot_file::{PositionSensorTable, RobotSource, TorqueSensorTable, ValueTable};
use crate::sensor_models::ModelTable;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationTable {
    /// The robot, as in a session.
    ///
    /// Example: `robot = "robot.toml"`
    pub robot: RobotSource,
    /// Seed of the noise and the poses.
    ///
    /// Unit: none.
    /// Example: `seed = 1`
    pub seed: u64,
    /// True gravity.
    ///
    /// Example: `gravity = { direction = [0, 0, -1], magnitude_m_per_s2 = 9.80665 }`
    pub gravity: GravityTable,
    /// How torques are read.
    ///
    /// Example: `torque = { unit = "N·m", std = 0.02 }`
    pub torque: TorqueTable,
    /// How positions are read.
    ///
    /// Example: `position = { unit = "rad" }`
    pub position: PositionTable,
    /// How far joints are from where their sensors say.
    ///
    /// Default: not at all.
    /// Example: `deflection = { hold_std_deg = 0.5 }`
    #[serde(default)]
    pub deflection: DeflectionTable,
    /// Time, temperature and motion of the poses.
    ///
    /// Example: `conditions = { pose_interval_s = 2 }`
    pub conditions: Option<ConditionsTable>,
    /// Write recordings in motion in place of tables of poses.
    ///
    /// Example: `recording = { rate_hz = 1000, samples = 200, move_s = 0.4 }`
    pub recording: Option<RecordingTable>,
    /// True values of a joint's sensors.
    ///
    /// Default: nominal.
    /// Example: `joint = [{ name = "joint2" }]`
    #[serde(default)]
    pub joint: Vec<JointTable>,
    // The next three are read by `instruments`; here they are only known to be there.
    #[serde(default, rename = "force_torque_sensor")]
    _force_torque_sensor: IgnoredAny,
    #[serde(default, rename = "accelerometer")]
    _accelerometer: IgnoredAny,
    #[serde(default, rename = "instrument_truth")]
    _instrument_truth: IgnoredAny,
    /// Loads.
    ///
    /// Default: none.
    /// Example: `load = [{ name = "plate", mass_kg = 2.0, link = "link3", position_m = [0.1, 0.05, 0.0] }]`
    #[serde(default)]
    pub load: Vec<LoadTable>,
    /// Distances that the session is given.
    ///
    /// Default: none.
    /// Example: `load_distance = [{ between = ["plate-a", "plate-b"] }]`
    #[serde(default)]
    pub load_distance: Vec<LoadDistanceTable>,
    /// Sweeps of one joint.
    ///
    /// Default: none.
    /// Example: `sweep = []`
    #[serde(default)]
    pub sweep: Vec<SweepTable>,
    /// Random poses within the limits.
    ///
    /// Default: none.
    /// Example: `random = [{ file = "bare.csv", poses = 30 }]`
    #[serde(default)]
    pub random: Vec<RandomTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GravityTable {
    /// Direction in base coordinates, of any length.
    ///
    /// Unit: none.
    /// Example: `direction = [0.3, 0.1, -1.0]`
    pub direction: [f64; 3],
    /// How strong it is.
    ///
    /// Example: `magnitude_m_per_s2 = 9.80665`
    pub magnitude_m_per_s2: f64,
    /// What the session is given.
    ///
    /// Unit: none.
    /// Default: the direction itself.
    /// Example: `hemisphere = [0, 0, -1]`
    pub hemisphere: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueTable {
    /// Unit of the readings; one for all joints or a list.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "N·m"`
    pub unit: Option<OneOrMany<String>>,
    /// Standard deviation of the noise; one for all joints or a list.
    ///
    /// Unit: the reading's.
    /// Example: `std = 0.02`
    pub std: OneOrMany<f64>,
    /// A converter that rounds and cuts off.
    ///
    /// Default: none.
    /// Example: `converter = { bits = 12, range = [0, 4096] }`
    pub converter: Option<ConverterTable>,
    /// Readings with an error of their own besides.
    ///
    /// Default: none.
    /// Example: `outliers = { share = 0.01, std = 20 }`
    pub outliers: Option<OutliersTable>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutliersTable {
    /// Which share of the readings.
    ///
    /// Unit: 1.
    /// Example: `share = 0.01`
    pub share: f64,
    /// Standard deviation of their errors.
    ///
    /// Unit: the reading's.
    /// Example: `std = 20`
    pub std: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConverterTable {
    /// Resolution.
    ///
    /// Unit: bit.
    /// Example: `bits = 12`
    pub bits: u32,
    /// Readings at its lower and upper end.
    ///
    /// Unit: the reading's.
    /// Example: `range = [0, 4096]`
    pub range: [f64; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionTable {
    /// Unit of the readings; one for all joints or a list.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "rad"`
    pub unit: Option<OneOrMany<String>>,
    /// Standard deviation of the noise.
    ///
    /// Unit: the reading's.
    /// Default: exact.
    /// Example: `std = 0.001`
    pub std: Option<OneOrMany<f64>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeflectionTable {
    /// Of joints that stand while another sweeps, one draw a sweep.
    ///
    /// Default: 0.
    /// Example: `hold_std_deg = 0.5`
    pub hold_std_deg: Option<f64>,
    /// Of joints that stand, one draw a pose.
    ///
    /// Default: 0.
    /// Example: `pose_std_deg = 0.05`
    pub pose_std_deg: Option<f64>,
    /// Whether the position sensors see it.
    ///
    /// Default: `false`.
    /// Example: `seen = true`
    #[serde(default)]
    pub seen: bool,
    /// In proportion to the torque that carries the arm; one for all joints or a list. Negative for joints that sag under it, as gears do.
    ///
    /// Default: 0.
    /// Example: `compliance_rad_per_newton_metre = -1e-4`
    pub compliance_rad_per_newton_metre: Option<OneOrMany<f64>>,
}

/// How the arm moves from pose to pose, and how it is recorded.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingTable {
    /// Samples a second.
    ///
    /// Example: `rate_hz = 1000`
    pub rate_hz: f64,
    /// Samples of each standstill after settling; with `motion`, of each stretch. `torque.std` stays that of the mean of so many.
    ///
    /// Unit: samples.
    /// Example: `samples = 200`
    pub samples: usize,
    /// How long a move takes; with `motion`, how long nothing is recorded between two stretches, 1 s at least. A move needs the torques of
    /// gravity and of the arm's inertia where the robot's file states inertia tensors; else those of gravity alone, and the recording is for
    /// `readings.still` only.
    ///
    /// Example: `move_s = 0.4`
    pub move_s: f64,
    /// How long the arm settles after it.
    ///
    /// Default: 0.
    /// Example: `settling_s = 0.2`
    pub settling_s: Option<f64>,
    /// First size of what settles, in standard deviations of a sample.
    ///
    /// Unit: standard deviations.
    /// Default: 0.
    /// Example: `vibration = 20`
    pub vibration: Option<f64>,
    /// Time constant with which it settles.
    ///
    /// Default: 0.05.
    /// Example: `settling_time_constant_s = 0.03`
    pub settling_time_constant_s: Option<f64>,
    /// Correlation time of the noise.
    ///
    /// Default: white noise.
    /// Example: `noise_correlation_s = 0.002`
    pub noise_correlation_s: Option<f64>,
    /// `"any"`: from the pose before. `"one-way"`: every joint rises to its pose. `"both-ways"`: each pose twice.
    ///
    /// Default: `"any"`.
    /// Example: `approach = "both-ways"`
    pub approach: Option<String>,
    /// The arm never stands: each joint moves on a sum of sines about the middle of its range. `poses` of a `[[random]]` or `[[sweep]]` is
    /// then how many stretches of such motion its file holds.
    ///
    /// Default: none.
    /// Example: `motion = { harmonics = 5, period_s = 10 }`
    pub motion: Option<HarmonicTable>,
    /// Every `[[sweep]]` is recorded slowly, to and fro, at this speed; `move_s` is how long it speeds up and slows down, and `samples`
    /// is what `torque.std` is of the mean of. The number of its poses is then what the session finds.
    ///
    /// Unit: deg/s.
    /// Default: it stands at each pose.
    /// Example: `sweep_deg_per_s = 4`
    pub sweep_deg_per_s: Option<f64>,
    /// Friction that stays in part where joints stand (Dahl).
    ///
    /// Default: none.
    /// Example: `friction = { coulomb_newton_metre = 0.1 }`
    pub friction: Option<FrictionTable>,
    /// Hysteresis of torque sensors.
    ///
    /// Default: none.
    /// Example: `hysteresis = { share = 0.02, over = 5 }`
    pub hysteresis: Option<HysteresisTable>,
    /// Creep of torque sensors.
    ///
    /// Default: none.
    /// Example: `creep = { share = 0.002, time_constant_s = 3 }`
    pub creep: Option<CreepTable>,
    /// Random walk of torque zeros: its size after one second; one for all joints or a list.
    ///
    /// Unit: the reading's.
    /// Default: 0.
    /// Example: `walk_per_root_s = 0.004`
    pub walk_per_root_s: Option<OneOrMany<f64>>,
    /// Share of readings that are far off.
    ///
    /// Unit: 1.
    /// Default: 0.
    /// Example: `outliers = 0.01`
    pub outliers: Option<f64>,
    /// Share of messages that are lost.
    ///
    /// Unit: 1.
    /// Default: 0.
    /// Example: `dropped = 0.01`
    pub dropped: Option<f64>,
    /// How many standstills are touched.
    ///
    /// Unit: standstills.
    /// Default: 0.
    /// Example: `touched = 2`
    pub touched: Option<usize>,
}

/// An arm that never stands. For each pose of a file there is one stretch of motion, on random trajectories of its own. It uses 90 % of each
/// joint's range; a joint without limits has one from −π to π (rad or m).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HarmonicTable {
    /// Sines in each joint's sum.
    ///
    /// Unit: none.
    /// Example: `harmonics = 5`
    pub harmonics: usize,
    /// Period of the slowest.
    ///
    /// Example: `period_s = 10`
    pub period_s: f64,
    /// Seed of their sizes and phases.
    ///
    /// Unit: none.
    /// Default: 1.
    /// Example: `seed = 2`
    pub seed: Option<u64>,
}

/// Friction that builds up before a joint slides, and stays in part where it stands (Dahl 1968).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionTable {
    /// Coulomb friction; one for all joints or a list. In N where a joint slides.
    ///
    /// Example: `coulomb_newton_metre = 0.1`
    pub coulomb_newton_metre: OneOrMany<f64>,
    /// It grows by so much of the torque that carries gravity.
    ///
    /// Unit: 1.
    /// Default: 0.
    /// Example: `per_torque = 0.02`
    pub per_torque: Option<f64>,
    /// Length over which it builds up; in m where a joint slides.
    ///
    /// Default: 2e-4.
    /// Example: `presliding_rad = 2e-4`
    pub presliding_rad: Option<f64>,
    /// Share that is left at rest, to the side of approach.
    ///
    /// Unit: 1.
    /// Default: 0.42.
    /// Example: `lean = 0.42`
    pub lean: Option<f64>,
    /// Standard deviation of that share.
    ///
    /// Unit: 1.
    /// Default: 0.25.
    /// Example: `spread = 0.25`
    pub spread: Option<f64>,
}

/// After its torque turned round a sensor lacks a share of the change, until that is so large.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HysteresisTable {
    /// Share of the change that is lacking.
    ///
    /// Unit: 1.
    /// Example: `share = 0.02`
    pub share: f64,
    /// Half of the change over which it builds up, from one side to the other; one for all joints or a list.
    ///
    /// Unit: the reading's.
    /// Example: `over = 5`
    pub over: OneOrMany<f64>,
}

/// After its torque changed a sensor lacks a share of the change, which dies away.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CreepTable {
    /// Share of the change that is lacking at first.
    ///
    /// Unit: 1.
    /// Example: `share = 0.002`
    pub share: f64,
    /// Time constant with which it dies away.
    ///
    /// Example: `time_constant_s = 3`
    pub time_constant_s: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConditionsTable {
    /// Time from pose to pose.
    ///
    /// Default: no clock.
    /// Example: `pose_interval_s = 2`
    pub pose_interval_s: Option<f64>,
    /// Temperature of the first and of the last pose.
    ///
    /// Unit: degC.
    /// Default: none.
    /// Example: `temperature_degC = [20, 30]`
    #[serde(rename = "temperature_degC")]
    pub temperature_degc: Option<[f64; 2]>,
    /// Poses are in motion, up to this speed.
    ///
    /// Default: at rest.
    /// Example: `largest_speed_rad_or_m_per_s = 0.1`
    pub largest_speed_rad_or_m_per_s: Option<f64>,
    /// Whether tables have the direction of approach.
    ///
    /// Default: `false`.
    /// Example: `direction = true`
    #[serde(default)]
    pub direction: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointTable {
    /// The joint's name.
    ///
    /// Example: `name = "joint2"`
    pub name: String,
    /// Its true torque sensor.
    ///
    /// Default: nominal.
    /// Example: `torque_sensor = { gain = { value = 1.08, unit = "N·m/(N·m)" } }`
    pub torque_sensor: Option<TorqueSensorTable>,
    /// Its true position sensor.
    ///
    /// Default: nominal.
    /// Example: `position_sensor = { gain = { value = 1.0, unit = "rad/rad" } }`
    pub position_sensor: Option<PositionSensorTable>,
    /// What its sensors do besides, with true values; the session is given the models.
    ///
    /// Default: nothing.
    /// Example: `sensor_models = [{ kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.1, unit = "N·m" } } }]`
    #[serde(default)]
    pub sensor_models: Vec<ModelTable<ValueTable>>,
    /// The same, but the session does not know of it.
    ///
    /// Default: nothing.
    /// Example: `unmodelled = []`
    #[serde(default)]
    pub unmodelled: Vec<ModelTable<ValueTable>>,
    /// In motion, what its motor turns before its gear, felt at the joint and read by its torque sensor; the session estimates it.
    ///
    /// Default: none.
    /// Example: `rotor_inertia = { value = 0.4, unit = "kg·m²" }`
    pub rotor_inertia: Option<ValueTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTable {
    /// Its name.
    ///
    /// Example: `name = "plate"`
    pub name: String,
    /// Its mass.
    ///
    /// Example: `mass_kg = 2.0`
    pub mass_kg: f64,
    /// The link that carries it.
    ///
    /// Example: `link = "link3"`
    pub link: String,
    /// Its centre of mass in that link's frame.
    ///
    /// Example: `position_m = [0.1, 0.05, 0.0]`
    pub position_m: [f64; 3],
    /// Whether the session is told the position.
    ///
    /// Default: `false`.
    /// Example: `position_known = true`
    #[serde(default)]
    pub position_known: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadDistanceTable {
    /// Names of two loads whose distance the session is given.
    ///
    /// Example: `between = ["plate-a", "plate-b"]`
    pub between: [String; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepTable {
    /// The table or recording to write.
    ///
    /// Example: `file = "bias-1.csv"`
    pub file: PathBuf,
    /// The joint that sweeps.
    ///
    /// Example: `joint = "joint1"`
    pub joint: String,
    /// From where to where.
    ///
    /// Example: `range_deg = [-90, 90]`
    pub range_deg: [f64; 2],
    /// How many poses.
    ///
    /// Unit: poses.
    /// Example: `poses = 37`
    pub poses: usize,
    /// Where the other joints stand, by name: each of them, here or in `held_rad`.
    ///
    /// Default: all of them are in `held_rad`.
    /// Example: `held_deg = { joint2 = 45 }`
    pub held_deg: Option<BTreeMap<String, f64>>,
    /// The same in radians.
    ///
    /// Default: all of them are in `held_deg`.
    /// Example: `held_rad = { joint2 = 0.785 }`
    pub held_rad: Option<BTreeMap<String, f64>>,
    /// The load that is attached.
    ///
    /// Default: nothing.
    /// Example: `load = "plate"`
    pub load: Option<String>,
    /// The step of the sequential estimator that reads it.
    ///
    /// Unit: none.
    /// Default: found.
    /// Example: `step = 2`
    pub step: Option<u8>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomTable {
    /// The table or recording to write.
    ///
    /// Example: `file = "bare.csv"`
    pub file: PathBuf,
    /// How many poses.
    ///
    /// Unit: poses.
    /// Example: `poses = 30`
    pub poses: usize,
    /// How many joints move from one pose to the next, drawn anew each time; the others stand.
    ///
    /// Unit: joints.
    /// Default: all.
    /// Example: `moving = 1`
    pub moving: Option<usize>,
    /// The load that is attached.
    ///
    /// Default: nothing.
    /// Example: `load = "plate"`
    pub load: Option<String>,
}
