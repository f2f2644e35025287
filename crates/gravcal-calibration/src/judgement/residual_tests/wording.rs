//! What sentences on tests have in common.

use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use super::columns::ALL_JOINTS;
use crate::result::ResidualTest;

/// What becomes of intervals where a term spoils them.
pub const WIDENED: &str = "Each interval is widened by the shift that this effect causes. Do not rely on the intervals until the model includes it.";
/// What is said where it does not.
pub const SMALL: &str = "It is real but small beside the noise, and changes no verdict.";

/// The size without its unit.
pub fn shown_size(test: &ResidualTest) -> String {
    significant(test.size, 2)
}

/// The size with its unit.
pub fn shown(test: &ResidualTest) -> String {
    format!("{} {}", shown_size(test), test.unit)
}

/// The same without its sign.
pub fn shown_amount(test: &ResidualTest) -> String {
    format!("{} {}", significant(test.size.abs(), 2), test.unit)
}

/// A p-value; digits far out in a tail mean nothing.
pub fn chance(p: f64) -> String {
    if p < 1e-6 { "p < 1e-6".into() } else { format!("p = {}", significant(p, 2)) }
}

/// Whether a channel is of a joint, by its name.
pub fn is_joint(session: &Session, channel: &str) -> bool {
    session.robot.chain.joints().iter().any(|joint| joint.name == channel)
}

/// The joint of a channel; the first one of all joints, whose units are then those of the first.
pub fn joint_of(session: &Session, channel: &str) -> usize {
    session.robot.chain.joints().iter().position(|joint| joint.name == channel).unwrap_or(0)
}

/// Only that of all joints, where there is one: it says what others say of some.
pub fn of_all_or_each<'t>(tests: &'t [&'t ResidualTest]) -> &'t [&'t ResidualTest] {
    let all = tests.iter().position(|test| test.channel == ALL_JOINTS);
    all.map_or(tests, |place| &tests[place..=place])
}

/// The channels of some tests, their sizes from least to most, and the largest of their p-values; nothing where there are none.
pub fn together(tests: &[&ResidualTest]) -> Option<(String, [f64; 2], f64)> {
    let sizes = || tests.iter().map(|test| test.size.abs());
    let channels: Vec<&str> = tests.iter().map(|test| test.channel.as_str()).collect();
    let p = tests.iter().map(|test| test.corrected_p_value).fold(0.0, f64::max);
    Some((channels.join(", "), [sizes().reduce(f64::min)?, sizes().reduce(f64::max)?], p))
}

/// The least and the most of several tests.
pub fn from_to(least: f64, most: f64, tests: &[&ResidualTest]) -> String {
    let most = significant(most, 2);
    if tests.len() > 1 { format!("{} to {most}", significant(least, 2)) } else { most }
}

/// How to add a formula to the torque reading of a channel, or of all joints; of each unknown its name, unit, and what else is said of it.
pub fn formula(channel: &str, adds: &str, unknowns: &[(&str, String, String)]) -> String {
    let place = if channel == ALL_JOINTS { "[joints]" } else { "its [[joint]]" };
    let unknowns = unknowns.iter().map(|(name, unit, said)| format!("{name} = {{ unit = \"{unit}\", {said} }}"));
    let unknowns: Vec<String> = unknowns.collect();
    format!(
        "sensor_models = [{{ kind = \"formula\", adds = \"{adds}\", unknowns = {{ {} }} }}] in {place}",
        unknowns.join(", ")
    )
}
