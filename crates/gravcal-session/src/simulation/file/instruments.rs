//! Instruments in `simulation.toml`: the sections of the session, and under `[instrument_truth.NAME]` what is true.

use std::collections::BTreeMap;
use std::path::Path;

use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::AuxiliarySensor;
use serde::Deserialize;

use crate::document::{Document, Field, FileError};
use crate::file::{AccelerometerTable, ForceTorqueTable, Instruments, read_instruments};
use crate::simulation::experiment::SimulatedInstruments;

/// The part of the file.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct InstrumentTables {
    /// Force-torque sensors, as in a session.
    ///
    /// Default: none.
    /// Example: `force_torque_sensor = []`
    force_torque_sensor: Vec<ForceTorqueTable>,
    /// Accelerometers, as in a session.
    ///
    /// Default: none.
    /// Example: `accelerometer = []`
    accelerometer: Vec<AccelerometerTable>,
    /// True values of these, by name.
    ///
    /// Default: nominal.
    /// Example: `instrument_truth = { wrist = { tool_mass_kg = 1.2 } }`
    instrument_truth: BTreeMap<String, TruthTable>,
}

/// The same as it will stand in the session.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Sections {
    force_torque_sensor: Vec<toml::Table>,
    accelerometer: Vec<toml::Table>,
}

/// True values; what is not said is as the session says.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
struct TruthTable {
    /// Gains, one for each axis or the whole matrix row by row.
    ///
    /// Unit: the reading's, over N, N·m or m/s².
    /// Default: nominal.
    /// Example: `gains = [1.02, 0.99, 1.0]`
    gains: Option<Vec<f64>>,
    /// Biases, one for each axis.
    ///
    /// Unit: the reading's.
    /// Default: 0.
    /// Example: `biases = [0.1, -0.2, 0.0]`
    biases: Option<Vec<f64>>,
    /// Mass that hangs beyond a force-torque sensor.
    ///
    /// Default: 0.
    /// Example: `tool_mass_kg = 1.2`
    tool_mass_kg: Option<f64>,
    /// Its first moment.
    ///
    /// Default: 0.
    /// Example: `tool_moment_kg_m = [0, 0, 0.06]`
    tool_moment_kg_m: Option<[f64; 3]>,
    /// Rotation vector by which the mounting is off.
    ///
    /// Default: 0.
    /// Example: `mounting_rotation_deg = [0.5, 0, 0]`
    mounting_rotation_deg: Option<[f64; 3]>,
}

/// What the sections come to.
pub(super) struct Read {
    pub instruments: Instruments,
    /// True values of their parameters.
    pub truth: Vec<f64>,
    /// Standard deviation of each axis.
    pub std: Vec<f64>,
    pub simulated: SimulatedInstruments,
}

pub(super) fn read(document: &Document, robot: &Robot, robot_path: &Path, poses: usize) -> Result<Read, FileError> {
    let (tables, sections): (InstrumentTables, Sections) = (document.parse()?, document.parse()?);
    let written = (&tables.force_torque_sensor[..], &tables.accelerometer[..]);
    let instruments = read_instruments(document, robot, robot_path, written, poses)?;
    let names: Vec<&str> = instruments.instruments.iter().map(|instrument| instrument.name.as_str()).collect();
    if let Some(wrist) = instruments.instruments.iter().position(|instrument| instrument.in_base) {
        let message = "a simulated sensor reads in its own frame: delete this";
        return Err(document.error(&Field::new("force_torque_sensor").at(wrist).key("frame"), message));
    }
    if let Some(place) = instruments.instruments.iter().position(|instrument| !instrument.drifts.is_empty()) {
        let message = format!(
            "the biases of a simulated instrument do not drift: delete the sensor_models of `{}`",
            names[place]
        );
        return Err(document.error(&Field::new("instrument_truth"), message));
    }
    let mut truth: Vec<f64> = instruments.parameters.iter().map(|p| p.prior.nominal).collect();
    for (name, table) in &tables.instrument_truth {
        let field = Field::new("instrument_truth").key(name);
        let place = document.lookup(&field, "instrument", name, &names)?;
        table.set(document, &field, &instruments.instruments[place], &mut truth)?;
    }
    let std = instruments.columns.iter().map(|column| column.as_ref().map_or(Some(0.0), |column| column.std));
    let std = std.collect::<Option<Vec<f64>>>().ok_or_else(|| {
        let message = "a simulated instrument needs to be told its noise: add std to the readings of each";
        document.error(&Field::new("force_torque_sensor"), message)
    })?;
    let columns = instruments.columns.iter().map(|column| column.as_ref().map(|c| c.column.clone())).collect();
    let Sections { force_torque_sensor, accelerometer } = sections;
    Ok(Read {
        instruments,
        truth,
        std,
        simulated: SimulatedInstruments { force_torque_sensor, accelerometer, columns },
    })
}

impl TruthTable {
    fn set(
        &self,
        document: &Document,
        field: &Field,
        instrument: &AuxiliarySensor,
        truth: &mut [f64],
    ) -> Result<(), FileError> {
        let own = instrument.own_parameters();
        let is_tool = own.len() == 4;
        let rotation = self.mounting_rotation_deg.map(|angles| angles.map(f64::to_radians).to_vec());
        let parts = [
            ("gains", instrument.gain_parameters(), self.gains.clone()),
            ("biases", instrument.bias_parameters(), self.biases.clone()),
            ("tool_mass_kg", own.start..own.start + 1, self.tool_mass_kg.map(|mass| vec![mass])),
            ("tool_moment_kg_m", own.start + 1..own.end, self.tool_moment_kg_m.map(|moment| moment.to_vec())),
            ("mounting_rotation_deg", own, rotation),
        ];
        for (key, places, values) in parts {
            let Some(values) = values else { continue };
            let wrong_kind = key.starts_with("tool") && !is_tool || key.starts_with("mounting") && is_tool;
            if wrong_kind || values.len() != places.len() {
                let expected = if wrong_kind { 0 } else { places.len() };
                let message = format!("expected {expected} values for `{}`, found {}", instrument.name, values.len());
                return Err(document.error(&field.key(key), message));
            }
            truth[places].copy_from_slice(&values);
        }
        Ok(())
    }
}
