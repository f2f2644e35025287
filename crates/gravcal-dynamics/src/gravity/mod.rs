//! Holding torque against gravity, and all its first derivatives.
//!
//! With link k at `p_k` with rotation `R_k` in base coordinates, mass `m_k` and first moment `h_k` in its own frame, a
//! point `o_i` and the direction `z_i` of axis i, what hangs beyond axis i has the mass and the first moment about `o_i`
//!
//! ```text
//!     m_i⁺ = Σ_{k ≥ i} m_k,      M_i = Σ_{k ≥ i} [ m_k (p_k − o_i) + R_k h_k ]
//! ```
//!
//! where `k ≥ i` means: axis i moves link k, which in a branched chain are the links of its branch from there on. And the joint holds it with
//!
//! ```text
//!     τ_i = z_i · (g × M_i) = (z_i × g) · M_i     revolute, N·m
//!     f_i = −(g · z_i) m_i⁺                       prismatic, N
//! ```
//!
//! the derivative of the potential energy `−Σ g · (m_k p_k + R_k h_k)` with respect to the joint's coordinate. Both are
//! `u_i m_i⁺ + w_i · M_i` with `(u, w) = (0, z × g)` or `(−g · z, 0)`; so, with `v_j = ∂M_i/∂q_j` for j ≥ i, which is
//! `z_j × M_j` (revolute) or `m_j⁺ z_j` (prismatic), everything else follows:
//!
//! ```text
//!     ∂τ_i/∂q_j = ∂τ_j/∂q_i = w_i · v_j,  j ≥ i        (second derivative of the energy, hence symmetric)
//!     ∂τ_i/∂g   = M_i × z_i   or  −m_i⁺ z_i
//!     ∂τ_i/∂m_k = u_i + w_i · (p_k − o_i),  ∂τ_i/∂h_k = R_kᵀ w_i,  k ≥ i
//! ```
//!
//! and all of it is zero for axes and links on different branches. One sweep outward for the frames and one inward for the
//! sums, then n² products. Where joints mimic others, see `../coupled.rs`.

mod body_beyond;

use std::ops::Range;

pub use body_beyond::Bodies;
pub(crate) use body_beyond::BodyBeyond;
use body_beyond::Sensitivity;
use nalgebra::Vector3;

use crate::arithmetic::{Arithmetic, Single, dot};
use crate::chain::{Chain, Drive};
use crate::coupled;
use crate::frame::constant;

/// Numbers of one link's inertia: mass and three components of the first moment.
pub(crate) const INERTIA: usize = 4;

/// The holding torques of one pose with their derivatives, all row-major; a workspace to be reused.
///
/// n is the number of joints that have a coordinate of their own, l that of links. `torque`, and every derivative, is in N·m (N for a prismatic joint) over the unit of what
/// it is derived by.
#[derive(Clone, Debug)]
pub struct GravityTorque {
    /// Holding torques, n.
    pub torque: Vec<f64>,
    /// By the joint coordinates (rad or m), n × n, symmetric.
    pub by_coordinate: Vec<f64>,
    /// By gravity in base coordinates (m/s²), n × 3.
    pub by_gravity: Vec<f64>,
    /// By the links' `[mass, h_x, h_y, h_z]` (kg, kg·m in link coordinates), n × 4l: the gravity regressor. Zero for
    /// links that the joint does not move.
    pub by_inertia: Vec<f64>,
    bodies: Bodies,
    /// The same by axes, where some joints mimic others.
    axes: Option<Box<Axes>>,
}

/// What is computed by axes before it is by joints.
#[derive(Clone, Debug)]
struct Axes {
    coordinates: Vec<f64>,
    torque: GravityTorque,
}

impl Axes {
    /// `θ = A q + c`.
    fn spread(&mut self, drives: &[Drive], coordinates: &[f64]) {
        for (own, drive) in self.coordinates.iter_mut().zip(drives) {
            *own = drive.coordinate(coordinates);
        }
    }
}

impl GravityTorque {
    /// A workspace for a chain of that many joints and links ([`Chain::joint_count`], [`Chain::link_count`]), all zero.
    pub fn new(joint_count: usize, link_count: usize) -> Self {
        let axes = || Axes { coordinates: vec![0.0; link_count], torque: GravityTorque::new(link_count, link_count) };
        GravityTorque {
            torque: vec![0.0; joint_count],
            by_coordinate: vec![0.0; joint_count * joint_count],
            by_gravity: vec![0.0; joint_count * 3],
            by_inertia: vec![0.0; joint_count * link_count * INERTIA],
            bodies: Bodies::new(link_count),
            axes: (link_count > joint_count).then(|| Box::new(axes())),
        }
    }

    /// Everything by joints, from everything by axes.
    fn gather(&mut self, drives: &[Drive], axes: &GravityTorque) {
        coupled::gather(Single, drives, &axes.torque, &mut self.torque);
        coupled::gather(Single, drives, &axes.by_gravity, &mut self.by_gravity);
        coupled::gather(Single, drives, &axes.by_inertia, &mut self.by_inertia);
        coupled::gather_both(Single, drives, &axes.by_coordinate, &mut self.by_coordinate);
    }

