//! The inverse dynamics against Lagrange's equations and the balance of power, both from forward kinematics alone; its derivatives against
//! differences.

use std::ops::AddAssign;

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use proptest::array::uniform3;
use proptest::collection::vec;
use proptest::prelude::*;

use super::*;
use crate::arithmetic::{LANES, Single, Vectorized};
use crate::body_inertia;
use crate::random_chain::{Pose, pose};

/// Step of the central differences of second order: balances rounding against curvature.
const STEP: f64 = 1e-5;
/// What such differences leave, of the largest number compared.
const DIFFERENCE: f64 = 1e-7;
/// Step in time of the differences of fourth order, s; for first derivatives, and for second ones.
const MOMENT: f64 = 1e-3;
/// What these leave of the largest torque, or of the sum of all powers.
const TRAJECTORY: f64 = 1e-6;
/// Rounding of sums, of the largest summand.
const ROUNDING: f64 = 1e-12;

/// A pose in motion, and everything that the inverse dynamics depends on.
#[derive(Clone, Debug)]
struct Moving {
    pose: Pose,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    links: Vec<f64>,
    rotor_inertia: Vec<f64>,
}

/// Bodies of three point masses on a light rod each: tensors as real bodies have them.
fn body() -> impl Strategy<Value = BodyNumbers> {
    vec((0.0..2.0, uniform3(-1.0..1.0)), 3).prop_map(|points| {
        let of_point = |(mass, place)| crate::BodyInertia::about_center(mass, place, [0.1, 0.01, 0.2, -0.02, 0.0, 0.3]);
        points.into_iter().map(of_point).fold(crate::BodyInertia::default(), |sum, body| sum + body).parameters()
    })
}

type BodyNumbers = [f64; BODY];

fn moving() -> impl Strategy<Value = Moving> {
    let of_joint = (-2.0..2.0, -4.0..4.0, 0.0..1.0);
    (pose(), vec(of_joint, 8), vec(body(), 8)).prop_map(|(pose, joints, bodies)| {
        let (n, l) = (pose.chain.joint_count(), pose.chain.link_count());
        Moving {
            velocities: joints[..n].iter().map(|joint| joint.0).collect(),
            accelerations: joints[..n].iter().map(|joint| joint.1).collect(),
            rotor_inertia: joints[..n].iter().map(|joint| joint.2).collect(),
            links: bodies[..l].concat(),
            pose,
        }
    })
}

impl Moving {
    fn chain(&self) -> &Chain {
        &self.pose.chain
    }

