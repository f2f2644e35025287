//! How the arm of a simulated experiment is moved and recorded.

use super::earlier_load::{Creep, Hysteresis};
use super::friction::FrictionAtRest;

/// How the arm is moved and recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Samples a second.
    pub rate: f64,
    /// Samples of each standstill, after settling; of an arm that never stands, of each stretch.
    pub samples: usize,
    /// Time of a move, s.
    pub moving: f64,
    /// Time between the end of a move and the standstill, s.
    pub settling: f64,
    /// First size of what settles, in standard deviations of a sample.
    pub vibration: f64,
    /// Time constant of what settles, s.
    pub settling_time: f64,
    /// Correlation time of the noise, s; 0 for white noise.
    pub correlation: f64,
    /// From which sides joints come to poses.
    pub approach: Approach,
    /// Friction that stays in part at rest, if there is any.
    pub friction: Option<FrictionAtRest>,
    /// Hysteresis of torque sensors, if they have any.
    pub hysteresis: Option<Hysteresis>,
    /// Their creep, if they have any.
    pub creep: Option<Creep>,
    /// Random walk of the zero of each torque reading: its standard deviation after a second, unit of the reading.
    pub walk: Vec<f64>,
    /// Where the arm never stands: in place of each pose there is a stretch of this motion, and what is between two is not recorded.
    pub harmonic: Option<HarmonicMotion>,
    /// Speed of sweeps that are recorded slowly, to and fro, in place of standstills, rad/s.
    pub sweeping: Option<f64>,
    /// What makes it dirty.
    pub dirt: Dirt,
}

/// How joints move that never stand: each on a sum of sines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicMotion {
    /// Sines in a sum.
    pub harmonics: usize,
    /// Period of the slowest, s.
    pub period: f64,
    /// Which random trajectories.
    pub seed: u64,
}

/// From which sides joints come to poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Approach {
    /// From where they were.
    #[default]
    Any,
    /// Every position reading rises.
    OneWay,
    /// Each pose twice: every position reading rises, then falls.
    BothWays,
}

impl Approach {
    /// The sides from which each pose is come to; 0 for any.
    pub fn sides(self) -> &'static [f64] {
        match self {
            Approach::Any => &[0.0],
            Approach::OneWay => &[1.0],
            Approach::BothWays => &[1.0, -1.0],
        }
    }
}

/// What makes a recording dirty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dirt {
    /// Share of the readings that are anything.
    pub outliers: f64,
    /// Share of the messages that are lost.
    pub dropped: f64,
    /// How many standstills are touched.
    pub touched: usize,
}