    fn assert_size(&self, n: usize, links: usize) {
        assert_eq!(self.torque.len(), n, "one torque for each joint");
        assert_eq!(self.by_coordinate.len(), n * n, "n × n derivatives by coordinates");
        assert_eq!(self.by_gravity.len(), n * 3, "n × 3 derivatives by gravity");
        assert_eq!(self.by_inertia.len(), n * links * INERTIA, "n × 4l derivatives by inertia");
        assert_eq!(self.bodies.as_slice().len(), links, "a workspace for as many links as the chain has");
    }
}

impl Chain {
    /// Holding torque of every joint, N·m (N for a prismatic joint), without derivatives.
    ///
    /// `coordinates`: n, rad or m. `gravity`: m/s² in base coordinates. `inertia`: 4 numbers a link, `[mass, h_x, h_y,
    /// h_z]` in kg and kg·m in link coordinates. `torque`: n, overwritten.
    ///
    /// # Panics
    ///
    /// When a slice has another length.
    pub fn gravity_torque(&self, coordinates: &[f64], gravity: [f64; 3], inertia: &[f64], torque: &mut [f64]) {
        assert_eq!(torque.len(), self.joint_count(), "one torque for each joint");
        let mut bodies = Bodies::new(self.link_count());
        bodies.sweep(Single, self, &self.axis_coordinates(coordinates), inertia);
        match &self.drives {
            None => torques(bodies.as_slice(), gravity, torque),
            Some(drives) => {
                let mut by_axis = vec![0.0; self.link_count()];
                torques(bodies.as_slice(), gravity, &mut by_axis);
                coupled::gather(Single, drives, &by_axis, torque);
            }
        }
    }

    /// Holding torques into `out.torque`; the derivatives there stay as they are. For the rest see
    /// [`Chain::gravity_torque`], to whose torques these are equal to the bit. Allocates nothing.
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `out` was made for another number of joints.
    pub fn update_gravity_torque(
        &self,
        coordinates: &[f64],
        gravity: [f64; 3],
        inertia: &[f64],
        out: &mut GravityTorque,
    ) {
        assert_eq!(coordinates.len(), self.joint_count(), "one coordinate for each joint");
        out.assert_size(self.joint_count(), self.link_count());
        if let (Some(drives), Some(axes)) = (&self.drives, &mut out.axes) {
            axes.spread(drives, coordinates);
            axes.torque.bodies.sweep(Single, self, &axes.coordinates, inertia);
            torques(axes.torque.bodies.as_slice(), gravity, &mut axes.torque.torque);
            coupled::gather(Single, drives, &axes.torque.torque, &mut out.torque);
        } else {
            out.bodies.sweep(Single, self, coordinates, inertia);
            torques(out.bodies.as_slice(), gravity, &mut out.torque);
        }
    }

    /// Holding torques and their derivatives; see [`GravityTorque`] for shapes, [`Chain::gravity_torque`] for the rest.
    ///
    /// Allocates nothing. The torques are bit for bit those of [`Chain::gravity_torque`].
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `out` was made for another number of joints.
    pub fn linearize_gravity_torque(
        &self,
        coordinates: &[f64],
        gravity: [f64; 3],
        inertia: &[f64],
        out: &mut GravityTorque,
    ) {
        assert_eq!(coordinates.len(), self.joint_count(), "one coordinate for each joint");
        out.assert_size(self.joint_count(), self.link_count());
        if let (Some(drives), Some(mut axes)) = (&self.drives, out.axes.take()) {
            axes.spread(drives, coordinates);
            self.linearize_axes(&axes.coordinates, gravity, inertia, &mut axes.torque);
            out.gather(drives, &axes.torque);
            out.axes = Some(axes);
        } else {
            self.linearize_axes(coordinates, gravity, inertia, out);
        }
    }

    /// The same joint by joint, of one pose or of several at once. Nothing where joints mimic others: their rows are sums.
    ///
    /// `coordinates`: of each joint, rad or m; gravity and inertia are those of all poses. `bodies` is a workspace to be reused.
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `bodies` was made for another number of links.
    #[inline(always)]
    pub fn gravity_torque_rows<'a, A: Arithmetic>(
        &'a self,
        on: A,
        coordinates: &[A::Stored],
        gravity: [f64; 3],
        inertia: &[f64],
        bodies: &'a mut Bodies<A::Stored>,
    ) -> Option<GravityTorqueRows<'a, A>> {
        assert_eq!(coordinates.len(), self.joint_count(), "one coordinate for each joint");
        assert_eq!(bodies.as_slice().len(), self.link_count(), "a workspace for as many links as the chain has");
        if self.drives.is_some() {
            return None;
        }
        bodies.sweep(on, self, coordinates, inertia);
        Some(GravityTorqueRows::new(on, self, gravity, bodies.as_slice()))
    }

    /// As if every axis had a coordinate of its own.
    fn linearize_axes(&self, coordinates: &[f64], gravity: [f64; 3], inertia: &[f64], out: &mut GravityTorque) {
        out.bodies.sweep(Single, self, coordinates, inertia);
        let rows = GravityTorqueRows::new(Single, self, gravity, out.bodies.as_slice());
        let n = out.torque.len();
        out.by_inertia.fill(0.0);
        for (i, by_inertia) in out.by_inertia.chunks_exact_mut(INERTIA * n).enumerate() {
            let row = rows.of_joint(i);
            out.torque[i] = row.torque();
            out.by_gravity[3 * i..3 * i + 3].copy_from_slice(&row.by_gravity());
            let by_coordinate = out.by_coordinate[n * i..].iter_mut().zip(row.by_coordinate());
            by_coordinate.for_each(|(entry, by)| *entry = by);
            let moved = &mut by_inertia.as_chunks_mut::<INERTIA>().0[row.moved()];
            moved.iter_mut().zip(row.by_inertia()).for_each(|(entry, by)| *entry = by);
        }
    }
}

