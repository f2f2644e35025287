//! Rotations of space.

use super::Manifold;

/// Rotations of ℝ³, stored as a unit quaternion `q = (w, x, y, z)` (Hamilton's, the real part first). Three tangent coordinates: a
/// rotation vector, rad.
///
/// With `R_AB` the rotation that takes vectors of frame B to frame A, a step turns B against itself and is stated in B:
///
/// ```text
///     q ⊞ d = q ⊗ Exp(d),    Exp(d) = (cos ‖d‖/2, d/‖d‖ sin ‖d‖/2),    B(q) = ½ [q]_L without its first column
/// ```
///
/// with `[q]_L b = q ⊗ b` (J. Solà, *Quaternion kinematics for the error-state Kalman filter*, arXiv:1711.02508, 2017: there it is a local
/// perturbation). `q` and `−q` are the same rotation; small steps do not change from one to the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rotation;

/// How far from one the length of a quaternion may be.
const LENGTH: f64 = 1e-9;

impl Manifold for Rotation {
    fn name(&self) -> &str {
        "rotation"
    }

    fn tangent_dimension(&self, _stored: usize) -> usize {
        3
    }

    fn retract(&self, x: &mut [f64], step: &[f64]) {
        let moved = product([x[0], x[1], x[2], x[3]], exponential([step[0], step[1], step[2]]));
        // Products of unit quaternions drift from length one by rounding.
        let length = moved.iter().map(|c| c * c).sum::<f64>().sqrt();
        x.iter_mut().zip(moved).for_each(|(x, moved)| *x = moved / length);
    }

    fn basis(&self, q: &[f64], basis: &mut [f64]) {
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| 0.5 * q[k]);
        basis.copy_from_slice(&[-x, -y, -z, w, -z, y, z, w, -x, -y, x, w]);
    }

    fn check(&self, x: &[f64]) -> Result<(), String> {
        let length = x.iter().map(|c| c * c).sum::<f64>().sqrt();
        match x.len() {
            4 if (length - 1.0).abs() <= LENGTH => Ok(()),
            4 => Err(format!("is no rotation: a quaternion of length {length} instead of 1")),
            _ => Err("is no rotation: that takes the four numbers of a unit quaternion (w, x, y, z)".into()),
        }
    }

    fn radian(&self) -> Option<f64> {
        Some(1.0)
    }
}

/// Hamilton's product `a ⊗ b`.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The unit quaternion of a rotation vector.
fn exponential(vector: [f64; 3]) -> [f64; 4] {
    let angle = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
    // sin(angle/2)/angle tends to 1/2: no division by zero for a vanishing step.
    let along = if angle > 0.0 { (0.5 * angle).sin() / angle } else { 0.5 };
    let [x, y, z] = vector.map(|c| along * c);
    [(0.5 * angle).cos(), x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_manifold;

    const TURNED: [f64; 4] = [0.6, -0.1, 0.7, -0.5];

    fn unit(q: [f64; 4]) -> [f64; 4] {
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        q.map(|c| c / length)
    }

    #[test]
    fn the_basis_is_the_slope_of_a_step() {
        for q in [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], unit(TURNED), unit(TURNED.map(|c| -c))] {
            check_manifold(&Rotation, &q, 1e-9).unwrap();
        }
    }

    /// Three quarter turns about x, y and x, each about the axis as it stands after the ones before, are one about z: by hand.
    #[test]
    fn a_step_turns_about_axes_that_turn_along() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let mut q = [1.0, 0.0, 0.0, 0.0];
        for step in [[quarter, 0.0, 0.0], [0.0, quarter, 0.0], [-quarter, 0.0, 0.0]] {
            Rotation.retract(&mut q, &step);
        }
        let half = 0.5f64.sqrt();
        assert!(q.iter().zip([half, 0.0, 0.0, half]).all(|(a, b)| (a - b).abs() < 1e-15), "{q:?}");
    }

    #[test]
    fn a_whole_turn_is_minus_the_same_quaternion() {
        let mut q = unit(TURNED);
        Rotation.retract(&mut q, &[0.0, 2.0 * std::f64::consts::PI, 0.0]);
        assert!(q.iter().zip(unit(TURNED)).all(|(a, b)| (a + b).abs() < 1e-14), "{q:?}");
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        assert!(Rotation.check(&unit(TURNED)).is_ok());
        assert!(Rotation.check(&TURNED).unwrap_err().starts_with("is no rotation: a quaternion of length"));
        assert!(Rotation.check(&[1.0, 0.0, 0.0]).unwrap_err().contains("the four numbers of a unit quaternion"));
    }
}
