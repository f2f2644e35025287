//! Writes a simulated session: `session.toml`, its tables, and the truth.

use std::path::{Path, PathBuf};

use gravcal_dynamics::Joint;
use gravcal_recording::{Cell, NewFiles, TorqueUnit, WriteError, clear_abandoned, holds, is_saturated, table_contents};
use gravcal_robot_model::session::Session;
use gravcal_robot_model::session::compliance::compliance_parameters;
use serde::Serialize;
use thiserror::Error;

use super::earlier_load::{Creep, Hysteresis};
use super::experiment::{Run, Simulation};
use super::friction::FrictionAtRest;
use super::write_conditions::{self, ConditionTables};
use super::{draw, write_recording};
use crate::document::relative_path;
use crate::sensor_models::ModelTable;

const SESSION: &str = "session.toml";
const TRUTH: &str = "truth.toml";

/// A simulated session cannot be written.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// A file stands in the way.
    #[error("{0} exists and differs: pass --overwrite to replace it, or --output to write elsewhere")]
    Exists(PathBuf),
    /// See [`WriteError`].
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A name cannot be written in TOML.
    #[error("the session cannot be written as TOML: {0}")]
    Toml(#[from] toml::ser::Error),
}

/// Writes one trial into a folder, which is made if it is missing: all files or none. Gives them, `session.toml` first.
///
/// Where all files hold the same bytes already they are left alone, unless they are recordings.
///
/// # Errors
/// Where a file differs and `overwrite` is not set, or cannot be written; then nothing is.
pub fn write_session(
    simulation: &Simulation,
    trial: u64,
    folder: &Path,
    overwrite: bool,
) -> Result<Vec<PathBuf>, SimulateError> {
    clear_abandoned(folder);
    match &simulation.motion {
        None => write_files(simulation, &draw::session(simulation, trial), folder, overwrite),
        Some(motion) => write_recording::write(simulation, motion, trial, folder, overwrite),
    }
}

/// The files that [`write_session`] writes, `session.toml` first.
pub fn session_files(simulation: &Simulation, folder: &Path) -> Vec<PathBuf> {
    let tables = simulation.template.tables.iter().map(|table| folder.join(&table.path));
    let [session, truth] = [SESSION, TRUTH].map(|name| folder.join(name));
    [session].into_iter().chain(tables).chain([truth]).collect()
}

fn write_files(
    simulation: &Simulation,
    session: &Session,
    folder: &Path,
    overwrite: bool,
) -> Result<Vec<PathBuf>, SimulateError> {
    let mut files: Vec<(PathBuf, Vec<u8>)> = vec![(SESSION.into(), session_toml(simulation, session, folder)?.into())];
    for (index, table) in session.tables.iter().enumerate() {
        files.push((table.path.clone(), table_bytes(simulation, session, index)?));
    }
    files.push((TRUTH.into(), truth_toml(simulation)?.into()));
    refuse_others(&files, folder, overwrite)?;
    let stands = |(name, bytes): &(PathBuf, Vec<u8>)| holds(&folder.join(name), bytes).unwrap_or(false);
    if !files.iter().all(stands) {
        let mut new = NewFiles::begin(folder)?;
        files.iter().try_for_each(|(name, bytes)| new.write(name, bytes))?;
        new.finish()?;
    }
    Ok(session_files(simulation, folder))
}

/// `session.toml` and `truth.toml` of a simulation whose tables are recordings.
pub(super) fn texts_of_recording(
    simulation: &Simulation,
    folder: &Path,
) -> Result<Vec<(PathBuf, Vec<u8>)>, SimulateError> {
    let session = session_toml(simulation, &simulation.template, folder)?;
    Ok(vec![(SESSION.into(), session.into()), (TRUTH.into(), truth_toml(simulation)?.into())])
}

/// Refuses to replace a file that holds other bytes, unless told.
pub(super) fn refuse_others(files: &[(PathBuf, Vec<u8>)], folder: &Path, overwrite: bool) -> Result<(), SimulateError> {
    let differs = |name: &Path, bytes: &[u8]| {
        let path = folder.join(name);
        path.exists() && !holds(&path, bytes).unwrap_or(false)
    };
    match files.iter().find(|(name, bytes)| !overwrite && differs(name, bytes)) {
        Some((name, _)) => Err(SimulateError::Exists(folder.join(name))),
        None => Ok(()),
    }
}