    fn sample(&self) -> JointMotion<'_> {
        let Moving { pose, velocities, accelerations, .. } = self;
        JointMotion { coordinates: &pose.coordinates, velocities, accelerations }
    }

    fn parameters(&self) -> DynamicParameters<'_> {
        DynamicParameters { links: &self.links, rotor_inertia: &self.rotor_inertia }
    }

    fn torque(&self) -> Vec<f64> {
        let mut out = InverseDynamics::new(self.chain());
        self.chain().inverse_dynamics(Single, self.sample(), self.pose.gravity, self.parameters(), &mut out);
        out.torque
    }

    fn linearized(&self) -> InverseDynamics {
        let mut out = InverseDynamics::new(self.chain());
        self.linearize_into(&mut out);
        out
    }

    fn linearize_into(&self, out: &mut InverseDynamics) {
        self.chain().linearize_inverse_dynamics(Single, self.sample(), self.pose.gravity, self.parameters(), out);
    }

    /// The coordinates some time later, s, with the accelerations as they are.
    fn after(&self, time: f64) -> Vec<f64> {
        let rates = self.velocities.iter().zip(&self.accelerations);
        let joints = self.pose.coordinates.iter().zip(rates);
        joints.map(|(q, (speed, rate))| q + time * (speed + 0.5 * time * rate)).collect()
    }

    /// The motion some time later.
    fn moved_on(&self, time: f64) -> Moving {
        let mut later = self.clone();
        later.pose.coordinates = self.after(time);
        let joints = later.velocities.iter_mut().zip(&self.accelerations);
        joints.for_each(|(speed, rate)| *speed += time * rate);
        later
    }

    /// Transforms of all links as matrices.
    fn places(&self, coordinates: &[f64]) -> Vec<Matrix4<f64>> {
        let matrix = |pose: crate::Transform| {
            let mut matrix = Matrix4::identity();
            matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.rotation);
            matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&pose.translation);
            matrix
        };
        self.chain().forward(coordinates).into_iter().map(matrix).collect()
    }

    /// Velocities of the links' transforms, by differences.
    fn place_rates(&self) -> Vec<Matrix4<f64>> {
        derivative(|time| self.places(&self.after(time)))
    }

    /// `[[E, h], [hᵀ, m]]` of each link.
    fn pseudo_inertias(&self) -> Vec<Matrix4<f64>> {
        let of_link = |own: &BodyNumbers| {
            let [mass, x, y, z, tensor @ ..] = *own;
            let tensor = body_inertia::matrix(tensor);
            let mut pseudo = Matrix4::zeros();
            pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * (0.5 * tensor.trace()) - tensor));
            pseudo.set_column(3, &Vector4::new(x, y, z, mass));
            pseudo.set_row(3, &Vector4::new(x, y, z, mass).transpose());
            pseudo
        };
        self.links.as_chunks::<BODY>().0.iter().map(of_link).collect()
    }

    /// Kinetic and potential energy, J.
    fn energy(&self) -> f64 {
        let gravity = Vector3::from(self.pose.gravity).push(0.0);
        let links = self.places(&self.pose.coordinates).into_iter().zip(self.place_rates()).zip(self.pseudo_inertias());
        let of_link = |((place, rate), pseudo): ((Matrix4<f64>, Matrix4<f64>), Matrix4<f64>)| {
            0.5 * (rate * pseudo * rate.transpose()).trace() - gravity.dot(&(place * pseudo).column(3))
        };
        let rotors = self.rotor_inertia.iter().zip(&self.velocities);
        links.map(of_link).sum::<f64>() + rotors.map(|(inertia, speed)| 0.5 * inertia * speed * speed).sum::<f64>()
    }

    /// `Σ_k tr(∂X_k/∂q_i P_k (Ẍ_k − [0 g])ᵀ) + Ia_i q̈_i` (Uicker 1965), all derivatives by differences.
    fn by_lagrange(&self) -> Vec<f64> {
        let gravity = Vector3::from(self.pose.gravity).push(0.0);
        let mut change = derivative(|time| self.moved_on(time).place_rates());
        change.iter_mut().for_each(|matrix| {
            let relative = matrix.column(3) - gravity;
            matrix.set_column(3, &relative);
        });
        let of_joint = |joint: usize| {
            let by = derivative(|step| {
                let mut coordinates = self.pose.coordinates.clone();
                coordinates[joint] += step;
                self.places(&coordinates)
            });
            let links = by.iter().zip(self.pseudo_inertias()).zip(&change);
            let sum: f64 = links.map(|((by, pseudo), change)| (by * pseudo * change.transpose()).trace()).sum();
            sum + self.rotor_inertia[joint] * self.accelerations[joint]
        };
        (0..self.chain().joint_count()).map(of_joint).collect()
    }
}

/// The derivative at zero by differences of fourth order.
fn derivative(at: impl Fn(f64) -> Vec<Matrix4<f64>>) -> Vec<Matrix4<f64>> {
    let weights = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
    let mut sum: Vec<Matrix4<f64>> = Vec::new();
    for (steps, weight) in weights {
        let terms = at(steps * MOMENT).into_iter().map(|matrix| matrix * (weight / (12.0 * MOMENT)));
        if sum.is_empty() {
            sum = terms.collect();
        } else {
            sum.iter_mut().zip(terms).for_each(|(sum, term)| sum.add_assign(term));
        }
    }
    sum
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(1.0, |largest, number| largest.max(number.abs()))
}

