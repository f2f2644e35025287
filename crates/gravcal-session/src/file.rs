//! Sessions from `session.toml`.
//!
//! ```toml
//! robot = "robot.toml"                       # or { urdf = "arm.urdf", base = "link_0", tip = "link_7" }; tip = [...] for branches
//! estimators = ["sequential", "joint"]       # optional
//! solver = "levenberg-marquardt"             # optional; or [solver] with name and options, such as max_iterations
//!
//! [gravity]
//! magnitude_m_per_s2 = 9.80665               # or latitude_deg and altitude_m
//! magnitude_std_m_per_s2 = 0.001             # optional: exact without it
//! hemisphere = [0, 0, -1]                    # optional: rough direction in base coordinates, settles the sign
//!
//! [inertia]                                  # optional
//! links = "unknown"                          # the default; or "model", with relative_std = 0.1 or by link { link2 = 0.1 }
//! description = "link"                       # the default; or "sweep": a moment for each sweep, lengths are not used
//!
//! [readings]
//! position = { columns = ["q1", "q2"], unit = "deg" }             # std = 0.02: of each reading, taken as exact without
//! torque = { columns = ["y1", ""], unit = "count", std = 0.8 }    # "": no torque sensor
//! # unexplained_std = "estimated" in it: errors beyond that noise, joint by joint from the residuals, as by default of means from
//! # `still` and `sweeps`; or "none", or a number; in the unit of the readings, one for all or a list, as std
//! # with lowest = 0, highest = 4095 in it: readings there or beyond are saturated, and left out
//! # or, where no robot is named and instruments are turned otherwise, how they stood: v_base = R v_body
//! orientation = { columns = ["qx", "qy", "qz", "qw"], order = "xyzw", rotation = "base-from-body" }
//! # order: or "wxyz", or none for the nine columns of a matrix, row by row; rotation: or "body-from-base"
//! sweep_column = "sweep"                     # optional: labels of sweeps
//! merge_repeated_rows = false                # optional: rows of one standstill become one pose
//! time = { column = "t", unit = "s" }        # these where a sensor's model or `select` needs them: one clock for all tables
//! # or unit = "ISO 8601", where cells are dates with times such as 2024-05-01T12:00:00.010Z
//! temperature = { columns = "T", unit = "degC" }                  # one for all joints, or a list
//! velocity = { columns = ["dq1", "dq2"], unit = "deg/s" }
//! # or velocity = { slope_over_s = 0.1 }: of the straight line through the positions that near in time (of the whole width)
//! acceleration = { slope_over_s = 0.1 }      # the same of the velocities; or columns with unit = "rad/s²"
//! direction = { columns = ["d1", "d2"] }     # from which side the joint came: 1 rising, -1 falling, 0 not known
//! further = { oil = "p_oil" }                # columns that only models of sensors know: further[oil] in a formula
//!
//! [readings.select]                          # optional: which readings of an arm in motion count
//! # a row counts where every joint keeps to this: each one's motion is felt in all torques
//! arm = { speed_below = { value = 0.8, unit = "rad/s" }, acceleration_below = { value = [0.5, 1], unit = "rad/s²" } }
//! # a joint's torque reading counts where the joint itself keeps to this; below a least speed no friction has a sign
//! joint = { speed_above = { value = 1, unit = "deg/s" } }
//!
//! [readings.still]                           # optional: the tables are recordings in motion, poses the standstills found in them
//! least_duration_s = 0.1                     # optional: shorter ones are left out; see `gravcal_recording::static_poses`
//!
//! [readings.motion]                          # optional: … or every moment of them counts, by the whole dynamics; may stand beside still
//! window_s = 0.32                            # optional: length of a window, of cut-off 1.6/window_s
//! torque_lag_s = 0.01                        # optional: torques come so much later than positions
//! recorded_filter_hz = 2                     # optional: torques have passed a low-pass filter, and positions have not
//!
//! [readings.sweeps]                          # optional: … or poses are what a joint passes slowly both ways; both may stand
//! bin_deg = 1                                # optional: a pose for each degree of that joint; see `gravcal_recording::slow_sweeps`
//! acceleration_below_rad_per_s2 = 0.05       # optional: so is the square of the speed, in rad/s
//!
//! [readings.csv]                             # optional: how CSV files are written, where that is found wrongly
//! delimiter = ";"                            # or ",", "\t", "|"
//! decimal_comma = true
//! header = false                             # columns are then "column1", "column2", ...
//! columns = ["t", "q1", "q2", "y1", "y2"]    # ... or these; files with a header have its names
//!
//! [[joint]]                                  # optional: what is known of a joint's sensors
//! name = "shoulder"
//! torque_sign = "reversed"                   # "normal" by default; position_sign likewise
//! torque_gain = { nominal = 6.69, unit = "count/(N·m)" }          # only a start
//! position_gain = { fixed = 1, unit = "deg/deg" }                 # exact
//! position_offset = { nominal = 135, std = 2, unit = "deg" }      # known that well
//! sensor_models = [                          # what its sensors do beyond gain and bias: see `gravcal_robot_model::sensors`
//!     { kind = "torque-bias-in-time", parameters = { torque_bias_drift = { nominal = 0, std = 1, unit = "count/s" } } },
//!     { kind = "torque-bias-with-temperature", reference_degC = 25 },
//! ]
//! rotor_inertia = "unknown"                  # of an arm in motion whose torques are its motors'; or what is known of it, in kg·m²
//!
//! [joints]                                   # optional: the same of all joints, where their own tables do not say it, key by key
//! sensor_models = [{ kind = "coulomb-friction" }]
//!
//! [[force_torque_sensor]]                    # optional: six axes on a last link; see `residuals::Wrench` for its signs
//! name = "wrist"
//! link = "forearm"                           # which one, where the robot branches
//! mounting = { position_m = [0, 0, 0.05], rpy_deg = [0, 0, 30] }  # optional: its frame in that link's
//! readings = { columns = ["fx", "fy", "fz", "nx", "ny", "nz"], unit = "count", std = 0.5 }   # as readings.torque
//! sign = "reversed"                          # optional: it reads what the tool exerts on the link, and not the link on the tool
//! gains = "axis"                             # optional: one an axis (the default), or a "matrix"
//! frame = "sensor"                           # optional: in which forces and moments are given (the default), or the "base"
//! biases = "session"                         # optional: one for all tables (the default), or one for each "table": zeroed anew
//! sensor_models = [{ kind = "bias-in-time" }, { kind = "bias-with-temperature", reference_degC = 25 }]   # optional: drifts of biases
//! force_gain = { nominal = 20, std = 1, unit = "count/N" }        # of each axis; as for a joint
//! moment_gain = { nominal = 400, unit = "count/(N·m)" }           # likewise force_bias, moment_bias
//! tool_mass = { fixed = 1.2, unit = "kg" }   # optional: what always hangs beyond it; tool_moment_x, _y, _z in kg·m
//!
//! [[accelerometer]]                          # optional: three axes on a link
//! name = "imu"
//! link = "link1"                             # which one, where there are several
//! mounting = { rpy_deg = [90, 0, 0] }        # optional; so is sign
//! mounting_std_deg = 2                       # optional: exact without it
//! readings = { columns = ["ax", "ay", "az"], unit = "g", std = 0.001 }
//! gain = { nominal = 0.102, unit = "g/(m/s²)" }                   # optional, likewise bias; gains as above
//!
//! [[residual]]                               # optional: what else was observed; see `gravcal_robot_model::residual_models`
//! kind = "dial-gauge"                        # a model that a program adds to gravcal
//! columns = { reading = "dial_m" }           # its columns; beside them stand the options of the model
//!
//! [[load]]                                   # optional
//! name = "plate-a"
//! mass_kg = 1.724
//! link = "link2"
//! position_m = [0, 0, 0.1]                   # optional, with or without position_std_m
//!
//! [[load_distance]]                          # optional; both loads on one link
//! between = ["plate-a", "plate-b"]
//! distance_m = 0.402
//! distance_std_m = 0.0005                    # optional: a micrometre without it
//!
//! [[poses]]                                  # one at least
//! file = "${DATA:-.}/poses-a.csv"
//! load = "plate-a"                           # optional: nothing attached without it
//! swept = "shoulder"                         # optional: found by movement without it
//! step = 2                                   # optional: the step of the sequential procedure that reads it
//! from_s = 10                                # optional, of a recording with a clock: the part that counts, after its first row
//! until_s = 95
//!
//! [[validation]]                             # optional: as [[poses]], but in no fit; what is found predicts them
//! file = "another-day.csv"
//!
//! [deflection]                               # optional: joints are not where their position sensors say
//! hold_std_deg = 0.5                         # those that stand while another sweeps: one unknown each in a sweep
//! pose_std_deg = 0.05                        # those that stand: one unknown each in a pose
//! compliance_std_rad_per_newton_metre = 1e-4 # those that stand: in proportion to their torque; or a list, one for each
//!
//! [loss]                                     # optional: how the joint estimator counts readings far beyond their noise
//! kind = "huber"                             # "none" (the default), "huber", "cauchy", "tukey", "geman-mcclure"
//! width = 1.345                              # optional, in standard deviations: where it begins to count less
//!
//! [uncertainty]                              # optional: where the joint estimator's standard deviations come from
//! kind = "jackknife"                         # "noise" (the default), "jackknife", "sandwich", "bootstrap"
//! block_poses = 10                           # neighbouring poses that may share an error; found by "jackknife", not with "noise"
//! # with "jackknife" also block_s = 1.5 (needs time), blocks = "sweeps", or blocks = "pairs" (the same pose from two sides)
//! replicates = 500                           # optional, with "bootstrap" only; so is seed = 1
//!
//! [constraints]                              # optional: obeyed by the joint estimate, which needs solver = "clarabel"
//! masses = "positive"                        # no link's mass is negative
//! center_of_mass_within_m = 0.3              # of the origin of each link's frame; or by link: { link2 = 0.3 }
//! torque_gains_within = 0.2                  # of their nominal values, relative to these
//!
//! [prior]                                    # optional: what an earlier calibration knows, for the joint estimate
//! calibration = "last-week/calibration.json" # parameters of the same names, with their whole covariance
//! estimator = "joint"                        # optional: whose answer
//! unchanged = ["base", "links", "loads"]     # optional: what is as it was then, besides the sensors
//!
//! [ask]                                      # optional
//! add = ["shoulder.position_offset"]
//! drop = ["shoulder.torque_gain"]
//! ```
//!
//! A link that turns about an axis through its frame's origin can obey both constraints on links by being heavier, which
//! changes no torque if the link before it is adapted. So these matter beside `links = "model"`, for prismatic joints, and
//! where frames lie off their axes.
//!
//! Where a value may differ by joint (`unit`, `std`, `count`) it is one for all or a list with one for each. The noise
//! columns `std_columns`, `count_columns` and `usable_columns` are lists, with `""` where a joint has none.
//!
//! Each section has its own file: what may stand there (a struct for serde) and what it comes to. Numbers carry their
//! unit in the name of the field or in a `unit` beside them; here they become SI and radians.

