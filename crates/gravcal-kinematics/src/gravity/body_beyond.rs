//! What hangs beyond each joint: frames outward, masses and moments inward.

use nalgebra::{Matrix3, Vector3};

use super::INERTIA;
use crate::axis_frame::Motion;
use crate::chain::Chain;
use crate::transform::Transform;

/// What hangs beyond one joint, in base coordinates.
#[derive(Clone, Debug)]
pub(super) struct BodyBeyond {
    motion: Motion,
    /// z_i.
    pub axis: Vector3<f64>,
    /// o_i, m.
    pub point: Vector3<f64>,
    /// R_k of the joint's own link.
    pub link_rotation: Matrix3<f64>,
    /// p_k of the joint's own link, m.
    pub link_origin: Vector3<f64>,
    /// m_i⁺, kg.
    pub mass: f64,
    /// M_i, kg·m.
    pub moment: Vector3<f64>,
    /// v_i = ∂M/∂q_i of this joint and of every one before it, kg·m over rad or m.
    pub moment_rate: Vector3<f64>,
}

/// The torque as a linear function of what hangs beyond the joint: `τ = to_mass · m⁺ + to_moment · M`.
pub(super) struct Sensitivity {
    /// u_i, m/s².
    pub to_mass: f64,
    /// w_i, m/s².
    pub to_moment: Vector3<f64>,
}

impl Default for BodyBeyond {
    fn default() -> Self {
        BodyBeyond {
            motion: Motion::Slide(0.0),
            axis: Vector3::zeros(),
            point: Vector3::zeros(),
            link_rotation: Matrix3::zeros(),
            link_origin: Vector3::zeros(),
            mass: 0.0,
            moment: Vector3::zeros(),
            moment_rate: Vector3::zeros(),
        }
    }
}

impl BodyBeyond {
    #[inline(always)]
    pub fn sensitivity(&self, gravity: &Vector3<f64>) -> Sensitivity {
        match self.motion {
            Motion::Turn { .. } => Sensitivity { to_mass: 0.0, to_moment: self.axis.cross(gravity) },
            Motion::Slide(_) => Sensitivity { to_mass: -gravity.dot(&self.axis), to_moment: Vector3::zeros() },
        }
    }

    pub fn torque(&self, sensitivity: &Sensitivity) -> f64 {
        sensitivity.to_mass * self.mass + sensitivity.to_moment.dot(&self.moment)
    }

    pub fn torque_by_gravity(&self) -> Vector3<f64> {
        match self.motion {
            Motion::Turn { .. } => self.moment.cross(&self.axis),
            Motion::Slide(_) => self.axis * -self.mass,
        }
    }
}

/// Fills `bodies`: frames outward, then masses and moments inward.
pub(super) fn sweep(chain: &Chain, coordinates: &[f64], inertia: &[f64], bodies: &mut [BodyBeyond]) {
    assert_eq!(coordinates.len(), chain.joint_count(), "one coordinate for each joint");
    assert_eq!(inertia.len(), INERTIA * chain.joint_count(), "four numbers for each link");
    place(chain, coordinates, bodies);
    gather(inertia, bodies);
}

/// Axes and link frames in base coordinates.
fn place(chain: &Chain, coordinates: &[f64], bodies: &mut [BodyBeyond]) {
    // All sines first: their branches would hold up the frames.
    for ((frame, &coordinate), body) in chain.axis_frames.iter().zip(coordinates).zip(&mut *bodies) {
        body.motion = frame.motion(coordinate);
    }
    let mut link = Transform::identity();
    for (frame, body) in chain.axis_frames.iter().zip(bodies) {
        let at_rest = frame.at_rest(&link);
        link = frame.link_pose(&at_rest, body.motion);
        body.axis = at_rest.rotation.column(2).into_owned();
        body.point = at_rest.translation;
        body.link_rotation = link.rotation;
        body.link_origin = link.translation;
    }
}

/// Masses and first moments, each about its own axis point, from the tip to the base.
fn gather(inertia: &[f64], bodies: &mut [BodyBeyond]) {
    let mut mass = 0.0;
    let mut moment = Vector3::zeros();
    let mut about = Vector3::zeros();
    for (body, own) in bodies.iter_mut().zip(inertia.chunks_exact(INERTIA)).rev() {
        moment += (about - body.point) * mass;
        about = body.point;
        mass += own[0];
        moment += (body.link_origin - body.point) * own[0];
        moment += body.link_rotation * Vector3::new(own[1], own[2], own[3]);
        body.mass = mass;
        body.moment = moment;
        body.moment_rate = match body.motion {
            Motion::Turn { .. } => body.axis.cross(&moment),
            Motion::Slide(_) => body.axis * mass,
        };
    }
}