fn check_close(left: &[f64], right: &[f64], tolerance: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(left.len(), right.len());
    let scale = largest(left).max(largest(right));
    for (k, (l, r)) in left.iter().zip(right).enumerate() {
        prop_assert!((l - r).abs() <= tolerance * scale, "[{k}]: {l} is not {r}, of {scale}");
    }
    Ok(())
}

/// A row-major Jacobian by central differences of the torque.
fn slopes(moving: &Moving, inputs: usize, change: impl Fn(&mut Moving, usize, f64)) -> Vec<f64> {
    let torque = |input: usize, step: f64| {
        let mut moved = moving.clone();
        change(&mut moved, input, step);
        moved.torque()
    };
    let columns: Vec<Vec<f64>> = (0..inputs)
        .map(|input| {
            let [plus, minus] = [torque(input, STEP), torque(input, -STEP)];
            plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * STEP)).collect()
        })
        .collect();
    (0..moving.chain().joint_count()).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
}

/// `matrix · vector` for a row-major matrix.
fn product(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    matrix.chunks(vector.len()).map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum()).collect()
}

fn sum(left: &[f64], right: impl IntoIterator<Item = f64>) -> Vec<f64> {
    left.iter().zip(right).map(|(a, b)| a + b).collect()
}

proptest! {
    #[test]
    fn torque_is_lagranges(moving in moving()) {
        check_close(&moving.torque(), &moving.by_lagrange(), TRAJECTORY)?;
    }

    #[test]
    fn the_power_of_all_joints_is_the_change_of_the_energy(moving in moving()) {
        let torque = moving.torque();
        let powers: Vec<f64> = torque.iter().zip(&moving.velocities).map(|(torque, speed)| torque * speed).collect();
        let energy = |steps: f64| moving.moved_on(steps * MOMENT).energy();
        let change = (energy(-2.0) - 8.0 * energy(-1.0) + 8.0 * energy(1.0) - energy(2.0)) / (12.0 * MOMENT);
        let scale: f64 = powers.iter().map(|power| power.abs()).sum::<f64>().max(largest(&torque));
        let power: f64 = powers.iter().sum();
        prop_assert!((power - change).abs() < TRAJECTORY * scale, "{power} W, {change} W");
    }

    #[test]
    fn at_rest_it_is_the_gravity_torque(mut moving in moving()) {
        moving.velocities.fill(0.0);
        moving.accelerations.fill(0.0);
        let (chain, Pose { coordinates, gravity, .. }) = (moving.chain(), &moving.pose);
        let inertia: Vec<f64> = moving.links.chunks(BODY).flat_map(|own| own[..4].to_vec()).collect();
        let mut held = crate::GravityTorque::new(chain.joint_count(), chain.link_count());
        chain.linearize_gravity_torque(coordinates, *gravity, &inertia, &mut held);
        let linearized = moving.linearized();
        check_close(&linearized.torque, &held.torque, ROUNDING)?;
        check_close(&linearized.by_coordinate, &held.by_coordinate, ROUNDING)?;
        check_close(&linearized.by_gravity, &held.by_gravity, ROUNDING)?;
        prop_assert!(linearized.by_velocity.iter().all(|by| *by == 0.0));
        let static_columns: Vec<f64> = linearized.by_parameters.chunks(BODY).flat_map(|own| own[..4].to_vec()).collect();
        check_close(&static_columns, &held.by_inertia, ROUNDING)?;
        let of_tensors = linearized.by_parameters.chunks(BODY).flat_map(|own| own[4..].to_vec());
        prop_assert!(of_tensors.into_iter().all(|by| by == 0.0));
    }

    #[test]
    fn derivatives_are_slopes(moving in moving()) {
        let linearized = moving.linearized();
        let n = moving.chain().joint_count();
        let by_coordinate = slopes(&moving, n, |moved, joint, step| moved.pose.coordinates[joint] += step);
        check_close(&linearized.by_coordinate, &by_coordinate, DIFFERENCE)?;
        let by_velocity = slopes(&moving, n, |moved, joint, step| moved.velocities[joint] += step);
        check_close(&linearized.by_velocity, &by_velocity, DIFFERENCE)?;
        let by_acceleration = slopes(&moving, n, |moved, joint, step| moved.accelerations[joint] += step);
        check_close(&linearized.by_acceleration, &by_acceleration, DIFFERENCE)?;
        let by_gravity = slopes(&moving, 3, |moved, axis, step| moved.pose.gravity[axis] += step);
        check_close(&linearized.by_gravity, &by_gravity, DIFFERENCE)?;
        let by_parameters = slopes(&moving, moving.links.len(), |moved, entry, step| moved.links[entry] += step);
        check_close(&linearized.by_parameters, &by_parameters, DIFFERENCE)?;
    }

    #[test]
    fn linear_in_parameters_and_in_gravity(moving in moving()) {
        let linearized = moving.linearized();
        let rotors: Vec<f64> = moving.rotor_inertia.iter().zip(&moving.accelerations).map(|(i, a)| i * a).collect();
        let of_links = product(&linearized.by_parameters, &moving.links);
        check_close(&linearized.torque, &sum(&of_links, rotors), ROUNDING)?;
        let mut weightless = moving.clone();
        weightless.pose.gravity = [0.0; 3];
        let of_gravity = product(&linearized.by_gravity, &moving.pose.gravity);
        check_close(&linearized.torque, &sum(&of_gravity, weightless.torque()), ROUNDING)?;
    }

    #[test]
    fn the_inertia_matrix_is_symmetric_and_links_elsewhere_do_not_load(moving in moving()) {
        let linearized = moving.linearized();
        let (chain, n) = (moving.chain(), moving.chain().joint_count());
        let transposed: Vec<f64> =
            (0..n * n).map(|entry| linearized.by_acceleration[n * (entry % n) + entry / n]).collect();
        check_close(&linearized.by_acceleration, &transposed, ROUNDING)?;
        for (joint, row) in linearized.by_parameters.chunks(BODY * chain.link_count()).enumerate() {
            for (link, entries) in row.chunks(BODY).enumerate() {
                prop_assert!(chain.moves(joint, link) || entries.iter().all(|entry| *entry == 0.0));
            }
        }
    }

    #[test]
    fn all_functions_agree_to_the_bit_and_the_workspace_keeps_nothing(first in moving(), moving in moving()) {
        let fresh = moving.linearized();
        prop_assert_eq!(&moving.torque(), &fresh.torque);
        let mut other = InverseDynamics::new(moving.chain());
        moving.chain().inverse_dynamics_regressor(Single, moving.sample(), moving.pose.gravity, &mut other);
        prop_assert_eq!(&other.by_parameters, &fresh.by_parameters);
        let size = |moving: &Moving| (moving.chain().joint_count(), moving.chain().link_count());
        if size(&first) == size(&moving) && first.chain().drives.is_some() == moving.chain().drives.is_some() {
            let mut reused = first.linearized();
            let parts = [&mut reused.by_parameters, &mut reused.by_coordinate, &mut reused.by_velocity,
                &mut reused.by_acceleration, &mut reused.by_gravity, &mut reused.torque];
            parts.into_iter().for_each(|part| part.fill(f64::NAN));
            moving.linearize_into(&mut reused);
            prop_assert_eq!(all(&reused), all(&fresh));
        }
    }

    #[test]
    fn the_regressor_is_known_under_any_gravity(moving in moving()) {
        let (chain, gravity) = (moving.chain(), moving.pose.gravity);
        let mut affine = InverseDynamics::new(chain);
        chain.affine_regressor(Single, moving.sample(), &mut affine);
        let mut expected = InverseDynamics::new(chain);
        chain.inverse_dynamics_regressor(Single, moving.sample(), gravity, &mut expected);
        let mut regressor = affine.by_parameters.clone();
        let entries = chain.joint_count() * chain.link_count();
        for (axis, component) in gravity.iter().enumerate() {
            let own = &affine.regressor_by_gravity.as_chunks::<INERTIA>().0[axis * entries..][..entries];
            for (body, by_gravity) in regressor.as_chunks_mut::<BODY>().0.iter_mut().zip(own) {
                body.iter_mut().zip(by_gravity).for_each(|(entry, by)| *entry += component * by);
            }
        }
        check_close(&regressor, &expected.by_parameters, ROUNDING)?;
    }

    #[test]
    fn samples_in_lanes_have_the_bits_that_each_has_alone(moving in moving()) {
        let Some(together) = pulp::Arch::new().dispatch(BatchSamples(&moving)) else { return Ok(()) };
        for lane in 0..LANES {
            let alone = moving.moved_on(0.1 * lane as f64).linearized();
            let lane: Vec<f64> = all(&together).iter().map(|lanes| lanes[lane]).collect();
            prop_assert_eq!(&lane, &all(&alone));
        }
    }
}

