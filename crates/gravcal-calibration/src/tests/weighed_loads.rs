//! Loads that were weighed with an error: gains are as uncertain as the mass that they are measured against, and no more than that.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::load_masses::add_load_masses;
use gravcal_robot_model::session::{ParameterPrior, PriorKind, Session};

use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, ParameterResult};
use crate::sequential::{Plan, report_steps, run_steps};
use crate::testing::{sarcos_shoulder, with_environment};

/// As a share of the mass.
const WEIGHED_TO: f64 = 0.01;

/// The plate at two placements, whose true mass is `off` standard deviations from the nominal one.
fn session(off: f64) -> Session {
    let mut session = sarcos_shoulder().session(0);
    let nominal = session.loads[0].mass / (1.0 + off * WEIGHED_TO);
    session.loads.iter_mut().for_each(|load| load.mass = nominal);
    session
}

fn weighed(off: f64) -> Session {
    let mut session = session(off);
    let std = vec![Some(WEIGHED_TO * session.loads[0].mass); session.loads.len()];
    session.load_masses = add_load_masses(&session.loads, &std, &mut session.further);
    session
}

fn jointly(session: &Session) -> EstimatorResult {
    with_environment(|environment| estimate_jointly(session, Signals::All, None, environment)).unwrap()
}

fn parameter<'r>(result: &'r EstimatorResult, name: &str) -> &'r ParameterResult {
    result.parameters.iter().find(|parameter| parameter.name == name).unwrap()
}

#[test]
fn gains_are_as_uncertain_as_the_mass_and_all_else_is_as_it_was() {
    for off in [0.0, 1.5] {
        let [exact, weighed] = [session(off), weighed(off)].map(|session| jointly(&session));
        for (alone, with_mass) in exact.parameters.iter().zip(&weighed.parameters) {
            assert_eq!(alone.name, with_mass.name);
            let ([Some(value), Some(was)], [Some(found), Some(std)]) =
                ([alone.value, alone.std], [with_mass.value, with_mass.std])
            else {
                continue;
            };
            if alone.held.is_some() {
                continue;
            }
            // Nothing else tells the mass: its nominal value stays, and with it every other number.
            assert!((value - found).abs() < 0.01 * was + 1e-9, "{}: {value} {found}", alone.name);
            let share = if alone.name.ends_with("torque_gain") { WEIGHED_TO * value } else { 0.0 };
            assert!((std / was.hypot(share) - 1.0).abs() < 0.01, "{}: {std}, was {was}", alone.name);
        }
        let gain = parameter(&weighed, "joint1.torque_gain");
        let z = (gain.value.unwrap() - 7.12) / gain.std.unwrap();
        assert!((z - off).abs() < 0.5, "{z}");
        let mass = parameter(&weighed, "load.plate-a.mass");
        assert!((mass.std.unwrap() / (WEIGHED_TO * mass.nominal) - 1.0).abs() < 0.01 && !mass.asked);
        let says_exact =
            |result: &EstimatorResult| result.notes.iter().any(|note| note.contains("masses, taken as exact"));
        assert!(says_exact(&exact) && !says_exact(&weighed));
    }
}

#[test]
fn a_known_gain_weighs_the_load() {
    let mut session = weighed(2.0);
    session.joints[0].parameters[SensorParameter::TorqueGain as usize] =
        ParameterPrior { nominal: 7.12, kind: PriorKind::Fixed };
    let result = jointly(&session);
    let mass = parameter(&result, "load.plate-a.mass");
    let (value, std) = (mass.value.unwrap(), mass.std.unwrap());
    assert!((value - 1.724).abs() < 3.0 * std && std < 0.5 * WEIGHED_TO * mass.nominal, "{value} ± {std}");
}

#[test]
fn the_steps_gains_are_as_uncertain_as_the_mass() {
    let gain = |session: &Session| {
        let result = with_environment(|environment| {
            report_steps(session, &run_steps(session, &Plan::new(session), environment), environment).unwrap()
        });
        let gain = parameter(&result, "joint1.torque_gain").clone();
        (gain.value.unwrap(), gain.std.unwrap())
    };
    let [(value, was), (found, std)] = [session(0.0), weighed(0.0)].map(|session| gain(&session));
    assert_eq!(value, found);
    assert!((std / was.hypot(WEIGHED_TO * value) - 1.0).abs() < 1e-6, "{std}, was {was}");
}