mod ask;
mod base_frame;
mod conditions;
mod constraints;
mod context;
mod csv;
mod deflection;
mod gravity;
mod inertia;
mod instruments;
mod joints;
mod loads;
mod loss;
mod missing_noise;
mod models;
#[cfg(test)]
mod models_tests;
mod motion;
mod normal_gravity;
mod orientation;
mod parameter_prior;
mod poses;
mod prior;
mod reading_columns;
mod readings;
mod recordings;
mod residuals;
mod rotors;
mod select;
mod single_poses;
mod solver;
mod still;
mod sweeps;
mod swept_speed;
#[cfg(test)]
mod tests;
mod uncertainty;
mod unexplained;

use std::path::{Path, PathBuf};

use gravcal_estimation::Loss;
use gravcal_recording::{Memory, PoseMapping};
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::{Parameter, SensorParameter};
use gravcal_robot_model::residual_models::ResidualInUse;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::sensors::SensorTerms;
use gravcal_robot_model::session::{
    Ask, AuxiliarySensor, Constraints, Deflection, GravityPrior, InertiaPrior, JointPriors, Load, LoadDistance, Pose,
    PoseTable, PriorKind, Session,
};
use serde::Deserialize;

use self::context::Context;
use self::poses::{ReadPoses, WrittenTables};
use self::readings::ReadingsTable;
use self::recordings::{InMotion, Recordings};
use crate::document::{Document, Field, FileError};
use crate::robot_file::{RobotSource, resolve_robot};

