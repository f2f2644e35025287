//! Reads `simulation.toml`.

mod disturbance;
mod instruments;
mod reader;
mod recording;
mod runs;
mod tables;
mod truth;

use std::path::{Path, PathBuf};

use gravcal_recording::{InputRole, PositionUnit, TorqueUnit};
use gravcal_robot_model::Registry;
use gravcal_robot_model::session::{
    GravityPrior, InputFile, JointPriors, Load, LoadDistance, ParameterPrior, PriorKind, Session, units,
};

use super::disturbance::Disturbance;
use super::experiment::{Run, Simulation};
use crate::document::{Document, Field, FileError, OneOrMany};
use crate::robot_file::resolve_robot;
use crate::sensor_models::{DeclaredModels, ModelTable};
use reader::Reader;
use tables::SimulationTable;

impl Simulation {
    /// Reads `simulation.toml` and the robot that it names.
    ///
    /// # Errors
    /// Names the file, the line and the field.
    pub fn read(path: &Path) -> Result<Simulation, FileError> {
        Simulation::read_with(path, &Registry::standard())
    }

    /// The same; `registry` says what may be named, such as sensor models of one's own.
    ///
    /// # Errors
    /// As for [`Simulation::read`].
    pub fn read_with(path: &Path, registry: &Registry) -> Result<Simulation, FileError> {
        Simulation::of(&Document::read(path)?, registry)
    }

    /// The same from a document, which may be another text than that of the file.
    ///
    /// # Errors
    /// As for [`Simulation::read`].
    pub fn of(document: &Document, registry: &Registry) -> Result<Simulation, FileError> {
        read(document, registry)
    }
}

/// Reads a simulation and the robot that it names.
fn read(document: &Document, registry: &Registry) -> Result<Simulation, FileError> {
    let table: SimulationTable = document.parse()?;
    let (robot, robot_path) = resolve_robot(document, &Field::new("robot"), &table.robot)?;
    Reader { document, registry, table: &table, robot: &robot }.simulation(document.path(), robot_path)
}

impl Reader<'_> {
    fn simulation(&self, path: &Path, robot_path: PathBuf) -> Result<Simulation, FileError> {
        let loads = self.loads()?;
        let (tables, runs) = self.runs(&loads)?;
        let mut template = Session {
            load_distances: self.load_distances(&loads)?,
            loads,
            tables,
            inputs: vec![InputFile::new(InputRole::Session, path), InputFile::new(InputRole::Robot, &robot_path)],
            ..Session::new(self.robot.clone(), self.gravity()?, self.joints()?)
        };
        let mut truth = self.truth(&mut template)?;
        let unmodelled = self.unmodelled(&template)?;
        let mut models = vec![Vec::new(); self.names().len()];
        for table in &self.table.joint {
            if let Some(joint) = self.names().iter().position(|name| *name == table.name) {
                models[joint] = table.sensor_models.iter().map(ModelTable::without_parameters).collect();
            }
        }
        self.check_seen(&template)?;
        let read = instruments::read(self.document, self.robot, &robot_path, template.tables.len())?;
        template.instruments = read.instruments.behind(&mut template.further);
        truth.further.extend(read.truth);
        let poses = runs.iter().map(Run::poses).sum();
        let disturbance = Disturbance { instrument_std: read.std, ..self.disturbance()? };
        let (conditions, motion, seed) = (self.conditions()?, self.motion(poses)?, self.table.seed);
        if motion.is_some() && !template.instruments.is_empty() {
            let message = "instruments are not recorded in motion: delete them, or this";
            return Err(self.document.error(&Field::new("recording"), message));
        }
        if motion.is_some() {
            truth.tensors = self.true_tensors().unwrap_or_default();
        }
        let (models, instruments) = (DeclaredModels::new(models), read.simulated);
        Ok(Simulation { template, truth, unmodelled, runs, disturbance, conditions, motion, models, instruments, seed })
    }

    fn gravity(&self) -> Result<GravityPrior, FileError> {
        let (field, table) = (Field::new("gravity"), &self.table.gravity);
        let unit = |key: &str, v: [f64; 3]| {
            let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            let message = "a direction needs a length: expected three numbers, not all zero";
            if norm > 0.0 { Ok(v.map(|c| c / norm)) } else { Err(self.document.error(&field.key(key), message)) }
        };
        let magnitude = field.key("magnitude_m_per_s2");
        Ok(GravityPrior {
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
    fn joints(&self) -> Result<Vec<JointPriors>, FileError> {
        let torque_units = self.units("torque", self.table.torque.unit.as_ref(), units::torque_reading)?;
        let position_units = self.units("position", self.table.position.unit.as_ref(), units::position_reading)?;
        let units = torque_units.into_iter().zip(position_units);
        units.enumerate().map(|(joint, (torque, position))| self.joint(joint, torque, position)).collect()
    }

    /// The unit in which each joint's sensor reads.
    fn units<U>(
        &self,
        key: &str,
        written: Option<&OneOrMany<String>>,
        read: impl Fn(Option<&str>) -> Result<U, units::UnitError>,
    ) -> Result<Vec<U>, FileError> {
        let (field, names) = (Field::new(key).key("unit"), self.names());
        let written = written.map(|units| self.document.for_each(&field, units, &names)).transpose()?;
        let unit = |joint: usize| {
            let unit = read(written.as_ref().map(|units| units[joint].as_str()));
            unit.map_err(|error| self.document.error(&field, error))
        };
        (0..names.len()).map(unit).collect()
    }

    fn joint(
        &self,
        joint: usize,
        torque_unit: TorqueUnit,
        position_unit: PositionUnit,
    ) -> Result<JointPriors, FileError> {
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
        let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
        // The first joint's offset is zero by definition of the base frame.
        let offset = if self.robot.chain.root_joint() == Some(joint) { 0.0 } else { position[1] };
        Ok(JointPriors {
            torque_unit: Some(torque_unit),
            torque_sign_declared: false,
            position_unit,
            parameters: [torque[0], torque[1], position[0], offset].map(start),
        })
    }
}