fn all<L: Copy>(out: &InverseDynamics<L>) -> Vec<L> {
    [&out.torque, &out.by_coordinate, &out.by_velocity, &out.by_acceleration, &out.by_gravity, &out.by_parameters]
        .map(|part| part.as_slice())
        .concat()
}

/// Some moments of one motion; nothing where the processor has no registers of so many lanes.
struct BatchSamples<'a>(&'a Moving);

impl pulp::WithSimd for BatchSamples<'_> {
    type Output = Option<InverseDynamics<[f64; LANES]>>;

    fn with_simd<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let moving = self.0;
        let samples: [Moving; LANES] = std::array::from_fn(|lane| moving.moved_on(0.1 * lane as f64));
        let batch = |numbers: fn(&Moving) -> &[f64]| -> Vec<[f64; LANES]> {
            let joints = 0..moving.chain().joint_count();
            joints.map(|joint| std::array::from_fn(|lane| numbers(&samples[lane])[joint])).collect()
        };
        let coordinates = batch(|moving| &moving.pose.coordinates);
        let velocities = batch(|moving| &moving.velocities);
        let accelerations = batch(|moving| &moving.accelerations);
        let sample = JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
        let mut out = InverseDynamics::new(moving.chain());
        let on = Vectorized::new(simd)?;
        moving.chain().linearize_inverse_dynamics(on, sample, moving.pose.gravity, moving.parameters(), &mut out);
        Some(out)
    }
}

