//! Simulated sessions of the Sarcos shoulder with sensors that are not affine.

use super::sarcos_shoulder;
use crate::joint::{Signals, estimate_jointly};
use crate::result::EstimatorResult;
use gravcal_dynamics::JointKind;
use gravcal_estimation::Solver;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::sensors::{Options, SensorTerms, Site, Term, declare_terms};
use gravcal_robot_model::session::Session;
use gravcal_session::simulation::{SimulatedConditions, Simulation};
use gravcal_solvers::LevenbergMarquardt;

/// The reference protocol, 10 s from pose to pose, sensors that warm up, and joints that come from both sides.
pub fn shoulder() -> Simulation {
    let mut simulation = sarcos_shoulder();
    simulation.conditions = SimulatedConditions {
        pose_interval: Some(10.0),
        temperature: Some([22.0, 35.0]),
        largest_speed: Some(0.05),
        direction: true,
    };
    simulation
}

/// The same with a model of one joint's sensor, its parameters truly these.
pub fn with_model(
    mut simulation: Simulation,
    joint: usize,
    model: &str,
    options: &Options,
    truth: &[f64],
) -> Simulation {
    let site = Site::new(
        joint,
        &["joint1", "joint2", "joint3"],
        &[JointKind::Revolute; 3],
        &simulation.template.joints[joint],
    );
    let registry = Registry::standard();
    let declared = declare_terms(registry.sensor_model(model).unwrap(), &site, options).unwrap();
    let (terms, parameters): (Vec<Term>, Vec<Vec<Parameter>>) = declared.into_iter().unzip();
    simulation.template.terms.extend(terms);
    simulation.template.further.extend(parameters.concat());
    simulation.truth.further.extend(truth);
    assert_eq!(simulation.template.further.len(), simulation.truth.further.len());
    simulation
}

/// The readings of a session taken for those of affine sensors.
pub fn taken_as_affine(session: &Session) -> Session {
    Session { terms: SensorTerms::default(), further: Vec::new(), ..session.clone() }
}

pub fn estimate(session: &Session) -> EstimatorResult {
    estimate_by(&LevenbergMarquardt::default(), session)
}

pub fn estimate_by(solver: &dyn Solver, session: &Session) -> EstimatorResult {
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(solver, &|_| {})).unwrap()
}

/// By determined parameter, how many standard deviations its value is off the truth.
pub fn errors(session: &Session, simulation: &Simulation, result: &EstimatorResult) -> Vec<(String, f64)> {
    let reported = session.parameters().into_iter().zip(&result.parameters);
    reported
        .filter_map(|(id, reported)| {
            let std = reported.std.filter(|std| *std > 0.0)?;
            Some((reported.name.clone(), (reported.value? - simulation.truth.value(id)) / std))
        })
        .collect()
}

/// Shows what a model is for: readings with it, taken for affine, are explained badly or give values many standard deviations
/// off; the model itself explains them, and finds the truth.
pub fn assert_distinguished(simulation: &Simulation) {
    let session = simulation.session(0);
    let affine = taken_as_affine(&session);
    let wrong = estimate(&affine);
    let largest = |errors: Vec<(String, f64)>| errors.iter().fold(0.0_f64, |m, (_, error)| m.max(error.abs()));
    let misfit = wrong.fit.as_ref().and_then(|fit| fit.p_value).is_some_and(|p| p < 1e-6);
    let off = largest(errors(&affine, simulation, &wrong));
    assert!(misfit || off > 5.0, "the affine model is off by {off} standard deviations at most, and fits");
    assert_found(simulation);
}

/// Shows that a model explains its readings, and finds the truth.
pub fn assert_found(simulation: &Simulation) {
    let session = simulation.session(0);
    let right = estimate(&session);
    let found = errors(&session, simulation, &right);
    assert_eq!(right.undetermined.len(), 1, "{:?}", right.undetermined);
    assert!(right.fit.as_ref().unwrap().p_value.unwrap() > 1e-3, "{:?}", right.fit);
    assert!(found.iter().all(|(_, error)| error.abs() < 4.0), "{found:?}");
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    for parameter in &session.further {
        assert!(names.contains(&parameter.name().as_str()), "{} is undetermined", parameter.name());
    }
}

/// Names of what a session cannot determine.
pub fn undetermined(session: &Session) -> Vec<String> {
    let reported = estimate(session).parameters;
    reported
        .into_iter()
        .filter(|reported| !reported.determined && reported.asked)
        .map(|reported| reported.name)
        .collect()
}
