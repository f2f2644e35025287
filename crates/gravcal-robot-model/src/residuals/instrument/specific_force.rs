//! Specific force that an accelerometer at rest senses.
//!
//! ```text
//!     u = −Exp(ρ)ᵀ v
//! ```
//!
//! `v` is gravity in the frame in which the accelerometer is said to be mounted, `ρ` the rotation vector (rad) that leads
//! from there to its true axes, `Exp` the exponential map. With `φ = ‖ρ‖`, `w = Exp(ρ)ᵀ v` and the right Jacobian
//!
//! ```text
//!     J_r = 1 − (1 − cos φ)/φ² [ρ] + (φ − sin φ)/φ³ [ρ]²      (Solà et al., A micro Lie theory, 2018, eq. (143))
//! ```
//!
//! the derivatives are `∂w/∂v = Exp(ρ)ᵀ` and `∂w/∂ρ = [w] J_r`, exact for every `ρ`.

use gravcal_estimation::BlockId;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::sensed::{Sensed, SensedQuantity};

/// Below this angle, rad, the coefficients come from their series: the next term is below rounding.
const SMALL: f64 = 1e-3;

/// What a three-axis accelerometer senses, m/s².
#[derive(Clone, Debug)]
pub struct SpecificForce {
    /// Components of `ρ`, rad.
    rotation: [BlockId; 3],
}

impl SpecificForce {
    /// `rotation`: the components of the rotation vector, rad.
    pub fn new(rotation: [BlockId; 3]) -> Self {
        SpecificForce { rotation }
    }
}

fn right_jacobian(rotation: &Vector3<f64>) -> Matrix3<f64> {
    let angle = rotation.norm();
    let (first, second) = if angle < SMALL {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3))
    };
    let cross = rotation.cross_matrix();
    Matrix3::identity() - first * cross + second * cross * cross
}

impl SensedQuantity for SpecificForce {
    fn axes(&self) -> usize {
        3
    }

    fn blocks(&self) -> Vec<BlockId> {
        self.rotation.to_vec()
    }

    fn sense(&self, gravity: &Vector3<f64>, own: &[f64]) -> Sensed {
        let rotation = Vector3::from_column_slice(own);
        let back = Rotation3::new(rotation).into_inner().transpose();
        let seen = back * gravity;
        let by_rotation = -seen.cross_matrix() * right_jacobian(&rotation);
        Sensed {
            value: (-seen).as_slice().to_vec(),
            by_gravity: (0..3).map(|axis| -back.row(axis).transpose()).collect(),
            by_own: (0..3).map(|axis| by_rotation.row(axis).iter().copied().collect()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::tests::check;
    use super::*;
    use crate::residuals::testing::ids;

    #[test]
    fn derivatives() {
        for full in [false, true] {
            check(3, full, &[1; 3], |own| Arc::new(SpecificForce::new([own[0], own[1], own[2]])));
        }
    }

    #[test]
    fn it_points_up_and_small_angles_are_like_others() {
        let ids = ids(&[1; 3]);
        let sensor = SpecificForce::new([ids[0], ids[1], ids[2]]);
        assert_eq!(sensor.sense(&Vector3::new(0.0, 0.0, -9.8), &[0.0; 3]).value, [0.0, 0.0, 9.8]);
        let direction = Vector3::new(0.48, -0.6, 0.64);
        let [below, above] = [0.999, 1.001].map(|share| right_jacobian(&(share * SMALL * direction)));
        assert!((above - below).norm() < 1.5e-6 * 2.0, "{}", above - below);
        assert!(
            (right_jacobian(&(SMALL * 0.9999999 * direction)) - right_jacobian(&(SMALL * direction))).norm() < 1e-9
        );
    }
}
