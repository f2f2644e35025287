//! Whether ten numbers are a rigid body's: the pseudo-inertia.
//!
//! ```text
//!     P = [ E   h ]        E = ∫ r rᵀ dm = ½ tr(I) 1 − I,      P = ∫ [r; 1] [r; 1]ᵀ dm
//!         [ hᵀ  m ]
//! ```
//!
//! Some distribution of positive masses has these ten numbers exactly where P is positive semidefinite; positive definite where it does not
//! lie in a plane (Wensing, Kim and Slotine, *IEEE RA-L* 3, 2018). That is a positive mass, a tensor about the centre of mass with positive
//! principal moments, and these obeying the triangle inequality.

use nalgebra::{Matrix3, Matrix4, Vector3};

use crate::body_inertia::{BodyInertia, matrix, six};

impl BodyInertia {
    /// The body of ten numbers in the order of [`BodyInertia::parameters`].
    pub fn from_parameters([mass, x, y, z, tensor @ ..]: [f64; 10]) -> Self {
        BodyInertia { mass, first_moment: [x, y, z], tensor }
    }

    /// P, rows of a symmetric matrix: kg·m² where both place and place meet, kg·m, and kg in the corner.
    pub fn pseudo_inertia(&self) -> [[f64; 4]; 4] {
        let tensor = matrix(self.tensor);
        let second = Matrix3::identity() * (0.5 * tensor.trace()) - tensor;
        let h = self.first_moment;
        let row = |i: usize| [second[(i, 0)], second[(i, 1)], second[(i, 2)], h[i]];
        [row(0), row(1), row(2), [h[0], h[1], h[2], self.mass]]
    }

    /// Centre of mass, m; no number where the body has no mass.
    pub fn center_of_mass(&self) -> [f64; 3] {
        self.first_moment.map(|moment| moment / self.mass)
    }

    /// The tensor about the centre of mass, along the frame's axes, kg·m²: what [`BodyInertia::about_center`] takes.
    pub fn tensor_about_center(&self) -> [f64; 6] {
        let center = Vector3::from(self.center_of_mass());
        six(&(matrix(self.tensor) - shift(self.mass, &center)))
    }

    /// Least mean square distance of the mass from a plane through its centre, m²: above zero for a body, below where no masses have these
    /// ten numbers. No number without a mass.
    pub fn least_spread(&self) -> f64 {
        self.spread().symmetric_eigenvalues().min()
    }

    /// The same body, but for mean square distances of its mass from planes through its centre below `least`, m², which are raised to that.
    #[must_use]
    pub fn spread_at_least(&self, least: f64) -> Self {
        let eigen = self.spread().symmetric_eigen();
        let raised = eigen.eigenvalues.map(|value| value.max(least));
        let second = eigen.eigenvectors * Matrix3::from_diagonal(&raised) * eigen.eigenvectors.transpose() * self.mass;
        let tensor = Matrix3::identity() * second.trace() - second;
        BodyInertia::about_center(self.mass, self.center_of_mass(), six(&tensor))
    }

    /// `∫ (r − c)(r − c)ᵀ dm / m`.
    fn spread(&self) -> Matrix3<f64> {
        let tensor = matrix(self.tensor_about_center());
        (Matrix3::identity() * (0.5 * tensor.trace()) - tensor) / self.mass
    }
}

/// What moves a tensor from the centre of mass to the origin (Steiner).
fn shift(mass: f64, center: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * center.dot(center) - center * center.transpose()) * mass
}

/// The ten numbers of P, in the order of [`BodyInertia::parameters`].
pub fn parameters_of_pseudo_inertia(pseudo: [[f64; 4]; 4]) -> [f64; 10] {
    let second = Matrix4::from(pseudo).fixed_view::<3, 3>(0, 0).into_owned();
    let tensor = Matrix3::identity() * second.trace() - second;
    let [xx, xy, yy, xz, yz, zz] = [tensor.m11, tensor.m12, tensor.m22, tensor.m13, tensor.m23, tensor.m33];
    [pseudo[3][3], pseudo[0][3], pseudo[1][3], pseudo[2][3], xx, xy, yy, xz, yz, zz]
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [(f64, [f64; 3]); 4] =
        [(1.0, [0.1, 0.2, -0.3]), (2.0, [-0.4, 0.0, 0.5]), (0.5, [0.0, 0.7, 0.1]), (1.5, [0.3, -0.2, 0.0])];

    fn body() -> BodyInertia {
        let points = POINTS.map(|(mass, place)| BodyInertia::about_center(mass, place, [0.0; 6]));
        points.into_iter().fold(BodyInertia::default(), |sum, point| sum + point)
    }

    #[test]
    fn it_is_the_sum_over_the_masses() {
        let mut sum = [[0.0; 4]; 4];
        for (mass, [x, y, z]) in POINTS {
            let place = [x, y, z, 1.0];
            (0..4).for_each(|i| (0..4).for_each(|j| sum[i][j] += mass * place[i] * place[j]));
        }
        let pseudo = body().pseudo_inertia();
        assert!((0..16).all(|k| (pseudo[k / 4][k % 4] - sum[k / 4][k % 4]).abs() < 1e-14), "{pseudo:?} {sum:?}");
        let back = parameters_of_pseudo_inertia(pseudo);
        assert!(back.iter().zip(body().parameters()).all(|(a, b)| (a - b).abs() < 1e-14), "{back:?}");
    }

    #[test]
    fn the_tensor_about_the_centre_leads_back() {
        let body = body();
        let again = BodyInertia::about_center(body.mass, body.center_of_mass(), body.tensor_about_center());
        assert!(again.parameters().iter().zip(body.parameters()).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn four_points_are_a_body_three_are_flat_and_a_broken_triangle_is_none() {
        assert!(body().least_spread() > 1e-3);
        let flat = POINTS[..3].iter().map(|(mass, place)| BodyInertia::about_center(*mass, *place, [0.0; 6]));
        assert!(flat.fold(BodyInertia::default(), |sum, point| sum + point).least_spread().abs() < 1e-14);
        let broken = BodyInertia::about_center(2.0, [0.1, 0.0, 0.2], [0.01, 0.0, 0.01, 0.0, 0.0, 0.05]);
        assert!((broken.least_spread() - (0.01 + 0.01 - 0.05) / 2.0 / 2.0).abs() < 1e-15);
        let raised = broken.spread_at_least(1e-4);
        assert!((raised.least_spread() - 1e-4).abs() < 1e-15, "{raised:?}");
        assert_eq!(raised.mass, 2.0);
        // What is a body is left as it is.
        let same = body().spread_at_least(1e-4);
        assert!(same.parameters().iter().zip(body().parameters()).all(|(a, b)| (a - b).abs() < 1e-14));
    }
}
