//! One random arm with its truth, its poses and what is known beforehand.

use std::f64::consts::PI;

use gravcal_calibration::joint::State;
use gravcal_dynamics::{ChainError, DhConvention, DhRow, JointKind, Link, chain_from_dh};
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{GravityPrior, Load, LoadDistance, PoseTable, Session};
use gravcal_session::simulation::{Disturbance, Run, Simulation};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::Knowing;
use crate::drawn::{GRAVITY, NOISE, direction_within, inertia, known, placements, sensors};

/// Poses bare, and with the load at each placement.
const POSES: [usize; 3] = [100; 3];
/// Joints reach this far to either side, rad.
const REACH: f64 = 120.0 / 180.0 * PI;
/// Angle between gravity and the base's −z, rad.
const TILT: [f64; 2] = [5.0 / 180.0 * PI, PI];
/// The declared direction of gravity is at most this far from the true one, rad.
const DECLARED_WITHIN: f64 = 60.0 / 180.0 * PI;

/// The arm of this number.
///
/// # Errors
/// Where its rows make no chain.
pub(crate) fn arm(seed: u64, index: u64, knowing: Knowing) -> Result<Simulation, ChainError> {
    let mut random = Pcg64::new(u128::from(seed), u128::from(index));
    let joints = random.random_range(2..=10);
    let rows: Vec<DhRow> = (0..joints).map(|joint| row(joint, &mut random)).collect();
    let chain = chain_from_dh("base", DhConvention::Standard, &rows)?;
    let down = direction_within(&mut random, [0.0, 0.0, -1.0], TILT);
    let declared = direction_within(&mut random, down, [0.0, DECLARED_WITHIN]);
    let last = joints - 1;
    let [a, b] = placements(&mut random);
    let distance = (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt();
    let mass = random.random_range(0.5..3.0);
    let load = |name: &str| Load { name: name.into(), mass, link: last, position: None, position_std: None };
    let table = |load| PoseTable { path: "poses.csv".into(), load, swept: None, step: None };
    let template = Session {
        loads: vec![load("placement a"), load("placement b")],
        load_distances: vec![LoadDistance { between: [0, 1], distance, std: None }],
        tables: [None, Some(0), Some(1)].map(table).into(),
        ..Session::new(
            Robot { name: "random arm".into(), sensors: vec![Default::default(); joints], chain },
            GravityPrior {
                magnitude: GRAVITY,
                magnitude_std: None,
                hemisphere: (knowing == Knowing::Nominal).then_some(declared),
            },
            vec![known(knowing); joints],
        )
    };
    let truth = State {
        gravity: down.map(|component| GRAVITY * component),
        sensors: (0..joints).map(|joint| sensors(joint == 0 || joint == last, &mut random)).collect(),
        inertia: (0..joints).map(|joint| inertia(joint, &mut random)).collect(),
        loads: vec![a, b],
        ..State::nominal(&template)
    };
    let disturbance = Disturbance::noise(vec![NOISE; joints]);
    let runs = POSES.map(|poses| Run::Random { poses, moving: None }).into();
    Ok(Simulation::new(template, truth, runs, disturbance, random.random()))
}

/// Any twist, lengths up to half a metre.
fn row(joint: usize, random: &mut Pcg64) -> DhRow {
    DhRow {
        name: format!("joint{}", joint + 1),
        kind: JointKind::Revolute,
        a: random.random_range(-0.5..0.5),
        alpha: random.random_range(-PI..PI),
        d: random.random_range(-0.5..0.5),
        theta: random.random_range(-PI..PI),
        limits: Some([-REACH, REACH]),
        link: Link { name: format!("link{}", joint + 1), inertia: None },
    }
}
