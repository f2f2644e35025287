//! Friction that stays in part where a joint stands: before a joint slides its bristles bend, and they stay bent.
//!
//! ```text
//!     F = (F_c + p |τ|) z                    friction of a joint; τ: the torque that carries gravity
//!     dz/dx = (sgn dx − z) / x_c             Dahl (1968), z from −1 to 1, x_c the length of pre-sliding
//! ```
//!
//! At the end of each approach the joint goes a little too far and comes back, by as much as leaves `z = ρ sgn(approach)`: `ρ` is drawn
//! for each joint and standstill with a mean, the *lean*, and a spread.

use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::normal::normal;

/// The least share that is left, as none leaves less than −1.
const LEAST: f64 = -0.95;
/// Keeps this stream apart from those of noise and dirt.
const STREAM: u64 = 0x6672_6963;

/// Friction of all joints.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionAtRest {
    /// Coulomb friction of each joint, N·m or N.
    pub coulomb: Vec<f64>,
    /// How much it grows with the torque that carries gravity.
    pub per_torque: f64,
    /// Length of pre-sliding, rad or m.
    pub presliding: f64,
    /// Mean of the share that is left at rest, to the side of approach.
    pub lean: f64,
    /// Standard deviation of that share.
    pub spread: f64,
}

impl FrictionAtRest {
    /// What is left at rest of Coulomb friction, to the side of approach.
    fn left(&self, random: &mut Pcg64) -> f64 {
        (self.lean + self.spread * normal(random)).clamp(LEAST, 1.0)
    }
}

/// The bristles of all joints of one recorded session.
pub(super) struct Bristles<'a> {
    friction: &'a FrictionAtRest,
    random: Pcg64,
    /// `z`.
    bent: Vec<f64>,
    /// Where the joints are, rad or m.
    at: Vec<f64>,
}

impl<'a> Bristles<'a> {
    pub fn new(friction: &'a FrictionAtRest, seed: u64, trial: u64) -> Bristles<'a> {
        let random = Pcg64::seed_from_u64(seed ^ trial.rotate_left(32) ^ STREAM);
        Bristles { friction, random, bent: Vec::new(), at: Vec::new() }
    }

    /// The arm came here from anywhere.
    pub fn appear(&mut self, at: Vec<f64>) {
        let side = |random: &mut Pcg64| normal(random).signum() * self.friction.left(random);
        self.bent = at.iter().map(|_| side(&mut self.random)).collect();
        self.at = at;
    }

    /// How far each joint goes beyond its goal, rad or m.
    pub fn overshoots(&mut self, goal: &[f64]) -> Vec<f64> {
        let (friction, random) = (self.friction, &mut self.random);
        let beyond = |(goal, at): (&f64, &f64)| {
            let way = -friction.presliding * (0.5 * (1.0 + friction.left(random))).ln();
            if goal == at { 0.0 } else { way * (goal - at).signum() }
        };
        goal.iter().zip(&self.at).map(beyond).collect()
    }

    /// The joints move on, each one way.
    pub fn go(&mut self, to: &[f64]) {
        for ((bent, at), to) in self.bent.iter_mut().zip(&mut self.at).zip(to) {
            let way = to - *at;
            if way != 0.0 {
                *bent = way.signum() - (way.signum() - *bent) * (-way.abs() / self.friction.presliding).exp();
            }
            *at = *to;
        }
    }

    /// Adds each joint's friction to the torque that carries gravity, N·m or N.
    pub fn add_to(&self, torque: &mut [f64]) {
        for ((torque, coulomb), bent) in torque.iter_mut().zip(&self.friction.coulomb).zip(&self.bent) {
            *torque += (coulomb + self.friction.per_torque * torque.abs()) * bent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRICTION: fn(Vec<f64>) -> FrictionAtRest =
        |coulomb| FrictionAtRest { coulomb, per_torque: 0.0, presliding: 2e-4, lean: 0.42, spread: 0.25 };

    /// A joint that goes up and down in turn: what stays has the stated mean and spread, to the side from where it came.
    #[test]
    fn what_is_left_at_rest_has_the_stated_lean_and_spread() {
        let friction = FRICTION(vec![0.1]);
        let mut bristles = Bristles::new(&friction, 1, 0);
        bristles.appear(vec![0.0]);
        let mut left = Vec::new();
        for step in 0..4000 {
            let goal = if step % 2 == 0 { 0.5 } else { 0.0 };
            let side = if step % 2 == 0 { 1.0 } else { -1.0 };
            let beyond = bristles.overshoots(&[goal]);
            bristles.go(&[goal + beyond[0]]);
            bristles.go(&[goal]);
            let mut torque = [0.0];
            bristles.add_to(&mut torque);
            left.push(side * torque[0] / 0.1);
        }
        let count = left.len() as f64;
        let mean = left.iter().sum::<f64>() / count;
        let rms = (left.iter().map(|share| share * share).sum::<f64>() / count).sqrt();
        assert!((mean - 0.42).abs() < 0.015 && (rms - 0.49).abs() < 0.015, "{mean} {rms}");
    }

    #[test]
    fn a_sliding_joint_has_all_of_it_against_the_motion_and_more_of_it_under_load() {
        let friction = FrictionAtRest { per_torque: 0.02, ..FRICTION(vec![0.1, 0.2]) };
        let mut bristles = Bristles::new(&friction, 1, 0);
        bristles.appear(vec![0.0, 0.0]);
        bristles.go(&[0.1, -0.1]);
        let mut torque = [10.0, -20.0];
        bristles.add_to(&mut torque);
        assert!((torque[0] - 10.3).abs() < 1e-9 && (torque[1] + 20.6).abs() < 1e-9, "{torque:?}");
        // A joint that stays keeps what it had.
        bristles.go(&[0.1, -0.1]);
        let mut again = [10.0, -20.0];
        bristles.add_to(&mut again);
        assert_eq!(again, torque);
    }
}