pub use context::SessionError;
pub(crate) use instruments::{AccelerometerTable, ForceTorqueTable, Instruments};
pub use solver::{read_solver_options, solver_name_error, solver_option_error};

/// The instruments that a document declares for a robot; `tables`: how many tables of poses there are.
pub(crate) fn read_instruments(
    document: &Document,
    robot: &Robot,
    robot_path: &Path,
    (force_torque, accelerometers): (&[ForceTorqueTable], &[AccelerometerTable]),
    tables: usize,
) -> Result<Instruments, FileError> {
    instruments::resolve(&Context::new(document, robot, robot_path), force_torque, accelerometers, tables)
}

/// `session.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct SessionTable {
    /// The robot: a `robot.toml`, or a URDF with its base and tip link (one tip for each branch). Left away only where
    /// `readings.orientation` says how a sensor stood.
    ///
    /// Example: `robot = { urdf = "arm.urdf", base = "link_0", tip = "link_7" }`
    robot: Option<RobotSource>,
    /// Which estimators run.
    ///
    /// Default: `["sequential", "joint"]`.
    /// Example: `estimators = ["joint"]`
    #[serde(default)]
    estimators: Vec<String>,
    /// The method that minimises: its name, or a table with `name` and its options.
    ///
    /// Default: `"levenberg-marquardt"`.
    /// Example: `solver = { name = "levenberg-marquardt", max_iterations = 50 }`
    solver: Option<solver::Written>,
    /// What is known of gravity.
    ///
    /// Example: `gravity = { magnitude_m_per_s2 = 9.80665 }`
    gravity: gravity::GravityTable,
    /// What is known of the links.
    ///
    /// Default: nothing is known of them.
    /// Example: `inertia = { links = "unknown" }`
    #[serde(default)]
    inertia: inertia::InertiaTable,
    /// Which columns hold the readings, and in which unit.
    ///
    /// Example: `readings = { position = { columns = ["q1"], unit = "rad" } }`
    readings: readings::ReadingsTable,
    /// What is known of one joint's sensors. One table for each joint of which something is known.
    ///
    /// Default: nominal sensors of the robot.
    /// Example: `joint = [{ name = "joint2", torque_sign = "reversed" }]`
    #[serde(default)]
    joint: Vec<joints::JointTable>,
    /// The same of all joints, key by key, where their own tables do not say it.
    ///
    /// Example: `joints = { sensor_models = [{ kind = "coulomb-friction" }] }`
    joints: Option<joints::JointTable>,
    /// Force-torque sensors: six axes on a last link, holding what hangs beyond them.
    ///
    /// Default: none.
    /// Example: `force_torque_sensor = []`
    #[serde(default)]
    force_torque_sensor: Vec<instruments::ForceTorqueTable>,
    /// Accelerometers: three axes on a link.
    ///
    /// Default: none.
    /// Example: `accelerometer = []`
    #[serde(default)]
    accelerometer: Vec<instruments::AccelerometerTable>,
    /// What else was observed, by models that a program adds to gravcal. Joint estimator only.
    ///
    /// Default: none.
    /// Example: `residual = [{ kind = "dial-gauge", columns = { reading = "dial_m" } }]`
    #[serde(default)]
    residual: Vec<residuals::ResidualTable>,
    /// Loads, of known or unknown mass.
    ///
    /// Default: none.
    /// Example: `load = [{ name = "plate", mass_kg = 2.0, link = "link3" }]`
    #[serde(default)]
    load: Vec<loads::LoadTable>,
    /// Known distances between two placements on one link.
    ///
    /// Default: none.
    /// Example: `load_distance = [{ between = ["plate-a", "plate-b"], distance_m = 0.402 }]`
    #[serde(default)]
    load_distance: Vec<loads::LoadDistanceTable>,
    /// The tables of poses, or recordings. At least one.
    ///
    /// Example: `poses = [{ file = "bare.csv" }]`
    #[serde(default)]
    poses: Vec<poses::PosesTable>,
    /// Tables that no fit sees; the result predicts them.
    ///
    /// Default: none.
    /// Example: `validation = [{ file = "another-day.csv" }]`
    #[serde(default)]
    validation: Vec<poses::PosesTable>,
    /// How far joints are from where their position sensors say. Joint estimator only.
    ///
    /// Default: joints do not deflect.
    /// Example: `deflection = { hold_std_deg = 0.5 }`
    #[serde(default)]
    deflection: deflection::DeflectionTable,
    /// How readings far beyond their noise count. Joint estimator only.
    ///
    /// Example: `loss = { kind = "huber" }`
    loss: Option<loss::LossTable>,
    /// Where the joint estimator's standard deviations come from.
    ///
    /// Default: the noise.
    /// Example: `uncertainty = { kind = "jackknife" }`
    #[serde(default)]
    uncertainty: uncertainty::UncertaintyTable,
    /// Inequalities that the joint estimate obeys (they need `solver = "clarabel"`), and inertias that rigid bodies can have (which do not).
    ///
    /// Default: none.
    /// Example: `constraints = { masses = "positive" }`
    #[serde(default)]
    constraints: constraints::ConstraintsTable,
    /// What an earlier calibration of other recordings knows. Joint estimator only.
    ///
    /// Example: `prior = { calibration = "last-week/calibration.json" }`
    prior: Option<prior::PriorTable>,
    /// Which parameters count for the verdict.
    ///
    /// Default: all that are not fixed.
    /// Example: `ask = { drop = ["joint1.torque_gain"] }`
    #[serde(default)]
    ask: ask::AskTable,
}

