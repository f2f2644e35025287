//! The directions of the axes, without any length.

use nalgebra::Matrix3;

use crate::axis_frame::AxisFrame;
use crate::chain::Chain;
use crate::transform::rows;

impl Chain {
    /// Rotation of every link's axis frame in that of the link it hangs on, row-major: `link_count()` matrices.
    ///
    /// An axis frame has its z along the joint's axis and its x as the smallest rotation from the joint frame leaves it
    /// (the joint frame itself where its axis is z). Of a joint on the base, the matrix is `R(base, axis frame)`. Of any
    /// other it is the constant `C` of
    ///
    /// ```text
    ///     R(axis frame of the parent, axis frame) = Rot_z(θ) · C
    /// ```
    ///
    /// with `θ` the coordinate of the parent's joint (zero for a prismatic joint). For standard Denavit-Hartenberg rows
    /// without a fixed part of θ, the first is the identity and that of joint i + 1 is `Rot_x(α_i)`, as in the paper's eq.
    /// (1). What is beyond a last axis does not appear.
    pub fn axis_rotations(&self) -> Vec<[[f64; 3]; 3]> {
        let rotation = |(frame, parent): (&AxisFrame, &Option<usize>)| {
            let before = parent.map_or_else(Matrix3::identity, |parent| *self.axis_frames[parent].to_link.rotation());
            rows(&(before * frame.from_parent.rotation()))
        };
        self.axis_frames.iter().zip(&self.topology.parents).map(rotation).collect()
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
            let chain = &pose.chain;
            let poses = chain.forward(&pose.coordinates);
            let mut moved: Vec<Matrix3<f64>> = Vec::new();
            for (k, rotation) in chain.axis_rotations().into_iter().enumerate() {
                let parent = chain.parent(k).map_or_else(Matrix3::identity, |parent| moved[parent]);
                let axis_frame = parent * Transform::from_rotation(rotation, [0.0; 3]).unwrap().rotation;
                let joint = &chain.movers()[k];
                let expected = (poses[k] * joint.after.inverse()).rotation * Vector3::from(joint.axis);
                prop_assert!((axis_frame.column(2) - expected).norm() < 1e-13);
                let turn = if joint.kind == JointKind::Revolute { pose.of_link(k) } else { 0.0 };
                moved.push(axis_frame * Transform::about_z(turn).rotation);
            }
        }
    }
}
