//! Reads `study.toml`.

use std::path::{Path, PathBuf};

use gravcal_robot_model::Registry;
use gravcal_robot_model::session::Session;
use gravcal_session::SessionError;
use gravcal_session::document::{Document, Field, FileError};
use gravcal_session::simulation::SimulateError;
use sha2::{Digest, Sha256};
use thiserror::Error;
use toml::{Table, Value};

use super::change::Change;
use super::draw::Draw;
use super::file::{ChangeTable, DrawTable, StudyTable, VaryTable};
use super::point::places;
use super::point_files::PointFiles;
use super::source::{Said, Source};
use super::{Axis, Compared, Point, Study, reported};
use crate::quantities::measured_quantities;
use crate::random_arms::Knowing;

/// A study cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Something is wrong in its file.
    #[error(transparent)]
    File(#[from] FileError),
    /// One of its points makes no simulation.
    #[error("{error}\n  {point}")]
    Simulation {
        /// What is wrong with the simulation.
        error: Box<FileError>,
        /// With which changes.
        point: String,
    },
    /// One of its points makes no session.
    #[error("{error}\n  {point}")]
    Session {
        /// What is wrong with the session.
        error: Box<SessionError>,
        /// With which changes.
        point: String,
    },
    /// A session could not be tried out.
    #[error(transparent)]
    Trial(#[from] SimulateError),
    /// There is no place for temporary files.
    #[error("a session cannot be tried out: {0}")]
    Temporary(#[from] std::io::Error),
}

/// Points beyond which a grid is a mistake.
pub(crate) const MOST_POINTS: usize = 10_000;
/// Trials of all points beyond which a number is a mistake.
pub(crate) const MOST_TRIALS: u64 = 100_000_000;
/// Arms that are looked at for the names of their joints.
const ARMS: u64 = 100;

pub(super) fn read(path: &Path, registry: &Registry) -> Result<Study, StudyError> {
    let document = Document::read(path)?;
    let table: StudyTable = document.parse()?;
    Reader { document: &document, registry, table: &table }.study()
}

/// The file being read.
struct Reader<'a> {
    document: &'a Document,
    registry: &'a Registry,
    table: &'a StudyTable,
}

/// A named case on an axis, and what it changes.
struct Case {
    label: String,
    number: Option<f64>,
    changes: Vec<Change>,
}

impl Reader<'_> {
    fn study(&self) -> Result<Study, StudyError> {
        let trials = self.trials()?;
        let estimators = self.estimators()?;
        let common = self.changes(&self.table.change, &Field::new("change"))?;
        let cases = self.cases()?;
        let axes: Vec<Axis> = self.table.vary.iter().zip(&cases).map(|(vary, cases)| axis(vary, cases)).collect();
        let mut hash = Sha256::new();
        let mut inputs = vec![self.document.path().to_owned()];
        self.hash_what_is_said(&mut hash);
        let points = match (&self.table.simulation, &self.table.random_arms) {
            (Some(written), None) => self.grid(written, &common, &axes, &cases, &mut hash, &mut inputs)?,
            (None, Some(family)) => {
                let point = self.random_arms(&family.know, &common, &cases)?;
                vec![point]
            }
            (Some(_), Some(_)) => {
                return Err(self.error("random_arms", "a study has a simulation or random arms").into());
            }
            (None, None) => {
                return Err(self
                    .error("simulation", "what is simulated? name a simulation.toml, or say random_arms")
                    .into());
            }
        };
        if trials.saturating_mul(points.len() as u64) > MOST_TRIALS {
            let message =
                format!("{} points have more than {MOST_TRIALS} trials in all: vary less at once", points.len());
            return Err(self.error("trials", message).into());
        }
        let quantities = quantities(&points);
        Ok(Study {
            document: self.document.clone(),
            trials,
            estimators,
            solvers: self.table.solvers.clone(),
            axes,
            points,
            quantities,
            inputs,
            fingerprint: hex(&hash.finalize()),
        })
    }

    fn error(&self, key: &str, message: impl std::fmt::Display) -> FileError {
        self.document.error(&Field::new(key), message)
    }

    fn trials(&self) -> Result<u64, FileError> {
        match self.table.trials {
            0 => Err(self.error("trials", "no trial is no study: expected 1 or more")),
            trials if trials > MOST_TRIALS => Err(self.error(
                "trials",
                format!("expected {MOST_TRIALS} at most; more make no error smaller that anyone reads"),
            )),
            trials => Ok(trials),
        }
    }

    fn estimators(&self) -> Result<Vec<Compared>, FileError> {
        let field = Field::new("estimators");
        if self.table.estimators.is_empty() {
            let known: Vec<String> = Compared::all().map(|compared| compared.to_string()).collect();
            let message = format!("which estimators are compared? there is: {}", known.join(", "));
            return Err(self.document.error(&field, message));
        }
        self.document.check_names(self.table.estimators.iter().map(String::as_str), |index| field.at(index))?;
        let solvers = Field::new("solvers");
        self.document.check_names(self.table.solvers.iter().map(String::as_str), |index| solvers.at(index))?;
        let named = self.table.estimators.iter().enumerate();
        named.map(|(i, name)| name.parse().map_err(|error| self.document.error(&field.at(i), error))).collect()
    }

    fn changes(&self, tables: &[ChangeTable], field: &Field) -> Result<Vec<Change>, FileError> {
        let mut changes = Vec::new();
        for (index, table) in tables.iter().enumerate() {
            let value = match (&table.value, table.drop) {
                (Some(value), false) => Some(value.clone()),
                (None, true) => None,
                (Some(_), true) => return Err(self.document.error(&field.at(index), "either a value, or drop = true")),
                (None, false) => {
                    return Err(self.document.error(&field.at(index), "to what? say value = …, or drop = true"));
                }
            };
            let said = field.at(index);
            let change = |name: &String| Change { field: name.clone(), value: value.clone(), said: said.clone() };
            changes.extend(table.field.as_slice().iter().map(change));
        }
        Ok(changes)
    }

    /// What is varied, axis by axis.
    fn cases(&self) -> Result<Vec<Vec<Case>>, FileError> {
        let field = |index: usize| Field::new("vary").at(index);
        let names = self.table.vary.iter().map(|vary| vary.name.as_str());
        self.document.check_names(names, |index| field(index).key("name"))?;
        let axes = self.table.vary.iter().enumerate();
        let axes = axes.map(|(index, vary)| self.cases_of(vary, &field(index))).collect::<Result<Vec<_>, _>>()?;
        let points = axes.iter().map(Vec::len).try_fold(1usize, usize::checked_mul);
        match points {
            Some(points) if points <= MOST_POINTS => Ok(axes),
            _ => Err(self.error("vary", format!("the grid has more than {MOST_POINTS} points: vary less at once"))),
        }
    }

    /// What one axis may be; no two cases look alike.
    fn cases_of(&self, vary: &VaryTable, field: &Field) -> Result<Vec<Case>, FileError> {
        let cases = self.read_cases(vary, field)?;
        for (index, case) in cases.iter().enumerate() {
            if cases[..index].iter().any(|before| before.label == case.label) {
                return Err(self.document.error(field, format!("`{}` stands there twice", case.label)));
            }
        }
        Ok(cases)
    }

    fn read_cases(&self, vary: &VaryTable, field: &Field) -> Result<Vec<Case>, FileError> {
        let empty = |key: &str| self.document.error(&field.key(key), "the list is empty: nothing to vary");
        match (&vary.field, &vary.values, &vary.cases) {
            (Some(names), Some(values), None) => {
                if values.is_empty() {
                    return Err(empty("values"));
                }
                let change = |value: &Value| {
                    let value = Some(value.clone());
                    let said = field.key("field");
                    let change =
                        |name: &String| Change { field: name.clone(), value: value.clone(), said: said.clone() };
                    names.as_slice().iter().map(change).collect()
                };
                Ok(values.iter().map(|value| case(value, change(value))).collect())
            }
            (None, None, Some(cases)) => {
                if cases.is_empty() {
                    return Err(empty("cases"));
                }
                let numbered = cases.iter().enumerate();
                numbered
                    .map(|(index, table)| {
                        let changes = field.key("cases").at(index).key("change");
                        Ok(case(&table.name, self.changes(&table.change, &changes)?))
                    })
                    .collect()
            }
            _ => Err(self.document.error(field, "expected `field` and `values`, or `cases`")),
        }
    }

    fn random_arms(&self, know: &str, common: &[Change], cases: &[Vec<Case>]) -> Result<Point, FileError> {
        if !common.is_empty() || !cases.is_empty() || self.table.draw.is_some() {
            return Err(self.error(
                "random_arms",
                "change, vary and draw go with a simulation: random arms are drawn as they are",
            ));
        }
        let field = Field::new("random_arms").key("know");
        let known = ["nominal", "nothing"];
        let knowing = [Knowing::Nominal, Knowing::Nothing][self.document.lookup(&field, "knowledge", know, &known)?];
        Ok(Point { places: Vec::new(), source: Source::RandomArms(knowing), seed: self.table.seed.unwrap_or(0) })
    }

    fn grid(
        &self,
        written: &str,
        common: &[Change],
        axes: &[Axis],
        cases: &[Vec<Case>],
        hash: &mut Sha256,
        inputs: &mut Vec<PathBuf>,
    ) -> Result<Vec<Point>, StudyError> {
        let field = Field::new("simulation");
        let path = self.document.resolve_path(&field, written)?;
        let named_by = |error: FileError| error.with_note(self.document.named_by(&field, written));
        let base: Table = Document::read(&path).map_err(named_by)?.parse()?;
        let draw = self.table.draw.map(|table| self.draw(&table)).transpose()?;
        let sizes: Vec<usize> = cases.iter().map(Vec::len).collect();
        (0..sizes.iter().product())
            .map(|index| {
                let places = places(index, &sizes);
                let chosen = cases.iter().zip(&places).flat_map(|(cases, place)| &cases[*place].changes);
                let changes: Vec<&Change> = common.iter().chain(chosen).collect();
                let reported = at(axes, &places);
                let (document, registry) = (self.document, self.registry);
                let files =
                    PointFiles { document, registry, path: &path, base: &base, changes: &changes, reported: &reported };
                let (mut simulation, session) = files.make(hash)?;
                for input in simulation.template.input_paths().chain(session.input_paths()) {
                    if !inputs.contains(input) {
                        inputs.push(input.clone());
                    }
                }
                let seed = self.table.seed.unwrap_or(simulation.seed);
                simulation.seed = seed;
                let said = Box::new(Said::of(session));
                let source = Source::Simulation { simulation: Box::new(simulation), said, draw };
                Ok(Point { places, source, seed })
            })
            .collect()
    }

    fn draw(&self, table: &DrawTable) -> Result<Draw, FileError> {
        let field = |key: &str| Field::new("draw").key(key);
        let not_negative = |key: &str, value: f64, most: f64| match value {
            value if (0.0..=most).contains(&value) => Ok(value),
            value => Err(self.document.error(&field(key), format!("{value}: expected 0 to {most}"))),
        };
        Ok(Draw {
            torque_gain: not_negative("torque_gain_relative", table.torque_gain_relative, 0.99)?,
            torque_bias: not_negative("torque_bias", table.torque_bias, f64::MAX)?,
            position_gain: not_negative("position_gain_relative", table.position_gain_relative, 0.99)?,
            position_offset: not_negative("position_offset_deg", table.position_offset_deg, 180.0)?.to_radians(),
            gravity: not_negative("gravity_deg", table.gravity_deg, 180.0)?.to_radians(),
        })
    }

    fn hash_what_is_said(&self, hash: &mut Sha256) {
        let StudyTable { trials, seed, estimators, solvers, draw, random_arms, .. } = self.table;
        let version = env!("CARGO_PKG_VERSION");
        hash.update(format!("{version} {trials} {seed:?} {estimators:?} {solvers:?} {draw:?} {random_arms:?}"));
    }
}

