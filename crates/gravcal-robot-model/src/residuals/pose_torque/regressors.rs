//! A window of an arm whose positions are known exactly: torques are linear in gravity and in the links' parameters.
//!
//! ```text
//!     τ̄ = (Y_0 + Σ_a g_a Y_a) π,      Y_0 = Σ_t h(t) Y(θ, θ̇, θ̈; 0),   Y_a = Σ_t h(t) [Y(θ, θ̇, θ̈; e_a) − Y(θ, θ̇, θ̈; 0)]
//! ```
//!
//! `Y_a` has columns of masses and first moments only. All four are computed once.

use gravcal_dynamics::{Chain, InverseDynamics, JointMotion, Single};
use gravcal_recording::Course;

use super::model::{GRAVITY, INERTIA};
use super::motion::{BODY, Means, add};

/// Mean regressors of a window.
#[derive(Clone, Debug)]
pub(super) struct Regressors {
    /// n × 10 l.
    without_gravity: Vec<f64>,
    /// For each axis n × 4 l.
    by_gravity: [Vec<f64>; GRAVITY],
}

impl Regressors {
    /// `positions`: gain and offset of each joint's position sensor.
    pub fn new(chain: &Chain, course: &Course, positions: &[[f64; 2]]) -> Regressors {
        let (n, links) = (chain.joint_count(), chain.link_count());
        let mut dynamics = InverseDynamics::new(chain);
        let mut without_gravity = vec![0.0; n * BODY * links];
        let mut by_gravity = [(); GRAVITY].map(|()| vec![0.0; n * INERTIA * links]);
        for sample in &course.samples {
            let scaled = |readings: &[f64]| -> Vec<f64> {
                readings.iter().zip(positions).map(|(reading, [gain, _])| gain * reading).collect()
            };
            let offsets = positions.iter().map(|[_, offset]| offset);
            let coordinates: Vec<f64> = scaled(&sample.position).iter().zip(offsets).map(|(q, o)| q + o).collect();
            let (velocities, accelerations) = (scaled(&sample.velocity), scaled(&sample.acceleration));
            let motion =
                JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
            chain.inverse_dynamics_regressor(Single, motion, [0.0; 3], &mut dynamics);
            let alone = dynamics.by_parameters.clone();
            add(&mut without_gravity, sample.weight, &alone);
            for (axis, by_axis) in by_gravity.iter_mut().enumerate() {
                let mut unit = [0.0; GRAVITY];
                unit[axis] = 1.0;
                chain.inverse_dynamics_regressor(Single, motion, unit, &mut dynamics);
                let bodies = dynamics.by_parameters.as_chunks::<BODY>().0.iter().zip(alone.as_chunks::<BODY>().0);
                for (sum, (with, without)) in by_axis.as_chunks_mut::<INERTIA>().0.iter_mut().zip(bodies) {
                    for (entry, sum) in sum.iter_mut().enumerate() {
                        *sum += sample.weight * (with[entry] - without[entry]);
                    }
                }
            }
        }
        Regressors { without_gravity, by_gravity }
    }

    /// Torques, and their derivatives by gravity and by the parameters; those by positions stay as they are.
    pub fn evaluate(&self, gravity: [f64; 3], parameters: &[f64], mean: &mut Means) {
        mean.by_parameters.copy_from_slice(&self.without_gravity);
        let (links, joints) = (parameters.len() / BODY, mean.torque.len());
        let (bodies, _) = parameters.as_chunks::<BODY>();
        for (axis, by_axis) in self.by_gravity.iter().enumerate() {
            let (by_axis, _) = by_axis.as_chunks::<INERTIA>();
            let (by_parameters, _) = mean.by_parameters.as_chunks_mut::<BODY>();
            for (entry, by_axis) in by_parameters.iter_mut().zip(by_axis) {
                add(&mut entry[..INERTIA], gravity[axis], by_axis);
            }
            for joint in 0..joints {
                let own = by_axis[links * joint..links * (joint + 1)].iter().zip(bodies);
                let dot = |(by_axis, body): (&[f64; INERTIA], &[f64; BODY])| -> f64 {
                    by_axis.iter().zip(body).map(|(a, b)| a * b).sum()
                };
                mean.by_gravity[GRAVITY * joint + axis] = own.map(dot).sum();
            }
        }
        for (torque, row) in mean.torque.iter_mut().zip(mean.by_parameters.chunks_exact(parameters.len())) {
            *torque = row.iter().zip(parameters).map(|(y, parameter)| y * parameter).sum();
        }
    }
}
