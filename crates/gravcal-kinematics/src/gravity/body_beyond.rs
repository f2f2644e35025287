//! What hangs beyond each joint: frames outward, masses and moments inward.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::INERTIA;
use crate::axis_frame::{AxisFrame, Motion};
use crate::chain::{Chain, Run};
use crate::transform::Transform;

/// What hangs beyond one joint, in base coordinates.
#[derive(Clone, Debug)]
pub(super) struct BodyBeyond {
    /// Of the joint, rad or m.
    coordinate: f64,
    motion: Motion,
    /// Whether the link is elsewhere than in the last pose.
    moved: bool,
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
    /// v_i = ∂M/∂q_i of this joint and of every one that carries it, kg·m over rad or m.
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
            coordinate: 0.0,
            motion: Motion::Slide(0.0),
            moved: true,
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

    fn link_pose(&self) -> Transform {
        Transform { rotation: self.link_rotation, translation: self.link_origin }
    }

    #[inline(always)]
    pub fn torque(&self, sensitivity: &Sensitivity) -> f64 {
        sensitivity.to_mass * self.mass + sensitivity.to_moment.dot(&self.moment)
    }

    #[inline(always)]
    pub fn torque_by_gravity(&self) -> Vector3<f64> {
        match self.motion {
            Motion::Turn { .. } => self.moment.cross(&self.axis),
            Motion::Slide(_) => self.axis * -self.mass,
        }
    }
}

/// One body for each link, from one pose to the next.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    all: Vec<BodyBeyond>,
    /// The chain whose links have been placed, by its axes.
    placed: Option<Arc<[AxisFrame]>>,
}

impl Bodies {
    pub fn new(links: usize) -> Self {
        Bodies { all: vec![BodyBeyond::default(); links], placed: None }
    }

    pub fn as_slice(&self) -> &[BodyBeyond] {
        &self.all
    }

    /// Another pose: frames outward, then masses and moments inward. `coordinates`: of each link's mover.
    pub fn sweep(&mut self, chain: &Chain, coordinates: &[f64], inertia: &[f64]) {
        assert_eq!(inertia.len(), INERTIA * chain.link_count(), "four numbers for each link");
        self.place(chain, coordinates);
        gather(chain, inertia, &mut self.all);
    }

    /// Axes and link frames in base coordinates. While one joint sweeps those before it stand: what has not moved since the last
    /// pose is left as it is.
    fn place(&mut self, chain: &Chain, coordinates: &[f64]) {
        let everything = self.placed.as_ref().is_none_or(|placed| !Arc::ptr_eq(placed, &chain.axis_frames));
        if everything {
            self.placed = Some(Arc::clone(&chain.axis_frames));
        }
        let bodies = &mut self.all;
        // All sines first: their branches would hold up the frames.
        for ((frame, &coordinate), body) in chain.axis_frames.iter().zip(coordinates).zip(&mut *bodies) {
            body.moved = everything || body.coordinate.to_bits() != coordinate.to_bits();
            if body.moved {
                body.coordinate = coordinate;
                body.motion = frame.motion(coordinate);
            }
        }
        for Run { links, parent } in &chain.topology.runs {
            let (mut link, mut moved) = match parent {
                Some(parent) => (bodies[*parent].link_pose(), bodies[*parent].moved),
                None => (Transform::identity(), false),
            };
            for (frame, body) in chain.axis_frames[links.clone()].iter().zip(&mut bodies[links.clone()]) {
                moved |= body.moved;
                body.moved = moved;
                if !moved {
                    link = body.link_pose();
                    continue;
                }
                let at_rest = frame.at_rest(&link);
                link = frame.link_pose(&at_rest, body.motion);
                body.axis = at_rest.rotation.column(2).into_owned();
                body.point = at_rest.translation;
                body.link_rotation = link.rotation;
                body.link_origin = link.translation;
            }
        }
    }
}

/// Masses and first moments, each about its own axis point, from the tips to the base.
fn gather(chain: &Chain, inertia: &[f64], bodies: &mut [BodyBeyond]) {
    let runs = &chain.topology.runs;
    for (index, Run { links, .. }) in runs.iter().enumerate().rev() {
        let last = links.end - 1;
        let mut about = bodies[last].point;
        let mut mass = 0.0;
        let mut moment = Vector3::zeros();
        for branch in runs[index + 1..].iter().filter(|run| run.parent == Some(last)) {
            let first = &bodies[branch.links.start];
            mass += first.mass;
            moment += first.moment + (first.point - about) * first.mass;
        }
        let own = inertia[INERTIA * links.start..INERTIA * links.end].chunks_exact(INERTIA);
        for (body, own) in bodies[links.clone()].iter_mut().zip(own).rev() {
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
}