/// Reads `session.toml` and everything it names.
///
/// # Errors
/// Names the file, the line and the field.
pub fn read_session(path: &Path) -> Result<Session, SessionError> {
    read_session_with(path, &Registry::standard())
}

/// The same; `registry` says what may be named, such as sensor models of one's own.
///
/// # Errors
/// As [`read_session`].
pub fn read_session_with(path: &Path, registry: &Registry) -> Result<Session, SessionError> {
    read_session_watched(path, registry, &|_, _| {})
}

/// The same; `watch` is told which recording in motion is being read, and which share of it is, as these may be long.
///
/// # Errors
/// As [`read_session`].
pub fn read_session_watched(
    path: &Path,
    registry: &Registry,
    watch: &dyn Fn(&Path, f64),
) -> Result<Session, SessionError> {
    read(&Document::read(path)?, registry, &Memory::default(), watch)
}

/// The same from a document, which may be another text than that of the file.
///
/// # Errors
/// As for [`read_session`].
pub fn read_session_document(document: &Document, registry: &Registry) -> Result<Session, SessionError> {
    read(document, registry, &Memory::default(), &|_, _| {})
}

/// The same from a document and recordings in memory, which it names as it would name files in its folder. Of these only what is a
/// file is among the [`inputs`](Session::inputs).
///
/// # Errors
/// As for [`read_session`].
pub fn read_session_in_memory(
    document: &Document,
    registry: &Registry,
    memory: &Memory,
    watch: &dyn Fn(&Path, f64),
) -> Result<Session, SessionError> {
    let session = read(document, registry, memory, watch)?;
    let is_file = |path: &PathBuf| path != document.path() && !memory.holds(path);
    Ok(Session { inputs: session.inputs.iter().filter(|path| is_file(path)).cloned().collect(), ..session })
}

