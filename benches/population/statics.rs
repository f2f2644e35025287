//! The torques that carry an arm, from first principles: nothing here is shared with what is judged.
//!
//! Joint j turns about the unit axis `a_j` through the point `p_j`; link l has the mass `m_l` and the first moment `c_l` in its own
//! frame, of which `R_l` and `p_l` are the pose. All in base coordinates, where gravity is `g`:
//!
//! ```text
//!     T_l = T_(l−1) · before_l · rotation(axis_l, θ_l)                       pose of link l
//!     τ_j = − a_j · Σ_(l ≥ j) [R_l c_l + m_l (p_l − p_j)] × g                moments of the weights beyond the joint
//! ```
//!
//! Numbers are complex, so that a derivative is the imaginary part of what a tiny imaginary step does: exact to rounding.

use nalgebra::{Complex, Isometry3, Matrix3, Vector3};

/// A number with the trace of a step in one unknown.
pub type Number = Complex<f64>;

/// A joint and the link that it moves.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// The joint's frame at coordinate zero in the frame of the link before.
    pub before: Isometry3<f64>,
    /// Unit vector in the joint's frame.
    pub axis: Vector3<f64>,
    /// How far it turns, rad.
    pub limits: [f64; 2],
    /// Mass, kg, and first moment, kg·m, of everything that the joint moves and the next one does not, in the link's frame.
    pub body: [f64; 4],
}

/// Where a joint and its link are, in base coordinates.
struct Place {
    rotation: Matrix3<Number>,
    origin: Vector3<Number>,
    axis: Vector3<Number>,
}

/// The torque of each joint. `bodies`: mass and first moment of each link.
pub fn torques(joints: &[Joint], angles: &[Number], gravity: &Vector3<Number>, bodies: &[[Number; 4]]) -> Vec<Number> {
    let places = places(joints, angles);
    let beyond = |joint: usize| places.iter().zip(bodies).skip(joint);
    let torque = |(joint, place): (usize, &Place)| {
        let moment = beyond(joint).fold(Vector3::zeros(), |sum, (link, [mass, x, y, z])| {
            sum + link.rotation * Vector3::new(*x, *y, *z) + (link.origin - place.origin) * *mass
        });
        -place.axis.dot(&moment.cross(gravity))
    };
    places.iter().enumerate().map(torque).collect()
}

/// Gravity in a frame that the last link carries.
pub fn gravity_at(
    joints: &[Joint],
    angles: &[Number],
    gravity: &Vector3<Number>,
    frame: &Isometry3<f64>,
) -> Vector3<Number> {
    let link = places(joints, angles).pop().map_or_else(Matrix3::identity, |place| place.rotation);
    let rotation = link * frame.rotation.to_rotation_matrix().into_inner().map(Number::from);
    rotation.transpose() * gravity
}

fn places(joints: &[Joint], angles: &[Number]) -> Vec<Place> {
    let (mut rotation, mut origin) = (Matrix3::identity(), Vector3::zeros());
    let place = |(joint, angle): (&Joint, &Number)| {
        origin += rotation * complex(&joint.before.translation.vector);
        rotation *= joint.before.rotation.to_rotation_matrix().into_inner().map(Number::from);
        let axis = rotation * complex(&joint.axis);
        rotation *= turned(&joint.axis, *angle);
        Place { rotation, origin, axis }
    };
    joints.iter().zip(angles).map(place).collect()
}

/// Rodrigues' rotation about a unit axis.
fn turned(axis: &Vector3<f64>, angle: Number) -> Matrix3<Number> {
    let cross = axis.cross_matrix();
    let [once, twice] = [cross, cross * cross].map(|matrix| matrix.map(Number::from));
    Matrix3::identity() + once * angle.sin() + twice * (Number::from(1.0) - angle.cos())
}

/// The same vector as numbers without a step.
pub fn complex(vector: &Vector3<f64>) -> Vector3<Number> {
    vector.map(Number::from)
}
