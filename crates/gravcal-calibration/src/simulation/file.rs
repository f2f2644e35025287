//! Reads `simulation.toml`.

mod instruments;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gravcal_estimation::Loss;
use gravcal_kinematics::JointKind;
use gravcal_recording::{PositionUnit, TorqueUnit};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::{Converter, Deflection, Disturbance, Run, SimulatedConditions, Simulation};
use crate::document::{Document, Field, FileError, OneOrMany};
use crate::joint::Unknowns;
use crate::parameter::Quantity;
use crate::robot::{
    PositionSensorTable, Robot, RobotSource, SensorTables, TorqueSensorTable, ValueTable, resolve_robot,
};
use crate::sensors::{DeclaredModels, ModelTable, Need, SensorTerms, Site, declare, to_unit_of};
use crate::session::{
    Ask, Constraints, GravityKnowledge, InertiaKnowledge, JointKnowledge, Knowledge, KnowledgeKind, Load, LoadDistance,
    PoseTable, Session, UncertaintyChoice, units,
};

/// Poses of one table at most: a day of standing still for a second each.
const MOST_POSES: usize = 100_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SimulationTable {
    robot: RobotSource,
    seed: u64,
    gravity: GravityTable,
    torque: TorqueTable,
    position: PositionTable,
    #[serde(default)]
    deflection: DeflectionTable,
    #[serde(default)]
    conditions: ConditionsTable,
    #[serde(default)]
    joint: Vec<JointTable>,
    // The next three are read by `instruments`; here they are only known to be there.
    #[serde(default, rename = "force_torque_sensor")]
    _force_torque_sensor: IgnoredAny,
    #[serde(default, rename = "accelerometer")]
    _accelerometer: IgnoredAny,
    #[serde(default, rename = "instrument_truth")]
    _instrument_truth: IgnoredAny,
    #[serde(default)]
    load: Vec<LoadTable>,
    #[serde(default)]
    load_distance: Vec<LoadDistanceTable>,
    #[serde(default)]
    sweep: Vec<SweepTable>,
    #[serde(default)]
    random: Vec<RandomTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GravityTable {
    direction: [f64; 3],
    magnitude_m_per_s2: f64,
    hemisphere: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TorqueTable {
    unit: Option<String>,
    std: OneOrMany<f64>,
    converter: Option<ConverterTable>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConverterTable {
    bits: u32,
    range: [f64; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionTable {
    unit: Option<String>,
    std: Option<OneOrMany<f64>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct DeflectionTable {
    hold_std_deg: Option<f64>,
    pose_std_deg: Option<f64>,
    #[serde(default)]
    seen: bool,
    compliance_rad_per_newton_metre: Option<OneOrMany<f64>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConditionsTable {
    pose_interval_s: Option<f64>,
    #[serde(rename = "temperature_degC")]
    temperature_degc: Option<[f64; 2]>,
    largest_speed_rad_or_m_per_s: Option<f64>,
    #[serde(default)]
    direction: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct JointTable {
    name: String,
    torque_sensor: Option<TorqueSensorTable>,
    position_sensor: Option<PositionSensorTable>,
    #[serde(default)]
    sensor_models: Vec<ModelTable<ValueTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LoadTable {
    name: String,
    mass_kg: f64,
    link: String,
    position_m: [f64; 3],
    /// Whether the session is told the position.
    #[serde(default)]
    position_known: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LoadDistanceTable {
    between: [String; 2],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepTable {
    file: PathBuf,
    joint: String,
    range_deg: [f64; 2],
    poses: usize,
    held_deg: Option<BTreeMap<String, f64>>,
    held_rad: Option<BTreeMap<String, f64>>,
    load: Option<String>,
    step: Option<u8>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RandomTable {
    file: PathBuf,
    poses: usize,
    load: Option<String>,
}

/// Reads a simulation and the robot that it names.
pub(super) fn read(path: &Path) -> Result<Simulation, FileError> {
    let document = Document::read(path)?;
    let table: SimulationTable = document.parse()?;
    let (robot, robot_path) = resolve_robot(&document, &Field::new("robot"), &table.robot)?;
    Reader { document: &document, table: &table, robot: &robot }.simulation(path, robot_path)
}

/// The file being read, and the robot whose names it uses.
struct Reader<'a> {
    document: &'a Document,
    table: &'a SimulationTable,
    robot: &'a Robot,
}

impl Reader<'_> {
    fn simulation(&self, path: &Path, robot_path: PathBuf) -> Result<Simulation, FileError> {
        let loads = self.loads()?;
        let (tables, runs) = self.runs(&loads)?;
        let mut template = Session {
            robot: self.robot.clone(),
            gravity: self.gravity()?,
            inertia: InertiaKnowledge::Unknown,
            load_distances: self.load_distances(&loads)?,
            loads,
            joints: self.joints()?,
            instruments: Vec::new(),
            terms: SensorTerms::default(),
            further: Vec::new(),
            tables,
            poses: Vec::new(),
            deflection: Default::default(),
            saturated: vec![0; self.robot.sensors.len()],
            loss: Loss::None,
            uncertainty: UncertaintyChoice::Noise,
            constraints: Constraints::default(),
            earlier: None,
            ask: Ask::default(),
            estimators: Vec::new(),
            solver: None,
            inputs: vec![path.to_owned(), robot_path],
        };
        let mut truth = self.truth(&mut template)?;
        let mut models = vec![Vec::new(); self.names().len()];
        for table in &self.table.joint {
            if let Some(joint) = self.names().iter().position(|name| *name == table.name) {
                models[joint] = table.sensor_models.iter().map(ModelTable::without_parameters).collect();
            }
        }
        self.check_seen(&template)?;
        let read = instruments::read(self.document, self.robot, &template.inputs[1])?;
        template.instruments = read.instruments.behind(&mut template.further);
        truth.further.extend(read.truth);
        let disturbance = Disturbance { instrument_std: read.std, ..self.disturbance()? };
        let (conditions, seed) = (self.conditions()?, self.table.seed);
        let (models, instruments) = (DeclaredModels::new(models), read.simulated);
        Ok(Simulation { template, truth, runs, disturbance, conditions, models, instruments, seed })
    }

    fn names(&self) -> Vec<&str> {
        self.robot.chain.joints().iter().map(|joint| joint.name.as_str()).collect()
    }

    fn kind(&self, joint: usize) -> JointKind {
        self.robot.chain.joints()[joint].kind
    }

    fn gravity(&self) -> Result<GravityKnowledge, FileError> {
        let (field, table) = (Field::new("gravity"), &self.table.gravity);
        let unit = |key: &str, v: [f64; 3]| {
            let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            let message = "a direction needs a length: expected three numbers, not all zero";
            if norm > 0.0 { Ok(v.map(|c| c / norm)) } else { Err(self.document.error(&field.key(key), message)) }
        };
        let magnitude = field.key("magnitude_m_per_s2");
        Ok(GravityKnowledge {
            magnitude: self.document.positive(&magnitude, table.magnitude_m_per_s2, "a gravity", "m/s²")?,
            magnitude_std: None,
            hemisphere: Some(match table.hemisphere {
                Some(hemisphere) => unit("hemisphere", hemisphere)?,
                None => unit("direction", table.direction)?,
            }),
        })
    }

    fn loads(&self) -> Result<Vec<Load>, FileError> {
        let links: Vec<&str> = self.robot.chain.links().iter().map(|link| link.name.as_str()).collect();
        self.document
            .check_names(self.table.load.iter().map(|l| l.name.as_str()), |i| Field::new("load").at(i).key("name"))?;
        self.table
            .load
            .iter()
            .enumerate()
            .map(|(index, load)| {
                let field = Field::new("load").at(index);
                Ok(Load {
                    name: load.name.clone(),
                    mass: self.document.positive(&field.key("mass_kg"), load.mass_kg, "a mass", "kg")?,
                    link: self.document.lookup(&field.key("link"), "link", &load.link, &links)?,
                    position: load.position_known.then_some(load.position_m),
                    position_std: None,
                })
            })
            .collect()
    }

    fn load(&self, field: &Field, name: &str, loads: &[Load]) -> Result<usize, FileError> {
        let names: Vec<&str> = loads.iter().map(|load| load.name.as_str()).collect();
        self.document.lookup(field, "load", name, &names)
    }

    fn load_distances(&self, loads: &[Load]) -> Result<Vec<LoadDistance>, FileError> {
        let table = self.table.load_distance.iter().enumerate();
        table
            .map(|(index, known)| {
                let field = Field::new("load_distance").at(index).key("between");
                let [a, b] = &known.between;
                let between = [self.load(&field.at(0), a, loads)?, self.load(&field.at(1), b, loads)?];
                let [p, q] = between.map(|load| self.table.load[load].position_m);
                let distance = (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
                if distance == 0.0 || loads[between[0]].link != loads[between[1]].link {
                    let message = "two placements of a known distance must differ and be on one link";
                    return Err(self.document.error(&field, message));
                }
                Ok(LoadDistance { between, distance, std: None })
            })
            .collect()
    }

    /// What the session will say of the joints: the robot's nominal sensors.
    fn joints(&self) -> Result<Vec<JointKnowledge>, FileError> {
        let fitting = |key: &str, error: units::UnitError| self.document.error(&Field::new(key).key("unit"), error);
        let torque_unit = units::torque_reading(self.table.torque.unit.as_deref()).map_err(|e| fitting("torque", e))?;
        let position_unit =
            units::position_reading(self.table.position.unit.as_deref()).map_err(|e| fitting("position", e))?;
        (0..self.robot.sensors.len()).map(|joint| self.joint(joint, torque_unit, position_unit)).collect()
    }

    fn joint(
        &self,
        joint: usize,
        torque_unit: TorqueUnit,
        position_unit: PositionUnit,
    ) -> Result<JointKnowledge, FileError> {
        let (sensors, name) = (self.robot.sensors[joint], self.names()[joint]);
        let disagree = |key: &str, unit: &str, nominal: &str| {
            let message = format!("readings in {unit}, but the robot says that {name} reads in {nominal}");
            self.document.error(&Field::new(key).key("unit"), message)
        };
        let torque = match sensors.torque {
            Some(nominal) if nominal.unit != torque_unit => {
                return Err(disagree("torque", torque_unit.name(), nominal.unit.name()));
            }
            Some(nominal) => [nominal.gain, nominal.bias],
            None if torque_unit == units::effort(self.kind(joint)) => [1.0, 0.0],
            None => return Err(disagree("torque", torque_unit.name(), "nothing: it has no nominal torque sensor")),
        };
        let position = match sensors.position {
            Some(nominal) if nominal.unit.si() != position_unit => {
                return Err(disagree("position", position_unit.name(), nominal.unit.si().name()));
            }
            Some(nominal) => [nominal.gain, nominal.offset],
            None if position_unit == units::si_coordinate(self.kind(joint)) => [1.0, 0.0],
            None => {
                return Err(disagree("position", position_unit.name(), units::si_coordinate(self.kind(joint)).name()));
            }
        };
        let start = |nominal| Knowledge { nominal, kind: KnowledgeKind::Start };
        // The first joint's offset is zero by definition of the base frame.
        let offset = if joint == 0 { 0.0 } else { position[1] };
        Ok(JointKnowledge {
            torque_unit: Some(torque_unit),
            torque_sign_declared: false,
            position_unit,
            parameters: [torque[0], torque[1], position[0], offset].map(start),
        })
    }

    fn truth(&self, template: &mut Session) -> Result<Unknowns, FileError> {
        let mut truth = Unknowns::nominal(template);
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
                true_values[Quantity::TorqueGain as usize] = torque.gain;
                true_values[Quantity::TorqueBias as usize] = torque.bias;
            }
            if let Some(position) = sensors.position {
                let unit = template.joints[joint].position_unit.name();
                self.same_unit(&field, "position_sensor", position.unit.si().name(), Some(unit))?;
                true_values[Quantity::PositionGain as usize] = position.gain;
                true_values[Quantity::PositionOffset as usize] = position.offset;
            }
        }
        if truth.sensors[0][Quantity::PositionOffset as usize] != 0.0 {
            let message = "the first joint's offset is zero by definition of the base frame: turn gravity instead";
            return Err(self.document.error(&Field::new("joint"), message));
        }
        Ok(truth)
    }

    /// What a joint's sensors do beyond gain and bias: the session declares it, and does not know how much.
    fn models(
        &self,
        joint: usize,
        field: &Field,
        table: &JointTable,
        template: &mut Session,
        truth: &mut Unknowns,
    ) -> Result<(), FileError> {
        let (names, kinds) = (self.names(), self.robot.chain.joints().iter().map(|j| j.kind).collect::<Vec<_>>());
        let site = Site::new(joint, &names, &kinds, &template.joints[joint]);
        let knows = |need| match need {
            Need::Time => self.table.conditions.pose_interval_s.is_some(),
            Need::Temperature => self.table.conditions.temperature_degc.is_some(),
            Need::Velocity => self.table.conditions.largest_speed_rad_or_m_per_s.is_some(),
            Need::Direction => {
                self.table.conditions.direction || self.table.conditions.largest_speed_rad_or_m_per_s.is_some()
            }
        };
        let mut terms = Vec::new();
        for found in declare(self.document, field, &site, &table.sensor_models, knows)? {
            let parameter = found.parameter;
            let Some(said) = found.said else {
                let message =
                    format!("what is the true {0}? add parameters = {{ {0} = {{ value, unit }} }}", parameter.quantity);
                return Err(self.document.error(&found.field, message));
            };
            let wrong = |message| self.document.error(&found.field.key("unit"), message);
            truth.further.push(said.value * to_unit_of(&parameter.unit, said.unit()).map_err(wrong)?);
            template.further.push(parameter);
            terms.push(found.term);
        }
        template.terms.extend(terms);
        Ok(())
    }

    fn conditions(&self) -> Result<SimulatedConditions, FileError> {
        let (field, table) = (Field::new("conditions"), &self.table.conditions);
        let positive = |key: &str, value: Option<f64>, what: &str, unit: &str| {
            value.map(|value| self.document.positive(&field.key(key), value, what, unit)).transpose()
        };
        Ok(SimulatedConditions {
            pose_interval: positive("pose_interval_s", table.pose_interval_s, "an interval", "s")?,
            temperature: table.temperature_degc,
            largest_speed: positive(
                "largest_speed_rad_or_m_per_s",
                table.largest_speed_rad_or_m_per_s,
                "a speed",
                "rad/s or m/s",
            )?,
            direction: table.direction,
        })
    }

    fn same_unit(&self, field: &Field, key: &str, found: &str, readings: Option<&str>) -> Result<(), FileError> {
        if readings == Some(found) {
            return Ok(());
        }
        let readings = readings.unwrap_or("nothing");
        let message = format!("a gain for readings in {found}, but the readings are in {readings}");
        Err(self.document.error(&field.key(key), message))
    }

    fn runs(&self, loads: &[Load]) -> Result<(Vec<PoseTable>, Vec<Run>), FileError> {
        let mut runs = Vec::new();
        for (index, sweep) in self.table.sweep.iter().enumerate() {
            let field = Field::new("sweep").at(index);
            let table = self.pose_table(&field, &sweep.file, sweep.load.as_deref(), loads)?;
            runs.push((PoseTable { step: sweep.step, ..table }, self.sweep(&field, sweep)?));
        }
        for (index, random) in self.table.random.iter().enumerate() {
            let field = Field::new("random").at(index);
            let table = self.pose_table(&field, &random.file, random.load.as_deref(), loads)?;
            self.enough(&field, random.poses)?;
            runs.push((table, Run::Random { poses: random.poses }));
        }
        if runs.is_empty() {
            let message = "nothing to simulate: add [[sweep]] or [[random]]";
            return Err(self.document.error(&Field::new("sweep"), message));
        }
        let files: Vec<String> = runs.iter().map(|(table, _)| table.path.to_string_lossy().into_owned()).collect();
        let sweeps = self.table.sweep.len();
        self.document.check_names(files.iter().map(String::as_str), |i| {
            let (key, index) = if i < sweeps { ("sweep", i) } else { ("random", i - sweeps) };
            Field::new(key).at(index).key("file")
        })?;
        Ok(runs.into_iter().unzip())
    }

    fn enough(&self, field: &Field, poses: usize) -> Result<(), FileError> {
        let message = match poses {
            0 | 1 => format!("{poses} poses identify nothing: expected 2 at least"),
            _ if poses > MOST_POSES => format!("{poses} poses are too many: expected {MOST_POSES} at most"),
            _ => return Ok(()),
        };
        Err(self.document.error(&field.key("poses"), message))
    }

    fn pose_table(
        &self,
        field: &Field,
        file: &Path,
        load: Option<&str>,
        loads: &[Load],
    ) -> Result<PoseTable, FileError> {
        let is_csv = file.extension().is_some_and(|extension| extension == "csv");
        if file.components().count() != 1 || !is_csv {
            let message = "expected the name of a CSV file in the session's own folder, such as \"poses.csv\"";
            return Err(self.document.error(&field.key("file"), message));
        }
        let load = load.map(|name| self.load(&field.key("load"), name, loads)).transpose()?;
        Ok(PoseTable { path: file.to_owned(), load, swept: None, step: None })
    }

    fn sweep(&self, field: &Field, sweep: &SweepTable) -> Result<Run, FileError> {
        self.enough(field, sweep.poses)?;
        if let Some(step) = sweep.step.filter(|step| !(1..=3).contains(step)) {
            return Err(self.document.error(&field.key("step"), format!("{step} is no step: expected 1, 2 or 3")));
        }
        let names = self.names();
        let swept = self.document.lookup(&field.key("joint"), "joint", &sweep.joint, &names)?;
        let mut held = vec![None; names.len()];
        for (key, table, to_rad) in
            [("held_deg", &sweep.held_deg, 1f64.to_radians()), ("held_rad", &sweep.held_rad, 1.0)]
        {
            for (name, value) in table.iter().flatten() {
                let joint = self.document.lookup(&field.key(key).key(name), "joint", name, &names)?;
                if joint == swept || held[joint].is_some() {
                    let message = format!("{name} is swept, or given twice");
                    return Err(self.document.error(&field.key(key).key(name), message));
                }
                held[joint] = Some(value * to_rad);
            }
        }
        if let Some(joint) = (0..names.len()).find(|joint| *joint != swept && held[*joint].is_none()) {
            let message = format!("where does {} stand? add it to held_deg or held_rad", names[joint]);
            return Err(self.document.error(field, message));
        }
        Ok(Run::Sweep {
            swept,
            range: sweep.range_deg.map(f64::to_radians),
            poses: sweep.poses,
            held: held.into_iter().map(|position| position.unwrap_or(0.0)).collect(),
        })
    }

    fn disturbance(&self) -> Result<Disturbance, FileError> {
        let (names, table) = (self.names(), self.table);
        let torque = Field::new("torque").key("std");
        let torque_std = self.document.for_each(&torque, &table.torque.std, &names)?;
        for std in &torque_std {
            self.document.positive(&torque, *std, "a standard deviation", "the reading's unit")?;
        }
        let zero = OneOrMany::One(0.0);
        let position = Field::new("position").key("std");
        let position_std = self.document.for_each(&position, table.position.std.as_ref().unwrap_or(&zero), &names)?;
        self.not_negative(&position, &position_std)?;
        Ok(Disturbance {
            torque_std,
            instrument_std: Vec::new(),
            position_std,
            converter: table.torque.converter.map(|c| self.converter(c)).transpose()?,
            deflection: self.deflection()?,
        })
    }

    fn deflection(&self) -> Result<Deflection, FileError> {
        let (field, table) = (|key: &str| Field::new("deflection").key(key), &self.table.deflection);
        let angle = |key: &str, written: Option<f64>| {
            let angle = written.unwrap_or(0.0).to_radians();
            self.not_negative(&field(key), &[angle]).map(|()| angle)
        };
        let zero = OneOrMany::One(0.0);
        let compliance = table.compliance_rad_per_newton_metre.as_ref().unwrap_or(&zero);
        Ok(Deflection {
            hold_std: angle("hold_std_deg", table.hold_std_deg)?,
            pose_std: angle("pose_std_deg", table.pose_std_deg)?,
            compliance: self.document.for_each(&field("compliance_rad_per_newton_metre"), compliance, &self.names())?,
            seen: table.seen,
        })
    }

    /// Readings that see a deflection are made by gain and offset alone.
    fn check_seen(&self, template: &Session) -> Result<(), FileError> {
        if self.table.deflection.seen && template.terms.of_positions().next().is_some() {
            let message = "a deflection can be seen by affine position sensors only: drop the sensor models of positions, or \
                           this";
            return Err(self.document.error(&Field::new("deflection").key("seen"), message));
        }
        Ok(())
    }

    fn not_negative(&self, field: &Field, values: &[f64]) -> Result<(), FileError> {
        match values.iter().find(|value| **value < 0.0) {
            Some(value) => Err(self.document.error(field, format!("{value} is negative: expected zero or more"))),
            None => Ok(()),
        }
    }

    fn converter(&self, ConverterTable { bits, range }: ConverterTable) -> Result<Converter, FileError> {
        let field = Field::new("torque").key("converter");
        if !(1..=32).contains(&bits) {
            return Err(self.document.error(&field.key("bits"), format!("{bits} bits: expected 1 to 32")));
        }
        if range[0] >= range[1] {
            return Err(self.document.error(&field.key("range"), "expected [lowest, highest] reading"));
        }
        Ok(Converter { bits, range })
    }
}
