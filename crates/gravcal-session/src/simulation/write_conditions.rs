//! Conditions of simulated poses as a session's readings declare them, and as columns of its tables.

use gravcal_dynamics::JointKind;
use gravcal_recording::Cell;
use gravcal_robot_model::session::{Pose, Session};
use serde::Serialize;

use super::conditions::SimulatedConditions;

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

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::read_session;
    use crate::simulation::{Simulation, write_session};
    use crate::testing::TWO_JOINTS;

    const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 3
[gravity]
direction = [0, 1, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.01
converter = { bits = 10, range = [-3.0, 3.0] }
[position]
unit = "rad"
[conditions]
pose_interval_s = 20
temperature_degC = [20, 30]
largest_speed_rad_or_m_per_s = 0.1
direction = true
[[joint]]
name = "shoulder"
sensor_models = [
    { kind = "torque-bias-in-time", parameters = { torque_bias_drift = { value = 1e-4, unit = "N·m/s" } } },
    { kind = "position-harmonics", orders = [1], parameters = { position_sine_1 = { value = 1, unit = "deg" }, position_cosine_1 = { value = 0.01, unit = "rad" } } },
]
[[joint]]
name = "elbow"
sensor_models = [
    { kind = "torque-bias-with-temperature", reference_degC = 25, parameters = { torque_bias_temperature_drift = { value = 0.02, unit = "N·m/K" } } },
    { kind = "torque-gain-polynomial", degree = 2, parameters = { torque_gain_2 = { value = 0.01, unit = "N·m/(N·m)^2" } } },
    { kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.1, unit = "Nm" } } },
    { kind = "viscous-friction", parameters = { viscous_friction = { value = 0.5, unit = "N·m/(rad/s)" } } },
    { kind = "torque-crosstalk", from = ["shoulder"], parameters = { torque_crosstalk_shoulder = { value = 0.05, unit = "N·m/(N·m)" } } },
]
[[random]]
file = "poses.csv"
poses = 60
"#;

    /// What is written is read back as what was drawn: models, their parameters, conditions, saturated readings.
    #[test]
    fn a_session_with_every_model_is_written_and_read() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
        fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
        let simulation = Simulation::read(&folder.path().join("simulation.toml")).unwrap();
        let drawn = simulation.session(0);
        let files = write_session(&simulation, 0, folder.path(), false).unwrap();
        let read = read_session(&files[0]).unwrap();
        assert_eq!(read.further, drawn.further);
        assert_eq!(read.further.len(), 8);
        assert_eq!((&read.poses, &read.saturated), (&drawn.poses, &drawn.saturated));
        assert!(read.saturated.iter().sum::<usize>() > 0);
        assert!((simulation.truth.further[1] - 1f64.to_radians()).abs() < 1e-15);
        let truth = fs::read_to_string(folder.path().join("truth.toml")).unwrap();
        assert!(truth.contains("name = \"elbow.torque_crosstalk_shoulder\"\nvalue = 0.05"), "{truth}");
    }

    #[test]
    fn where_one_joint_moves_the_other_stands() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
        let drawn = |moving: &str| {
            let text = SIMULATION.replace("poses = 60", &format!("poses = 60\n{moving}"));
            fs::write(folder.path().join("simulation.toml"), text).unwrap();
            let session = Simulation::read(&folder.path().join("simulation.toml")).unwrap().session(0);
            session.poses.iter().map(|pose| pose.position.clone()).collect::<Vec<_>>()
        };
        let moved = |positions: &[Vec<f64>]| -> Vec<usize> {
            positions.windows(2).map(|two| two[0].iter().zip(&two[1]).filter(|(a, b)| a != b).count()).collect()
        };
        let one = drawn("moving = 1");
        assert_eq!(moved(&one), [1; 59]);
        let of_first = one.windows(2).filter(|two| two[0][0] != two[1][0]).count();
        assert!((15..45).contains(&of_first), "either moves about as often: {of_first} of 59");
        assert_eq!(moved(&drawn("moving = 2")), [2; 59]);
        assert_eq!(moved(&drawn("")), [2; 59]);
        let message = refused("poses = 60", "poses = 60\nmoving = 3");
        assert!(message.contains("random[0].moving: expected 1 to 2 joints that move"), "{message}");
    }

    fn refused(from: &str, to: &str) -> String {
        assert!(SIMULATION.contains(from), "{from}");
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
        fs::write(folder.path().join("simulation.toml"), SIMULATION.replace(from, to)).unwrap();
        Simulation::read(&folder.path().join("simulation.toml")).unwrap_err().to_string()
    }

    #[test]
    fn true_values_and_conditions_must_be_there() {
        let message = refused(", parameters = { coulomb_friction = { value = 0.1, unit = \"Nm\" } }", "");
        assert!(
            message.contains("joint[1].sensor_models[2]: what is the true coulomb_friction? add parameters"),
            "{message}"
        );
        let message = refused("pose_interval_s = 20", "");
        assert!(message.contains("torque-bias-in-time needs the time of each pose"), "{message}");
        let message = refused("{ value = 1, unit = \"deg\" }", "{ value = 1, unit = \"mm\" }");
        assert!(message.contains("the unit `mm` does not fit: expected `rad` or `deg`"), "{message}");
    }
}
