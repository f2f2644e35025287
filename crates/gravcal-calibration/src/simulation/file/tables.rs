//! What `simulation.toml` may hold.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::document::OneOrMany;
use crate::robot::{PositionSensorTable, RobotSource, TorqueSensorTable, ValueTable};
use crate::sensors::ModelTable;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationTable {
    pub robot: RobotSource,
    pub seed: u64,
    pub gravity: GravityTable,
    pub torque: TorqueTable,
    pub position: PositionTable,
    #[serde(default)]
    pub deflection: DeflectionTable,
    pub conditions: Option<ConditionsTable>,
    pub recording: Option<RecordingTable>,
    #[serde(default)]
    pub joint: Vec<JointTable>,
    // The next three are read by `instruments`; here they are only known to be there.
    #[serde(default, rename = "force_torque_sensor")]
    _force_torque_sensor: IgnoredAny,
    #[serde(default, rename = "accelerometer")]
    _accelerometer: IgnoredAny,
    #[serde(default, rename = "instrument_truth")]
    _instrument_truth: IgnoredAny,
    #[serde(default)]
    pub load: Vec<LoadTable>,
    #[serde(default)]
    pub load_distance: Vec<LoadDistanceTable>,
    #[serde(default)]
    pub sweep: Vec<SweepTable>,
    #[serde(default)]
    pub random: Vec<RandomTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GravityTable {
    pub direction: [f64; 3],
    pub magnitude_m_per_s2: f64,
    pub hemisphere: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueTable {
    pub unit: Option<OneOrMany<String>>,
    pub std: OneOrMany<f64>,
    pub converter: Option<ConverterTable>,
    pub outliers: Option<OutliersTable>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutliersTable {
    pub share: f64,
    pub std: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConverterTable {
    pub bits: u32,
    pub range: [f64; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionTable {
    pub unit: Option<OneOrMany<String>>,
    pub std: Option<OneOrMany<f64>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeflectionTable {
    pub hold_std_deg: Option<f64>,
    pub pose_std_deg: Option<f64>,
    #[serde(default)]
    pub seen: bool,
    pub compliance_rad_per_newton_metre: Option<OneOrMany<f64>>,
}

/// See [`Motion`](crate::simulation::Motion).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingTable {
    pub rate_hz: f64,
    pub samples: usize,
    pub move_s: f64,
    pub settling_s: Option<f64>,
    pub vibration: Option<f64>,
    pub settling_time_constant_s: Option<f64>,
    pub noise_correlation_s: Option<f64>,
    pub approach: Option<String>,
    pub friction: Option<FrictionTable>,
    pub walk_per_root_s: Option<OneOrMany<f64>>,
    pub outliers: Option<f64>,
    pub dropped: Option<f64>,
    pub touched: Option<usize>,
}

/// See [`FrictionAtRest`](crate::simulation::FrictionAtRest).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionTable {
    pub coulomb_newton_metre: OneOrMany<f64>,
    pub per_torque: Option<f64>,
    pub presliding_rad: Option<f64>,
    pub lean: Option<f64>,
    pub spread: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConditionsTable {
    pub pose_interval_s: Option<f64>,
    #[serde(rename = "temperature_degC")]
    pub temperature_degc: Option<[f64; 2]>,
    pub largest_speed_rad_or_m_per_s: Option<f64>,
    #[serde(default)]
    pub direction: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointTable {
    pub name: String,
    pub torque_sensor: Option<TorqueSensorTable>,
    pub position_sensor: Option<PositionSensorTable>,
    #[serde(default)]
    pub sensor_models: Vec<ModelTable<ValueTable>>,
    #[serde(default)]
    pub unmodelled: Vec<ModelTable<ValueTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTable {
    pub name: String,
    pub mass_kg: f64,
    pub link: String,
    pub position_m: [f64; 3],
    /// Whether the session is told the position.
    #[serde(default)]
    pub position_known: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadDistanceTable {
    pub between: [String; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepTable {
    pub file: PathBuf,
    pub joint: String,
    pub range_deg: [f64; 2],
    pub poses: usize,
    pub held_deg: Option<BTreeMap<String, f64>>,
    pub held_rad: Option<BTreeMap<String, f64>>,
    pub load: Option<String>,
    pub step: Option<u8>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomTable {
    pub file: PathBuf,
    pub poses: usize,
    pub load: Option<String>,
}
