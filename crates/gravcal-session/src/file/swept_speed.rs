//! What the speed of a slow sweep makes joints read that stand.
//!
//! ```text
//!     τ_c = h(θ, θ̇_j e_j)        torque of the joints at the speed of the joint j that sweeps, gravity and acceleration left away
//! ```
//!
//! It goes with the square of the speed, so that it is the same both ways and does not cancel in their mean. On the joint that sweeps it is
//! zero. By the masses and inertia tensors of the robot's file (of a link without a tensor its mass in its centre of mass) it is
//! subtracted from each reading. Such files are off by a third at worst ([`UNCERTAIN`]), and a load whose place nobody states may be
//! anywhere nearby ([`NEARBY`]). What is wrong then is wrong alike in a whole sweep: where it may exceed a quarter of what noise leaves in the mean
//! of all readings of the sweep ([`TOLERATED`]), the reading is left out, as the arm passed too fast for it. Where the file states no masses
//! nothing can be said.

use gravcal_dynamics::{BodyInertia, Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_recording::{StaticPose, Sweeps};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{JointPriors, Load};

/// Share of what masses in robots' files make that may be wrong: chosen, not measured. Tensors in files are often those of a
/// drawing, and what hangs on an arm is in none.
const UNCERTAIN: f64 = 1.0 / 3.0;

/// How far a load's centre of mass may lie from the origin of its link's frame along each of its axes where nobody states its place, m: chosen,
/// as a tool's is.
const NEARBY: f64 = 0.1;

/// Share of the noise of a sweep's mean up to which a wrong correction is tolerated: what is wrong in the masses is wrong alike in all sweeps of a
/// session, sixteen of which make as much of it as of their noise.
const TOLERATED: f64 = 0.25;

/// The arm as its file states it, with a load or without.
pub(super) struct MovingArm<'a> {
    chain: &'a Chain,
    joints: &'a [JointPriors],
    parameters: Vec<f64>,
    /// The same with a load whose place is not known in other places nearby.
    elsewhere: Vec<Vec<f64>>,
    dynamics: InverseDynamics,
}

impl<'a> MovingArm<'a> {
    /// Nothing where the robot's file states no mass. A load whose place is not known is taken at the origin of its link's frame.
    pub fn new(chain: &'a Chain, joints: &'a [JointPriors], load: Option<&Load>) -> Option<MovingArm<'a>> {
        if chain.links().iter().all(|link| link.inertia.is_none_or(|inertia| inertia.mass == 0.0)) {
            return None;
        }
        let stated = chain.inertial_parameters().ok()?;
        let body =
            |[mass, x, y, z, tensor @ ..]: &[f64; 10]| match tensor.iter().all(|entry| *entry == 0.0) && *mass > 0.0 {
                true => BodyInertia::about_center(*mass, [x / mass, y / mass, z / mass], [0.0; 6]),
                false => BodyInertia { mass: *mass, first_moment: [*x, *y, *z], tensor: *tensor },
            };
        let bodies: Vec<BodyInertia> = stated.as_chunks().0.iter().map(body).collect();
        let load = load.filter(|load| !load.is_unknown());
        let with_load = |shift: [f64; 3]| -> Vec<f64> {
            let mut bodies = bodies.clone();
            if let Some(load) = load {
                let position = load.position.unwrap_or(shift);
                bodies[load.link] = bodies[load.link] + BodyInertia::about_center(load.mass, position, [0.0; 6]);
            }
            bodies.iter().flat_map(BodyInertia::parameters).collect()
        };
        let elsewhere = match load.is_some_and(|load| load.position.is_none()) {
            true => {
                [0, 1, 2].map(|axis| with_load(std::array::from_fn(|k| if k == axis { NEARBY } else { 0.0 }))).into()
            }
            false => Vec::new(),
        };
        let parameters = with_load([0.0; 3]);
        Some(MovingArm { chain, joints, parameters, elsewhere, dynamics: InverseDynamics::new(chain) })
    }

    /// Takes from the readings of joints that stand what the speed makes of them, and leaves out those of which it is known too badly. Says so.
    pub fn subtract(&mut self, sweeps: &mut Sweeps) -> Option<String> {
        let (mut off_by, mut left_out) = (0.0_f64, 0);
        for sweep in &mut sweeps.found {
            let alike = (sweep.bins.len() as f64).sqrt();
            for side in sweep.bins.iter_mut().flat_map(|bin| &mut bin.sides) {
                let torque = self.of_speed(side, sweep.joint);
                for (joint, (torque, uncertain)) in
                    torque.into_iter().enumerate().filter(|(joint, _)| *joint != sweep.joint)
                {
                    let Some(reading) = &mut side.torque[joint] else { continue };
                    let gain = self.nominal(joint, SensorParameter::TorqueGain);
                    reading.value -= gain * torque;
                    if reading.std.is_some_and(|std| (gain * uncertain).abs() * alike > TOLERATED * std) {
                        side.torque[joint] = None;
                        (off_by, left_out) = (off_by.max(uncertain), left_out + 1);
                    }
                }
            }
        }
        let cure = if self.elsewhere.is_empty() { "" } else { ", or state position_m of the load" };
        (left_out > 0).then(|| {
            format!(
                "{left_out} readings of joints that stand while another sweeps are left out: the sweep's speed adds a torque to them that the masses \
                 in the robot's file predict only within {} N·m. That is too much beside the noise of their mean. Sweep more slowly{cure}.",
                significant(off_by, 2)
            )
        })
    }

    fn nominal(&self, joint: usize, parameter: SensorParameter) -> f64 {
        self.joints[joint].of(parameter).nominal
    }

    /// Torques that the speed of one joint makes, and by how much each may be off, N·m.
    fn of_speed(&mut self, side: &StaticPose, swept: usize) -> Vec<(f64, f64)> {
        let count = self.joints.len();
        let coordinate = |joint: usize| {
            self.nominal(joint, SensorParameter::PositionGain) * side.position[joint]
                + self.nominal(joint, SensorParameter::PositionOffset)
        };
        let coordinates: Vec<f64> = (0..count).map(coordinate).collect();
        let (mut velocities, accelerations) = (vec![0.0; count], vec![0.0; count]);
        velocities[swept] = side.conditions.velocity.get(swept).copied().unwrap_or(0.0);
        let motion = JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
        let mut torques = |links: &[f64]| {
            let parameters = DynamicParameters { links, rotor_inertia: &accelerations };
            self.chain.inverse_dynamics(Single, motion, [0.0; 3], parameters, &mut self.dynamics);
            self.dynamics.torque.clone()
        };
        let stated = torques(&self.parameters);
        let elsewhere: Vec<Vec<f64>> = self.elsewhere.iter().map(|links| torques(links)).collect();
        let uncertain = |joint: usize| {
            let moved = elsewhere.iter().map(|torque| (torque[joint] - stated[joint]).powi(2)).sum::<f64>();
            ((UNCERTAIN * stated[joint]).powi(2) + moved).sqrt()
        };
        (0..count).map(|joint| (stated[joint], uncertain(joint))).collect()
    }
}
