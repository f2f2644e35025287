//! How often the 95 % interval of the last joint's torque gain holds the truth.
//!
//! The paper reads a joint while the next one sweeps, and so says that its way cannot reach the last joint. The same
//! recordings, with all torques read and solved for jointly, give its gain too: this counts how well they do. Each draw is an
//! arm of its own: sensors, masses, placements and noise are drawn, the geometry (twists of ±90°, lengths between every
//! other pair of axes) and the poses are not. The poses are the paper's: every joint sweeps bare, the second one at two
//! positions of the first; then each but the first sweeps with the load at two placements a known distance apart, at two
//! positions of the joint before it.

use std::f64::consts::FRAC_PI_2;

use gravcal_calibration::SolveEnvironment;
use gravcal_calibration::joint::{Signals, State, estimate_briefly, select};
use gravcal_dynamics::{ChainError, DhConvention, DhRow, JointKind, Link, chain_from_dh};
use gravcal_estimation::Solver;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{GravityPrior, Load, LoadDistance, PoseTable, Session};
use gravcal_session::simulation::{Disturbance, Run, Simulation};
use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::drawn::{GRAVITY, NOISE, inertia, known, placements, sensors};
use crate::random_arms::Knowing;

/// Readings of one sweep.
const SWEEP_POSES: usize = 19;
/// Two positions of the joint before the one that sweeps, rad.
const POSITIONS: [f64; 2] = [-0.7, 0.8];
/// Distance between every other pair of axes, m.
const LENGTH: f64 = 0.4;
/// Mass of the load, kg (the paper's).
const LOAD: f64 = 1.724;
/// Gravity on the paper's tilted base, and its declared direction: not of unit length.
const TRUE_DIRECTION: [f64; 3] = [-3.43, -5.94, -7.0];
const DECLARED_DIRECTION: [f64; 3] = [0.0, -1.0, -1.0];

/// What the draws of one number of joints came to.
#[derive(Clone, Debug, PartialEq)]
pub struct LastJoint {
    /// Joints of the arm.
    pub joints: usize,
    /// Error of the last joint's torque gain in its own standard deviations, in the order of the draws; `None` where the gain
    /// was not told as determined.
    pub errors_in_std: Vec<Option<f64>>,
    /// Draws whose 95 % interval holds the truth.
    pub within: usize,
    /// Root mean square of the standard deviation, relative to the true gain.
    pub relative_std: f64,
}

impl LastJoint {
    /// Draws in which the gain was told as determined.
    pub fn determined(&self) -> usize {
        self.errors_in_std.iter().flatten().count()
    }

    /// Sum of the squared errors, each in its own standard deviation: χ² of as many degrees of freedom as are determined.
    pub fn chi_squared(&self) -> f64 {
        self.errors_in_std.iter().flatten().map(|error| error * error).sum()
    }
}

/// Calibrates `draws` arms of so many joints; each depends on seed and number only.
///
/// # Errors
/// Where the rows make no chain: fewer than two joints.
pub fn last_joint(
    joints: usize,
    draws: u64,
    seed: u64,
    solver: &dyn Solver,
    progress: &(dyn Fn() + Sync),
) -> Result<LastJoint, ChainError> {
    let arms: Result<Vec<Simulation>, ChainError> = (0..draws).map(|draw| arm(joints, seed, draw)).collect();
    let found: Vec<Option<Found>> = arms?
        .par_iter()
        .map(|arm| {
            let found = calibrate(arm, solver);
            progress();
            found
        })
        .collect();
    let determined = found.iter().flatten();
    let squares: f64 = determined.clone().map(|found| found.relative_std.powi(2)).sum();
    Ok(LastJoint {
        joints,
        within: determined.clone().filter(|found| found.within).count(),
        relative_std: (squares / determined.count() as f64).sqrt(),
        errors_in_std: found.iter().map(|found| found.as_ref().map(|found| found.error_in_std)).collect(),
    })
}

/// The last joint's torque gain as one draw tells it.
struct Found {
    within: bool,
    error_in_std: f64,
    relative_std: f64,
}

fn calibrate(arm: &Simulation, solver: &dyn Solver) -> Option<Found> {
    let session = arm.session(0);
    let quiet = |_: &str| {};
    let (readings, environment) = (select(&session, Signals::All), SolveEnvironment::new(solver, &quiet));
    let result = estimate_briefly(&session, &readings, None, &environment).ok()?;
    let last = session.robot.chain.joints().last()?;
    let name = SensorParameter::TorqueGain.name(&last.name);
    let reported = result.parameter(&name)?;
    let truth = arm.truth.sensors.last()?[SensorParameter::TorqueGain as usize];
    let ([low, high], value, std) = (reported.ci95?, reported.value?, reported.std?);
    Some(Found {
        within: (low..=high).contains(&truth),
        error_in_std: (value - truth) / std,
        relative_std: std / truth,
    })
}

