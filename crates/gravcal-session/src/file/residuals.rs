//! `[[residual]]`: what else was observed, by models of anyone's.

use std::collections::BTreeMap;

use gravcal_recording::{FurtherColumn, PoseMapping};
use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::residual_models::{ResidualInUse, ResidualModel, Scene, Setting, Tie, declare_residual};
use gravcal_robot_model::sensors::{Options, RefusedOption, WrongDerivative};
use gravcal_robot_model::session::{AuxiliarySensor, Session};
use gravcal_robot_model::{Registry, State};
use serde::Deserialize;
use toml::Table;

use super::context::Context;
use super::model_derivatives::{LOOKED_AT, at_most_places, beside};
use super::models::{check_shared, with_prior};
use super::parameter_prior::ParameterPriorTable;
use crate::document::{Document, Field, FileError};
use crate::sensor_models::{ParameterInFile, check_options};

/// `[[residual]]`: what else was observed, by a model that a program adds to gravcal. Beside these keys stand the options of the model.
#[derive(Debug, Deserialize)]
#[serde(expecting = "a table")]
pub(super) struct ResidualTable {
    /// The model, one of those that a program adds to gravcal, which has none of its own: `--help` of that program lists them.
    ///
    /// Example: `kind = "dial-gauge"`
    kind: String,
    /// What its parameters are called by in results.
    ///
    /// Default: its kind.
    /// Example: `name = "gauge"`
    name: Option<String>,
    /// Its columns in the tables of poses, by what the model calls them. A pose whose cell is empty was not observed.
    ///
    /// Default: none.
    /// Example: `columns = { reading = "dial_m" }`
    #[serde(default)]
    columns: BTreeMap<String, String>,
    /// What is known of its parameters.
    ///
    /// Default: what the model says.
    /// Example: `parameters = { zero = { nominal = 0.3, std = 0.01, unit = "m" } }`
    #[serde(default)]
    parameters: BTreeMap<String, ParameterPriorTable>,
    /// Everything else; which of it there may be is the model's.
    #[serde(flatten)]
    options: Table,
}

impl ResidualTable {
    fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.kind)
    }
}

fn section(index: usize) -> Field {
    Field::new("residual").at(index)
}

/// The residuals of a session. Their columns come behind the further ones of `mapping`, their parameters behind those of `further`.
pub(super) fn resolve(
    context: &Context<'_>,
    registry: &Registry,
    tables: &[ResidualTable],
    instruments: &[AuxiliarySensor],
    (mapping, further): (&mut PoseMapping, &mut Vec<Parameter>),
) -> Result<Vec<ResidualInUse>, FileError> {
    if context.robot.chain.joint_count() == 0 && !tables.is_empty() {
        let message = "a residual is of where the joints are, and the session has none: name a robot, or delete this";
        return Err(context.document.error(&section(0), message));
    }
    check_names(context, tables, instruments, further)?;
    let mut all = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let section = Section { context, field: section(index), table };
        let model = registry
            .residual_model(&table.kind)
            .map_err(|error| context.document.error(&section.field.key("kind"), error))?;
        all.push(section.resolve(model, (mapping, further))?);
    }
    Ok(all)
}

/// Results are told by name, so a residual may not be called like anything else.
fn check_names(
    context: &Context<'_>,
    tables: &[ResidualTable],
    instruments: &[AuxiliarySensor],
    further: &[Parameter],
) -> Result<(), FileError> {
    let field = |index: usize| section(index).key(if tables[index].name.is_some() { "name" } else { "kind" });
    context.document.check_names(tables.iter().map(ResidualTable::name), field)?;
    let taken = |name: &str| {
        let instrument = instruments.iter().any(|instrument| instrument.name == name);
        let owner = further.iter().any(|parameter| parameter.owner == name);
        instrument
            || owner
            || name == "gravity"
            || context.joint_names.contains(&name)
            || context.link_names.contains(&name)
    };
    match tables.iter().position(|table| taken(table.name())) {
        None => Ok(()),
        Some(index) => {
            let name = tables[index].name();
            let message = format!(
                "`{name}` is a joint, a link, an instrument, gravity or what sensors share: give the residual a name of its own"
            );
            Err(context.document.error(&field(index), message))
        }
    }
}

