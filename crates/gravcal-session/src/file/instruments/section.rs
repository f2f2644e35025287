//! One instrument with its parameters.

use gravcal_robot_model::parameter::{Limit, Parameter};
use gravcal_robot_model::session::parameters::GIVEN;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, Drift, ParameterPrior, PriorKind, units};

use super::found::Instruments;
use super::tables::{DriftKind, DriftTable, Gains};
use crate::document::{Field, FileError};
use crate::file::context::Context;
use crate::file::joints::{Sign, factor};
use crate::file::parameter_prior::{ParameterPriorTable, start};
use crate::file::reading_columns::{ReadingColumns, ReadingColumnsTable};
use crate::file::unexplained;
use crate::robot_file::MountingTable;

/// Standard deviation beyond which a number would mislead: share of a gain, kg, kg·m, rad.
const GAIN_LIMIT: f64 = 0.1;
const MASS_LIMIT: f64 = 0.1;
const MOMENT_LIMIT: f64 = 0.01;
const ANGLE_LIMIT: f64 = 0.1;
/// A tool of which nothing is said starts as 1 kg a few centimetres from the sensor, in no special direction.
const SOME_TOOL: [f64; 4] = [1.0, 0.03, 0.02, 0.05];

const CONVENTION: &str = "reading = gain * sensed + bias";
const CONVENTION_BY_TABLE: &str = "reading = gain * sensed + bias of its table, numbered as the [[poses]]";
const CONVENTION_IN_BASE: &str = "reading, turned from the base's frame into the sensor's, = gain * sensed + bias";
const TOOL_CONVENTION: &str = "force = -mass * gravity, moment = gravity x first moment, in the sensor's frame";
const ROTATION_CONVENTION: &str = "rotation vector from the stated mounting to the true one";

/// Convention of a drift, and what would determine it.
type DriftWords = (&'static str, &'static str);
const IN_TIME: DriftWords = (
    "reading = ... + bias_drift * (time since the first pose)",
    "record poses of the same kind again, hours later and without zeroing the sensor",
);
const WITH_TEMPERATURE: DriftWords = (
    "reading = ... + bias_temperature_drift * (temperature - reference_degC)",
    "record poses of the same kind again with the sensor some kelvins warmer or colder",
);

/// What would determine what the data do not.
const TURN_MORE: &str = "add poses that turn the instrument in more directions";
const FORCE_SCALE: &str = "take the gains of readings in N at their word, force_gain = { fixed = 1, unit = \"N/N\" }; or state \
                           tool_mass; or record poses with a load of known mass beyond the sensor besides those without, at two \
                           placements for a matrix of gains";
const FORCE_SCALE_BESIDE_MASS: &str = "take the gains of readings in N at their word, force_gain = { fixed = 1, unit = \"N/N\" }; or \
                                       record poses with a load of known mass beyond the sensor besides those without, at two \
                                       placements for a matrix of gains";
const MOMENT_SCALE: &str = "take the gains of readings in N·m at their word, moment_gain = { fixed = 1, unit = \"N·m/(N·m)\" }; or \
                            state tool_moment_x, tool_moment_y and tool_moment_z; or record poses with a load of known mass at a \
                            known place beyond the sensor besides those without, at two placements for a matrix of gains";
const STATE_MOUNTING: &str = "state how the instrument is mounted (mounting, with a smaller mounting_std_deg or none), and \
                              turn the joints before it further";

/// Gain and bias of three axes, as they are written.
pub type Group<'a> = (&'a Option<ParameterPriorTable>, &'a Option<ParameterPriorTable>);

/// Keys of the groups of axes.
fn keys(kind: AuxiliarySensorKind, group: usize) -> [&'static str; 2] {
    match (kind, group) {
        (AuxiliarySensorKind::ForceTorque, 0) => ["force_gain", "force_bias"],
        (AuxiliarySensorKind::ForceTorque, _) => ["moment_gain", "moment_bias"],
        (AuxiliarySensorKind::Accelerometer, _) => ["gain", "bias"],
    }
}

/// One instrument and where it stands.
pub struct Section<'a> {
    pub context: &'a Context<'a>,
    pub field: Field,
    pub kind: AuxiliarySensorKind,
    pub name: &'a str,
    pub sign: Option<Sign>,
}

