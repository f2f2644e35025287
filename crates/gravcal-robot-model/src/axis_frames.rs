//! Gravity seen from one joint's axis after the other: what the paper's steps need of a robot.
//!
//! With `C_i` the constant rotation from one axis frame to the next (standard DH: `Rot_x(α_i)`), gravity moves out
//! along the chain as
//!
//! ```text
//!     g_{i+1} = C_iᵀ Rot_z(−θ_i) g_i        (paper, eqs. (1), (11))
//! ```
//!
//! No length enters.

use nalgebra::{Matrix3, Vector3};

/// A vector in an axis frame, with its derivatives by the quantities it came from.
#[derive(Clone, Debug)]
pub struct Moved {
    /// The vector.
    pub value: Vector3<f64>,
    /// Its derivatives: three by the components it started from, then one by each coordinate it was turned by.
    pub derivatives: Vec<Vector3<f64>>,
}

impl Moved {
    /// A vector that depends on itself.
    fn start(value: Vector3<f64>) -> Self {
        let derivatives = Matrix3::identity().column_iter().map(Into::into).collect();
        Moved { value, derivatives }
    }

    fn map(&mut self, f: impl Fn(&Vector3<f64>) -> Vector3<f64>) {
        self.value = f(&self.value);
        self.derivatives.iter_mut().for_each(|d| *d = f(d));
    }

    /// `v ← Cᵀ Rot_z(−θ) v`, and a new derivative by `θ`.
    pub fn step(&mut self, coordinate: f64, constant: &Matrix3<f64>) {
        let (sin, cos) = coordinate.sin_cos();
        let turn = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        self.map(|v| turn * v);
        self.derivatives.push(-Vector3::z().cross(&self.value));
        self.map(|v| constant.tr_mul(v));
    }

    /// `v ← z × v`.
    pub fn cross_z(&mut self) {
        self.map(|v| Vector3::z().cross(v));
    }
}

/// The directions of a chain's axes.
#[derive(Clone, Debug)]
pub struct AxisFrames {
    constants: Vec<Matrix3<f64>>,
}

impl AxisFrames {
    /// `rotations`: base to the first axis frame, then from each axis frame to the next, row-major.
    pub fn new(rotations: &[[[f64; 3]; 3]]) -> Self {
        let constants = rotations.iter().map(|r| Matrix3::from_fn(|i, j| r[i][j])).collect();
        AxisFrames { constants }
    }

    /// The constant rotation from the axis frame of `joint` to that of the next joint.
    pub fn to_next(&self, joint: usize) -> &Matrix3<f64> {
        &self.constants[joint + 1]
    }

    /// Gravity in the axis frame of joint `coordinates.len()`, the joints before it at `coordinates`.
    pub fn gravity(&self, gravity: &[f64], coordinates: &[f64]) -> Moved {
        let mut moved = Moved::start(Vector3::from_column_slice(gravity));
        moved.map(|v| self.constants[0].tr_mul(v));
        for (coordinate, constant) in coordinates.iter().zip(&self.constants[1..]) {
            moved.step(*coordinate, constant);
        }
        moved
    }
}
