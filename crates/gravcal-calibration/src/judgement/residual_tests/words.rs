//! What a test says, and what to do about it.

use crate::result::{ResidualTest, ResidualTestKind};
use crate::session::Session;

/// A test that names something, in sentences.
pub(crate) fn in_words(session: &Session, test: &ResidualTest) -> String {
    let ResidualTest { channel, size, unit, in_noise, corrected_p_value, .. } = test;
    let of_joint = session.robot.chain.joints().iter().any(|joint| joint.name == *channel);
    let size = number(*size);
    let (what, cure) = match &test.kind {
        ResidualTestKind::Trend => {
            (format!("The residual of {channel} drifts by {size} {unit}: its zero creeps."), drift(of_joint))
        }
        ResidualTestKind::TrendInTables => (
            format!("The residual of {channel} drifts by {size} {unit} within each table: its zero creeps, and is read anew between them."),
            "Let the sensor warm up before it is read, and visit some poses twice in each table: at its beginning and its end.".into(),
        ),
        ResidualTestKind::Neighbours => (
            format!("The residuals of {channel} are alike in neighbouring poses (correlation {size}): its errors are not noise, and more poses nearby tell less than they seem to."),
            "Take standard deviations from blocks of poses ([uncertainty] kind = \"sandwich\"), and visit poses in another order, far from each other.".into(),
        ),
        ResidualTestKind::TorqueHarmonic { order } => (
            format!("The residual of {channel} goes with its own angle, {}, by {size} {unit}.", periods(*order)),
            "A cable, a gear or a sensor that is loaded from the side does so: look at what pulls at the joint; spread the poses over its whole range.".into(),
        ),
        ResidualTestKind::PositionHarmonic { order } => (
            format!("The residuals show a coordinate of {channel} that runs unevenly, {}, by {size} rad.", periods(*order)),
            format!("Estimate it: sensor_models = [{{ kind = \"position-harmonics\", orders = [{order}] }}] in its [[joint]]."),
        ),
        ResidualTestKind::Velocity => (
            format!("The residual of {channel} goes with its speed: {size} {unit}."),
            "This is viscous friction (sensor_models = [{ kind = \"viscous-friction\" }]) or what comes with speed: drive slower, and both ways.".into(),
        ),
        ResidualTestKind::Acceleration => (
            format!("The residual of {channel} goes with its acceleration: {size} {unit}. This is inertia."),
            "Leave accelerated rows out ([readings.select]), let joints stand ([readings.still]), or drive steadily.".into(),
        ),
        ResidualTestKind::Direction => (
            format!("The residual of {channel} goes with the side from which the joint came: by {size} {unit} either way. This is friction."),
            "Estimate it (sensor_models = [{ kind = \"coulomb-friction\" }] in its [[joint]]), and come to each pose from both sides.".into(),
        ),
        ResidualTestKind::Tables { file } => (
            format!("The residual of {channel} is another in each table: in {file} by {size} {unit}."),
            tables(of_joint),
        ),
    };
    let consequence = match (test.spoils_intervals, &test.kind) {
        (true, _) => "Intervals cannot hold.",
        (false, ResidualTestKind::Neighbours) => "Intervals are hardly touched by it.",
        (false, _) => "It is real but small beside the noise, and changes no verdict.",
    };
    let seen = match test.kind {
        ResidualTestKind::Neighbours => String::new(),
        _ => format!(", {} times the noise of a reading", number(*in_noise)),
    };
    format!("{what} (p = {}{seen}, all tests counted.) {consequence} {cure}", number(*corrected_p_value))
}

fn drift(of_joint: bool) -> String {
    let kind = if of_joint { "torque-bias-in-time" } else { "bias-in-time" };
    format!(
        "Let the sensor warm up before it is read; or estimate a steady drift: sensor_models = [{{ kind = \"{kind}\" }}], with the \
         poses in an order that has nothing to do with their angles."
    )
}

fn tables(of_joint: bool) -> String {
    let zero = if of_joint {
        "or the sensor's zero was another"
    } else {
        "or its zero was another (bias of its own for each table)"
    };
    format!(
        "A load that sat otherwise than said does so, a cable that was moved, {zero}: look at what changed between the tables."
    )
}

fn periods(order: u32) -> String {
    match order {
        1 => "once a turn".into(),
        2 => "twice a turn".into(),
        _ => format!("{order} times a turn"),
    }
}

/// Two digits.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value.abs()) {
        let digits = (1 - value.abs().max(1e-3).log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}
