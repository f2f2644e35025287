//! What is drawn for a session: the arm, its sensors, gravity, loads and poses.

use std::f64::consts::TAU;

use clap::ValueEnum;
use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::arm::{self, Arm};
use super::poor;
use super::truth::{GRAVITY, Said, Sensors, Table, Truth, Wrist};

/// Where a session's counts stand that says nothing else, and how many a newton metre makes.
pub const NOMINAL_BIAS: f64 = 2048.0;
/// Counts a newton metre.
pub const NOMINAL_GAIN: f64 = 6.5;
/// Distance between the two placements of a load, m.
const DISTANCE: f64 = 0.4;
/// Noise of counts.
const COUNT_NOISE: f64 = 0.8;

/// Noise of a wrist sensor's forces, N, and moments, N·m.
pub const WRIST_NOISE: [f64; 6] = [0.05, 0.05, 0.05, 0.005, 0.005, 0.005];

/// What kind of sessions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Few joints move, or little, or there are few poses.
    Poor,
    /// No load; noise of 1e-4 to 1 N·m; noise and the direction of gravity stated or not.
    Bare,
    /// Bare, and with a load of known mass at two placements a known distance apart.
    Ordinary,
    /// Poor, with a six-axis sensor at the wrist, whose noise is stated.
    Wrist,
    /// 124 bare poses within a narrow range, with errors ten times the readings' noise, which is not stated.
    Noise,
}

impl Kind {
    fn is_poor(self) -> bool {
        matches!(self, Kind::Poor | Kind::Wrist)
    }

    /// In names.
    pub fn as_str(self) -> &'static str {
        match self {
            Kind::Poor => "poor",
            Kind::Bare => "bare",
            Kind::Ordinary => "ordinary",
            Kind::Noise => "noise",
            Kind::Wrist => "wrist",
        }
    }
}

/// The session of this number: it depends on kind, robots, seed and number only. Robots take turns, and a random arm with them.
///
/// # Errors
/// Where a random arm's URDF makes no arm.
pub fn draw(kind: Kind, robots: &[Arm], seed: u64, number: u64) -> Result<Truth, String> {
    let mut random = Pcg64::new(u128::from(seed), u128::from(number));
    let turn = number % (robots.len() as u64 + 1);
    let arm = match robots.get(turn as usize) {
        Some(robot) => robot.clone(),
        None => arm::random(&mut random)?,
    };
    let said = said(kind, &mut random);
    let gravity = gravity(kind, &mut random);
    let (sensors, mut noise) = (
        sensors(arm.joint_count(), said.counts, &mut random),
        noise(kind, arm.joint_count(), said.counts, &mut random),
    );
    let placements = placements(kind, &mut random);
    let tables = tables(kind, &arm, placements.len(), &mut random);
    let mass = random.random_range(1.0..4.0);
    let wrist = (kind == Kind::Wrist).then(|| wrist(&mut random));
    if wrist.is_some() {
        noise.extend(WRIST_NOISE);
    }
    let mut truth = Truth { arm, gravity, sensors, wrist, noise, mass, placements, tables, errors: Vec::new(), said };
    truth.errors = (0..truth.readings()).map(|_| normal(&mut random)).collect();
    Ok(truth)
}

fn said(kind: Kind, random: &mut Pcg64) -> Said {
    let [std, hemisphere] = match kind {
        Kind::Poor | Kind::Wrist | Kind::Ordinary => [0.8, 1.0],
        Kind::Bare => [0.5, 0.5],
        Kind::Noise => [0.0, 0.5],
    };
    let mut chance = |probability: f64| random.random_range(0.0..1.0) < probability;
    Said { counts: chance(0.5), degrees: chance(0.5), std: chance(std), hemisphere: chance(hemisphere) }
}

/// Half of the bases are upright; poor ones are tilted by up to three degrees, too.
fn gravity(kind: Kind, random: &mut Pcg64) -> Vector3<f64> {
    let tilt = match random.random_range(0..4) {
        0 | 1 => 0.0,
        2 if kind.is_poor() => random.random_range(0.0..3.0_f64).to_radians(),
        _ => 0.3 * normal(random),
    };
    let heading = random.random_range(0.0..TAU);
    GRAVITY * Vector3::new(tilt.sin() * heading.cos(), tilt.sin() * heading.sin(), -tilt.cos())
}