/// One of them.
struct Section<'a> {
    context: &'a Context<'a>,
    field: Field,
    table: &'a ResidualTable,
}

impl Section<'_> {
    fn resolve(
        &self,
        model: &dyn ResidualModel,
        (mapping, further): (&mut PoseMapping, &mut Vec<Parameter>),
    ) -> Result<ResidualInUse, FileError> {
        let (context, table) = (self.context, self.table);
        let options = Options::of(table.options.clone());
        let beside = ["name", "columns", "parameters"];
        check_options(context.document, &self.field, (model.name(), model.options(), &beside), &options)?;
        let columns = &mut mapping.conditions.further;
        let names = model.columns();
        let setting = Setting::new(&context.robot.chain, &names, columns.len());
        columns.extend(self.columns(model)?);
        let refused = |RefusedOption { keys, message }: RefusedOption| {
            context.document.error(&keys.iter().fold(self.field.clone(), |field, key| field.key(key)), message)
        };
        let (mut residual, parameters) =
            declare_residual(model, &setting, (table.name(), &options)).map_err(refused)?;
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.quantity.as_str()).collect();
        for name in table.parameters.keys() {
            context.document.lookup(&self.field.key("parameters").key(name), "parameter", name, &names)?;
        }
        for parameter in parameters {
            residual.places.push(self.place(parameter, further)?);
        }
        Ok(residual)
    }

    /// Every column of the model by the name that it has in the tables.
    fn columns(&self, model: &dyn ResidualModel) -> Result<Vec<FurtherColumn>, FileError> {
        let (document, field) = (self.context.document, self.field.key("columns"));
        let names = model.columns();
        for name in self.table.columns.keys() {
            document.lookup(&field.key(name), "column", name, &names)?;
        }
        let column = |name: &&str| {
            let written = self.table.columns.get(*name).filter(|column| !column.is_empty());
            let written = written.ok_or_else(|| {
                let message = format!(
                    "{} reads a column `{name}`: add columns = {{ {name} = \"…\" }}, its name in the tables",
                    model.name()
                );
                document.error(&field.key(name), message)
            })?;
            let name = format!("{}.{name}", self.table.name());
            Ok(FurtherColumn { name, column: written.clone(), may_be_empty: true })
        };
        names.iter().map(column).collect()
    }

    /// The place of a parameter among the further ones, with what is said of it; of one that is shared, where it stands first.
    fn place(&self, parameter: Parameter, further: &mut Vec<Parameter>) -> Result<usize, FileError> {
        let said = self.table.parameters.get(&parameter.quantity);
        let place = said.map(|_| self.field.key("parameters").key(&parameter.quantity));
        let is_own = parameter.owner == self.table.name();
        let found = ParameterInFile { field: place.unwrap_or_else(|| self.field.clone()), said, parameter };
        if let (false, Some(place)) = (is_own, check_shared(self.context, further, &found)?) {
            return Ok(place);
        }
        further.push(with_prior(self.context, found)?);
        Ok(further.len() - 1)
    }
}

/// Columns of residuals are read from tables of static poses.
pub(super) fn check_recordings(
    document: &Document,
    residuals: &[ResidualInUse],
    mapping: &PoseMapping,
    recorded: bool,
) -> Result<(), FileError> {
    let of_residuals = mapping.conditions.further.iter().any(|column| column.may_be_empty);
    match recorded && of_residuals && !residuals.is_empty() {
        false => Ok(()),
        true => {
            let message = "columns of residuals are read from tables of static poses, and not from recordings in motion: delete this, or \
                           readings.still, readings.sweeps and readings.motion";
            Err(document.error(&section(0), message))
        }
    }
}

