//! What hangs beyond each joint: frames outward, masses and moments inward.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::INERTIA;
use crate::arithmetic::{Arithmetic, Stored, columns, cross, dot, matrix, times};
use crate::axis_frame::{AxisFrame, Motion};
use crate::chain::{Chain, Run};
use crate::frame::{Frame, constant, load, store};
use crate::transform::Transform;

/// What hangs beyond one joint, in base coordinates, as it lies in memory.
#[derive(Clone, Debug)]
pub(crate) struct BodyBeyond<L> {
    /// Of the joint, rad or m.
    coordinate: L,
    motion: Motion<L>,
    /// Whether the link is elsewhere than in the last pose.
    moved: bool,
    /// z_i.
    axis: Vector3<L>,
    /// o_i, m.
    point: Vector3<L>,
    /// R_k of the joint's own link.
    link_rotation: Matrix3<L>,
    /// p_k of the joint's own link, m.
    link_origin: Vector3<L>,
    /// m_i⁺, kg.
    mass: f64,
    /// M_i, kg·m.
    moment: Vector3<L>,
    /// v_i = ∂M/∂q_i of this joint and of every one that carries it, kg·m over rad or m.
    moment_rate: Vector3<L>,
}

/// The torque as a linear function of what hangs beyond the joint: `τ = to_mass · m⁺ + to_moment · M`.
pub(super) struct Sensitivity<N> {
    /// u_i, m/s².
    pub to_mass: N,
    /// w_i, m/s².
    pub to_moment: Vector3<N>,
}

impl<L: Stored> BodyBeyond<L> {
    fn nowhere() -> Self {
        let zero = Vector3::new(L::ZERO, L::ZERO, L::ZERO);
        BodyBeyond {
            coordinate: L::ZERO,
            motion: Motion::Slide(L::ZERO),
            moved: true,
            axis: zero,
            point: zero,
            link_rotation: matrix(zero, zero, zero),
            link_origin: zero,
            mass: 0.0,
            moment: zero,
            moment_rate: zero,
        }
    }

    #[inline(always)]
    pub(super) fn sensitivity<A: Arithmetic<Stored = L>>(
        &self,
        on: A,
        gravity: &Vector3<A::Number>,
    ) -> Sensitivity<A::Number> {
        let axis = load(on, &self.axis);
        match self.motion {
            Motion::Turn { .. } => Sensitivity { to_mass: on.constant(0.0), to_moment: cross(&axis, gravity) },
            Motion::Slide(_) => {
                Sensitivity { to_mass: -dot(gravity, &axis), to_moment: constant(on, &Vector3::zeros()) }
            }
        }
    }

    /// z_i and o_i; no point where the joint slides.
    #[inline(always)]
    pub fn axis<A: Arithmetic<Stored = L>>(&self, on: A) -> (Vector3<A::Number>, Option<Vector3<A::Number>>) {
        let point = match self.motion {
            Motion::Turn { .. } => Some(load(on, &self.point)),
            Motion::Slide(_) => None,
        };
        (load(on, &self.axis), point)
    }

    /// R_k and p_k.
    #[inline(always)]
    pub fn link_pose<A: Arithmetic<Stored = L>>(&self, on: A) -> Frame<A::Number> {
        let [x, y, z] = self.link_axes(on);
        Frame { rotation: matrix(x, y, z), translation: load(on, &self.link_origin) }
    }

    /// The columns of R_k.
    #[inline(always)]
    pub fn link_axes<A: Arithmetic<Stored = L>>(&self, on: A) -> [Vector3<A::Number>; 3] {
        let [x, y, z] = columns(&self.link_rotation);
        [load(on, &x), load(on, &y), load(on, &z)]
    }

    /// p_k − o, m.
    #[inline(always)]
    pub fn link_origin_from<A: Arithmetic<Stored = L>>(&self, on: A, point: &BodyBeyond<L>) -> Vector3<A::Number> {
        load(on, &self.link_origin) - load(on, &point.point)
    }

    /// v_i.
    #[inline(always)]
    pub fn moment_rate<A: Arithmetic<Stored = L>>(&self, on: A) -> Vector3<A::Number> {
        load(on, &self.moment_rate)
    }

    #[inline(always)]
    pub(super) fn torque<A: Arithmetic<Stored = L>>(&self, on: A, sensitivity: &Sensitivity<A::Number>) -> A::Number {
        sensitivity.to_mass * on.constant(self.mass) + dot(&sensitivity.to_moment, &load(on, &self.moment))
    }

    #[inline(always)]
    pub fn torque_by_gravity<A: Arithmetic<Stored = L>>(&self, on: A) -> Vector3<A::Number> {
        let axis = load(on, &self.axis);
        match self.motion {
            Motion::Turn { .. } => cross(&load(on, &self.moment), &axis),
            Motion::Slide(_) => axis * on.constant(-self.mass),
        }
    }
}

