//! What is drawn for the arms of a study: sensors, masses, placements.

use std::f64::consts::PI;

use gravcal_recording::{PositionUnit, TorqueUnit};
use gravcal_robot_model::session::{JointPriors, ParameterPrior, PriorKind};
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::random_arms::Knowing;

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
/// Magnitude of gravity, m/s².
pub(crate) const GRAVITY: f64 = 9.80665;

/// What is said of a joint's sensors.
pub(crate) fn known(knowing: Knowing) -> JointPriors {
    let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
    let (gain, bias) = match knowing {
        Knowing::Nominal => (GAIN, BIAS),
        Knowing::Nothing => (1.0, 0.0),
    };
    JointPriors {
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
pub(crate) fn direction_within(random: &mut Pcg64, pole: [f64; 3], [least, most]: [f64; 2]) -> [f64; 3] {
    let pole = nalgebra::Vector3::from(pole);
    let aside = if pole.x.abs() < 0.8 { nalgebra::Vector3::x() } else { nalgebra::Vector3::y() };
    let u = pole.cross(&aside).normalize();
    let v = pole.cross(&u);
    let (sin, cos) = random.random_range(least..=most).sin_cos();
    let (across, along) = random.random_range(-PI..PI).sin_cos();
    (cos * pole + sin * (along * u + across * v)).into()
}