/// Reads a session and everything it names. What `session.toml` says is checked before any table is opened.
/// `watch` is told how far each recording in motion is read.
fn read(
    document: &Document,
    registry: &Registry,
    memory: &Memory,
    watch: &dyn Fn(&Path, f64),
) -> Result<Session, SessionError> {
    let written: SessionTable = document.parse()?;
    orientation::check_robot(document, written.robot.as_ref(), &written.readings)?;
    let (robot, robot_path) = robot(document, written.robot.as_ref())?;
    let context = Context::new(document, &robot, robot_path.as_deref().unwrap_or(document.path()));

    let declared = Declared::resolve(&context, registry, &written)?;
    let all = WrittenTables { poses: &written.poses, validation: &written.validation };
    let mut tables = poses::tables(&context, &declared.loads, all, declared.has_clock())?;
    let read = declared.read_poses(&context, (memory, watch), all, &mut tables)?;
    poses::check_validation(document, all, (&declared.loads, &declared.inertia), &tables)?;
    let ReadPoses { poses, saturated, in_motion, searched } = read;
    let (poses, validation) = poses.into_iter().partition(|pose: &Pose| pose.table < all.poses.len());
    let poses = checked(document, poses)?;
    let uncertainty = uncertainty::resolve(&context, &written.uncertainty, &poses)?;
    let inputs = inputs(document.path(), robot_path.as_deref(), tables.iter().map(|table| table.path.clone()));

    let (unexplained, finds_rest) = (declared.unexplained.clone(), declared.motion.finds_rest());
    let session = Session {
        tables,
        poses,
        validation,
        saturated,
        in_motion,
        searched,
        uncertainty,
        inputs,
        ..declared.session(&context, &written)
    };
    let session = match &written.prior {
        None => session,
        Some(prior) => prior::resolve(&context, prior, all, session)?,
    };
    check(&context, &session)?;
    let session = unexplained::resolve(document, &unexplained, finds_rest && !session.has_windows(), session)?;
    Ok(Session { repeated: session.find_repeated(), doubts: session.find_doubts(), ..session })
}

