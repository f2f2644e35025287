//! Inverse dynamics, their regressor and derivatives against Pinocchio's, for eleven robots of ten URDFs: serial and branched, with
//! sliding joints, with joints that mimic others.
//!
//! `pinocchio_dynamics.toml` holds Pinocchio's numbers; `pinocchio_dynamics.py` wrote it and says how. The URDFs are read where they
//! are, in `GRAVCAL_SHARED_DATA` or `../shared/data` beside the project; without them there is nothing to compare, and the test
//! says so.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod shared;

use gravcal_dynamics::{Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use serde::Deserialize;
use shared::{chain, largest_difference, shared_data};

/// Of the largest torque of a robot, N·m, and so for derivatives a rad, rad/s, rad/s², m/s² and unit of a parameter.
const TOLERANCE: f64 = 1e-10;

#[derive(Deserialize)]
struct Facts {
    gravity: [f64; 3],
    robot: Vec<Robot>,
}

#[derive(Deserialize)]
struct Robot {
    file: String,
    base: String,
    tips: Vec<String>,
    joints: Vec<String>,
    rotor_inertia: Vec<f64>,
    state: Vec<State>,
}

#[derive(Deserialize)]
struct State {
    coordinates: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    torque: Vec<f64>,
    by_coordinate: Vec<Vec<f64>>,
    by_velocity: Vec<Vec<f64>>,
    by_acceleration: Vec<Vec<f64>>,
    by_gravity: Vec<Vec<f64>>,
    by_parameters: Option<Vec<Vec<f64>>>,
}

/// Largest deviations over everything compared.
#[derive(Debug, Default)]
struct Worst {
    largest_torque: f64,
    torque: f64,
    by_state: f64,
    by_gravity: f64,
    by_parameters: f64,
}

impl Worst {
    fn compare(&mut self, out: &InverseDynamics, state: &State) {
        let largest = state.torque.iter().fold(0.0_f64, |largest, torque| largest.max(torque.abs()));
        self.largest_torque = self.largest_torque.max(largest);
        self.torque = self.torque.max(largest_difference(&out.torque, &state.torque));
        self.by_gravity = self.by_gravity.max(largest_difference(&out.by_gravity, &state.by_gravity.concat()));
        for (own, theirs) in [
            (&out.by_coordinate, &state.by_coordinate),
            (&out.by_velocity, &state.by_velocity),
            (&out.by_acceleration, &state.by_acceleration),
        ] {
            self.by_state = self.by_state.max(largest_difference(own, &theirs.concat()));
        }
        if let Some(rows) = &state.by_parameters {
            self.by_parameters = self.by_parameters.max(largest_difference(&out.by_parameters, &rows.concat()));
        }
    }
}

fn compare_robot(chain: &Chain, gravity: [f64; 3], robot: &Robot) -> Worst {
    let links = chain.inertial_parameters().unwrap();
    let parameters = DynamicParameters { links: &links, rotor_inertia: &robot.rotor_inertia };
    let mut out = InverseDynamics::new(chain);
    let mut worst = Worst::default();
    for state in &robot.state {
        let State { coordinates, velocities, accelerations, .. } = state;
        let sample = JointMotion { coordinates, velocities, accelerations };
        chain.linearize_inverse_dynamics(Single, sample, gravity, parameters, &mut out);
        worst.compare(&out, state);
    }
    worst
}

#[test]
fn dynamics_agree_with_pinocchio() {
    let Some(folder) = shared_data() else { return };
    let facts: Facts = toml::from_str(include_str!("pinocchio_dynamics.toml")).unwrap();
    assert_eq!(facts.robot.len(), 11);
    for robot in &facts.robot {
        let chain = chain(&folder, &robot.file, &robot.base, &robot.tips, &robot.joints);
        let worst = compare_robot(&chain, facts.gravity, robot);
        println!("{}, {} joints, {} links: {worst:?}", robot.file, chain.joint_count(), chain.link_count());
        let limit = TOLERANCE * worst.largest_torque;
        let deviations = [worst.torque, worst.by_state, worst.by_gravity, worst.by_parameters];
        assert!(deviations.iter().all(|deviation| *deviation < limit), "{}: {worst:?}", robot.file);
    }
}
