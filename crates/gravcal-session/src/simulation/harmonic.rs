//! Arms in steady motion: every joint on a sum of sines, and the torques that move it so.
//!
//! ```text
//!     θ_j(t) = c_j + Σ_l a_jl sin(2π l t / T + φ_jl),     Σ_l |a_jl| = 0.9 of half of the joint's range about its middle c_j
//! ```
//!
//! Sizes and phases are drawn anew for each stretch.

use std::f64::consts::{PI, TAU};

use gravcal_dynamics::{BodyInertia, DynamicParameters, InverseDynamics, JointMotion, Single};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::experiment::Simulation;
use super::motion::HarmonicMotion;

/// Share of a joint's range that it uses.
const REACH: f64 = 0.9;

/// Beside a moment at which torques are differentiated by time, s.
const STEP: f64 = 1e-3;

/// One stretch of it.
pub(super) struct Trajectory {
    period: f64,
    /// Middle of each joint, then size and phase of its sines.
    joints: Vec<(f64, Vec<[f64; 2]>)>,
}

impl HarmonicMotion {
    /// The next stretch.
    pub(super) fn trajectory(&self, simulation: &Simulation, random: &mut Pcg64) -> Trajectory {
        let joints = simulation.template.robot.chain.joints().iter().map(|joint| {
            let [low, high] = joint.limits.unwrap_or([-PI, PI]);
            let sines: Vec<[f64; 2]> =
                (0..self.harmonics).map(|_| [random.random_range(0.3..1.0), random.random_range(0.0..TAU)]).collect();
            let sum: f64 = sines.iter().map(|[size, _]| size).sum();
            let scale = REACH * 0.5 * (high - low) / sum;
            (0.5 * (low + high), sines.into_iter().map(|[size, phase]| [scale * size, phase]).collect())
        });
        Trajectory { period: self.period, joints: joints.collect() }
    }
}

impl Trajectory {
    /// Coordinates, velocities and accelerations of all joints at a time, s.
    pub fn at(&self, time: f64) -> [Vec<f64>; 3] {
        let mut states = [(); 3].map(|()| Vec::with_capacity(self.joints.len()));
        for (middle, sines) in &self.joints {
            let mut state = [*middle, 0.0, 0.0];
            for (harmonic, [size, phase]) in sines.iter().enumerate() {
                let rate = TAU * (harmonic + 1) as f64 / self.period;
                let (sin, cos) = (rate * time + phase).sin_cos();
                state[0] += size * sin;
                state[1] += size * rate * cos;
                state[2] -= size * rate * rate * sin;
            }
            states.iter_mut().zip(state).for_each(|(states, state)| states.push(state));
        }
        states
    }
}

/// The true arm in motion, with one load or none. Links whose tensors the robot's file does not state are masses in their centres.
pub(super) struct Dynamics<'s> {
    simulation: &'s Simulation,
    parameters: Vec<f64>,
    rotors: Vec<f64>,
    dynamics: InverseDynamics,
}

/// How far joints bend under what they carry at a moment, between their motors, where their position sensors sit, and the links.
pub(super) struct Bent {
    /// By joint, rad.
    pub by: Vec<f64>,
    /// Its derivative by time, rad/s.
    pub rate: Vec<f64>,
    /// What a rotor needs less than if it went as its joint does, N·m.
    pub of_rotors: Vec<f64>,
}

/// The true rotor inertia of each joint; zero where it has none.
fn rotors(simulation: &Simulation) -> Vec<f64> {
    let template = &simulation.template;
    let of = |joint: usize| template.rotors.get(joint).copied().flatten();
    (0..template.joints.len()).map(|joint| of(joint).map_or(0.0, |place| simulation.truth.further[place])).collect()
}

impl<'s> Dynamics<'s> {
    pub fn new(simulation: &'s Simulation, load: Option<usize>) -> Dynamics<'s> {
        let (chain, truth) = (&simulation.template.robot.chain, &simulation.truth);
        let link = |(moments, tensor): (&[f64; 4], &[f64; 6])| {
            let [mass, first_moment @ ..] = *moments;
            BodyInertia { mass, first_moment, tensor: *tensor }
        };
        let point = |[mass, x, y, z]: &[f64; 4]| match *mass > 0.0 {
            true => BodyInertia::about_center(*mass, [x / mass, y / mass, z / mass], [0.0; 6]),
            false => BodyInertia { mass: *mass, first_moment: [*x, *y, *z], tensor: [0.0; 6] },
        };
        let mut bodies: Vec<BodyInertia> = match truth.tensors.is_empty() {
            true => truth.inertia.iter().map(point).collect(),
            false => truth.inertia.iter().zip(&truth.tensors).map(link).collect(),
        };
        if let Some(load) = load {
            let known = &simulation.template.loads[load];
            let carried = BodyInertia::about_center(known.mass, truth.loads[load], [0.0; 6]);
            bodies[known.link] = bodies[known.link] + carried;
        }
        Dynamics {
            simulation,
            parameters: bodies.iter().flat_map(BodyInertia::parameters).collect(),
            rotors: rotors(simulation),
            dynamics: InverseDynamics::new(chain),
        }
    }

    /// How the joints bend at a time of a trajectory of the links, s; zero where their position sensors see it.
    pub fn bent(&mut self, trajectory: &Trajectory, time: f64) -> Bent {
        let deflection = &self.simulation.disturbance.deflection;
        let bends = |(joint, compliance): (usize, &f64)| (*compliance != 0.0).then_some((joint, *compliance));
        let bending: Vec<(usize, f64)> = deflection.compliance.iter().enumerate().filter_map(bends).collect();
        let [mut by, mut rate, mut of_rotors] = [(); 3].map(|()| vec![0.0; self.rotors.len()]);
        if deflection.seen || bending.is_empty() {
            return Bent { by, rate, of_rotors };
        }
        let [before, now, after] = [-STEP, 0.0, STEP].map(|step| {
            let [coordinates, velocities, accelerations] = trajectory.at(time + step);
            let torque = self.torques([&coordinates, &velocities, &accelerations]).to_vec();
            let carried = torque.iter().zip(self.rotors.iter().zip(&accelerations));
            carried.map(|(torque, (rotor, acceleration))| torque - rotor * acceleration).collect::<Vec<f64>>()
        });
        for (joint, compliance) in bending {
            let second_derivative = (before[joint] - 2.0 * now[joint] + after[joint]) / (STEP * STEP);
            by[joint] = compliance * now[joint];
            rate[joint] = compliance * (after[joint] - before[joint]) / (2.0 * STEP);
            of_rotors[joint] = self.rotors[joint] * compliance * second_derivative;
        }
        Bent { by, rate, of_rotors }
    }

    /// The torques that move it so.
    pub fn torques(&mut self, states: [&[f64]; 3]) -> &[f64] {
        self.torques_in(self.simulation.truth.gravity, states)
    }

    /// The same without gravity.
    pub fn torques_of_motion(&mut self, states: [&[f64]; 3]) -> &[f64] {
        self.torques_in([0.0; 3], states)
    }

    fn torques_in(&mut self, gravity: [f64; 3], [coordinates, velocities, accelerations]: [&[f64]; 3]) -> &[f64] {
        let inertia = DynamicParameters { links: &self.parameters, rotor_inertia: &self.rotors };
        let motion = JointMotion { coordinates, velocities, accelerations };
        let chain = &self.simulation.template.robot.chain;
        chain.inverse_dynamics(Single, motion, gravity, inertia, &mut self.dynamics);
        &self.dynamics.torque
    }
}