/// The robot, with the path of its file; without one a body that stands as the tables say.
fn robot(document: &Document, source: Option<&RobotSource>) -> Result<(Robot, Option<PathBuf>), FileError> {
    let read = source.map(|source| resolve_robot(document, &Field::new("robot"), source)).transpose()?;
    Ok(match read {
        Some((robot, path)) => (robot, Some(path)),
        None => (orientation::free_body(), None),
    })
}

/// The poses that enter, where anything is read in any of them.
fn checked(document: &Document, mut poses: Vec<Pose>) -> Result<Vec<Pose>, FileError> {
    missing_noise::fill_in(&mut poses);
    motion::count_alike(&mut poses);
    if poses.iter().all(|pose| pose.torque.iter().chain(&pose.instruments).all(Option::is_none)) {
        let message = "no table has a usable torque reading: every torque cell is empty, marked unusable or saturated";
        return Err(document.error(&Field::new("readings").key("torque"), message));
    }
    Ok(poses)
}

/// What the sections of a session say together must go with its poses.
fn check(context: &Context<'_>, session: &Session) -> Result<(), FileError> {
    inertia::check_sweeps(context.document, session)?;
    loads::check_unknown(context.document, session)?;
    motion::check(context, session)?;
    single_poses::check_single_poses(context.document, session)?;
    deflection::check_instruments(context.document, session)?;
    residuals::check(context.document, session)
}

/// Who is told which recording is read, and which share of it is.
type Watch<'w> = &'w dyn Fn(&Path, f64);

/// What `session.toml` says, before any table is opened.
struct Declared {
    gravity: GravityPrior,
    inertia: InertiaPrior,
    joints: Vec<JointPriors>,
    instruments: Vec<AuxiliarySensor>,
    terms: SensorTerms,
    residuals: Vec<ResidualInUse>,
    further: Vec<Parameter>,
    rotors: Vec<Option<usize>>,
    load_masses: Vec<Option<usize>>,
    mapping: PoseMapping,
    motion: InMotion,
    unexplained: Vec<Option<unexplained::Said>>,
    loads: Vec<Load>,
    load_distances: Vec<LoadDistance>,
    deflection: Deflection,
    loss: Loss,
    constraints: Constraints,
    ask: Ask,
}

impl Declared {
    fn resolve(context: &Context<'_>, registry: &Registry, written: &SessionTable) -> Result<Declared, FileError> {
        let document = context.document;
        let gravity = gravity::resolve(document, &written.gravity)?;
        let inertia = inertia::resolve(context, &written.inertia)?;
        let (wrists, accelerometers) = (&written.force_torque_sensor, &written.accelerometer);
        let instruments = instruments::resolve(context, wrists, accelerometers, written.poses.len())?;
        let mut mapping = readings::mapping(context, &written.readings, &instruments)?;
        let unexplained =
            [readings::unexplained(context, &written.readings)?, instruments.unexplained.clone()].concat();
        let said = joints::said(context, &written.joint, written.joints.as_ref())?;
        let joints = joints::resolve(context, &mapping, &said)?;
        let motion = in_motion(context, &written.readings, &mapping, &joints)?;
        let (terms, mut further) = models::resolve(context, registry, &mapping, &motion, &joints, &said)?;
        let instruments = instruments.behind(&mut further);
        instruments::check_conditions(document, &instruments, &mapping, motion.is_any())?;
        let observed = (&mut mapping, &mut further);
        let residuals = residuals::resolve(context, registry, &written.residual, &instruments, observed)?;
        residuals::check_recordings(document, &residuals, &mapping, motion.is_any())?;
        refuse_prior_on_base_frame(context, &joints, &said)?;
        let loads = loads::resolve(context, &written.load)?;
        Ok(Declared {
            load_distances: loads::resolve_distances(document, &loads, &written.load_distance)?,
            deflection: deflection::resolve(context, &written.deflection, &written.readings, &mut further)?,
            rotors: rotors::resolve(context, &said, (&joints, motion.windows.is_some()), &mut further)?,
            load_masses: loads::masses(context, &written.load, &loads, &mut further)?,
            loss: loss::resolve(context, written.loss.as_ref())?,
            constraints: constraints::resolve(context, &written.constraints)?,
            ask: ask::resolve(context, &joints, &further, &written.ask)?,
            gravity,
            inertia,
            joints,
            instruments,
            terms,
            residuals,
            further,
            mapping,
            motion,
            unexplained,
            loads,
        })
    }

