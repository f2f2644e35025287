//! The gravity torque against differences of the energy, and its derivatives against differences of the torque.

use proptest::prelude::*;

use super::*;
use crate::arithmetic::{LANES, Vectorized};
use crate::joint::JointKind;
use crate::random_chain::{Pose, dh_row, pose, standard_chain};

/// Step of the central differences: balances 1e-16/h of rounding against h² of curvature.
const STEP: f64 = 1e-5;
/// What such differences leave of torques up to some hundred N·m.
const DIFFERENCE: f64 = 1e-6;
/// Rounding of sums of torques up to some hundred N·m.
const ROUNDING: f64 = 1e-11;

impl Pose {
    fn torque(&self) -> Vec<f64> {
        let mut torque = vec![f64::NAN; self.chain.joint_count()];
        self.chain.gravity_torque(&self.coordinates, self.gravity, &self.inertia, &mut torque);
        torque
    }

    fn linearized(&self) -> GravityTorque {
        let mut out = GravityTorque::new(self.chain.joint_count(), self.chain.link_count());
        self.chain.linearize_gravity_torque(&self.coordinates, self.gravity, &self.inertia, &mut out);
        out
    }

    /// Potential energy −Σ g·(m p + R h) from the public forward kinematics, J.
    fn energy(&self) -> f64 {
        let poses = self.chain.forward(&self.coordinates);
        let links = poses.iter().zip(self.inertia.chunks(INERTIA));
        let moment = links.fold(Vector3::zeros(), |sum, (pose, own)| {
            let from_base = Vector3::from(pose.translation()) * own[0];
            sum + from_base + Vector3::from(pose.rotate_vector([own[1], own[2], own[3]]))
        });
        -moment.dot(&Vector3::from(self.gravity))
    }
}

/// d torque / d (one input), by central differences.
fn column(pose: &Pose, change: impl Fn(&mut Pose, f64)) -> Vec<f64> {
    let moved = |step| {
        let mut pose = pose.clone();
        change(&mut pose, step);
        pose.torque()
    };
    moved(STEP).iter().zip(moved(-STEP)).map(|(plus, minus)| (plus - minus) / (2.0 * STEP)).collect()
}

/// Compares a row-major Jacobian with its columns by differences.
fn check_columns(jacobian: &[f64], columns: &[Vec<f64>]) -> Result<(), TestCaseError> {
    let width = columns.len();
    for (j, column) in columns.iter().enumerate() {
        for (i, difference) in column.iter().enumerate() {
            let analytic = jacobian[width * i + j];
            prop_assert!((analytic - difference).abs() < DIFFERENCE, "[{i}, {j}]: {analytic}, {difference}");
        }
    }
    Ok(())
}

fn check_equal(left: &[f64], right: &[f64]) -> Result<(), TestCaseError> {
    prop_assert_eq!(left.len(), right.len());
    for (l, r) in left.iter().zip(right) {
        prop_assert!((l - r).abs() < ROUNDING, "{left:?} is not {right:?}");
    }
    Ok(())
}

/// `matrix · vector` for a row-major matrix.
fn product(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    matrix.chunks(vector.len()).map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum()).collect()
}

