//! Vectors of ℝ³ whose length is known.

use super::Manifold;

/// Vectors of ℝ³ with a fixed length, in the unit of the block. Two tangent coordinates, in the same unit.
///
/// A step `d` follows the great circle that leaves `x` in the direction `B d`, by the arc length `‖d‖`; the columns of `B` are
/// orthonormal and perpendicular to `x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The length that every value has.
    pub radius: f64,
}

impl Manifold for Sphere {
    fn name(&self) -> &str {
        "sphere"
    }

    fn tangent_dimension(&self, _stored: usize) -> usize {
        2
    }

    fn retract(&self, x: &mut [f64], step: &[f64]) {
        let radius = self.radius;
        let point = [x[0], x[1], x[2]];
        let [b1, b2] = tangent_basis(point);
        let length = step[0].hypot(step[1]);
        let angle = length / radius;
        // sin(angle)/length tends to 1/radius: no division by zero for a vanishing step.
        let along = if length > 0.0 { radius * angle.sin() / length } else { 1.0 };
        let moved: [f64; 3] =
            std::array::from_fn(|i| angle.cos() * point[i] + along * (step[0] * b1[i] + step[1] * b2[i]));
        let norm = norm(moved);
        x.iter_mut().zip(moved).for_each(|(x, m)| *x = radius * m / norm);
    }

    fn basis(&self, x: &[f64], basis: &mut [f64]) {
        let [b1, b2] = tangent_basis([x[0], x[1], x[2]]);
        basis.copy_from_slice(&[b1[0], b2[0], b1[1], b2[1], b1[2], b2[2]]);
    }

    fn check(&self, x: &[f64]) -> Result<(), String> {
        let radius = self.radius;
        if x.len() != 3 || !(radius.is_finite() && radius > 0.0) {
            return Err(format!(
                "lies on no sphere of radius {radius}: that takes 3 numbers, and a radius that is positive and finite"
            ));
        }
        let norm = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        if (norm - radius).abs() > 1e-9 * radius {
            return Err("does not have the length of its sphere".into());
        }
        Ok(())
    }

    fn radian(&self) -> Option<f64> {
        Some(self.radius)
    }
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Two orthonormal vectors perpendicular to `x`, chosen from the coordinate axis least aligned with it.
fn tangent_basis(x: [f64; 3]) -> [[f64; 3]; 2] {
    let smallest = if x[0].abs() <= x[1].abs() && x[0].abs() <= x[2].abs() {
        0
    } else if x[1].abs() <= x[2].abs() {
        1
    } else {
        2
    };
    let mut axis = [0.0; 3];
    axis[smallest] = 1.0;
    let unit = |v: [f64; 3]| v.map(|c| c / norm(v));
    let b1 = unit(cross(x, axis));
    let b2 = unit(cross(x, b1));
    [b1, b2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_manifold;

    #[test]
    fn steps_keep_the_length_and_follow_the_basis() {
        let sphere = Sphere { radius: 9.8 };
        let start = [-3.43, -5.94, -7.0];
        let scale = 9.8 / norm(start);
        let start = start.map(|c| c * scale);
        check_manifold(&sphere, &start, 1e-9).unwrap();
        for step in [[0.0, 0.0], [1e-6, -2e-6], [3.0, 4.0], [-40.0, 7.0]] {
            let mut x = start;
            sphere.retract(&mut x, &step);
            assert!((norm(x) - 9.8).abs() < 1e-13);
        }
    }

    #[test]
    fn basis_is_orthonormal_for_axes_too() {
        for x in [[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 3.0], [1.0, 1.0, 1.0]] {
            let [b1, b2] = tangent_basis(x);
            let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            assert!(dot(b1, x).abs() < 1e-15 && dot(b2, x).abs() < 1e-15 && dot(b1, b2).abs() < 1e-15);
            assert!((norm(b1) - 1.0).abs() < 1e-15 && (norm(b2) - 1.0).abs() < 1e-15);
        }
    }
}
