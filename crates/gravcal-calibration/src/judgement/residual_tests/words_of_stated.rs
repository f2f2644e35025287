//! What a test says of what is stated of loads and of the robot, and what to do about it.

use gravcal_robot_model::number::{shown_unit, significant};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};

use crate::result::{ResidualTest, ResidualTestKind};

/// What is said of the like, where one that is named widens intervals.
pub fn of_like(session: &Session, kind: &ResidualTestKind) -> Option<&'static str> {
    match kind {
        ResidualTestKind::LoadMass { .. } if has_other_loads(session) => {
            Some("The masses of other loads may be as wrong: intervals include what that would do.")
        }
        ResidualTestKind::JointPlacement { .. } => {
            Some("Other lengths of the robot may be as wrong: intervals include what that would do.")
        }
        ResidualTestKind::JointTilt { .. } => {
            Some("Other axes of the robot may be tilted as much: intervals include what that would do.")
        }
        _ => None,
    }
}

/// What was found, and what to do; nothing of other kinds.
pub fn of_stated(session: &Session, test: &ResidualTest) -> (String, String) {
    let (size, unit) = (significant(test.size.abs(), 2), &test.unit);
    match &test.kind {
        ResidualTestKind::LoadMass { load } => {
            let heavier = if test.size > 0.0 { "heavier" } else { "lighter" };
            (
                format!("The residuals of all joints show load {load} to be {heavier} than stated, by {size} {unit}."),
                format!(
                    "Weigh it again, or say how well it is weighed (mass_kg = {{ nominal = …, std = … }}).{}",
                    or_stated_scale(session)
                ),
            )
        }
        ResidualTestKind::LoadPlacement { load } => (
            format!("The residuals of all joints show load {load} {size} {unit} from where position_m says."),
            "Leave position_m away: torque gains do not need it. Or say how well it is known (position_std_m).".into(),
        ),
        ResidualTestKind::LoadDistance { load, other } => {
            let apart = if test.size > 0.0 { "farther apart" } else { "closer together" };
            (
                format!("The residuals of all joints show loads {load} and {other} {size} {unit} {apart} than distance_m says."),
                "Measure the distance again, between centres of mass, or say how well it is known (std_m beside distance_m).".into(),
            )
        }
        ResidualTestKind::JointTilt { joint } => (
            format!(
                "The residuals of all joints show the axis of {joint} tilted by {}° against the robot's description.",
                significant(test.size.to_degrees(), 2)
            ),
            "Use axes that were measured for this very arm: controllers of many arms hold them. Or say how well they are known ([inertia] axis_std_deg).".into(),
        ),
        ResidualTestKind::JointPlacement { joint } => (
            format!(
                "The residuals of all joints show {joint} {size} {unit} from where the robot's description has it on the link before."
            ),
            format!(
                "Use lengths that were measured for this very arm: controllers of many arms hold them. Or say how well they are known \
                 ([inertia] length_std_m).{}",
                or_stated_place(session)
            ),
        ),
        _ => Default::default(),
    }
}

/// The same of a parameter of a joint's sensors.
pub fn of_stated_sensor(session: &Session, test: &ResidualTest, parameter: &str) -> (String, String) {
    let (unit, factor) = shown_unit(&test.unit);
    let (size, more) = (significant(factor * test.size.abs(), 2), if test.size > 0.0 { "more" } else { "less" });
    let quantity = parameter.rsplit('.').next().unwrap_or(parameter);
    let of_joint = session.parameters().into_iter().find(|id| session.parameter_name(*id) == parameter);
    let stated = of_joint.map_or(PriorKind::Fixed, |id| session.prior(id).kind);
    let cure = match stated {
        PriorKind::Gaussian { .. } => {
            format!("Check its nominal value and its std; without std the value of {quantity} is only a start.")
        }
        _ => format!("Take fixed out of its {quantity}: a nominal value is only a start."),
    };
    (format!("The residuals show that {parameter} is not what the session states, but {size} {unit} {more}."), cure)
}

fn has_other_loads(session: &Session) -> bool {
    session.loads.iter().filter(|load| !load.is_unknown()).count() > 1
}

/// Masses and torque gains have one scale: another mass, and a torque gain that is stated, contradict the mass as it contradicts them.
fn or_stated_scale(session: &Session) -> String {
    let gains = (0..session.joints.len()).map(|joint| ParameterId::Sensor(joint, SensorParameter::TorqueGain));
    let stated =
        gains.filter(|gain| matches!(session.prior(*gain).kind, PriorKind::Gaussian { .. } | PriorKind::Fixed));
    let stated = stated.map(|gain| session.parameter_name(gain));
    let others: Vec<String> =
        has_other_loads(session).then(|| "another load".to_owned()).into_iter().chain(stated).collect();
    match others.is_empty() {
        true => String::new(),
        false => format!(" What is stated of {} may be wrong instead.", others.join(" or of ")),
    }
}

/// A joint that sits elsewhere looks much like a load that does.
fn or_stated_place(session: &Session) -> &'static str {
    let exact = session.loads.iter().any(|load| load.position.is_some() && load.position_std.is_none());
    if exact { " A load may be elsewhere than position_m says instead." } else { "" }
}