proptest! {
    #[test]
    fn torque_is_the_derivative_of_the_energy(pose in pose()) {
        for (j, torque) in pose.torque().into_iter().enumerate() {
            let energy = |step: f64| {
                let mut moved = pose.clone();
                moved.coordinates[j] += step;
                moved.energy()
            };
            let difference = (energy(STEP) - energy(-STEP)) / (2.0 * STEP);
            prop_assert!((torque - difference).abs() < DIFFERENCE, "joint {j}: {torque}, {difference}");
        }
    }

    #[test]
    fn derivative_by_coordinates(pose in pose()) {
        let columns: Vec<_> =
            (0..pose.chain.joint_count()).map(|j| column(&pose, |p, step| p.coordinates[j] += step)).collect();
        check_columns(&pose.linearized().by_coordinate, &columns)?;
    }

    #[test]
    fn derivative_by_gravity(pose in pose()) {
        let columns: Vec<_> = (0..3).map(|j| column(&pose, |p, step| p.gravity[j] += step)).collect();
        check_columns(&pose.linearized().by_gravity, &columns)?;
    }

    #[test]
    fn derivative_by_inertia(pose in pose()) {
        let columns: Vec<_> =
            (0..pose.inertia.len()).map(|j| column(&pose, |p, step| p.inertia[j] += step)).collect();
        check_columns(&pose.linearized().by_inertia, &columns)?;
    }

    #[test]
    fn second_derivative_is_symmetric(pose in pose()) {
        let n = pose.chain.joint_count();
        let by_coordinate = pose.linearized().by_coordinate;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b] = [by_coordinate[n * i + j], by_coordinate[n * j + i]];
            // Sums over coupled axes may be taken in another order.
            prop_assert!(if pose.chain.is_serial() { a == b } else { (a - b).abs() < ROUNDING }, "{a} {b}");
        }
    }

    #[test]
    fn linear_in_gravity_and_in_inertia(pose in pose()) {
        let linearized = pose.linearized();
        check_equal(&linearized.torque, &product(&linearized.by_gravity, &pose.gravity))?;
        check_equal(&linearized.torque, &product(&linearized.by_inertia, &pose.inertia))?;
    }

    #[test]
    fn links_that_a_joint_does_not_move_do_not_load_it(pose in pose()) {
        let by_inertia = pose.linearized().by_inertia;
        for (joint, row) in by_inertia.chunks(4 * pose.chain.link_count()).enumerate() {
            for (link, entries) in row.chunks(4).enumerate() {
                prop_assert!(pose.chain.moves(joint, link) || entries.iter().all(|entry| *entry == 0.0));
            }
        }
    }

    #[test]
    fn joints_that_do_not_meet_do_not_matter_to_each_other(pose in pose()) {
        let n = pose.chain.joint_count();
        let by_coordinate = pose.linearized().by_coordinate;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            prop_assert!(pose.chain.meet(i, j) || by_coordinate[n * i + j] == 0.0);
        }
    }

    #[test]
    fn all_functions_agree_to_the_bit_and_the_workspace_keeps_nothing(first in pose(), second in pose()) {
        let fresh = second.linearized();
        prop_assert_eq!(second.torque(), fresh.torque.clone());
        let mut updated = GravityTorque::new(second.chain.joint_count(), second.chain.link_count());
        second.chain.update_gravity_torque(&second.coordinates, second.gravity, &second.inertia, &mut updated);
        prop_assert_eq!(&updated.torque, &fresh.torque);
        let size = |pose: &Pose| (pose.chain.joint_count(), pose.chain.link_count());
        if size(&first) == size(&second) {
            let mut reused = first.linearized();
            for derivative in [&mut reused.by_inertia, &mut reused.by_coordinate, &mut reused.by_gravity] {
                derivative.fill(f64::NAN);
            }
            second.chain.linearize_gravity_torque(
                &second.coordinates, second.gravity, &second.inertia, &mut reused);
            prop_assert_eq!(&reused.by_inertia, &fresh.by_inertia);
            prop_assert_eq!(&reused.by_coordinate, &fresh.by_coordinate);
            prop_assert_eq!(&reused.by_gravity, &fresh.by_gravity);
        }
    }

    #[test]
    fn links_that_stay_where_they_were_make_no_difference(first in pose(), moved in any::<u16>()) {
        let mut second = first.clone();
        let joints = second.coordinates.iter_mut().enumerate();
        joints.filter(|(joint, _)| moved >> (joint % 16) & 1 == 1).for_each(|(_, coordinate)| *coordinate += 0.3);
        let (fresh, mut reused) = (second.linearized(), first.linearized());
        second.chain.linearize_gravity_torque(&second.coordinates, second.gravity, &second.inertia, &mut reused);
        prop_assert_eq!(&reused.torque, &fresh.torque);
        prop_assert_eq!(&reused.by_inertia, &fresh.by_inertia);
        prop_assert_eq!(&reused.by_coordinate, &fresh.by_coordinate);
        prop_assert_eq!(&reused.by_gravity, &fresh.by_gravity);
    }
}

