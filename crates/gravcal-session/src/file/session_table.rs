//! What may stand in `session.toml`.

use serde::Deserialize;

use super::{
    ask, constraints, deflection, gravity, inertia, instruments, joints, loads, loss, poses, prior, readings,
    residuals, solver, uncertainty,
};
use crate::robot_file::RobotSource;

/// `session.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct SessionTable {
    /// The robot: a `robot.toml`, or a URDF with its base and tip link (one tip for each branch). Left away only where
    /// `readings.orientation` says how a sensor stood.
    ///
    /// Example: `robot = { urdf = "arm.urdf", base = "link_0", tip = "link_7" }`
    pub robot: Option<RobotSource>,
    /// Which estimators run.
    ///
    /// Default: `["sequential", "joint"]`.
    /// Example: `estimators = ["joint"]`
    #[serde(default)]
    pub estimators: Vec<String>,
    /// The method that minimises: its name, or a table with `name` and its options.
    ///
    /// Default: `"levenberg-marquardt"`.
    /// Example: `solver = { name = "levenberg-marquardt", max_iterations = 50 }`
    pub solver: Option<solver::Written>,
    /// What is known of gravity.
    ///
    /// Example: `gravity = { magnitude_m_per_s2 = 9.80665 }`
    pub gravity: gravity::GravityTable,
    /// What is known of the links.
    ///
    /// Default: nothing is known of them.
    /// Example: `inertia = { links = "unknown" }`
    #[serde(default)]
    pub inertia: inertia::InertiaTable,
    /// Which columns hold the readings, and in which unit.
    ///
    /// Example: `readings = { position = { columns = ["q1"], unit = "rad" } }`
    pub readings: readings::ReadingsTable,
    /// What is known of one joint's sensors. One table for each joint of which something is known.
    ///
    /// Default: nominal sensors of the robot.
    /// Example: `joint = [{ name = "joint2", torque_sign = "reversed" }]`
    #[serde(default)]
    pub joint: Vec<joints::JointTable>,
    /// The same of all joints, key by key, where their own tables do not say it.
    ///
    /// Example: `joints = { sensor_models = [{ kind = "coulomb-friction" }] }`
    pub joints: Option<joints::JointTable>,
    /// Force-torque sensors: six axes on a last link, holding what hangs beyond them.
    ///
    /// Default: none.
    /// Example: `force_torque_sensor = []`
    #[serde(default)]
    pub force_torque_sensor: Vec<instruments::ForceTorqueTable>,
    /// Accelerometers: three axes on a link.
    ///
    /// Default: none.
    /// Example: `accelerometer = []`
    #[serde(default)]
    pub accelerometer: Vec<instruments::AccelerometerTable>,
    /// What else was observed, by models that a program adds to gravcal. Joint estimator only.
    ///
    /// Default: none.
    /// Example: `residual = [{ kind = "dial-gauge", columns = { reading = "dial_m" } }]`
    #[serde(default)]
    pub residual: Vec<residuals::ResidualTable>,
    /// Loads, of known or unknown mass.
    ///
    /// Default: none.
    /// Example: `load = [{ name = "plate", mass_kg = 2.0, link = "link3" }]`
    #[serde(default)]
    pub load: Vec<loads::LoadTable>,
    /// Known distances between two placements on one link.
    ///
    /// Default: none.
    /// Example: `load_distance = [{ between = ["plate-a", "plate-b"], distance_m = 0.402 }]`
    #[serde(default)]
    pub load_distance: Vec<loads::LoadDistanceTable>,
    /// The tables of poses, or recordings. At least one.
    ///
    /// Example: `poses = [{ file = "bare.csv" }]`
    #[serde(default)]
    pub poses: Vec<poses::PosesTable>,
    /// Tables that no fit sees; the result predicts them.
    ///
    /// Default: none.
    /// Example: `validation = [{ file = "another-day.csv" }]`
    #[serde(default)]
    pub validation: Vec<poses::PosesTable>,
    /// How far joints are from where their position sensors say. Joint estimator only.
    ///
    /// Default: joints do not deflect.
    /// Example: `deflection = { hold_std_deg = 0.5 }`
    #[serde(default)]
    pub deflection: deflection::DeflectionTable,
    /// How readings far beyond their noise count. Joint estimator only.
    ///
    /// Example: `loss = { kind = "huber" }`
    pub loss: Option<loss::LossTable>,
    /// Where the joint estimator's standard deviations come from.
    ///
    /// Default: the noise.
    /// Example: `uncertainty = { kind = "jackknife" }`
    #[serde(default)]
    pub uncertainty: uncertainty::UncertaintyTable,
    /// Inequalities that the joint estimate obeys (they need `solver = "clarabel"`), and inertias that rigid bodies can have (which do not).
    ///
    /// Default: none.
    /// Example: `constraints = { masses = "positive" }`
    #[serde(default)]
    pub constraints: constraints::ConstraintsTable,
    /// What an earlier calibration of other recordings knows. Joint estimator only.
    ///
    /// Example: `prior = { calibration = "last-week/calibration.json" }`
    pub prior: Option<prior::PriorTable>,
    /// Which parameters count for the verdict.
    ///
    /// Default: all that are not fixed.
    /// Example: `ask = { drop = ["joint1.torque_gain"] }`
    #[serde(default)]
    pub ask: ask::AskTable,
}
