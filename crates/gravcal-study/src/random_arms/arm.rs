//! One random arm with its truth, its poses and what is known beforehand.

use std::f64::consts::PI;

use gravcal_calibration::joint::Unknowns;
use gravcal_calibration::robot::Robot;
use gravcal_calibration::session::{
    GravityKnowledge, JointKnowledge, Knowledge, KnowledgeKind, Load, LoadDistance, PoseTable, Session,
};
use gravcal_calibration::simulation::{Disturbance, Run, Simulation};
use gravcal_kinematics::{ChainError, DhConvention, DhRow, JointKind, Link, chain_from_dh};
use gravcal_recording::{PositionUnit, TorqueUnit};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::Knowing;

/// Poses bare, and with the load at each placement.
const POSES: [usize; 3] = [100; 3];
/// Joints reach this far to either side, rad.
const REACH: f64 = 120.0 / 180.0 * PI;
/// Standard deviation of a torque reading, count.
pub(crate) const NOISE: f64 = 0.8;
/// Nominal torque gain, count/(N·m), and bias, count: a 12-bit converter's (the Sarcos arm's).
const GAIN: f64 = 6.69;
const BIAS: f64 = 2048.0;
/// How far the truth may be from the nominal values: shares of both gains, count, rad.
const GAIN_SPREAD: f64 = 0.3;
const POSITION_GAIN_SPREAD: f64 = 0.03;
const BIAS_SPREAD: f64 = 100.0;
const OFFSET_SPREAD: f64 = 20.0 / 180.0 * PI;
/// Angle between gravity and the base's −z, rad.
const TILT: [f64; 2] = [5.0 / 180.0 * PI, PI];
/// The declared direction of gravity is at most this far from the true one, rad.
const DECLARED_WITHIN: f64 = 60.0 / 180.0 * PI;
pub(crate) const GRAVITY: f64 = 9.80665;

/// The arm of this number.
///
/// # Errors
/// Where its rows make no chain.
pub(super) fn arm(seed: u64, index: u64, knowing: Knowing) -> Result<Simulation, ChainError> {
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
            GravityKnowledge {
                magnitude: GRAVITY,
                magnitude_std: None,
                hemisphere: (knowing == Knowing::Nominal).then_some(declared),
            },
            vec![known(knowing); joints],
        )
    };
    let truth = Unknowns {
        gravity: down.map(|component| GRAVITY * component),
        sensors: (0..joints).map(|joint| sensors(joint == 0 || joint == last, &mut random)).collect(),
        inertia: (0..joints).map(|joint| inertia(joint, &mut random)).collect(),
        loads: vec![a, b],
        ..Unknowns::nominal(&template)
    };
    let disturbance = Disturbance::noise(vec![NOISE; joints]);
    let runs = POSES.map(|poses| Run::Random { poses }).into();
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

/// What is said of a joint's sensors.
pub(crate) fn known(knowing: Knowing) -> JointKnowledge {
    let start = |nominal| Knowledge { nominal, kind: KnowledgeKind::Start };
    let (gain, bias) = match knowing {
        Knowing::Nominal => (GAIN, BIAS),
        Knowing::Nothing => (1.0, 0.0),
    };
    JointKnowledge {
        torque_unit: Some(TorqueUnit::Count),
        torque_sign_declared: true,
        position_unit: PositionUnit::Radian,
        parameters: [start(gain), start(bias), start(1.0), start(0.0)],
    }
}

/// `[k, b, s, o]`; the offsets of the first and the last joint are choices of frames, zero.
pub(crate) fn sensors(frame_choice: bool, random: &mut Pcg64) -> [f64; 4] {
    let mut within = |spread: f64| random.random_range(-spread..spread);
    let [gain, bias, position_gain, offset] =
        [GAIN_SPREAD, BIAS_SPREAD, POSITION_GAIN_SPREAD, OFFSET_SPREAD].map(&mut within);
    [GAIN * (1.0 + gain), BIAS + bias, 1.0 + position_gain, if frame_choice { 0.0 } else { offset }]
}

/// Links grow lighter towards the tip; centres of mass within 0.2 m of the frame's origin along each axis.
pub(crate) fn inertia(joint: usize, random: &mut Pcg64) -> [f64; 4] {
    let mass = random.random_range(1.0..6.0) / (1.0 + 0.3 * joint as f64);
    let centre: [f64; 3] = std::array::from_fn(|_| random.random_range(-0.2..0.2));
    [mass, mass * centre[0], mass * centre[1], mass * centre[2]]
}

/// Two placements 0.2 m to 0.5 m apart.
pub(crate) fn placements(random: &mut Pcg64) -> [[f64; 3]; 2] {
    let centre: [f64; 3] = std::array::from_fn(|_| random.random_range(-0.2..0.2));
    let half = 0.5 * random.random_range(0.2..0.5);
    let arm = direction_within(random, [0.0, 0.0, 1.0], [0.0, PI]);
    [1.0, -1.0].map(|side| [0, 1, 2].map(|axis| centre[axis] + side * half * arm[axis]))
}

/// A direction at an angle to `pole` drawn from a range, on any side.
fn direction_within(random: &mut Pcg64, pole: [f64; 3], [least, most]: [f64; 2]) -> [f64; 3] {
    let pole = nalgebra::Vector3::from(pole);
    let aside = if pole.x.abs() < 0.8 { nalgebra::Vector3::x() } else { nalgebra::Vector3::y() };
    let u = pole.cross(&aside).normalize();
    let v = pole.cross(&u);
    let (sin, cos) = random.random_range(least..=most).sin_cos();
    let (across, along) = random.random_range(-PI..PI).sin_cos();
    (cos * pole + sin * (along * u + across * v)).into()
}