/// Torques and derivatives of all joints, by what computes them.
struct Flat<'a, A: Arithmetic> {
    chain: &'a Chain,
    coordinates: &'a [A::Stored],
    pose: &'a Pose,
}

impl<A: Arithmetic> Flat<'_, A> {
    fn rows(&self, on: A) -> Option<Vec<A::Stored>> {
        let mut bodies = Bodies::new(self.chain.link_count());
        let Pose { gravity, inertia, .. } = self.pose;
        let rows = self.chain.gravity_torque_rows(on, self.coordinates, *gravity, inertia, &mut bodies)?;
        let of_joint = |joint: usize| {
            let row = rows.of_joint(joint);
            let by_inertia: Vec<A::Number> = row.by_inertia().flatten().collect();
            let by: Vec<A::Number> = row.by_gravity().into_iter().chain(row.by_coordinate()).collect();
            let all = std::iter::once(row.torque()).chain(by).chain(by_inertia);
            all.map(|number| on.store(number)).collect::<Vec<_>>()
        };
        Some((0..self.chain.joint_count()).flat_map(of_joint).collect())
    }
}

/// Nothing where the processor has no registers of so many lanes, or joints mimic others.
struct BatchRows<'a>(&'a Pose, &'a [[f64; LANES]]);

impl pulp::WithSimd for BatchRows<'_> {
    type Output = Option<Vec<[f64; LANES]>>;

    fn with_simd<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let BatchRows(pose, coordinates) = self;
        Flat { chain: &pose.chain, coordinates, pose }.rows(Vectorized::new(simd)?)
    }
}

proptest! {
    #[test]
    fn poses_in_lanes_have_the_bits_that_each_has_alone(pose in pose()) {
        let shifted = |lane: usize, q: &f64| q + 0.1 * lane as f64;
        let batch: Vec<[f64; LANES]> =
            pose.coordinates.iter().map(|q| std::array::from_fn(|lane| shifted(lane, q))).collect();
        let together = pulp::Arch::new().dispatch(BatchRows(&pose, &batch));
        for lane in 0..LANES {
            let own: Vec<f64> = pose.coordinates.iter().map(|q| shifted(lane, q)).collect();
            let alone = Flat { chain: &pose.chain, coordinates: &own, pose: &pose }.rows(Single);
            let Some(together) = &together else { continue };
            let lane: Vec<f64> = together.iter().map(|lanes| lanes[lane]).collect();
            prop_assert_eq!(&lane, &alone.unwrap());
        }
    }
}

#[test]
fn a_level_arm_is_held_upwards() {
    // Axis along −y of the base (twist 90°): a positive angle raises the arm, so does a positive torque.
    let rows = [
        dh_row(0, JointKind::Revolute, [0.0, std::f64::consts::FRAC_PI_2, 0.0, 0.0]),
        dh_row(1, JointKind::Revolute, [0.5, 0.0, 0.0, 0.0]),
    ];
    let inertia = [0.0, 0.0, 0.0, 0.0, 2.0, -0.3, 0.0, 0.0];
    let mut torque = [0.0; 2];
    standard_chain(&rows).gravity_torque(&[0.7, 0.0], [0.0, 0.0, -10.0], &inertia, &mut torque);
    assert!(torque[0].abs() < 1e-14);
    assert!((torque[1] - 10.0 * (2.0 * 0.5 - 0.3)).abs() < 1e-14);
}

#[test]
fn a_lift_carries_its_weight() {
    let rows = [dh_row(0, JointKind::Prismatic, [0.1, 0.2, 0.3, 0.4])];
    let mut force = [0.0];
    standard_chain(&rows).gravity_torque(&[0.7], [1.0, 0.0, -10.0], &[2.0, 0.1, 0.1, 0.1], &mut force);
    assert_eq!(force, [20.0]);
}