    /// Whether rows have a time.
    fn has_clock(&self) -> bool {
        self.motion.is_any() || self.mapping.conditions.time.is_some()
    }

    /// All poses of all tables, what instruments read in their own frames.
    fn read_poses(
        &self,
        context: &Context<'_>,
        (memory, watch): (&Memory, Watch<'_>),
        written: WrittenTables<'_>,
        tables: &mut [PoseTable],
    ) -> Result<ReadPoses, SessionError> {
        let (document, loads) = (context.document, &self.loads);
        let mut read = if self.motion.is_any() {
            let (apart, frictional) = (self.terms.need_direction(), self.terms.with_friction());
            let (chain, joints) = (&context.robot.chain, &self.joints[..]);
            let recordings = Recordings { document, memory, written, chain, joints, loads, apart, frictional, watch };
            recordings.read(tables, &self.mapping, &self.motion)?
        } else {
            poses::read_all(document, memory, written, tables, &self.mapping)?
        };
        for wrist in self.instruments.iter().filter(|instrument| instrument.in_base) {
            base_frame::turn_back(context.robot, &self.joints, wrist, &mut read.poses);
        }
        Ok(read)
    }

    /// The session without what comes of its tables.
    fn session(self, context: &Context<'_>, written: &SessionTable) -> Session {
        Session {
            inertia: self.inertia,
            loads: self.loads,
            load_distances: self.load_distances,
            instruments: self.instruments,
            terms: self.terms,
            residuals: self.residuals,
            further: self.further,
            rotors: self.rotors,
            load_masses: self.load_masses,
            readings: self.mapping,
            deflection: self.deflection,
            loss: self.loss,
            constraints: self.constraints,
            ask: self.ask,
            estimators: written.estimators.clone(),
            solver: written.solver.clone().map(|solver| solver.choice(context.document)),
            ..Session::new(context.robot.clone(), self.gravity, self.joints)
        }
    }
}

/// What of recordings in motion counts.
fn in_motion(
    context: &Context<'_>,
    written: &ReadingsTable,
    mapping: &PoseMapping,
    joints: &[JointPriors],
) -> Result<InMotion, FileError> {
    let still = written.still.as_ref().map(|still| still::resolve(context, still, mapping)).transpose()?;
    let sweeps = written.sweeps.as_ref();
    let sweeps = sweeps.map(|sweeps| sweeps::resolve(context, sweeps, mapping, joints)).transpose()?;
    let windows = written.motion.as_ref();
    let windows = windows.map(|windows| motion::resolve(context, windows, mapping, joints)).transpose()?;
    let motion = InMotion { still, sweeps, windows };
    motion::check_beside(context, &motion)?;
    Ok(motion)
}

/// The offset of the joint on which all others hang defines the base frame: it has a value, but it cannot be uncertain.
fn refuse_prior_on_base_frame(
    context: &Context<'_>,
    joints: &[JointPriors],
    said: &[joints::Said<'_>],
) -> Result<(), FileError> {
    let Some(root) = context.robot.chain.root_joint() else { return Ok(()) };
    let PriorKind::Gaussian { .. } = joints[root].of(SensorParameter::PositionOffset).kind else { return Ok(()) };
    let Some(entry) = said[root].of(SensorParameter::PositionOffset) else { return Ok(()) };
    let message = match entry.of_all {
        false => {
            "the first joint's offset defines the base frame, so it cannot be uncertain: leave std away".to_owned()
        }
        true => format!(
            "the first joint's offset defines the base frame, so it cannot be uncertain: add [[joint]] name = \"{}\", \
             position_offset = {{ nominal = 0, unit = \"rad\" }}",
            context.joint_names[root]
        ),
    };
    Err(context.document.error(&entry.field.key("std"), message))
}

fn inputs(session: &Path, robot: Option<&Path>, tables: impl Iterator<Item = PathBuf>) -> Vec<PathBuf> {
    std::iter::once(session).chain(robot).map(Path::to_owned).chain(tables).collect()
}