/// The holding torques of one pose, or of several at once, and their derivatives; of a chain whose joints all have a coordinate of their
/// own.
pub struct GravityTorqueRows<'a, A: Arithmetic> {
    on: A,
    chain: &'a Chain,
    gravity: Vector3<A::Number>,
    bodies: &'a [BodyBeyond<A::Stored>],
}

impl<'a, A: Arithmetic> GravityTorqueRows<'a, A> {
    #[inline(always)]
    fn new(on: A, chain: &'a Chain, gravity: [f64; 3], bodies: &'a [BodyBeyond<A::Stored>]) -> Self {
        GravityTorqueRows { on, chain, gravity: constant(on, &gravity.into()), bodies }
    }

    /// The torque of joint i.
    ///
    /// # Panics
    ///
    /// When there is no such joint.
    #[inline(always)]
    pub fn of_joint(&self, i: usize) -> GravityTorqueRow<'_, A> {
        GravityTorqueRow { all: self, joint: i, sensitivity: self.bodies[i].sensitivity(self.on, &self.gravity) }
    }
}

/// The holding torque of one joint, N·m (N for a prismatic joint), and its derivatives.
pub struct GravityTorqueRow<'a, A: Arithmetic> {
    all: &'a GravityTorqueRows<'a, A>,
    joint: usize,
    sensitivity: Sensitivity<A::Number>,
}

impl<A: Arithmetic> GravityTorqueRow<'_, A> {
    /// Which joint it is.
    #[inline(always)]
    pub fn joint(&self) -> usize {
        self.joint
    }

    /// The torque itself.
    #[inline(always)]
    pub fn torque(&self) -> A::Number {
        self.all.bodies[self.joint].torque(self.all.on, &self.sensitivity)
    }

    /// By gravity in base coordinates (m/s²).
    #[inline(always)]
    pub fn by_gravity(&self) -> [A::Number; 3] {
        self.all.bodies[self.joint].torque_by_gravity(self.all.on).into()
    }

    /// By the coordinate of each joint (rad or m), as many as there are: `w_i · v_j` for joints j beyond i, `w_j · v_i` for those before, zero for those on other
    /// branches.
    #[inline(always)]
    pub fn by_coordinate(&self) -> impl Iterator<Item = A::Number> {
        let (GravityTorqueRows { on, chain, gravity, bodies }, i) = (self.all, self.joint);
        let ends = &chain.topology.ends;
        bodies.iter().enumerate().map(
            #[inline(always)]
            move |(j, body)| match j {
                _ if j >= i && j < ends[i] => dot(&self.sensitivity.to_moment, &body.moment_rate(*on)),
                _ if j < i && i < ends[j] => {
                    dot(&body.sensitivity(*on, gravity).to_moment, &bodies[i].moment_rate(*on))
                }
                _ => on.constant(0.0),
            },
        )
    }

    /// The links that the joint moves.
    #[inline(always)]
    pub fn moved(&self) -> Range<usize> {
        self.joint..self.all.chain.topology.ends[self.joint]
    }

    /// By mass and first moment `[m, h_x, h_y, h_z]` (kg, kg·m in link coordinates) of each link that it [moves](Self::moved).
    #[inline(always)]
    pub fn by_inertia(&self) -> impl Iterator<Item = [A::Number; INERTIA]> {
        let (on, own) = (self.all.on, &self.all.bodies[self.joint]);
        let Sensitivity { to_mass, to_moment } = &self.sensitivity;
        self.all.bodies[self.moved()].iter().map(
            #[inline(always)]
            move |link| {
                let [x, y, z] = link.link_axes(on);
                let by_mass = *to_mass + dot(to_moment, &link.link_origin_from(on, own));
                [by_mass, dot(&x, to_moment), dot(&y, to_moment), dot(&z, to_moment)]
            },
        )
    }
}

fn torques(bodies: &[BodyBeyond<f64>], gravity: [f64; 3], torque: &mut [f64]) {
    let gravity = Vector3::from(gravity);
    for (torque, body) in torque.iter_mut().zip(bodies) {
        *torque = body.torque(Single, &body.sensitivity(Single, &gravity));
    }
}

#[cfg(test)]
mod tests;
