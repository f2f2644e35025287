//! What the session states, or the robot's description, and is not so: of a joint's sensors, of loads, of where joints sit and how they are tilted.

use gravcal_robot_model::number::{shown_unit, significant};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::score::dot;
use crate::judgement::residual_tests::wording::shown_amount;
use crate::result::{ResidualTest, ResidualTestKind};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stated {
    /// Of a joint's sensor, in the unit of the parameter.
    Sensor(SensorParameter),
    /// Of all channels: the mass of a load, kg.
    LoadMass(usize),
    /// Of all channels: the place of a load, m along the axes of its link.
    LoadPlacement(usize),
    /// Of all channels: the distance of two loads, m; its number.
    LoadDistance(usize),
    /// Of all channels: where a joint sits on the link before it, m along the axes of that link; its number among those that can be told.
    JointPlacement(usize),
    /// Of all channels: how a joint is tilted on the link before it, rad about two axes perpendicular to its own; the link that it moves.
    JointTilt(usize),
}

impl Stated {
    /// Those of these parameters of a joint's sensors of which the session states more than a start.
    pub fn of_sensors(of: &Columns, joint: usize, parameters: [SensorParameter; 2]) -> impl Iterator<Item = Stated> {
        let stated = move |parameter: &SensorParameter| of.session.joints[joint].of(*parameter).kind != PriorKind::Flat;
        parameters.into_iter().filter(stated).map(Stated::Sensor)
    }

    /// What is stated of loads without a standard deviation.
    pub fn of_loads(of: &Columns) -> Vec<Stated> {
        let loads = (0..of.loads.len()).flat_map(|load| [Stated::LoadMass(load), Stated::LoadPlacement(load)]);
        loads.chain((0..of.distances.len()).map(Stated::LoadDistance)).collect()
    }

    /// What the robot's description says.
    pub fn of_robot(of: &Columns) -> Vec<Stated> {
        let placements = (0..of.displaced.aside.len()).map(Stated::JointPlacement);
        placements.chain(of.displaced.tilted.iter().map(|tilted| Stated::JointTilt(tilted.link))).collect()
    }

    /// Whether it is where a joint sits, or how it is tilted, on the link before it.
    pub fn is_of_description(&self) -> bool {
        matches!(self, Stated::JointPlacement(_) | Stated::JointTilt(_))
    }
}

impl Lacked for Stated {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match *self {
            Stated::Sensor(parameter) => vec![match parameter {
                SensorParameter::TorqueGain => of.reading(channel, |pose| of.predicted.torque(pose, channel)),
                SensorParameter::TorqueBias => of.reading(channel, |_| 1.0),
                SensorParameter::PositionGain => {
                    of.coordinate(channel, |pose| of.session.poses[pose].position[channel])
                }
                SensorParameter::PositionOffset => of.coordinate(channel, |_| 1.0),
            }],
            Stated::LoadMass(load) => of.loads[load].mass.clone(),
            Stated::LoadPlacement(load) => of.loads[load].placement.clone(),
            Stated::LoadDistance(distance) => of.distances[distance].clone(),
            Stated::JointPlacement(placement) => of.displaced.aside[placement].columns.clone(),
            Stated::JointTilt(link) => of.displaced.tilted[link].columns.clone(),
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let session = of.session;
        let first = coefficients.first().copied().unwrap_or(0.0);
        let length = dot(coefficients, coefficients).sqrt();
        let load = |load: usize| session.loads[load].name.clone();
        let joint = |link: usize| session.robot.chain.movers()[link].name.clone();
        match *self {
            Stated::Sensor(parameter) => {
                let id = ParameterId::Sensor(channel, parameter);
                let parameter = session.parameter_name(id);
                Found::new(ResidualTestKind::StatedSensor { parameter }, first, session.parameter(id).unit)
            }
            Stated::LoadMass(of_load) => Found::new(ResidualTestKind::LoadMass { load: load(of_load) }, first, "kg"),
            Stated::LoadPlacement(of_load) => {
                Found::new(ResidualTestKind::LoadPlacement { load: load(of_load) }, length, "m")
            }
            Stated::LoadDistance(distance) => {
                let [load, other] = session.load_distances[distance].between.map(load);
                Found::new(ResidualTestKind::LoadDistance { load, other }, first, "m")
            }
            Stated::JointPlacement(placement) => {
                let joint = joint(of.displaced.aside[placement].link);
                Found::new(ResidualTestKind::JointPlacement { joint }, length, "m")
            }
            Stated::JointTilt(link) => Found::new(ResidualTestKind::JointTilt { joint: joint(link) }, length, "rad"),
        }
    }
}

pub fn of_sensor(session: &Session, test: &ResidualTest, parameter: &str) -> Words {
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
    Words::new(
        format!("The residuals show that {parameter} is not what the session states, but {size} {unit} {more}."),
        cure,
    )
}

pub fn of_load_mass(session: &Session, test: &ResidualTest, load: &str) -> Words {
    let heavier = if test.size > 0.0 { "heavier" } else { "lighter" };
    Words::new(
        format!("The residuals of all joints show load {load} to be {heavier} than stated, by {}.", shown_amount(test)),
        format!(
            "Weigh it again, or say how well it is weighed (mass_kg = {{ nominal = …, std = … }}).{}",
            or_stated_scale(session)
        ),
    )
    .beside(
        has_other_loads(session)
            .then_some("The masses of other loads may be as wrong: intervals include what that would do."),
    )
}

pub fn of_load_placement(test: &ResidualTest, load: &str) -> Words {
    Words::new(
        format!("The residuals of all joints show load {load} {} from where position_m says.", shown_amount(test)),
        "Leave position_m away: torque gains do not need it. Or say how well it is known (position_std_m).",
    )
}

pub fn of_load_distance(test: &ResidualTest, load: &str, other: &str) -> Words {
    let apart = if test.size > 0.0 { "farther apart" } else { "closer together" };
    Words::new(
        format!(
            "The residuals of all joints show loads {load} and {other} {} {apart} than distance_m says.",
            shown_amount(test)
        ),
        "Measure the distance again, between centres of mass, or say how well it is known (std_m beside distance_m).",
    )
}

pub fn of_joint_placement(session: &Session, test: &ResidualTest, joint: &str) -> Words {
    Words::new(
        format!(
            "The residuals of all joints show {joint} {} from where the robot's description has it on the link before.",
            shown_amount(test)
        ),
        format!(
            "Use lengths that were measured for this very arm: controllers of many arms hold them. Or say how well they are known \
             ([inertia] length_std_m).{}",
            or_stated_place(session)
        ),
    )
    .beside(Some("Other lengths of the robot may be as wrong: intervals include what that would do."))
}

pub fn of_joint_tilt(test: &ResidualTest, joint: &str) -> Words {
    Words::new(
        format!(
            "The residuals of all joints show the axis of {joint} tilted by {}° against the robot's description.",
            significant(test.size.to_degrees(), 2)
        ),
        "Use axes that were measured for this very arm: controllers of many arms hold them. Or say how well they are known ([inertia] axis_std_deg).",
    )
    .beside(Some("Other axes of the robot may be tilted as much: intervals include what that would do."))
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
