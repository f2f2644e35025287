//! Under which conditions simulated poses are read.
//!
//! Poses follow each other in even time, the sensors warm up from one temperature to another as
//! `T = T₁ + (T₀ − T₁) exp(−3 · share of the time)`, and each joint comes from where it stood the pose before, at a speed
//! between nothing and the largest.

use gravcal_recording::Conditions;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// What a simulation says of conditions; what it does not say, its sessions do not know.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulatedConditions {
    /// s from one pose to the next.
    pub pose_interval: Option<f64>,
    /// First and last temperature, °C.
    pub temperature: Option<[f64; 2]>,
    /// Largest speed of each joint, rad/s (m/s).
    pub largest_speed: Option<f64>,
    /// Whether the direction of approach is recorded.
    pub direction: bool,
}

/// The conditions of one pose after the other.
pub(super) struct Course<'a> {
    conditions: &'a SimulatedConditions,
    poses: usize,
    passed: usize,
    before: Option<Vec<f64>>,
    /// Its own, so that conditions do not shift the noise of the readings.
    random: Pcg64,
}

impl<'a> Course<'a> {
    pub fn new(conditions: &'a SimulatedConditions, poses: usize, seed: u64, trial: u64) -> Course<'a> {
        let random = Pcg64::seed_from_u64(seed ^ trial.rotate_left(32));
        Course { conditions, poses, passed: 0, before: None, random }
    }

    /// The conditions of the next pose, at these position readings.
    pub fn next(&mut self, position: &[f64]) -> Conditions {
        let share = self.passed as f64 / (self.poses as f64 - 1.0).max(1.0);
        let directions: Vec<f64> = match &self.before {
            Some(before) => position.iter().zip(before).map(|(q, before)| sign(q - before)).collect(),
            None => vec![0.0; position.len()],
        };
        let SimulatedConditions { pose_interval, temperature, largest_speed, direction } = self.conditions;
        let conditions = Conditions {
            time: pose_interval.map(|interval| interval * self.passed as f64),
            temperature: temperature.map_or_else(Vec::new, |[first, last]| {
                vec![last + (first - last) * (-3.0 * share).exp(); position.len()]
            }),
            velocity: largest_speed.map_or_else(Vec::new, |largest| {
                directions.iter().map(|direction| direction * largest * self.random.random_range(0.0..1.0)).collect()
            }),
            acceleration: Vec::new(),
            direction: if *direction { directions } else { Vec::new() },
            presliding: Vec::new(),
            further: Vec::new(),
        };
        self.passed += 1;
        self.before = Some(position.to_vec());
        conditions
    }
}

/// −1, 0 or 1.
fn sign(difference: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference.signum() }
}