fn case(name: &Value, changes: Vec<Change>) -> Case {
    let number = name.as_float().or_else(|| name.as_integer().map(|integer| integer as f64));
    let label = match name {
        Value::String(text) => text.clone(),
        _ => number.map_or_else(|| name.to_string(), |number| number.to_string()),
    };
    Case { label, number, changes }
}

fn axis(vary: &VaryTable, cases: &[Case]) -> Axis {
    Axis {
        name: vary.name.clone(),
        unit: vary.unit.clone(),
        labels: cases.iter().map(|case| case.label.clone()).collect(),
        numbers: cases.iter().map(|case| case.number).collect(),
    }
}

/// What is chosen at a point, as a note for errors; nothing where nothing is varied.
fn at(axes: &[Axis], places: &[usize]) -> String {
    let reported = reported(axes, places);
    if reported.is_empty() { reported } else { format!("at {reported}") }
}

/// Name and unit of everything that any trial measures.
fn quantities(points: &[Point]) -> Vec<(String, String)> {
    let mut quantities: Vec<(String, String)> = Vec::new();
    let mut add = |session: &Session| {
        for measured in measured_quantities(session) {
            let name = measured.name(session);
            if quantities.iter().all(|(known, _)| *known != name) {
                quantities.push((name, measured.unit(session)));
            }
        }
    };
    for point in points {
        match &point.source {
            Source::Simulation { said, .. } => add(&said.session),
            Source::RandomArms(_) => {
                let drawn = (0..ARMS).filter_map(|trial| point.source.draw(point.seed, trial).ok());
                let mut sessions: Vec<Session> = drawn.map(|drawn| drawn.session).collect();
                sessions.sort_by_key(|session| std::cmp::Reverse(session.joints.len()));
                sessions.iter().for_each(&mut add);
            }
        }
    }
    quantities
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
