//! Joints of a recording become those of a robot, and their columns get units.

use gravcal_dynamics::JointKind;
use gravcal_recording::{
    ColumnFound, ConditionUnit, Inspection, JointFound, PositionUnit, TorqueUnit, Travel, are_same_numbers,
    column_numbers,
};
use gravcal_robot_model::robot::{NominalSensors, Robot};

use super::error::DraftError;

/// A joint with its columns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DraftJoint {
    /// The robot's name for it, or the recording's where there is no robot.
    pub name: String,
    /// The recording's name.
    pub recorded: String,
    /// Whether the robot's name for it stands in that of its column, among other words.
    pub by_part: bool,
    pub kind: JointKind,
    pub position: (String, PositionUnit),
    pub torque: Option<(String, TorqueUnit)>,
    pub velocity: Option<(String, ConditionUnit)>,
    /// Lowest and highest position reading.
    pub reach: [f64; 2],
    /// Lowest and highest torque reading.
    pub torque_range: [f64; 2],
    /// Ends of the torque sensor's range at which readings seem to be.
    pub clipped: Vec<f64>,
    /// What the robot file says of its sensors.
    pub nominal: NominalSensors,
}

impl DraftJoint {
    /// What a reading is multiplied with to be an angle or a length in SI, or 1 where nothing says it.
    pub fn scale(&self) -> f64 {
        let gain = self.nominal.position.map(|sensor| sensor.gain).filter(|_| self.position.1.is_sensors_own());
        self.position.1.to_si() * gain.unwrap_or(1.0)
    }

    /// How far it travels for each unit of its reading, in SI.
    pub fn travel(&self) -> Option<Travel> {
        let own = self.position.1.is_sensors_own();
        let gain = if own { self.nominal.position.map(|sensor| sensor.gain.abs()) } else { Some(1.0) }?;
        Some(match self.kind {
            JointKind::Revolute => Travel::Turns(gain),
            JointKind::Prismatic => Travel::Slides(gain),
        })
    }
}

/// Longest travel of a sliding joint that is taken for metres.
const METRES: f64 = 10.0;

/// How joints of a recording became those of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MatchedBy {
    /// Their names agree.
    Name,
    /// No name or not all agree: the numbers in the names of columns tell the order.
    Number,
    /// The columns stand in the order of the joints.
    Order,
}

/// The robot's joints with the columns of the recording, and what told which is which. The recording may have more joints. Without a
/// robot those of the recording.
pub(super) fn matched(
    inspection: &Inspection,
    found: &[JointFound],
    robot: Option<&Robot>,
) -> Result<(Vec<DraftJoint>, MatchedBy), DraftError> {
    let Some(robot) = robot else {
        let joint =
            |found: &JointFound| draft(inspection, found, &found.name, JointKind::Revolute, NominalSensors::default());
        return Ok((found.iter().map(joint).collect(), MatchedBy::Name));
    };
    let joints = robot.chain.joints();
    let of_name = |name: &str| found.iter().find(|found| plain(&found.name) == plain(name));
    let named: Vec<Option<&JointFound>> = joints.iter().map(|joint| of_name(&joint.name)).collect();
    let missing = joints.iter().zip(&named).filter(|(_, named)| named.is_none()).map(|(joint, _)| joint.name.as_str());
    let missing: Vec<&str> = missing.collect();
    let with_torque = inspection.joints_with_torque();
    let by_order = missing.len() == joints.len() || (!missing.is_empty() && found.len() == joints.len());
    let in_order = || match (found.len() == joints.len(), with_torque.len() == joints.len()) {
        (true, _) => Some(found.iter().collect::<Vec<_>>()),
        (false, true) => Some(with_torque.iter().collect()),
        (false, false) => None,
    };
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    let matched = match by_order {
        true => in_order().map(|found| numbered(inspection, found, &names)),
        false => named.into_iter().collect::<Option<Vec<_>>>().map(|found| (found, MatchedBy::Name)),
    };
    let Some((matched, by)) = matched else {
        let recorded = found.iter().map(|found| found.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(DraftError::OtherJoints { missing: missing.join(", "), joints: joints.len(), recorded });
    };
    let by_name = joints.iter().map(|joint| of_name(&joint.name));
    let elsewhere = |(named, taken): (Option<&JointFound>, &&JointFound)| {
        named.is_some_and(|named| named.position != taken.position)
    };
    if by == MatchedBy::Order && by_name.zip(&matched).any(elsewhere) {
        let unnamed = found.iter().filter(|found| joints.iter().all(|joint| plain(&joint.name) != plain(&found.name)));
        let columns: Vec<String> =
            unnamed.map(|found| format!("`{}`", inspection.columns[found.position].name)).collect();
        return Err(DraftError::HalfNamed { missing: missing.join(", "), columns: columns.join(", ") });
    }
    let drafts = joints.iter().zip(matched).zip(&robot.sensors);
    let drafts = drafts.map(|((joint, found), sensors)| draft(inspection, found, &joint.name, joint.kind, *sensors));
    Ok((drafts.collect(), by))
}

/// As many joints of the recording as the robot has, whose names are these, in the robot's order: that of the numbers in the names of both
/// where these are the same, else as they stand, which is that of their own numbers, where they have any.
fn numbered<'a>(
    inspection: &Inspection,
    found: Vec<&'a JointFound>,
    names: &[&str],
) -> (Vec<&'a JointFound>, MatchedBy) {
    let Some(numbers) = column_numbers(found.iter().map(|found| inspection.columns[found.position].name.as_str()))
    else {
        return (found, MatchedBy::Order);
    };
    let of_robot = column_numbers(names.iter().copied()).filter(|of_robot| are_same_numbers(of_robot, &numbers));
    let Some(of_robot) = of_robot else { return (found, MatchedBy::Number) };
    let of = |number: &u64| numbers.iter().position(|of| of == number).map(|place| found[place]);
    (of_robot.iter().filter_map(of).collect(), MatchedBy::Number)
}