#[test]
fn a_pendulum_swings_as_in_the_book() {
    // Axis along z, 2 kg at half a metre with 0.1 kg·m² about its centre, 0.3 kg·m² of rotor; gravity along −y.
    let row = crate::random_chain::dh_row(0, crate::JointKind::Revolute, [0.0; 4]);
    let chain = crate::random_chain::standard_chain(&[row]);
    let body = crate::BodyInertia::about_center(2.0, [0.5, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.1]);
    let parameters = DynamicParameters { links: &body.parameters(), rotor_inertia: &[0.3] };
    let mut out = InverseDynamics::new(&chain);
    let sample = JointMotion { coordinates: &[0.4], velocities: &[5.0], accelerations: &[3.0] };
    chain.inverse_dynamics(Single, sample, [0.0, -10.0, 0.0], parameters, &mut out);
    let expected = (2.0 * 0.25 + 0.1 + 0.3) * 3.0 + 2.0 * 10.0 * 0.5 * 0.4_f64.cos();
    assert!((out.torque[0] - expected).abs() < 1e-14, "{} is not {expected}", out.torque[0]);
}

#[test]
fn a_body_without_joints_has_no_torque() {
    let chain = Chain::free_body("base", "body");
    let parameters = DynamicParameters { links: &[1.0; BODY], rotor_inertia: &[] };
    let sample = JointMotion { coordinates: &[], velocities: &[], accelerations: &[] };
    let mut out = InverseDynamics::new(&chain);
    chain.linearize_inverse_dynamics(Single, sample, [0.0, 0.0, -9.81], parameters, &mut out);
    assert!(all(&out).is_empty());
}
