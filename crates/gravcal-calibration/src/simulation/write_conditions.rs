//! Conditions of simulated poses as a session's readings declare them, and as columns of its tables.

use gravcal_kinematics::JointKind;
use gravcal_recording::Cell;
use serde::Serialize;

use super::SimulatedConditions;
use crate::session::{Pose, Session};

const TIME: &str = "time_s";
const TEMPERATURE: &str = "temperature_degC";

/// Their part of `[readings]`.
#[derive(Serialize)]
pub(super) struct ConditionTables {
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Columns<&'static str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    temperature: Option<Columns<&'static str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<Columns<Vec<String>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<Columns<Vec<String>>>,
}

#[derive(Serialize)]
struct Columns<C> {
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<C>,
    #[serde(skip_serializing_if = "Option::is_none")]
    columns: Option<C>,
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<C>,
}

pub(super) fn tables(session: &Session, conditions: &SimulatedConditions) -> ConditionTables {
    let units = (0..session.joints.len()).map(|joint| velocity_unit(session, joint).to_owned()).collect();
    ConditionTables {
        time: conditions.pose_interval.map(|_| Columns { column: Some(TIME), columns: None, unit: Some("s") }),
        temperature: conditions.temperature.map(|_| Columns {
            column: None,
            columns: Some(TEMPERATURE),
            unit: Some("degC"),
        }),
        velocity: conditions.largest_speed.map(|_| Columns {
            column: None,
            columns: Some(velocity_columns(session)),
            unit: Some(units),
        }),
        direction: conditions.direction.then(|| Columns {
            column: None,
            columns: Some(direction_columns(session)),
            unit: None,
        }),
    }
}

/// The columns of a table.
pub(super) fn columns(session: &Session, conditions: &SimulatedConditions) -> Vec<String> {
    let time = conditions.pose_interval.map(|_| TIME.to_owned());
    let temperature = conditions.temperature.map(|_| TEMPERATURE.to_owned());
    let velocity = conditions.largest_speed.map_or_else(Vec::new, |_| velocity_columns(session));
    let direction = if conditions.direction { direction_columns(session) } else { Vec::new() };
    time.into_iter().chain(temperature).chain(velocity).chain(direction).collect()
}

/// The cells of one pose in them.
pub(super) fn cells(pose: &Pose) -> Vec<Cell> {
    let conditions = &pose.conditions;
    let temperature = conditions.temperature.first();
    let numbers = conditions.time.iter().chain(temperature).chain(&conditions.velocity).chain(&conditions.direction);
    numbers.map(|number| Cell::from(*number)).collect()
}

fn velocity_columns(session: &Session) -> Vec<String> {
    let joints = session.robot.chain.joints().iter().enumerate();
    joints.map(|(index, joint)| format!("{}_velocity_{}", joint.name, velocity_unit(session, index))).collect()
}

fn velocity_unit(session: &Session, joint: usize) -> &'static str {
    match session.robot.chain.joints()[joint].kind {
        JointKind::Revolute => "rad/s",
        JointKind::Prismatic => "m/s",
    }
}

fn direction_columns(session: &Session) -> Vec<String> {
    session.robot.chain.joints().iter().map(|joint| format!("{}_direction", joint.name)).collect()
}