/// A name without what writers of tables change in it.
pub(super) fn plain(name: &str) -> String {
    name.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn draft(
    inspection: &Inspection,
    found: &JointFound,
    name: &str,
    kind: JointKind,
    nominal: NominalSensors,
) -> DraftJoint {
    let column = |place: usize| &inspection.columns[place];
    let position = column(found.position);
    let torque = found.torque.map(column);
    let velocity = found.velocity.map(column);
    DraftJoint {
        name: name.to_owned(),
        recorded: found.name.clone(),
        by_part: position.guess.by_part,
        kind,
        position: (position.name.clone(), position_unit(position, kind, nominal)),
        torque: torque.map(|torque| (torque.name.clone(), torque_unit(torque, kind, nominal))),
        velocity: velocity.map(|velocity| (velocity.name.clone(), velocity_unit(velocity, kind))),
        reach: [position.lowest, position.highest],
        torque_range: torque.map_or([0.0; 2], |torque| [torque.lowest, torque.highest]),
        clipped: torque.map_or_else(Vec::new, |torque| torque.clipped.iter().map(|end| end.at).collect()),
        nominal,
    }
}

/// A sensor's own unit is known to the robot's file, others to the names of columns, the rest tell ranges.
fn position_unit(column: &ColumnFound, kind: JointKind, nominal: NominalSensors) -> PositionUnit {
    let own = nominal.position.map(|sensor| sensor.unit).filter(|unit| unit.is_sensors_own());
    let guessed = || column.guess.unit.and_then(|unit| unit.parse().ok()).unwrap_or(PositionUnit::Radian);
    let long = column.lowest.abs().max(column.highest.abs()) > METRES;
    match (own.unwrap_or_else(guessed), kind) {
        (PositionUnit::Radian | PositionUnit::Degree, JointKind::Prismatic) if long => PositionUnit::Millimeter,
        (PositionUnit::Radian | PositionUnit::Degree, JointKind::Prismatic) => PositionUnit::Meter,
        (PositionUnit::Meter | PositionUnit::Millimeter, JointKind::Revolute) => PositionUnit::Radian,
        (unit, _) => unit,
    }
}

fn torque_unit(column: &ColumnFound, kind: JointKind, nominal: NominalSensors) -> TorqueUnit {
    let guessed = || column.guess.unit.and_then(|unit| unit.parse().ok()).unwrap_or(TorqueUnit::NewtonMeter);
    match (nominal.torque.map_or_else(guessed, |sensor| sensor.unit), kind) {
        (TorqueUnit::NewtonMeter | TorqueUnit::MillinewtonMeter, JointKind::Prismatic) => TorqueUnit::Newton,
        (TorqueUnit::Newton, JointKind::Revolute) => TorqueUnit::NewtonMeter,
        (unit, _) => unit,
    }
}

fn velocity_unit(column: &ColumnFound, kind: JointKind) -> ConditionUnit {
    let known = match kind {
        JointKind::Revolute => ConditionUnit::ANGULAR_VELOCITY,
        JointKind::Prismatic => ConditionUnit::VELOCITY,
    };
    known.into_iter().find(|unit| Some(unit.name) == column.guess.unit).unwrap_or(known[0])
}
