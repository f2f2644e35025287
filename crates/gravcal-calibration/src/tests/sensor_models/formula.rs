//! What a session writes as a formula is told from affine sensors.

use gravcal_robot_model::sensors::Options;
use toml::{Table, Value};

use crate::testing::sensor_models::{assert_distinguished, estimate, shoulder, with_model};

/// Unknowns each with its nominal value and its limit; they are counted in the order of their names.
fn formula(adds: &str, unknowns: [(&str, f64, f64); 3]) -> Options {
    let said = |(name, nominal, limit): (&str, f64, f64)| {
        let table = [("unit", "1".into()), ("nominal", nominal.into()), ("limit", limit.into())];
        let table: Table = table.into_iter().map(|(key, value): (&str, Value)| (key.to_owned(), value)).collect();
        (name.to_owned(), Value::Table(table))
    };
    Options::default().with("adds", adds).with("unknowns", unknowns.into_iter().map(said).collect::<Table>())
}

#[test]
fn torque_ripple_over_the_angle_is_distinguished_from_a_constant_bias() {
    let unknowns = [("ripple", 3.0, 1.0), ("order", 6.0, 0.1), ("phase", 0.2, 0.2)];
    let options = formula("ripple * sin(order * position + phase)", unknowns);
    assert_distinguished(&with_model(shoulder(), 1, "formula", &options, &[6.15, 0.5, 5.0]));
}

/// Over the calibrated angle, and with the load: both move with other unknowns.
#[test]
fn ripple_that_grows_with_the_torque_is_distinguished_from_a_constant_gain() {
    let unknowns = [("ripple", 0.2, 0.1), ("order", 4.0, 0.1), ("phase", 0.0, 0.2)];
    let options = formula("ripple * torque * sin(order * coordinate + phase)", unknowns);
    assert_distinguished(&with_model(shoulder(), 1, "formula", &options, &[4.1, 0.3, 0.3]));
}

#[test]
fn a_position_sensor_may_have_a_formula() {
    let unknowns = [("wave", 0.03, 0.01), ("order", 4.0, 0.1), ("phase", 0.0, 0.2)];
    let options = formula("wave * sin(order * position + phase)", unknowns);
    assert_distinguished(&with_model(shoulder(), 2, "position-formula", &options, &[4.1, 0.2, 0.05]));
}

/// What does not vanish where its unknowns are zero has no absence to be tested against.
#[test]
fn a_formula_that_does_not_vanish_is_not_tested_against_its_absence() {
    let unknowns = [("size", 1.0, 1.0), ("width", 9.0, 3.0), ("shift", 0.0, 1.0)];
    let options = formula("(size + 1) * tanh((width + 1) * position) + shift * direction", unknowns);
    let result = estimate(&with_model(shoulder(), 1, "formula", &options, &[3.0, 4.0, 5.0]).session(0));
    assert!(result.sensor_models.is_empty(), "{:?}", result.sensor_models);
}
