//! Sessions without any file: a robot, and poses from arrays.

use gravcal_dynamics::JointKind;
use gravcal_recording::{Conditions, PositionUnit, Reading, TorqueUnit};
use thiserror::Error;

use super::contents::Session;
use super::known::{GravityPrior, JointPriors};
use super::parameter_prior::{ParameterPrior, PriorKind};
use super::pose::{Pose, PoseTable};
use crate::robot::{NominalSensors, Robot};

/// Poses of one recording, one after the other, each with one number for each joint of the robot.
#[derive(Clone, Copy, Debug)]
pub struct PoseArrays<'a> {
    /// What stands in place of a file's name in results.
    pub name: &'a str,
    /// Index into [`Session::loads`] of the load that is attached, if any.
    pub load: Option<usize>,
    /// Position readings: rad, or m of joints that slide; in the sensor's own unit where the robot's nominal sensor has one.
    pub positions: &'a [f64],
    /// Torque readings: N·m, or N of joints that slide; in the sensor's own unit where the robot's nominal sensor has one. NaN where
    /// there is none.
    pub torques: &'a [f64],
    /// Standard deviation of a torque reading of each joint, in its unit; without it the noise is found in the residuals.
    pub torque_std: Option<&'a [f64]>,
}

/// Why arrays are no poses.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PoseArraysError {
    /// Not one number for each joint of each pose.
    #[error("`{name}` has {found} {what}, and the robot {joints} joints: expected {expected}")]
    Length {
        /// Of the arrays.
        name: String,
        /// Which numbers.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many joints the robot has.
        joints: usize,
        /// How many there should be, in words.
        expected: String,
    },
    /// No number.
    #[error("`{name}`, pose {pose}, joint {joint}: {value} is no {what}: expected a finite number")]
    NotFinite {
        /// Of the arrays.
        name: String,
        /// Counted from 0.
        pose: usize,
        /// Counted from 0.
        joint: usize,
        /// What stands there.
        value: f64,
        /// What should.
        what: &'static str,
    },
    /// No standard deviation.
    #[error("`{name}`, joint {joint}: {value} is no standard deviation: expected a finite number greater than 0")]
    Std {
        /// Of the arrays.
        name: String,
        /// Counted from 0.
        joint: usize,
        /// What stands there.
        value: f64,
    },
    /// The session has no such load.
    #[error("`{name}` has load {load}, and the session has {loads}: push it to `loads` first")]
    Load {
        /// Of the arrays.
        name: String,
        /// The index.
        load: usize,
        /// How many there are.
        loads: usize,
    },
}

impl JointPriors {
    /// What a robot's nominal sensors say of one joint, as a start only: gain 1 and bias or offset 0 where they say nothing.
    pub fn nominal(sensors: &NominalSensors, kind: JointKind) -> JointPriors {
        let (position_unit, torque_unit) = match kind {
            JointKind::Revolute => (PositionUnit::Radian, TorqueUnit::NewtonMeter),
            JointKind::Prismatic => (PositionUnit::Meter, TorqueUnit::Newton),
        };
        let torque =
            sensors.torque.map_or((torque_unit, [1.0, 0.0]), |torque| (torque.unit, [torque.gain, torque.bias]));
        let position = sensors
            .position
            .map_or((position_unit, [1.0, 0.0]), |position| (position.unit, [position.gain, position.offset]));
        let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
        JointPriors {
            torque_unit: Some(torque.0),
            torque_sign_declared: false,
            position_unit: position.0,
            parameters: [torque.1[0], torque.1[1], position.1[0], position.1[1]].map(start),
        }
    }
}

impl Session {
    /// A session without poses, of a robot whose joints all have a torque sensor and nominal sensors as the robot says.
    pub fn of_robot(robot: Robot, gravity: GravityPrior) -> Session {
        let joints = robot.chain.joints().iter().zip(&robot.sensors);
        let joints = joints.map(|(joint, sensors)| JointPriors::nominal(sensors, joint.kind)).collect();
        Session::new(robot, gravity, joints)
    }

    /// Adds the poses of one recording, as a table of their own; the first has line 1.
    ///
    /// # Errors
    /// Where the arrays do not go together, with the robot or with the session, or hold what is no number. Nothing is added then.
    pub fn add_poses(&mut self, arrays: &PoseArrays<'_>) -> Result<(), PoseArraysError> {
        let joints = self.joints.len();
        check(arrays, joints, self.loads.len())?;
        let table = self.tables.len();
        self.tables.push(PoseTable { path: arrays.name.into(), load: arrays.load, swept: None, step: None });
        let rows = arrays.positions.chunks_exact(joints).zip(arrays.torques.chunks_exact(joints));
        self.poses.extend(rows.enumerate().map(|(row, (position, torques))| Pose {
            table,
            line: row as u64 + 1,
            sweep_label: None,
            load: arrays.load,
            position: position.to_vec(),
            orientation: None,
            torque: torques.iter().enumerate().map(|(joint, value)| reading(arrays, joint, *value)).collect(),
            instruments: Vec::new(),
            conditions: Conditions::default(),
            course: None,
        }));
        self.repeated = self.find_repeated();
        self.doubts = self.find_doubts();
        Ok(())
    }
}

fn reading(arrays: &PoseArrays<'_>, joint: usize, value: f64) -> Option<Reading> {
    (!value.is_nan()).then(|| Reading { value, std: arrays.torque_std.map(|std| std[joint]) })
}