/// What hangs beyond each joint of a chain: a workspace of [`Chain::gravity_torque_rows`], to be reused from one pose to the next
/// (`L = f64`), or from some batched poses to the next (`L = [f64; LANES]`).
#[derive(Clone, Debug)]
pub struct Bodies<L = f64> {
    all: Vec<BodyBeyond<L>>,
    /// The chain whose links have been placed, by its axes.
    placed: Option<Arc<[AxisFrame]>>,
}

impl<L: Stored> Bodies<L> {
    /// For a chain of so many links ([`Chain::link_count`]).
    pub fn new(links: usize) -> Self {
        Bodies { all: vec![BodyBeyond::nowhere(); links], placed: None }
    }

    pub(crate) fn as_slice(&self) -> &[BodyBeyond<L>] {
        &self.all
    }

    /// Another pose: frames outward, then masses and moments inward. `coordinates`: of each link's mover.
    #[inline(always)]
    pub(super) fn sweep<A: Arithmetic<Stored = L>>(
        &mut self,
        on: A,
        chain: &Chain,
        coordinates: &[L],
        inertia: &[f64],
    ) {
        assert_eq!(inertia.len(), INERTIA * chain.link_count(), "four numbers for each link");
        self.place(on, chain, coordinates);
        gather(on, chain, inertia, &mut self.all);
    }

    /// Axes and link frames in base coordinates. While one joint sweeps those before it stand: what has not moved since the last
    /// pose is left as it is.
    #[inline(always)]
    pub(crate) fn place<A: Arithmetic<Stored = L>>(&mut self, on: A, chain: &Chain, coordinates: &[L]) {
        let everything = self.placed.as_ref().is_none_or(|placed| !Arc::ptr_eq(placed, &chain.axis_frames));
        if everything {
            self.placed = Some(Arc::clone(&chain.axis_frames));
        }
        let bodies = &mut self.all;
        // All sines first: their branches would hold up the frames.
        for ((frame, &coordinate), body) in chain.axis_frames.iter().zip(coordinates).zip(&mut *bodies) {
            body.moved = everything || !body.coordinate.same(coordinate);
            if body.moved {
                body.coordinate = coordinate;
                body.motion = frame.motion(coordinate);
            }
        }
        for Run { links, parent } in &chain.topology.runs {
            let (mut link, mut moved) = match parent {
                Some(parent) => (bodies[*parent].link_pose(on), bodies[*parent].moved),
                None => (Frame::constant(on, &Transform::identity()), false),
            };
            for (frame, body) in chain.axis_frames[links.clone()].iter().zip(&mut bodies[links.clone()]) {
                moved |= body.moved;
                body.moved = moved;
                if !moved {
                    link = body.link_pose(on);
                    continue;
                }
                let at_rest = frame.at_rest(on, &link);
                link = frame.link_pose(on, &at_rest, &body.motion);
                body.axis = store(on, &columns(&at_rest.rotation)[2]);
                body.point = store(on, &at_rest.translation);
                let [x, y, z] = columns(&link.rotation);
                body.link_rotation = matrix(store(on, &x), store(on, &y), store(on, &z));
                body.link_origin = store(on, &link.translation);
            }
        }
    }
}

/// Masses and first moments, each about its own axis point, from the tips to the base.
#[inline(always)]
fn gather<A: Arithmetic>(on: A, chain: &Chain, inertia: &[f64], bodies: &mut [BodyBeyond<A::Stored>]) {
    let runs = &chain.topology.runs;
    for (index, Run { links, .. }) in runs.iter().enumerate().rev() {
        let last = links.end - 1;
        let mut about = load(on, &bodies[last].point);
        let mut mass = 0.0;
        let mut moment = constant(on, &Vector3::zeros());
        for branch in runs[index + 1..].iter().filter(|run| run.parent == Some(last)) {
            let first = &bodies[branch.links.start];
            mass += first.mass;
            moment += load(on, &first.moment) + (load(on, &first.point) - about) * on.constant(first.mass);
        }
        let own = inertia[INERTIA * links.start..INERTIA * links.end].as_chunks::<INERTIA>().0;
        for (body, [own_mass, own_moment @ ..]) in bodies[links.clone()].iter_mut().zip(own).rev() {
            let point = load(on, &body.point);
            moment += (about - point) * on.constant(mass);
            about = point;
            mass += own_mass;
            let link = body.link_pose(on);
            moment += (link.translation - point) * on.constant(*own_mass);
            moment += times(&link.rotation, &constant(on, &Vector3::from(*own_moment)));
            body.mass = mass;
            body.moment = store(on, &moment);
            let axis = load(on, &body.axis);
            body.moment_rate = store(
                on,
                &match body.motion {
                    Motion::Turn { .. } => cross(&axis, &moment),
                    Motion::Slide(_) => axis * on.constant(mass),
                },
            );
        }
    }
}