impl Section<'_> {
    fn error(&self, key: &str, message: impl std::fmt::Display) -> FileError {
        self.context.document.error(&self.field.key(key), message)
    }

    /// The instrument with its gains and biases.
    pub fn add(
        &self,
        all: &mut Instruments,
        (link, mounting): (usize, MountingTable),
        readings: &ReadingColumnsTable,
        (gains, biases, groups): (Gains, usize, &[Group<'_>]),
    ) -> Result<(), FileError> {
        let axes = self.kind.axes();
        let columns = ReadingColumns::new(self.context, &self.field.key("readings"), axes, readings)?;
        all.unexplained.extend(unexplained::said(self.context, &self.field.key("readings"), axes, readings)?);
        let mut units = Vec::new();
        for axis in 0..axes.len() {
            let unit = if columns.have_units_of_their_own() { units::sensed_reading } else { units::sensed_by_all };
            let read = columns.of(axis, |written| unit(written, self.kind, axis))?;
            let (column, unit) = read.unzip();
            all.columns.push(column);
            units.push(unit);
        }
        let entries: Vec<(usize, usize)> = (0..axes.len())
            .flat_map(|reading| (0..axes.len()).map(move |sensed| (reading, sensed)))
            .filter(|(reading, sensed)| gains == Gains::Matrix || reading == sensed)
            .collect();
        let first = all.parameters.len();
        let own = self.own_gains(&units, groups)?;
        all.parameters.extend(entries.iter().map(|entry| self.gain(*entry, &units, &own)));
        for set in (1..=biases).map(|set| (biases > 1).then_some(set)) {
            for axis in 0..axes.len() {
                let channel = self.context.joint_names.len() + all.columns.len() - axes.len() + axis;
                all.parameters.push(self.bias((axis, set), &units, groups[axis / 3].1, channel)?);
            }
        }
        all.instruments.push(AuxiliarySensor {
            name: self.name.to_owned(),
            kind: self.kind,
            link,
            mounting: mounting.transform(),
            first_reading: all.columns.len() - axes.len(),
            in_base: false,
            sign_declared: self.sign.is_some(),
            units,
            gains: entries,
            biases,
            drifts: Vec::new(),
            first_parameter: first,
        });
        Ok(())
    }

    /// Lets the tables give what the instrument, the last one, reads in the base's frame.
    pub fn enter_in_base(&self, all: &mut Instruments) -> Result<(), FileError> {
        let Some(instrument) = all.instruments.last_mut() else { return Ok(()) };
        for units in instrument.units.chunks(3) {
            if units.iter().any(|unit| *unit != units[0]) {
                let message = "only three axes of one unit can be turned into the sensor's frame: name the columns of all three \
                               forces, in one unit, and so of the moments (or of none of them)";
                return Err(self.error("frame", message));
            }
        }
        instrument.in_base = true;
        let first = instrument.first_parameter;
        let whole = [CONVENTION, CONVENTION_BY_TABLE];
        let readings = all.parameters[first..].iter_mut().filter(|parameter| whole.contains(&&*parameter.convention));
        readings.for_each(|parameter| parameter.convention = CONVENTION_IN_BASE.into());
        Ok(())
    }

    /// Knowledge of the gain of each axis for what it senses itself.
    fn own_gains(&self, units: &[Option<String>], groups: &[Group<'_>]) -> Result<Vec<ParameterPrior>, FileError> {
        let prior = |(axis, unit): (usize, &Option<String>)| {
            let [key, _] = keys(self.kind, axis / 3);
            let sensed = self.kind.sensed_unit(axis);
            match (unit, groups[axis / 3].0) {
                (None, None) => Ok(start(factor(self.sign))),
                (Some(unit), Some(table)) => {
                    let field = self.field.key(key);
                    let expected = units::gain_of(unit, sensed);
                    let turned = |unit: &str| units::same(Some(unit), &expected).is_ok();
                    units::same(table.unit(), &expected)
                        .map_err(|error| error.of_gain(table.value(), turned))
                        .map_err(|error| self.context.document.error(&field.key("unit"), error))?;
                    table.gain(self.context.document, &field, factor(self.sign))
                }
                (Some(unit), None) => units::natural_gain(unit, sensed).map(|gain| start(factor(self.sign) * gain)).ok_or_else(|| {
                    let message = format!(
                        "readings of `{}` are in {unit}, and nothing says roughly what that is: add {key} = {{ nominal = \
                         ..., unit = \"{}\" }}",
                        self.name,
                        units::gain_of(unit, sensed)
                    );
                    self.context.document.error(&self.field, message)
                }),
                (None, Some(table)) => table.gain(self.context.document, &self.field.key(key), factor(self.sign)),
            }
        };
        units.iter().enumerate().map(prior).collect()
    }

    fn gain(&self, (reading, sensed): (usize, usize), units: &[Option<String>], own: &[ParameterPrior]) -> Parameter {
        let axes = self.kind.axes();
        let unit = units[reading].as_deref().unwrap_or("1");
        let (quantity, prior, limit) = if reading == sensed {
            (format!("gain_{}", axes[reading]), own[reading], Limit::ShareOfNominal(GAIN_LIMIT))
        } else {
            let limit = Limit::Absolute(GAIN_LIMIT * own[sensed].nominal.abs());
            (format!("gain_{}_{}", axes[reading], axes[sensed]), start(0.0), limit)
        };
        let cure = match self.kind {
            AuxiliarySensorKind::ForceTorque if sensed < 3 => FORCE_SCALE,
            AuxiliarySensorKind::ForceTorque => MOMENT_SCALE,
            AuxiliarySensorKind::Accelerometer => TURN_MORE,
        };
        Parameter {
            limit,
            cure: cure.into(),
            ..self.parameter(quantity, units::gain_of(unit, self.kind.sensed_unit(sensed)), CONVENTION, prior)
        }
        .unread_unless(units[reading].is_some())
    }

    /// `set`: number of the table, where each has its own.
    fn bias(
        &self,
        (axis, set): (usize, Option<usize>),
        units: &[Option<String>],
        written: &Option<ParameterPriorTable>,
        channel: usize,
    ) -> Result<Parameter, FileError> {
        let [_, key] = keys(self.kind, axis / 3);
        let unit = units[axis].clone().unwrap_or_else(|| "1".to_owned());
        let prior = match written {
            None => start(0.0),
            Some(table) => {
                let field = self.field.key(key);
                units::same(table.unit(), &unit)
                    .map_err(|error| self.context.document.error(&field.key("unit"), error))?;
                table.prior(self.context.document, &field)?
            }
        };
        let name = format!("bias_{}", self.kind.axes()[axis]);
        let (name, convention) = match set {
            None => (name, CONVENTION),
            Some(set) => (format!("{name}_{set}"), CONVENTION_BY_TABLE),
        };
        let parameter = self.parameter(name, unit, convention, prior);
        let parameter = Parameter { limit: Limit::HalfSpread { channel }, linear: true, ..parameter };
        Ok(parameter.unread_unless(units[axis].is_some()))
    }

    /// What the biases of the instrument, the last one, drift with.
    pub fn add_drifts(&self, all: &mut Instruments, tables: &[DriftTable]) -> Result<(), FileError> {
        let number = all.instruments.len() - 1;
        let Some(instrument) = all.instruments.last_mut() else { return Ok(()) };
        for (index, table) in tables.iter().enumerate() {
            let field = self.field.key("sensor_models").at(index);
            let refuse = |key: &str, message: &str| Err(self.context.document.error(&field.key(key), message));
            if tables[..index].iter().any(|other| other.kind == table.kind) {
                return refuse("kind", "this stands here already: delete one");
            }
            let (drift, name, unit, words) = match (table.kind, table.reference_degc) {
                (DriftKind::BiasInTime, None) => (Drift::Time, "drift", "s", IN_TIME),
                (DriftKind::BiasInTime, Some(_)) => {
                    return refuse("reference_degC", "only a drift with temperature has one: delete this");
                }
                (DriftKind::BiasWithTemperature, Some(reference)) => {
                    let place = self.context.joint_names.len() + number;
                    (Drift::Temperature { place, reference }, "temperature_drift", "K", WITH_TEMPERATURE)
                }
                (DriftKind::BiasWithTemperature, None) => {
                    let message = "at which temperature is the bias the bias? add reference_degC, such as 25";
                    return refuse("reference_degC", message);
                }
            };
            instrument.drifts.push(drift);
            for (axis, read) in instrument.units.iter().enumerate() {
                let unit = format!("{}/{unit}", read.as_deref().unwrap_or("1"));
                let channel = self.context.joint_names.len() + instrument.first_reading + axis;
                let name = format!("bias_{}_{name}", self.kind.axes()[axis]);
                let parameter = self.parameter(name, unit, words.0, start(0.0));
                let limit = Limit::HalfSpread { channel };
                let parameter = Parameter { limit, cure: words.1.into(), linear: true, ..parameter };
                all.parameters.push(parameter.unread_unless(read.is_some()));
            }
        }
        Ok(())
    }

    /// Mass and first moment of what always hangs beyond the sensor.
    pub fn add_tool(
        &self,
        all: &mut Instruments,
        mass: &Option<ParameterPriorTable>,
        moments: [&Option<ParameterPriorTable>; 3],
    ) -> Result<(), FileError> {
        let written = [
            ("tool_mass", mass, "kg", MASS_LIMIT),
            ("tool_moment_x", moments[0], "kg·m", MOMENT_LIMIT),
            ("tool_moment_y", moments[1], "kg·m", MOMENT_LIMIT),
            ("tool_moment_z", moments[2], "kg·m", MOMENT_LIMIT),
        ];
        for ((key, written, unit, limit), nominal) in written.into_iter().zip(SOME_TOOL) {
            let field = self.field.key(key);
            let prior = match written {
                None => start(nominal),
                Some(table) => {
                    units::same(table.unit(), unit).map_err(|error| self.error(key, error))?;
                    table.prior(self.context.document, &field)?
                }
            };
            let parameter = self.parameter(key.to_owned(), unit.to_owned(), TOOL_CONVENTION, prior);
            let limit = Limit::Absolute(limit);
            let cure = if key == "tool_mass" { FORCE_SCALE } else { MOMENT_SCALE };
            all.parameters.push(Parameter { limit, cure: cure.into(), linear: true, ..parameter });
        }
        let Some(instrument) = all.instruments.last() else { return Ok(()) };
        let (own, first) = (instrument.own_parameters(), instrument.first_parameter);
        if all.parameters[own.start].prior.kind != PriorKind::Flat {
            let scaled = all.parameters[first..].iter_mut().filter(|parameter| parameter.cure == FORCE_SCALE);
            scaled.for_each(|parameter| parameter.cure = FORCE_SCALE_BESIDE_MASS.into());
        }
        Ok(())
    }

    /// How the true mounting is turned from the stated one.
    pub fn add_rotation(&self, all: &mut Instruments, std_deg: Option<f64>) -> Result<(), FileError> {
        let key = self.field.key("mounting_std_deg");
        let positive = |std| self.context.document.positive(&key, std, "a standard deviation", "deg (or leave it out)");
        let kind = match std_deg.map(positive).transpose()? {
            None => PriorKind::Fixed,
            Some(std) => PriorKind::Gaussian { std: std.to_radians() },
        };
        for axis in ["x", "y", "z"] {
            let prior = ParameterPrior { nominal: 0.0, kind };
            let name = format!("mounting_{axis}");
            let parameter = self.parameter(name, "rad".to_owned(), ROTATION_CONVENTION, prior);
            let limit = Limit::Absolute(ANGLE_LIMIT);
            all.parameters.push(Parameter { limit, cure: STATE_MOUNTING.into(), ..parameter });
        }
        Ok(())
    }

    fn parameter(&self, quantity: String, unit: String, convention: &'static str, prior: ParameterPrior) -> Parameter {
        Parameter {
            owner: self.name.to_owned(),
            quantity,
            unit,
            convention: convention.into(),
            fixed: (prior.kind == PriorKind::Fixed).then_some(GIVEN),
            prior,
            limit: Limit::ShareOfNominal(GAIN_LIMIT),
            cure: TURN_MORE.into(),
            linear: false,
            same_as: None,
        }
    }
}