fn arm(joints: usize, seed: u64, draw: u64) -> Result<Simulation, ChainError> {
    let mut random = Pcg64::new(u128::from(seed), u128::from(draw));
    let rows: Vec<DhRow> = (0..joints).map(row).collect();
    let chain = chain_from_dh("base", DhConvention::Standard, &rows)?;
    let last = joints - 1;
    let [a, b] = placements(&mut random);
    let distance = (Vector3::from(a) - Vector3::from(b)).norm();
    let load = |name: &str| Load { name: name.into(), mass: LOAD, link: last, position: None, position_std: None };
    let table = |load| PoseTable { path: "sweep.csv".into(), load, swept: None, step: None };
    let (loads, runs): (Vec<Option<usize>>, Vec<Run>) = sweeps(joints).into_iter().unzip();
    let gravity = |direction: [f64; 3]| Vector3::from(direction).normalize();
    let template = Session {
        loads: vec![load("placement a"), load("placement b")],
        load_distances: vec![LoadDistance { between: [0, 1], distance, std: None }],
        tables: loads.into_iter().map(table).collect(),
        ..Session::new(
            Robot { name: format!("arm of {joints} joints"), sensors: vec![Default::default(); joints], chain },
            GravityPrior {
                magnitude: GRAVITY,
                magnitude_std: None,
                hemisphere: Some(gravity(DECLARED_DIRECTION).into()),
            },
            vec![known(Knowing::Nominal); joints],
        )
    };
    let truth = State {
        gravity: (GRAVITY * gravity(TRUE_DIRECTION)).into(),
        sensors: (0..joints).map(|joint| sensors(joint == 0 || joint == last, &mut random)).collect(),
        inertia: (0..joints).map(|joint| inertia(joint, &mut random)).collect(),
        loads: vec![a, b],
        further: Vec::new(),
        tensors: Vec::new(),
        with_payloads: Vec::new(),
        sweep_moments: Vec::new(),
        deflections: Vec::new(),
        static_friction: Vec::new(),
        at_rest: Vec::new(),
        growing_friction: Vec::new(),
        bending: Vec::new(),
        lengths: Vec::new(),
        axes: Vec::new(),
    };
    Ok(Simulation::new(template, truth, runs, Disturbance::noise(vec![NOISE; joints]), random.random()))
}

fn row(joint: usize) -> DhRow {
    DhRow {
        name: format!("joint{}", joint + 1),
        kind: JointKind::Revolute,
        a: 0.0,
        alpha: if joint.is_multiple_of(2) { FRAC_PI_2 } else { -FRAC_PI_2 },
        d: if joint.is_multiple_of(2) { LENGTH } else { 0.0 },
        theta: 0.0,
        limits: None,
        link: Link { name: format!("link{}", joint + 1), inertia: None },
    }
}

/// The paper's sweeps for any number of joints, each with its load.
fn sweeps(joints: usize) -> Vec<(Option<usize>, Run)> {
    let rest: Vec<f64> = (0..joints).map(|joint| if joint.is_multiple_of(2) { -FRAC_PI_2 } else { 0.5 }).collect();
    let sweep =
        |swept: usize, held: Vec<f64>| Run::Sweep { swept, range: [-FRAC_PI_2, FRAC_PI_2], poses: SWEEP_POSES, held };
    let at = |joint: usize, position: f64| {
        let mut held = rest.clone();
        held[joint] = position;
        held
    };
    let mut sweeps: Vec<(Option<usize>, Run)> = (0..joints).map(|swept| (None, sweep(swept, rest.clone()))).collect();
    sweeps.extend(POSITIONS.map(|position| (None, sweep(1, at(0, position)))));
    for swept in 1..joints {
        for position in POSITIONS {
            sweeps.extend([0, 1].map(|load| (Some(load), sweep(swept, at(swept - 1, position)))));
        }
    }
    sweeps
}

#[cfg(test)]
mod tests {
    use gravcal_solvers::LevenbergMarquardt;

    use super::*;

    const DRAWS: u64 = 60;
    /// Of 60 intervals of 95 % fewer than 51 hold the truth once in 1,400 times.
    const FEWEST_WITHIN: usize = 51;
    /// χ² of 60 degrees of freedom is outside once in 1,000 times.
    const CHI_SQUARED: [f64; 2] = [30.3, 102.7];

    #[test]
    fn the_gain_of_the_last_joint_is_found_and_its_interval_holds() {
        for joints in [3, 6, 7] {
            let found = last_joint(joints, DRAWS, 2, &LevenbergMarquardt::default(), &|| {}).unwrap();
            assert_eq!(found.determined(), DRAWS as usize, "{joints} joints");
            assert!(found.within >= FEWEST_WITHIN, "{joints} joints: {} within", found.within);
            let chi_squared = found.chi_squared();
            assert!((CHI_SQUARED[0]..CHI_SQUARED[1]).contains(&chi_squared), "{joints} joints: χ² {chi_squared}");
            assert!(found.relative_std < 0.01, "{joints} joints: {}", found.relative_std);
        }
    }
}
