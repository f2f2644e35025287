//! Chains from Denavit-Hartenberg rows, in either convention.
//!
//! ```text
//!     standard:  X_{i−1,i} = Rot_z(θ_i) Trans_z(d_i) Trans_x(a_i) Rot_x(α_i)                joint axis i is z_{i−1}
//!     modified:  X_{i−1,i} = Rot_x(α_{i−1}) Trans_x(a_{i−1}) Rot_z(θ_i) Trans_z(d_i)        joint axis i is z_i
//! ```
//!
//! Standard: Denavit and Hartenberg as in the paper's eq. (1). Modified: Craig, *Introduction to Robotics*, eq. (3.6); row
//! i then holds `a_{i−1}, α_{i−1}, d_i, θ_i`.

use serde::{Deserialize, Serialize};

use crate::chain::{Chain, ChainError};
use crate::joint::{Joint, JointKind};
use crate::link::Link;
use crate::transform::Transform;

/// Which of the two Denavit-Hartenberg conventions a table is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DhConvention {
    /// The classic one: link frame i sits at the far end of link i, joint i turns about `z_{i−1}`.
    Standard,
    /// Craig's: link frame i sits on axis i, joint i turns about `z_i`.
    Modified,
}

/// One row of a Denavit-Hartenberg table: a joint, and the link it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct DhRow {
    /// Name of the joint.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Length along x, m (of link i, or i−1 if modified).
    pub a: f64,
    /// Twist about x, rad (of link i, or i−1 if modified).
    pub alpha: f64,
    /// Offset along the axis, m; added to the coordinate of a prismatic joint.
    pub d: f64,
    /// Angle about the axis, rad; added to the coordinate of a revolute joint.
    pub theta: f64,
    /// Lower and upper bound of the true coordinate (without the fixed part), rad or m.
    pub limits: Option<[f64; 2]>,
    /// The link this joint moves, in the frame that the row defines.
    pub link: Link,
}

/// The serial chain of a Denavit-Hartenberg table.
///
/// # Errors
///
/// See [`Chain::new`].
pub fn chain_from_dh(base: &str, convention: DhConvention, rows: &[DhRow]) -> Result<Chain, ChainError> {
    let joints = rows.iter().map(|row| joint_from_dh(convention, row)).collect();
    let links = rows.iter().map(|row| row.link.clone()).collect();
    Chain::new(base, joints, links)
}

/// The joint of one row, as it hangs on the link of the row before.
pub fn joint_from_dh(convention: DhConvention, row: &DhRow) -> Joint {
    let x_screw = Transform::along([row.a, 0.0, 0.0]) * Transform::about_x(row.alpha);
    let turn = Transform::about_z(row.theta);
    let shift = Transform::along([0.0, 0.0, row.d]);
    // Turn and shift along one axis commute with the motion: which side they stand on is a choice, made so that a
    // standard row without θ leaves the joint frame on the frame before it.
    let (before, after) = match convention {
        DhConvention::Standard => (turn, shift * x_screw),
        DhConvention::Modified => (x_screw * turn, shift),
    };
    Joint { name: row.name.clone(), kind: row.kind, before, axis: [0.0, 0.0, 1.0], after, limits: row.limits }
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;
    use crate::random_chain::{dh_row, dh_rows, standard_chain};

    /// The modified table of the same robot: the links' x-screws move one row on, the last one drops out (the last
    /// modified frame sits on the last axis, where standard has one more screw to go).
    fn to_modified(standard: &[DhRow]) -> Vec<DhRow> {
        let screws = std::iter::once((0.0, 0.0)).chain(standard.iter().map(|row| (row.a, row.alpha)));
        standard.iter().zip(screws).map(|(row, (a, alpha))| DhRow { a, alpha, ..row.clone() }).collect()
    }

    /// Pose of standard link frame i in modified link frame i.
    fn last_screw(row: &DhRow) -> Transform {
        Transform::along([row.a, 0.0, 0.0]) * Transform::about_x(row.alpha)
    }

    /// The same bodies, told in modified link frames.
    fn in_modified_frames(standard: &[DhRow], inertia: &[f64]) -> Vec<f64> {
        let links = standard.iter().zip(inertia.chunks(4));
        links
            .flat_map(|(row, own)| {
                let screw = last_screw(row);
                let [turned, lever] = [screw.rotate_vector([own[1], own[2], own[3]]), screw.translation()];
                let moment = |axis: usize| turned[axis] + own[0] * lever[axis];
                [own[0], moment(0), moment(1), moment(2)]
            })
            .collect()
    }

    fn close(left: &[f64], right: &[f64]) -> bool {
        left.len() == right.len() && left.iter().zip(right).all(|(l, r)| (l - r).abs() < 1e-11)
    }

    proptest! {
        #[test]
        fn both_conventions_tell_the_same_robot(
            rows in dh_rows(),
            coordinates in vec(-3.0..3.0, 7),
            inertia in vec(-2.0..2.0, 28),
        ) {
            let n = rows.len();
            let (coordinates, inertia, gravity) = (&coordinates[..n], &inertia[..4 * n], [1.0, -4.0, -9.0]);
            let standard = standard_chain(&rows);
            let modified = chain_from_dh("base", DhConvention::Modified, &to_modified(&rows)).unwrap();

            let [mut left, mut right] = [vec![0.0; n], vec![0.0; n]];
            standard.gravity_torque(coordinates, gravity, inertia, &mut left);
            modified.gravity_torque(coordinates, gravity, &in_modified_frames(&rows, inertia), &mut right);
            prop_assert!(close(&left, &right), "{left:?} is not {right:?}");
            prop_assert_eq!(standard.axis_rotations().len(), modified.axis_rotations().len());
        }

        #[test]
        fn rows_are_the_printed_product(rows in dh_rows(), coordinates in vec(-3.0..3.0, 7)) {
            let mut expected = Transform::identity();
            for (row, coordinate) in rows.iter().zip(&coordinates) {
                let (turn, shift) = match row.kind {
                    JointKind::Revolute => (row.theta + coordinate, row.d),
                    JointKind::Prismatic => (row.theta, row.d + coordinate),
                };
                expected = expected * Transform::about_z(turn) * Transform::along([0.0, 0.0, shift]) * last_screw(row);
            }
            let poses = standard_chain(&rows).forward(&coordinates[..rows.len()]);
            let last = poses[rows.len() - 1];
            prop_assert!(close(&last.translation(), &expected.translation()));
            prop_assert!(close(&last.rotation().concat(), &expected.rotation().concat()));
        }
    }

    #[test]
    fn names_of_conventions_and_kinds_in_files() {
        assert_eq!(serde_json::to_string(&DhConvention::Modified).unwrap(), "\"modified\"");
        assert_eq!(serde_json::from_str::<JointKind>("\"prismatic\"").unwrap(), JointKind::Prismatic);
    }

    #[test]
    fn limits_and_links_are_kept() {
        let mut row = dh_row(0, JointKind::Revolute, [0.0; 4]);
        row.limits = Some([-1.0, 2.0]);
        let chain = standard_chain(&[row]);
        assert_eq!(chain.joints()[0].limits, Some([-1.0, 2.0]));
        assert_eq!(chain.links()[0].name, "link0");
    }
}
