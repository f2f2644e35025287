//! Names of estimators and solvers: from the command line, else from the session, else the default.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use gravcal_calibration::{UnsuitableChoice, check_choice};
use gravcal_estimation::Solver;
use gravcal_recording::{LARGEST_DOCUMENT, read_earlier_estimators, read_whole};
use gravcal_robot_model::sensors::{Options as ModelOptions, RefusedOption};
use gravcal_robot_model::session::SolverChoice;
use gravcal_robot_model::{EstimatorName, Registry, Session, SolverFactory};
use gravcal_session::document::FileError;
use gravcal_session::{read_solver_options, solver_name_error, solver_option_error};
use gravcal_solvers::SolverName;
use toml::{Spanned, Table, Value};

use crate::failure::Failure;

/// Takes the name of an estimator; the help lists them.
pub fn estimator_parser() -> impl TypedValueParser<Value = EstimatorName> {
    PossibleValuesParser::new(EstimatorName::ALL.map(EstimatorName::as_str)).try_map(|name| name.parse())
}

/// The estimator of a calibration.json that is meant: the one that is named, else the only one that it has, else the joint one.
pub fn estimator_of(calibration: &Path, said: Option<EstimatorName>) -> Result<EstimatorName, Failure> {
    if let Some(name) = said {
        return Ok(name);
    }
    let known = read_earlier_estimators(calibration).map_err(|error| Failure::bad_input(&error))?;
    match known.as_slice() {
        [only] => only.parse().map_err(|error| Failure::bad_input(&error).about(calibration.display())),
        several if several.iter().any(|name| name == EstimatorName::Joint.as_str()) => Ok(EstimatorName::Joint),
        several => {
            let message = format!("{}: it does not say which of its estimators is meant", calibration.display());
            Err(Failure::said(message).hint(format!("--estimator NAME chooses one of: {}", several.join(", "))))
        }
    }
}

/// Takes the name of a solver, one of gravcal's or of a registry; the help lists them.
pub fn solver_parser(registry: &Registry) -> PossibleValuesParser {
    PossibleValuesParser::new(solver_names(registry))
}

/// Names of all methods: gravcal's, then those of a registry.
fn solver_names(registry: &Registry) -> Vec<String> {
    let ours = SolverName::ALL.map(SolverName::as_str);
    let added = registry.solvers().map(SolverFactory::name).filter(|name| !ours.contains(name));
    ours.into_iter().chain(added).map(str::to_owned).collect()
}

/// A method of a registry, or else one of gravcal's, with its default options.
///
/// # Errors
/// There is none of this name, or it has no default options; in words.
pub fn solver_named(name: &str, registry: &Registry) -> Result<Box<dyn Solver>, String> {
    if let Some(factory) = added_solver(name, registry) {
        return factory.build(&ModelOptions::default()).map_err(|refused| refused.message);
    }
    name.parse::<SolverName>().map(SolverName::build).map_err(|_| unknown_solver(name, registry))
}

fn added_solver<'r>(name: &str, registry: &'r Registry) -> Option<&'r dyn SolverFactory> {
    registry.solvers().find(|factory| factory.name() == name)
}

fn unknown_solver(name: &str, registry: &Registry) -> String {
    format!("unknown solver `{name}`; there is: {}", solver_names(registry).join(", "))
}

/// What runs, and by which method.
pub struct Choice {
    /// Each at most once.
    pub estimators: Vec<EstimatorName>,
    /// The method.
    pub solver: ChosenSolver,
}

/// A method with its options.
pub struct ChosenSolver {
    /// Its name.
    pub name: String,
    /// What the session says of its options.
    pub options: Table,
    /// The method itself.
    pub method: Box<dyn Solver>,
}

impl Choice {
    /// What the command line says (`estimators` may be empty), else the session at `path`, else the default; `registry`: which methods there
    /// are besides gravcal's own.
    ///
    /// # Errors
    /// A name is unknown, or what is chosen does not go with the session.
    pub fn new(
        (estimators, solver): (&[EstimatorName], Option<&str>),
        (session, path): (&Session, &Path),
        registry: &Registry,
    ) -> Result<Choice, Failure> {
        let default = if session.joints.is_empty() { &[EstimatorName::Joint][..] } else { &EstimatorName::DEFAULT };
        let estimators = once(choose_estimators(estimators, &session.estimators, default, path)?);
        let solver = ChosenSolver::new(solver, session.solver.as_ref(), registry)?;
        check_choice(session, &estimators, solver.method.as_ref())
            .map_err(|error| unsuitable(&error, session, path))?;
        Ok(Choice { estimators, solver })
    }
}

impl ChosenSolver {
    /// Options in the session are those of the method that it names: with another one they do not apply.
    fn new(said: Option<&str>, session: Option<&SolverChoice>, registry: &Registry) -> Result<ChosenSolver, Failure> {
        match session.filter(|choice| said.is_none_or(|said| said == choice.name())) {
            Some(choice) => ChosenSolver::of_session(choice, registry).map_err(|error| Failure::bad_input(&error)),
            None => {
                let name = said.unwrap_or(SolverName::LevenbergMarquardt.as_str());
                let method = solver_named(name, registry).map_err(Failure::said)?;
                Ok(ChosenSolver { name: name.to_owned(), options: Table::new(), method })
            }
        }
    }

    fn of_session(choice: &SolverChoice, registry: &Registry) -> Result<ChosenSolver, FileError> {
        let method = match added_solver(choice.name(), registry) {
            Some(factory) => of_factory(factory, choice)?,
            None => {
                let name: SolverName = choice
                    .name()
                    .parse()
                    .map_err(|_| solver_name_error(choice, unknown_solver(choice.name(), registry)))?;
                read_solver_options(choice, name)?
            }
        };
        Ok(ChosenSolver { name: choice.name().to_owned(), options: choice.options(), method })
    }
}

