//! Gravity from sweeps of one joint at several positions of the joints before it.
//!
//! With the measured `d_j = a_j − i c_j` of sweep j, equations (12)–(13) of the paper are
//!
//! ```text
//!     u_j + i v_j = κ d_j,     (u_j, v_j) = x and y of gravity in the swept joint's axis frame, linear in g
//! ```
//!
//! with one unknown complex κ for all j: homogeneous and linear in `(g, κ_r, κ_i)`, solved by the smallest
//! singular vector.

use faer::Mat;
use nalgebra::{Complex, Vector3};

/// What one sweep says of gravity's direction.
#[derive(Clone, Debug)]
pub(crate) struct SweepDirection {
    /// Rows that give u and v from gravity in the base.
    pub u: Vector3<f64>,
    /// See `u`.
    pub v: Vector3<f64>,
    /// `a − i c` in the unit of the torque reading.
    pub measured: Complex<f64>,
    /// Standard deviation of `a` and `c`, in that unit.
    pub std: f64,
}

/// Gravity's direction and how well the sweeps determine it.
#[derive(Clone, Debug)]
pub(crate) struct GravityStart {
    /// Unit vector in base coordinates, in the given hemisphere.
    pub direction: Vector3<f64>,
    /// `(p, q)` of the lumped moment for gravity of unit length, where `a − i c = (p − i q) (u + i v)`: unit of the torque reading.
    pub moment: [f64; 2],
    /// Predicted standard deviation of the direction, rad; good within a factor of 2.
    pub direction_std: f64,
}

/// Solves for the direction of gravity. `None` with fewer than two sweeps, or no signal in any.
pub(crate) fn gravity_from_sweeps(sweeps: &[SweepDirection], hemisphere: Vector3<f64>) -> Option<GravityStart> {
    let largest = sweeps.iter().map(|s| s.measured.norm()).fold(0.0, f64::max);
    if sweeps.len() < 2 || largest == 0.0 {
        return None;
    }
    // Never fewer rows than the five unknowns, so that the smallest singular vectors all come out.
    let mut system = Mat::<f64>::zeros((2 * sweeps.len()).max(5), 5);
    for (j, sweep) in sweeps.iter().enumerate() {
        let d = sweep.measured / largest;
        for axis in 0..3 {
            system[(2 * j, axis)] = sweep.u[axis];
            system[(2 * j + 1, axis)] = sweep.v[axis];
        }
        // κ d = (κ_r d_r − κ_i d_i) + i (κ_r d_i + κ_i d_r)
        system[(2 * j, 3)] = -d.re;
        system[(2 * j, 4)] = d.im;
        system[(2 * j + 1, 3)] = -d.im;
        system[(2 * j + 1, 4)] = -d.re;
    }
    let svd = system.svd().ok()?;
    let gravity = Vector3::new(svd.V()[(0, 4)], svd.V()[(1, 4)], svd.V()[(2, 4)]);
    let direction = gravity.try_normalize(1e-12)?;
    let direction = if direction.dot(&hemisphere) < 0.0 { -direction } else { direction };
    let beyond = |s: &SweepDirection| Complex::new(s.u.dot(&direction), s.v.dot(&direction));
    let product: Complex<f64> = sweeps.iter().map(|s| beyond(s).conj() * s.measured).sum();
    let moment = product / sweeps.iter().map(|s| beyond(s).norm_sqr()).sum::<f64>();
    let std = sweeps.iter().map(|s| s.std).fold(0.0, f64::max);
    Some(GravityStart {
        direction,
        moment: [moment.re, -moment.im],
        direction_std: std / (largest * svd.S()[3].max(f64::MIN_POSITIVE)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Joint 1 about z at `angle`, twist +90°, as in the paper's eq. (11).
    fn sweep(angle: f64, gravity: Vector3<f64>) -> SweepDirection {
        let u = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let v = Vector3::z();
        let signal = Complex::new(u.dot(&gravity), v.dot(&gravity));
        SweepDirection { u, v, measured: signal * Complex::new(3.0, -1.2), std: 0.1 }
    }

    #[test]
    fn two_positions_give_a_tilted_gravity() {
        let gravity = Vector3::new(-3.43, -5.94, -7.0).normalize();
        let start = gravity_from_sweeps(&[sweep(-0.6, gravity), sweep(0.9, gravity)], -Vector3::z()).unwrap();
        assert!((start.direction - gravity).amax() < 1e-12);
        assert!((start.moment[0] - 3.0).abs() < 1e-12 && (start.moment[1] - 1.2).abs() < 1e-12);
        assert!(start.direction_std < 0.1);
    }

    #[test]
    fn an_upright_base_needs_a_third_position() {
        let upright = -Vector3::z();
        let two = gravity_from_sweeps(&[sweep(-0.6, upright), sweep(0.9, upright)], upright).unwrap();
        assert!(two.direction_std > 1e6);
        let three = [sweep(-0.6, upright), sweep(0.9, upright), sweep(2.0, upright)];
        let three = gravity_from_sweeps(&three, upright).unwrap();
        assert!(three.direction_std < 0.2 && (three.direction - upright).amax() < 1e-9);
    }

    #[test]
    fn positions_a_multiple_of_pi_apart_are_one_position() {
        let gravity = Vector3::new(-3.43, -5.94, -7.0).normalize();
        let start = gravity_from_sweeps(&[sweep(0.3, gravity), sweep(0.3 + std::f64::consts::PI, gravity)], gravity);
        assert!(start.unwrap().direction_std > 1e6);
    }
}