fn check(arrays: &PoseArrays<'_>, joints: usize, loads: usize) -> Result<(), PoseArraysError> {
    let name = || arrays.name.to_owned();
    let length = |what, found, expected| PoseArraysError::Length { name: name(), what, found, joints, expected };
    let (positions, torques) = (arrays.positions.len(), arrays.torques.len());
    if joints == 0 || positions == 0 || positions % joints != 0 {
        return Err(length("positions", positions, "one for each joint of each pose".to_owned()));
    }
    if torques != positions {
        return Err(length("torques", torques, format!("{positions}, as many as positions")));
    }
    let infinite = |numbers: &[f64], what, wrong: fn(&f64) -> bool| {
        let place = numbers.iter().position(wrong)?;
        let (pose, joint) = (place / joints, place % joints);
        Some(PoseArraysError::NotFinite { name: name(), pose, joint, value: numbers[place], what })
    };
    let wrong = infinite(arrays.positions, "position", |number| !number.is_finite())
        .or_else(|| infinite(arrays.torques, "torque", |number| number.is_infinite()));
    if let Some(error) = wrong {
        return Err(error);
    }
    if let Some(std) = arrays.torque_std {
        if std.len() != joints {
            return Err(length("standard deviations", std.len(), "one for each joint".to_owned()));
        }
        if let Some(joint) = std.iter().position(|std| !(std.is_finite() && *std > 0.0)) {
            return Err(PoseArraysError::Std { name: name(), joint, value: std[joint] });
        }
    }
    match arrays.load {
        Some(load) if load >= loads => Err(PoseArraysError::Load { name: name(), load, loads }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};

    use super::*;

    /// Three joints of which nothing is known but their axes.
    fn session() -> Session {
        let row = |i: usize| DhRow {
            name: format!("joint{i}"),
            kind: JointKind::Revolute,
            a: 0.0,
            alpha: 1.5,
            d: 0.0,
            theta: 0.0,
            limits: None,
            link: Link { name: format!("link{i}"), inertia: None },
        };
        let chain = chain_from_dh("base", DhConvention::Standard, &[row(1), row(2), row(3)]).unwrap();
        let robot = Robot { name: "arm".into(), chain, sensors: vec![Default::default(); 3] };
        Session::of_robot(robot, GravityPrior { magnitude: 9.8, magnitude_std: None, hemisphere: None })
    }

    fn arrays<'a>(positions: &'a [f64], torques: &'a [f64]) -> PoseArrays<'a> {
        PoseArrays { name: "bare", load: None, positions, torques, torque_std: None }
    }

    #[test]
    fn sensors_of_which_nothing_is_known_read_newton_metres_and_radians() {
        for joint in session().joints {
            assert_eq!((joint.torque_unit, joint.position_unit), (Some(TorqueUnit::NewtonMeter), PositionUnit::Radian));
            assert_eq!(joint.parameters.map(|known| known.nominal), [1.0, 0.0, 1.0, 0.0]);
        }
    }

    #[test]
    fn rows_become_poses_of_a_table() {
        let mut session = session();
        let arrays = arrays(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6], &[1.0, f64::NAN, 3.0, 4.0, 5.0, 6.0]);
        session.add_poses(&PoseArrays { torque_std: Some(&[0.1, 0.2, 0.3]), ..arrays }).unwrap();
        session.add_poses(&PoseArrays { name: "again", ..arrays }).unwrap();
        assert_eq!(
            session.tables.iter().map(|table| table.path.to_str()).collect::<Vec<_>>(),
            [Some("bare"), Some("again")]
        );
        let second = &session.poses[1];
        assert_eq!((second.table, second.line, &second.position[..]), (0, 2, &[0.4, 0.5, 0.6][..]));
        assert_eq!(second.torque[2], Some(Reading { value: 6.0, std: Some(0.3) }));
        assert_eq!(session.poses[0].torque[1], None);
        assert_eq!((session.poses[2].table, session.poses[2].torque[0].unwrap().std), (1, None));
    }

    #[test]
    fn what_is_no_poses_is_refused_and_adds_nothing() {
        let three = [0.1, 0.2, 0.3];
        let good = arrays(&three, &three);
        let wrong = [
            (arrays(&[], &[]), "has 0 positions"),
            (
                arrays(&three[..2], &three[..2]),
                "`bare` has 2 positions, and the robot 3 joints: expected one for each joint",
            ),
            (arrays(&three, &three[..2]), "has 2 torques, and the robot 3 joints: expected 3, as many as positions"),
            (arrays(&[0.1, f64::NAN, 0.3], &three), "pose 0, joint 1: NaN is no position"),
            (arrays(&three, &[0.1, 0.2, f64::INFINITY]), "pose 0, joint 2: inf is no torque"),
            (PoseArrays { torque_std: Some(&three[..1]), ..good }, "has 1 standard deviations"),
            (PoseArrays { torque_std: Some(&[0.1, 0.0, 0.1]), ..good }, "joint 1: 0 is no standard deviation"),
            (PoseArrays { load: Some(0), ..good }, "has load 0, and the session has 0"),
        ];
        let mut session = session();
        for (arrays, reported) in wrong {
            let error = session.add_poses(&arrays).unwrap_err().to_string();
            assert!(error.contains(reported), "{error}");
            assert!(session.poses.is_empty() && session.tables.is_empty());
        }
    }
}