fn sensors(joints: usize, counts: bool, random: &mut Pcg64) -> Sensors {
    let mut each =
        |draw: &mut dyn FnMut(usize, &mut Pcg64) -> f64| (0..joints).map(|joint| draw(joint, random)).collect();
    Sensors {
        torque_gain: each(&mut |_, random| {
            if counts { random.random_range(5.0..8.0) } else { 1.0 + 0.06 * normal(random) }
        }),
        torque_bias: each(&mut |_, random| {
            if counts { NOMINAL_BIAS + 40.0 * normal(random) } else { 0.6 * normal(random) }
        }),
        position_gain: each(&mut |_, random| 1.0 + 0.01 * normal(random)),
        position_offset: each(&mut |joint, random| if joint == 0 { 0.0 } else { 0.05 * normal(random) }),
    }
}

/// Standard deviation of each joint's torque readings, in their unit.
fn noise(kind: Kind, joints: usize, counts: bool, random: &mut Pcg64) -> Vec<f64> {
    let unit = if counts { NOMINAL_GAIN } else { 1.0 };
    match kind {
        Kind::Poor | Kind::Wrist | Kind::Ordinary if counts => vec![COUNT_NOISE; joints],
        Kind::Poor | Kind::Wrist | Kind::Ordinary => vec![10f64.powf(random.random_range(-3.0..-1.0)); joints],
        Kind::Bare => vec![unit * 10f64.powf(random.random_range(-4.0..0.0)); joints],
        Kind::Noise => {
            let of_readings = 10f64.powf(random.random_range(-2.5..-1.0));
            (0..joints).map(|_| unit * 10.0 * of_readings * random.random_range(0.5..2.0)).collect()
        }
    }
}

fn wrist(random: &mut Pcg64) -> Wrist {
    let mut six = |spread: f64| -> [f64; 6] { std::array::from_fn(|_| spread * normal(random)) };
    let (gain, bias) = (six(0.05).map(|error| 1.0 + error), six(1.0));
    let mass = random.random_range(0.2..2.0);
    let mut moment = || mass * random.random_range(-0.1..0.1);
    let tool = [mass, moment(), moment(), moment()];
    Wrist { gain, bias, tool, mass_said: random.random_range(0..2) == 0 }
}

/// None, one, or two at their known distance.
fn placements(kind: Kind, random: &mut Pcg64) -> Vec<Vector3<f64>> {
    let count = match kind {
        Kind::Bare | Kind::Noise => 0,
        Kind::Ordinary => 2,
        Kind::Poor | Kind::Wrist => [0, 1, 2, 2][random.random_range(0..4)],
    };
    let mut three = || Vector3::from_fn(|_, _| normal(random));
    let (first, away) = (0.1 * three(), three().normalize() * DISTANCE);
    [first, first - away].into_iter().take(count).collect()
}

fn tables(kind: Kind, arm: &Arm, placements: usize, random: &mut Pcg64) -> Vec<Table> {
    let poses = if kind == Kind::Noise { 124 } else { random.random_range(30..=100) };
    let ranges = match kind {
        Kind::Poor | Kind::Wrist => return poor::tables(arm, placements, random),
        Kind::Noise => narrow(arm, random),
        Kind::Bare | Kind::Ordinary => arm.joints.iter().map(|joint| joint.limits).collect(),
    };
    with_each_load(placements, &mut |_| within(&ranges, poses, random))
}

/// A table without load, and one for each placement.
pub fn with_each_load(placements: usize, angles: &mut dyn FnMut(Option<usize>) -> Vec<Vec<f64>>) -> Vec<Table> {
    let loads = std::iter::once(None).chain((0..placements).map(Some));
    loads.map(|placement| Table { placement, angles: angles(placement) }).collect()
}

/// Poses drawn within these ranges; one without width is a joint that stands.
pub fn within(ranges: &[[f64; 2]], poses: usize, random: &mut Pcg64) -> Vec<Vec<f64>> {
    let mut angle = |[low, high]: &[f64; 2]| if low < high { random.random_range(*low..*high) } else { *low };
    (0..poses).map(|_| ranges.iter().map(&mut angle).collect()).collect()
}

/// About the middle of each joint's range.
fn narrow(arm: &Arm, random: &mut Pcg64) -> Vec<[f64; 2]> {
    let width = random.random_range(5.0..30.0_f64).to_radians();
    let mut range = |[low, high]: [f64; 2]| {
        let middle = 0.5 * (low + high) + random.random_range(-0.5..0.5);
        [middle - 0.5 * width, middle + 0.5 * width]
    };
    arm.joints.iter().map(|joint| range(joint.limits)).collect()
}

/// A standard normal number.
pub fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}