/// A method of a registry with what a session says of its options.
fn of_factory(factory: &dyn SolverFactory, choice: &SolverChoice) -> Result<Box<dyn Solver>, FileError> {
    let options = choice.options();
    if let Some(key) = options.keys().find(|key| !factory.options().contains(&key.as_str())) {
        let known = factory.options().join(", ");
        let known = if known.is_empty() { "none".to_owned() } else { known };
        let message = format!("{} has no such option; it has: {known}", factory.name());
        return Err(solver_option_error(choice, std::slice::from_ref(key), message));
    }
    let built = factory.build(&ModelOptions::of(options));
    built.map_err(|RefusedOption { keys, message }| solver_option_error(choice, &keys, message))
}

fn choose_estimators(
    said: &[EstimatorName],
    session: &[String],
    default: &[EstimatorName],
    path: &Path,
) -> Result<Vec<EstimatorName>, Failure> {
    if !said.is_empty() {
        return Ok(said.to_vec());
    }
    if session.is_empty() {
        return Ok(default.to_vec());
    }
    session.iter().map(|name| named(name, "estimators", path)).collect()
}

/// Names the field that says what does not go with the choice: constraints are what a method most likely cannot take.
fn unsuitable(error: &UnsuitableChoice, session: &Session, path: &Path) -> Failure {
    let constraints = !session.constraints.is_empty();
    let field = match error {
        UnsuitableChoice::Solver(_) if constraints => "constraints",
        UnsuitableChoice::Solver(_) => "solver",
        UnsuitableChoice::ConstraintsIgnored => "constraints",
        UnsuitableChoice::EarlierIgnored => "prior",
        UnsuitableChoice::ResidualsIgnored => "residual",
        UnsuitableChoice::NoJoints(_)
        | UnsuitableChoice::NoSerialChain(_)
        | UnsuitableChoice::NoSweeps(_)
        | UnsuitableChoice::NotByGroups { .. } => "estimators",
    };
    let failure = Failure::bad_input(error).about(place(field, path));
    match error {
        UnsuitableChoice::Solver(_) if constraints => {
            failure.hint("write solver = \"clarabel\" in the session, or give --solver clarabel")
        }
        _ => failure,
    }
}

/// A name in a field of the session.
fn named<T: FromStr<Err: Error>>(name: &str, field: &str, path: &Path) -> Result<T, Failure> {
    name.parse().map_err(|error| Failure::bad_input(&error).about(place(field, path)))
}

/// File, line and field.
fn place(field: &str, path: &Path) -> String {
    let line = line_of(field, path).map_or_else(String::new, |line| format!(":{line}"));
    format!("{}{line}: {field}", path.display())
}

/// Line, counted from 1, on which a field of the session's top level has its value.
fn line_of(field: &str, path: &Path) -> Option<usize> {
    let text = String::from_utf8(read_whole(path, LARGEST_DOCUMENT).ok()?).ok()?;
    let fields: BTreeMap<String, Spanned<Value>> = toml::from_str(&text).ok()?;
    let start = fields.get(field)?.span().start;
    Some(text.get(..start)?.matches('\n').count() + 1)
}

/// Twice the same estimator is twice the same answer.
fn once(estimators: Vec<EstimatorName>) -> Vec<EstimatorName> {
    let mut different = Vec::new();
    for estimator in estimators {
        if !different.contains(&estimator) {
            different.push(estimator);
        }
    }
    different
}

#[cfg(test)]
mod tests {
    use super::*;
    use EstimatorName::{Joint, JointPaperSignals, Sequential};

    fn chosen(said: &[EstimatorName], session: &[&str]) -> Result<Vec<EstimatorName>, Failure> {
        let session: Vec<String> = session.iter().map(|name| (*name).to_owned()).collect();
        choose_estimators(said, &session, &EstimatorName::DEFAULT, Path::new("session.toml"))
    }

    #[test]
    fn command_line_before_session_before_default() {
        assert_eq!(chosen(&[], &[]), Ok(vec![Sequential, Joint]));
        assert_eq!(chosen(&[], &["joint-paper-signals"]), Ok(vec![JointPaperSignals]));
        assert_eq!(chosen(&[Sequential], &["joint"]), Ok(vec![Sequential]));
        assert_eq!(once(vec![Joint, Sequential, Joint]), [Joint, Sequential]);
    }

    #[test]
    fn an_unknown_name_in_the_session_is_reported_with_the_known_ones() {
        let failure = chosen(&[], &["kalman"]).unwrap_err();
        assert_eq!(
            failure.to_string(),
            "error: session.toml: estimators: unknown estimator `kalman`; there is: sequential, joint, \
             joint-paper-signals, sequential-with-covariance, recursive"
        );
    }

    #[test]
    fn the_line_of_the_name_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("session.toml");
        std::fs::write(&path, "robot = \"robot.toml\"\n\nestimators = [\"kalman\"]\n").unwrap();
        let failure =
            choose_estimators(&[], &["kalman".to_owned()], &EstimatorName::DEFAULT, &path).unwrap_err().to_string();
        assert!(failure.starts_with(&format!("error: {}:3: estimators: unknown estimator", path.display())));
    }

    #[test]
    fn the_command_line_chooses_before_the_default() {
        let chosen = |said| ChosenSolver::new(said, None, &Registry::standard()).unwrap();
        assert_eq!(chosen(None).name, "levenberg-marquardt");
        let dogleg = chosen(Some("dogleg"));
        assert_eq!((dogleg.name.as_str(), dogleg.method.name(), dogleg.options.len()), ("dogleg", "dogleg", 0));
    }
}
