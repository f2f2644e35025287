//! What may stand in the sections of instruments.

use serde::Deserialize;

use crate::file::joints::Sign;
use crate::file::parameter_prior::ParameterPriorTable;
use crate::file::reading_columns::ReadingColumnsTable;
use crate::robot_file::MountingTable;

/// `[[force_torque_sensor]]`, on a last link.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct ForceTorqueTable {
    /// Its name in the results.
    ///
    /// Example: `name = "wrist"`
    pub(super) name: String,
    /// The link that carries it.
    ///
    /// Default: the only one.
    /// Example: `link = "link7"`
    pub(super) link: Option<String>,
    /// Its frame in the link's.
    ///
    /// Default: the link's frame.
    /// Example: `mounting = { position_m = [0, 0, 0.05], rpy_deg = [0, 0, 30] }`
    #[serde(default)]
    pub(super) mounting: MountingTable,
    /// In which frame forces and moments are given: the sensor's, or the base's.
    ///
    /// Default: `"sensor"`.
    /// Example: `frame = "base"`
    #[serde(default)]
    pub(super) frame: Frame,
    /// `"reversed"`: it reads the opposite.
    ///
    /// Default: `"normal"`.
    /// Example: `sign = "reversed"`
    pub(super) sign: Option<Sign>,
    /// The six columns: three forces, three moments. `unit = "N"` includes moments in N·m.
    ///
    /// Example: `readings = { columns = ["fx", "fy", "fz", "nx", "ny", "nz"], unit = "N", std = 0.5 }`
    pub(super) readings: ReadingColumnsTable,
    /// One gain for each axis, or a matrix.
    ///
    /// Default: `"axis"`.
    /// Example: `gains = "matrix"`
    #[serde(default)]
    pub(super) gains: Gains,
    /// One bias for all tables, or one for each table (zeroed before each).
    ///
    /// Default: `"session"`.
    /// Example: `biases = "table"`
    #[serde(default)]
    pub(super) biases: Biases,
    /// Drifts of the biases.
    ///
    /// Default: none.
    /// Example: `sensor_models = [{ kind = "bias-in-time" }]`
    #[serde(default)]
    pub(super) sensor_models: Vec<DriftTable>,
    /// What is known of the gain of each force axis.
    ///
    /// Default: 1 where it reads N.
    /// Example: `force_gain = { nominal = 20, std = 1, unit = "count/N" }`
    pub(super) force_gain: Option<ParameterPriorTable>,
    /// What is known of the gain of each moment axis.
    ///
    /// Default: 1 where it reads N·m.
    /// Example: `moment_gain = { nominal = 400, unit = "count/(N·m)" }`
    pub(super) moment_gain: Option<ParameterPriorTable>,
    /// What is known of the bias of each force axis.
    ///
    /// Default: unknown.
    /// Example: `force_bias = { nominal = 0, unit = "N" }`
    pub(super) force_bias: Option<ParameterPriorTable>,
    /// What is known of the bias of each moment axis.
    ///
    /// Default: unknown.
    /// Example: `moment_bias = { nominal = 0, unit = "N·m" }`
    pub(super) moment_bias: Option<ParameterPriorTable>,
    /// What is known of the mass that always hangs beyond it.
    ///
    /// Default: unknown.
    /// Example: `tool_mass = { nominal = 1.2, std = 0.01, unit = "kg" }`
    pub(super) tool_mass: Option<ParameterPriorTable>,
    /// What is known of the first moment of that mass.
    ///
    /// Default: unknown.
    /// Example: `tool_moment_x = { nominal = 0, unit = "kg·m" }`
    pub(super) tool_moment_x: Option<ParameterPriorTable>,
    /// The same along y.
    ///
    /// Default: unknown.
    /// Example: `tool_moment_y = { nominal = 0, unit = "kg·m" }`
    pub(super) tool_moment_y: Option<ParameterPriorTable>,
    /// The same along z.
    ///
    /// Default: unknown.
    /// Example: `tool_moment_z = { nominal = 0.06, unit = "kg·m" }`
    pub(super) tool_moment_z: Option<ParameterPriorTable>,
}

/// `[[accelerometer]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct AccelerometerTable {
    /// Its name in the results.
    ///
    /// Example: `name = "imu"`
    pub(super) name: String,
    /// The link that carries it.
    ///
    /// Default: the only one.
    /// Example: `link = "link1"`
    pub(super) link: Option<String>,
    /// Its frame in the link's.
    ///
    /// Default: the link's frame.
    /// Example: `mounting = { position_m = [0, 0, 0.05], rpy_deg = [0, 0, 30] }`
    #[serde(default)]
    pub(super) mounting: MountingTable,
    /// How well the mounting is known.
    ///
    /// Default: exact.
    /// Example: `mounting_std_deg = 2`
    pub(super) mounting_std_deg: Option<f64>,
    /// `"reversed"`: it reads the opposite.
    ///
    /// Default: `"normal"`.
    /// Example: `sign = "reversed"`
    pub(super) sign: Option<Sign>,
    /// The three columns.
    ///
    /// Example: `readings = { columns = ["ax", "ay", "az"], unit = "g", std = 0.001 }`
    pub(super) readings: ReadingColumnsTable,
    /// One gain for each axis, or a matrix.
    ///
    /// Default: `"axis"`.
    /// Example: `gains = "matrix"`
    #[serde(default)]
    pub(super) gains: Gains,
    /// One bias for all tables, or one for each table (zeroed before each).
    ///
    /// Default: `"session"`.
    /// Example: `biases = "table"`
    #[serde(default)]
    pub(super) biases: Biases,
    /// Drifts of the biases.
    ///
    /// Default: none.
    /// Example: `sensor_models = [{ kind = "bias-in-time" }]`
    #[serde(default)]
    pub(super) sensor_models: Vec<DriftTable>,
    /// What is known of the gain of each axis.
    ///
    /// Default: 1 in m/s².
    /// Example: `gain = { nominal = 0.102, unit = "g/(m/s²)" }`
    pub(super) gain: Option<ParameterPriorTable>,
    /// What is known of the bias of each axis.
    ///
    /// Default: unknown.
    /// Example: `bias = { nominal = 0, unit = "g" }`
    pub(super) bias: Option<ParameterPriorTable>,
}

/// One gain an axis, or a full matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Gains {
    #[default]
    Axis,
    Matrix,
}

/// One bias an axis for all of the session, or one for each table: of a sensor that is zeroed whenever a program starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Biases {
    #[default]
    Session,
    Table,
}

/// One of `sensor_models`: what biases drift with.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct DriftTable {
    /// Which drift.
    ///
    /// Example: `kind = "bias-in-time"`
    pub(super) kind: DriftKind,
    /// Temperature at which the bias is told.
    ///
    /// Unit: degC.
    /// Example: `reference_degC = 25`
    #[serde(rename = "reference_degC")]
    pub(super) reference_degc: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DriftKind {
    BiasInTime,
    BiasWithTemperature,
}

/// In which frame tables give what a wrist sensor reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    #[default]
    Sensor,
    Base,
}

impl Biases {
    /// How many each axis has.
    pub fn sets(self, tables: usize) -> usize {
        match self {
            Biases::Session => 1,
            Biases::Table => tables.max(1),
        }
    }
}
