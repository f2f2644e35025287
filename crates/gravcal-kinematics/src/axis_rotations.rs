//! The directions of the axes, without any length.

use nalgebra::Matrix3;

use crate::chain::Chain;
use crate::transform::rows;

impl Chain {
    /// Rotations between successive axis frames, row-major: `joint_count()` matrices.
    ///
    /// An axis frame has its z along the joint's axis and its x as the smallest rotation from the joint frame leaves it
    /// (the joint frame itself where its axis is z). Element 0 is `R(base, axis frame 1)`. Element i (for
    /// 1 ≤ i < n, between joints i and i+1 counted from 1) is the constant `C_i` of
    ///
    /// ```text
    ///     R(axis frame i, axis frame i+1) = Rot_z(θ_i) · C_i
    /// ```
    ///
    /// with `θ_i` the coordinate of joint i (zero for a prismatic joint). For standard Denavit-Hartenberg rows without a
    /// fixed part of θ, element 0 is the identity and `C_i = Rot_x(α_i)`, as in the paper's eq. (1). What is beyond the
    /// last axis does not appear.
    pub fn axis_rotations(&self) -> Vec<[[f64; 3]; 3]> {
        let mut before = Matrix3::identity();
        self.axis_frames
            .iter()
            .map(|frame| {
                let rotation = before * frame.from_parent.rotation();
                before = *frame.to_link.rotation();
                rows(&rotation)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use proptest::prelude::*;

    use super::*;
    use crate::joint::JointKind;
    use crate::random_chain::{dh_row, pose, standard_chain};
    use crate::transform::Transform;

    #[test]
    fn axis_rotations_of_standard_rows_are_the_twists_exactly() {
        let twists = [1.2, -0.7, 0.4];
        let rows: Vec<_> = (0..3).map(|i| dh_row(i, JointKind::Revolute, [0.1, twists[i], 0.3, 0.0])).collect();
        let rotations = standard_chain(&rows).axis_rotations();
        assert_eq!(rotations[0], Transform::identity().rotation());
        assert_eq!(rotations[1], Transform::about_x(twists[0]).rotation());
        assert_eq!(rotations[2], Transform::about_x(twists[1]).rotation());
        assert_eq!(rotations.len(), 3);
    }

    proptest! {
        /// The axes in base coordinates, once from the rotations and once from the link poses.
        #[test]
        fn axis_rotations_agree_with_forward(pose in pose()) {
            let (chain, coordinates) = (&pose.chain, &pose.coordinates);
            let poses = chain.forward(coordinates);
            let mut axis_frame = Matrix3::identity();
            for (i, rotation) in chain.axis_rotations().into_iter().enumerate() {
                axis_frame *= Transform::from_rotation(rotation, [0.0; 3]).unwrap().rotation;
                let joint = &chain.joints()[i];
                let expected = (poses[i] * joint.after.inverse()).rotation * Vector3::from(joint.axis);
                prop_assert!((axis_frame.column(2) - expected).norm() < 1e-13);
                if joint.kind == JointKind::Revolute {
                    axis_frame *= Transform::about_z(coordinates[i]).rotation;
                }
            }
        }
    }
}