/// `session.toml` as its reader expects it.
#[derive(Serialize)]
struct SessionTable {
    robot: RobotTable,
    gravity: GravityTable,
    readings: ReadingsTable,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    joint: Vec<JointTable>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    force_torque_sensor: Vec<toml::Table>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    accelerometer: Vec<toml::Table>,
    load: Vec<LoadTable>,
    load_distance: Vec<LoadDistanceTable>,
    poses: Vec<PosesTable>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum RobotTable {
    Toml(String),
    Urdf { urdf: String, base: String, tip: Tip },
}

/// The last link, or that of each branch.
#[derive(Serialize)]
#[serde(untagged)]
enum Tip {
    One(String),
    Each(Vec<String>),
}

#[derive(Serialize)]
struct GravityTable {
    magnitude_m_per_s2: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    hemisphere: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct ReadingsTable {
    position: PositionTable,
    torque: TorqueTable,
    #[serde(flatten)]
    conditions: ConditionTables,
    /// Of recordings in motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    still: Option<EmptyTable>,
    /// Of recordings with slow sweeps.
    #[serde(skip_serializing_if = "Option::is_none")]
    sweeps: Option<EmptyTable>,
    /// Of arms that never stand.
    #[serde(skip_serializing_if = "Option::is_none")]
    motion: Option<EmptyTable>,
}

#[derive(Serialize)]
struct EmptyTable {}

#[derive(Serialize)]
struct JointTable {
    name: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sensor_models: Vec<ModelTable<()>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotor_inertia: Option<&'static str>,
}

#[derive(Serialize)]
struct PositionTable {
    columns: Vec<String>,
    unit: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    std: Option<Vec<f64>>,
}

#[derive(Serialize)]
struct TorqueTable {
    columns: Vec<String>,
    unit: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    std: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lowest: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    highest: Option<f64>,
}

#[derive(Serialize)]
struct LoadTable {
    name: String,
    mass_kg: f64,
    link: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_m: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct LoadDistanceTable {
    between: [String; 2],
    distance_m: f64,
}

#[derive(Serialize)]
struct PosesTable {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<u8>,
}

/// The ends of the converter's range, where a reading is there: otherwise nothing need be said of them.
fn range(simulation: &Simulation, session: &Session) -> Option<[f64; 2]> {
    let [lowest, highest] = simulation.disturbance.converter?.ends();
    if simulation.motion.is_some() {
        return Some([lowest, highest]);
    }
    let mut values = session.poses.iter().flat_map(|pose| pose.torque.iter().flatten()).map(|reading| reading.value);
    values.any(|value| is_saturated(value, Some(lowest), Some(highest))).then_some([lowest, highest])
}

fn session_toml(simulation: &Simulation, session: &Session, folder: &Path) -> Result<String, SimulateError> {
    let range = range(simulation, session);
    let joints = 0..session.joints.len();
    let recorded = simulation.motion.as_ref();
    let moves = recorded.is_some_and(|motion| motion.harmonic.is_some());
    let slow = recorded.is_some_and(|motion| motion.sweeping.is_some());
    let sweeps = |run: &Run| slow && matches!(run, Run::Sweep { .. });
    let finds = |found: bool| (recorded.is_some() && !moves && found).then_some(EmptyTable {});
    let [still, sweeps] = [finds(!simulation.runs.iter().all(sweeps)), finds(simulation.runs.iter().any(sweeps))];
    let motion = moves.then_some(EmptyTable {});
    let load_name = |load: usize| session.loads[load].name.clone();
    let table = SessionTable {
        robot: robot_table(session, folder),
        gravity: GravityTable { magnitude_m_per_s2: session.gravity.magnitude, hemisphere: session.gravity.hemisphere },
        readings: ReadingsTable {
            position: PositionTable {
                columns: joints.clone().map(|joint| position_column(simulation, joint)).collect(),
                unit: session.joints.iter().map(|joint| joint.position_unit.to_string()).collect(),
                std: (!moves && simulation.disturbance.position_std.iter().any(|std| *std > 0.0))
                    .then(|| simulation.disturbance.position_std.clone()),
            },
            torque: TorqueTable {
                columns: joints.clone().map(|joint| torque_column(simulation, joint)).collect(),
                unit: session.joints.iter().map(|joint| torque_unit(joint.torque_unit).to_owned()).collect(),
                std: recorded.is_none().then(|| joints.map(|joint| simulation.stated_std(joint)).collect()),
                lowest: range.map(|[lowest, _]| lowest),
                highest: range.map(|[_, highest]| highest),
            },
            conditions: write_conditions::tables(session, &simulation.conditions),
            still,
            sweeps,
            motion,
        },
        joint: joint_tables(simulation, session),
        force_torque_sensor: simulation.instruments.force_torque_sensor.clone(),
        accelerometer: simulation.instruments.accelerometer.clone(),
        load: session
            .loads
            .iter()
            .map(|load| LoadTable {
                name: load.name.clone(),
                mass_kg: load.mass,
                link: session.robot.chain.links()[load.link].name.clone(),
                position_m: load.position,
            })
            .collect(),
        load_distance: session
            .load_distances
            .iter()
            .map(|known| LoadDistanceTable { between: known.between.map(load_name), distance_m: known.distance })
            .collect(),
        poses: session
            .tables
            .iter()
            .map(|table| PosesTable {
                file: table.path.to_string_lossy().into_owned(),
                load: table.load.map(load_name),
                step: table.step,
            })
            .collect(),
    };
    Ok(format!(
        "# Simulated: made by `gravcal simulate`. truth.toml holds the true values.\n{}",
        toml::to_string(&table)?
    ))
}

/// What is said of joints of which anything is.
fn joint_tables(simulation: &Simulation, session: &Session) -> Vec<JointTable> {
    let table = |(joint, described): (usize, &Joint)| JointTable {
        name: described.name.clone(),
        sensor_models: simulation.models.of(joint).to_vec(),
        rotor_inertia: session.rotors.get(joint).copied().flatten().map(|_| "unknown"),
    };
    let all = session.robot.chain.joints().iter().enumerate().map(table);
    all.filter(|table| !table.sensor_models.is_empty() || table.rotor_inertia.is_some()).collect()
}

/// The robot by its path relative to the session's folder.
fn robot_table(session: &Session, folder: &Path) -> RobotTable {
    let path = session.robot_file().unwrap_or(Path::new(""));
    let written = relative_path(folder, path);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf")) {
        let chain = &session.robot.chain;
        let mut tips: Vec<String> = chain.last_links().map(|link| chain.links()[link].name.clone()).collect();
        let tip = if tips.len() == 1 { Tip::One(tips.remove(0)) } else { Tip::Each(tips) };
        RobotTable::Urdf { urdf: written, base: chain.base().to_owned(), tip }
    } else {
        RobotTable::Toml(written)
    }
}

/// Columns of recordings are those that messages of joint states have.
pub(super) fn position_column(simulation: &Simulation, joint: usize) -> String {
    let session = &simulation.template;
    if simulation.motion.is_some() {
        return format!("{}.position", session.robot.chain.joints()[joint].name);
    }
    format!("{}_position_{}", session.robot.chain.joints()[joint].name, session.joints[joint].position_unit)
}

pub(super) fn torque_column(simulation: &Simulation, joint: usize) -> String {
    let session = &simulation.template;
    if simulation.motion.is_some() {
        return format!("{}.effort", session.robot.chain.joints()[joint].name);
    }
    let unit = torque_unit(session.joints[joint].torque_unit).replace('·', "");
    format!("{}_torque_{unit}", session.robot.chain.joints()[joint].name)
}

fn torque_unit(unit: Option<TorqueUnit>) -> &'static str {
    unit.map_or("", TorqueUnit::name)
}

fn table_bytes(simulation: &Simulation, session: &Session, table: usize) -> Result<Vec<u8>, WriteError> {
    let joints = 0..session.joints.len();
    let positions = joints.clone().map(|joint| position_column(simulation, joint));
    let torques = joints.map(|joint| torque_column(simulation, joint));
    let conditions = write_conditions::columns(session, &simulation.conditions);
    let instruments = simulation.instruments.columns.iter().flatten().cloned();
    let columns: Vec<String> = positions.chain(torques).chain(conditions).chain(instruments).collect();
    let rows: Vec<Vec<Cell>> = session
        .poses
        .iter()
        .filter(|pose| pose.table == table)
        .map(|pose| {
            let torques = pose.torque.iter().map(|reading| Cell::from(reading.as_ref().map(|r| r.value)));
            let own =
                pose.instruments.iter().zip(&simulation.instruments.columns).filter(|(_, column)| column.is_some());
            let instruments = own.map(|(reading, _)| Cell::from(reading.as_ref().map(|r| r.value)));
            let positions = pose.position.iter().map(|q| Cell::from(*q));
            positions.chain(torques).chain(write_conditions::cells(pose)).chain(instruments).collect()
        })
        .collect();
    table_contents(&session.tables[table].path, &[], &columns, &rows)
}

/// `truth.toml`, inside units.
#[derive(Serialize)]
struct TruthTable {
    gravity_m_per_s2: [f64; 3],
    /// After a second, unit of the reading.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    walk_per_root_s: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    friction_at_rest: Option<TrueFriction>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hysteresis: Option<Hysteresis>,
    #[serde(skip_serializing_if = "Option::is_none")]
    creep: Option<Creep>,
    parameter: Vec<TrueParameter>,
    /// What the session does not say.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unmodelled: Vec<TrueParameter>,
    load: Vec<TruePlacement>,
}

/// As the simulation says it, by joint.
#[derive(Serialize)]
struct TrueFriction {
    coulomb_newton_metre: Vec<f64>,
    per_torque: f64,
    presliding_rad: f64,
    lean: f64,
    spread: f64,
}

impl From<&FrictionAtRest> for TrueFriction {
    fn from(friction: &FrictionAtRest) -> TrueFriction {
        let FrictionAtRest { coulomb, per_torque, presliding, lean, spread } = friction.clone();
        TrueFriction { coulomb_newton_metre: coulomb, per_torque, presliding_rad: presliding, lean, spread }
    }
}

#[derive(Serialize)]
struct TrueParameter {
    name: String,
    value: f64,
    unit: String,
}

#[derive(Serialize)]
struct TruePlacement {
    name: String,
    position_m: [f64; 3],
}

fn truth_toml(simulation: &Simulation) -> Result<String, SimulateError> {
    let (session, truth) = (&simulation.template, &simulation.truth);
    let parameter = session.parameters().into_iter().map(|id| TrueParameter {
        name: session.parameter_name(id),
        value: truth.value(id),
        unit: session.parameter(id).unit,
    });
    let compliance = &simulation.disturbance.deflection.compliance;
    let compliances = compliance_parameters(session.robot.chain.joints(), compliance).into_iter().zip(compliance);
    let compliances = compliances.filter(|(_, value)| **value != 0.0).map(|(parameter, value)| TrueParameter {
        name: parameter.name(),
        value: *value,
        unit: parameter.unit,
    });
    let load = session.loads.iter().zip(&truth.loads);
    let unmodelled = simulation.unmodelled.parameters().map(|(parameter, value)| TrueParameter {
        name: parameter.name(),
        value,
        unit: parameter.unit.clone(),
    });
    let motion = simulation.motion.as_ref();
    let walk = motion.map(|motion| motion.walk.clone()).filter(|walk| walk.iter().any(|walk| *walk > 0.0));
    Ok(toml::to_string(&TruthTable {
        gravity_m_per_s2: truth.gravity,
        friction_at_rest: motion.and_then(|motion| motion.friction.as_ref()).map(TrueFriction::from),
        hysteresis: motion.and_then(|motion| motion.hysteresis.clone()),
        creep: motion.and_then(|motion| motion.creep),
        walk_per_root_s: walk.unwrap_or_default(),
        parameter: parameter.chain(compliances).collect(),
        unmodelled: unmodelled.collect(),
        load: load.map(|(load, position)| TruePlacement { name: load.name.clone(), position_m: *position }).collect(),
    })?)
}