/// Sees to it that residuals have rows in the poses that were read, and numbers there.
pub(super) fn check(document: &Document, session: &Session) -> Result<(), FileError> {
    if let (false, Some(_)) = (session.compliances().is_empty(), session.residuals.first()) {
        let message = "joints that give way under their torque move what is observed, which is not modelled for residuals: leave out \
                       compliance_std_rad_per_newton_metre, and state hold_std_deg instead";
        return Err(document.error(&section(0), message));
    }
    let nominal = State::nominal(session);
    for (index, residual) in session.residuals.iter().enumerate() {
        let refuse = |message: String| Err(document.error(&section(index), message));
        let ties = residual.ties(&session.poses);
        if ties.is_empty() {
            return refuse(format!(
                "{} finds nothing in the poses that it could observe: are the cells of its columns empty? It takes static poses only",
                residual.model
            ));
        }
        for tie in &ties {
            let value =
                at_nominal(session, residual, (&nominal, tie), |scenes, x| residual.value(tie, scenes, x, None));
            let pose = &session.poses[tie.poses[0]];
            let at = format!("in {}:{}", session.tables[pose.table].path.display(), pose.line);
            if !(tie.std > 0.0 && tie.std.is_finite()) {
                return refuse(format!("{at}: {} is no standard deviation: expected a positive number", tie.std));
            }
            if !value.is_finite() {
                return refuse(format!(
                    "{at}: at nominal values it comes to {value}, and not to a number. Does it say that it sees all that it uses \
                     (coordinates, gravity)?"
                ));
            }
        }
        if let Some(wrong) = wrong_derivative(session, residual, &nominal, &ties) {
            return refuse(format!("the model {} is wrong: {wrong}", residual.model));
        }
    }
    Ok(())
}

/// What a function makes of the scenes of a row and of the residual's parameters, at nominal values.
fn at_nominal<T>(
    session: &Session,
    residual: &ResidualInUse,
    (nominal, tie): (&State, &Tie),
    function: impl Fn(&[Scene<'_>], &[f64]) -> T,
) -> T {
    let mut gravity = nominal.gravity;
    let coordinates = |pose: &usize| session.nominal_coordinates(&session.poses[*pose]);
    let mut all: Vec<Vec<f64>> = tie.poses.iter().map(coordinates).collect();
    all.iter_mut().for_each(|coordinates| residual.hide_unseen(coordinates, &mut gravity));
    let chain = &session.robot.chain;
    let scenes: Vec<Scene<'_>> = all
        .iter()
        .zip(&tie.poses)
        .map(|(coordinates, pose)| {
            let pose = &session.poses[*pose];
            Scene::new(chain, (coordinates, &pose.position), gravity, &pose.conditions)
        })
        .collect();
    let x: Vec<f64> = residual.places.iter().map(|place| nominal.further[*place]).collect();
    function(&scenes, &x)
}

/// Poses of a row whose derivatives are looked at.
const MOST_POSES: usize = 20;

/// Derivatives that differences of values contradict at most of the places that are looked at. A residual may have a kink where one of them is taken.
fn wrong_derivative(
    session: &Session,
    residual: &ResidualInUse,
    nominal: &State,
    ties: &[Tie],
) -> Option<WrongDerivative> {
    let wrong = |tie: &&Tie| {
        at_nominal(session, residual, (nominal, tie), |scenes, x| {
            residual.check_derivatives(tie, scenes, &beside(x)).err()
        })
    };
    // What many poses have in common has too many derivatives to look at each.
    let ties: Vec<&Tie> = ties.iter().filter(|tie| tie.poses.len() <= MOST_POSES).collect();
    let every = ties.len().div_ceil(LOOKED_AT).max(1);
    at_most_places(ties.iter().step_by(every).map(wrong))
}
