//! The true values of the sensors.

use gravcal_recording::TorqueUnit;
use gravcal_robot_model::State;
use gravcal_robot_model::parameter::{Parameter, SensorParameter, same_in};
use gravcal_robot_model::sensors::{Need, Site, Term};
use gravcal_robot_model::session::rotors::rotor_inertia_unit;
use gravcal_robot_model::session::{ParameterPrior, PriorKind, Session, units};

use super::reader::Reader;
use super::tables::{ConditionsTable, JointTable};
use crate::document::{Field, FileError};
use crate::robot_file::{SensorTables, ValueTable};
use crate::sensor_models::{DeclaredInFile, ModelContext, ModelTable, ParameterInFile, declare, to_unit_of};
use crate::simulation::unmodelled::Unmodelled;

/// A term with its parameters and their true values, in units inside.
struct TrueTerm {
    term: Term,
    parameters: Vec<Parameter>,
    /// None where a parameter is shared and has its value elsewhere.
    values: Vec<Option<f64>>,
    /// Where each is said, or its model.
    fields: Vec<Field>,
}

fn unsaid(parameter: &Parameter) -> String {
    format!("what is the true {0}? add parameters = {{ {0} = {{ value, unit }} }}", parameter.quantity)
}

impl Reader<'_> {
    pub fn truth(&self, template: &mut Session) -> Result<State, FileError> {
        let mut truth = State::nominal(template);
        let direction = self.table.gravity.direction;
        let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        truth.gravity = direction.map(|c| template.gravity.magnitude * c / norm);
        truth.loads = self.table.load.iter().map(|load| load.position_m).collect();
        if let Some(link) = self.robot.chain.links().iter().find(|link| link.inertia.is_none()) {
            let message = format!("a simulation needs masses: the robot file gives none for link `{}`", link.name);
            return Err(self.document.error(&Field::new("robot"), message));
        }
        let fields = |index: usize| Field::new("joint").at(index);
        self.document.check_names(self.table.joint.iter().map(|j| j.name.as_str()), |i| fields(i).key("name"))?;
        for (index, table) in self.table.joint.iter().enumerate() {
            let field = fields(index);
            let joint = self.document.lookup(&field.key("name"), "joint", &table.name, &self.names())?;
            let tables = SensorTables {
                kind: self.kind(joint),
                torque: table.torque_sensor.as_ref(),
                position: table.position_sensor.as_ref(),
            };
            let sensors = tables.nominal(self.document, &field)?;
            self.models(joint, &field, table, template, &mut truth)?;
            let true_values = &mut truth.sensors[joint];
            if let Some(torque) = sensors.torque {
                self.same_unit(
                    &field,
                    "torque_sensor",
                    torque.unit.name(),
                    template.joints[joint].torque_unit.map(TorqueUnit::name),
                )?;
                true_values[SensorParameter::TorqueGain as usize] = torque.gain;
                true_values[SensorParameter::TorqueBias as usize] = torque.bias;
            }
            if let Some(position) = sensors.position {
                let unit = template.joints[joint].position_unit.name();
                self.same_unit(&field, "position_sensor", position.unit.si().name(), Some(unit))?;
                true_values[SensorParameter::PositionGain as usize] = position.gain;
                true_values[SensorParameter::PositionOffset as usize] = position.offset;
            }
        }
        self.rotors(template, &mut truth)?;
        let root = self.robot.chain.root_joint();
        if root.is_some_and(|root| truth.sensors[root][SensorParameter::PositionOffset as usize] != 0.0) {
            let message = "the first joint's offset is zero by definition of the base frame: turn gravity instead";
            return Err(self.document.error(&Field::new("joint"), message));
        }
        Ok(truth)
    }

    /// What motors turn before their gears, behind the parameters of all sensors: the session declares it, and does not know how much.
    fn rotors(&self, template: &mut Session, truth: &mut State) -> Result<(), FileError> {
        let moves = self.table.recording.as_ref().is_some_and(|recording| recording.motion.is_some());
        for (index, table) in self.table.joint.iter().enumerate() {
            let field = Field::new("joint").at(index).key("rotor_inertia");
            let refused = |key: &str, message: String| self.document.error(&field.key(key), message);
            let (Some(said), Some(joint)) =
                (&table.rotor_inertia, self.names().iter().position(|name| *name == table.name))
            else {
                continue;
            };
            if !moves {
                let message = "an arm that stands does not feel it: add motion to [recording], or delete this";
                return Err(self.document.error(&field, message));
            }
            let unit = rotor_inertia_unit(self.kind(joint));
            units::same(said.unit(), unit).map_err(|error| refused("unit", error.to_string()))?;
            if !(0.0..f64::INFINITY).contains(&said.value) {
                let message = format!("{} {unit} is no inertia of a rotor: expected zero or more", said.value);
                return Err(refused("value", message));
            }
            template.set_rotor_inertia(joint, ParameterPrior { nominal: 0.0, kind: PriorKind::Flat });
            truth.further.push(said.value);
        }
        Ok(())
    }

    /// What a joint's sensors do beyond gain and bias: the session declares it, and does not know how much.
    fn models(
        &self,
        joint: usize,
        field: &Field,
        table: &JointTable,
        template: &mut Session,
        truth: &mut State,
    ) -> Result<(), FileError> {
        for found in self.true_terms(joint, &field.key("sensor_models"), &table.sensor_models, template)? {
            for ((parameter, value), field) in found.parameters.into_iter().zip(found.values).zip(&found.fields) {
                let (parameter, value) = self.shared(joint, (template, truth), (parameter, value), field)?;
                truth.further.push(value);
                template.further.push(parameter);
            }
            template.terms.extend([found.term]);
        }
        Ok(())
    }

    /// A parameter with its true value; where several sensors share it, that of the first.
    fn shared(
        &self,
        joint: usize,
        (template, truth): (&Session, &State),
        (parameter, value): (Parameter, Option<f64>),
        field: &Field,
    ) -> Result<(Parameter, f64), FileError> {
        let refuse = |message: String| self.document.error(field, message);
        let place = match parameter.owner == self.names()[joint] {
            true => None,
            false => same_in(&template.further, &parameter).map_err(refuse)?,
        };
        let Some(place) = place else {
            let value = value.ok_or_else(|| refuse(unsaid(&parameter)))?;
            return Ok((parameter, value));
        };
        let first = truth.further[place];
        match value {
            Some(value) if value != first => Err(refuse(format!(
                "{} is shared, and truly {first} where it stands first: say the same, or nothing",
                parameter.name()
            ))),
            _ => Ok((Parameter { same_as: Some(place), ..template.further[place].clone() }, first)),
        }
    }

    /// What the sensors of all joints do besides, and no session says.
    pub fn unmodelled(&self, template: &Session) -> Result<Unmodelled, FileError> {
        let mut unmodelled = Unmodelled::none(template);
        for (index, table) in self.table.joint.iter().enumerate() {
            let Some(joint) = self.names().iter().position(|name| *name == table.name) else { continue };
            let field = Field::new("joint").at(index).key("unmodelled");
            for found in self.true_terms(joint, &field, &table.unmodelled, template)? {
                let said = found.values.iter().zip(&found.parameters).zip(&found.fields);
                let value = |((value, parameter), field): ((&Option<f64>, &Parameter), &Field)| {
                    value.ok_or_else(|| self.document.error(field, unsaid(parameter)))
                };
                let values = said.map(value).collect::<Result<_, FileError>>()?;
                unmodelled.add(found.term, found.parameters, values);
            }
        }
        Ok(unmodelled)
    }

    fn true_terms(
        &self,
        joint: usize,
        field: &Field,
        tables: &[ModelTable<ValueTable>],
        template: &Session,
    ) -> Result<Vec<TrueTerm>, FileError> {
        let (names, kinds) = (self.names(), self.robot.chain.joints().iter().map(|j| j.kind).collect::<Vec<_>>());
        let site = Site::new(joint, &names, &kinds, &template.joints[joint]);
        let (conditions, moves) = (self.table.conditions.as_ref(), self.table.recording.is_some());
        let said = |says: &dyn Fn(&ConditionsTable) -> bool| conditions.is_some_and(says);
        let knows = |need| match need {
            Need::Time => moves || said(&|table| table.pose_interval_s.is_some()),
            Need::Temperature => said(&|table| table.temperature_degc.is_some()),
            Need::Presliding => self.table.recording.as_ref().is_some_and(|table| table.motion.is_some()),
            Need::Velocity if self.table.recording.as_ref().is_some_and(|table| table.motion.is_some()) => true,
            Need::Velocity => said(&|table| table.largest_speed_rad_or_m_per_s.is_some()),
            Need::Direction => moves || said(&|table| table.direction || table.largest_speed_rad_or_m_per_s.is_some()),
        };
        let true_value = |ParameterInFile { parameter, field, said }: &ParameterInFile<'_, ValueTable>| {
            let Some(said) = said else {
                let is_shared = parameter.owner != names[joint];
                return if is_shared { Ok(None) } else { Err(self.document.error(field, unsaid(parameter))) };
            };
            let factor = to_unit_of(&parameter.unit, said.unit());
            let factor = factor.map_err(|message| self.document.error(&field.key("unit"), message))?;
            Ok(Some(said.value * factor))
        };
        let with_values = |DeclaredInFile { term, parameters }: DeclaredInFile<'_, ValueTable>| {
            let values = parameters.iter().map(true_value).collect::<Result<_, FileError>>()?;
            let fields = parameters.iter().map(|own| own.field.clone()).collect();
            Ok(TrueTerm { term, parameters: parameters.into_iter().map(|own| own.parameter).collect(), values, fields })
        };
        let context = ModelContext { document: self.document, registry: self.registry, models: field.clone() };
        declare(&context, &site, tables, knows, |_| false)?.into_iter().map(with_values).collect()
    }

    fn same_unit(&self, field: &Field, key: &str, found: &str, readings: Option<&str>) -> Result<(), FileError> {
        if readings == Some(found) {
            return Ok(());
        }
        let readings = readings.unwrap_or("nothing");
        let message = format!("a gain for readings in {found}, but the readings are in {readings}");
        Err(self.document.error(&field.key(key), message))
    }
}
