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
//! sums, then n² products. Where joints mimic others, see `coupled.rs`.

mod body_beyond;
mod coupled;

use body_beyond::{Bodies, BodyBeyond, Sensitivity};
use nalgebra::Vector3;

use crate::chain::Chain;

/// Numbers of one link's inertia: mass and three components of the first moment.
const INERTIA: usize = 4;

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
        bodies.sweep(self, &self.axis_coordinates(coordinates), inertia);
        match &self.drives {
            None => torques(bodies.as_slice(), gravity, torque),
            Some(drives) => {
                let mut by_axis = vec![0.0; self.link_count()];
                torques(bodies.as_slice(), gravity, &mut by_axis);
                coupled::gather(drives, &by_axis, torque);
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
            axes.torque.bodies.sweep(self, &axes.coordinates, inertia);
            torques(axes.torque.bodies.as_slice(), gravity, &mut axes.torque.torque);
            coupled::gather(drives, &axes.torque.torque, &mut out.torque);
        } else {
            out.bodies.sweep(self, coordinates, inertia);
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
        let gravity = Vector3::from(gravity);
        if let (Some(drives), Some(mut axes)) = (&self.drives, out.axes.take()) {
            axes.spread(drives, coordinates);
            self.linearize_axes(&axes.coordinates, &gravity, inertia, &mut axes.torque);
            out.gather(drives, &axes.torque);
            out.axes = Some(axes);
        } else {
            self.linearize_axes(coordinates, &gravity, inertia, out);
        }
    }

    /// The same row by row, each written where it is wanted; the numbers in `workspace` stay as they are. Nothing where joints mimic
    /// others: their rows are sums.
    ///
    /// # Panics
    ///
    /// As [`Chain::linearize_gravity_torque`].
    pub fn gravity_torque_rows<'a>(
        &'a self,
        coordinates: &[f64],
        gravity: [f64; 3],
        inertia: &[f64],
        workspace: &'a mut GravityTorque,
    ) -> Option<GravityTorqueRows<'a>> {
        assert_eq!(coordinates.len(), self.joint_count(), "one coordinate for each joint");
        workspace.assert_size(self.joint_count(), self.link_count());
        if self.drives.is_some() {
            return None;
        }
        workspace.bodies.sweep(self, coordinates, inertia);
        Some(GravityTorqueRows { chain: self, gravity: gravity.into(), bodies: workspace.bodies.as_slice() })
    }

    /// As if every axis had a coordinate of its own.
    fn linearize_axes(&self, coordinates: &[f64], gravity: &Vector3<f64>, inertia: &[f64], out: &mut GravityTorque) {
        out.bodies.sweep(self, coordinates, inertia);
        let rows = GravityTorqueRows { chain: self, gravity: *gravity, bodies: out.bodies.as_slice() };
        let n = out.torque.len();
        out.by_inertia.fill(0.0);
        for (i, by_inertia) in out.by_inertia.chunks_exact_mut(INERTIA * n).enumerate() {
            let (by_gravity, by_coordinate) = (&mut out.by_gravity[3 * i..3 * i + 3], &mut out.by_coordinate[n * i..]);
            out.torque[i] = rows.write(i, 1.0, by_gravity, &mut by_coordinate[..n], by_inertia);
        }
    }
}

/// The holding torques of one pose and their derivatives, of a chain whose joints all have a coordinate of their own.
pub struct GravityTorqueRows<'a> {
    chain: &'a Chain,
    gravity: Vector3<f64>,
    bodies: &'a [BodyBeyond],
}

impl GravityTorqueRows<'_> {
    /// Writes the derivatives of joint i's torque, times `scale`, and gives the torque itself: by gravity (3), by all coordinates (n), and
    /// by the inertia (4 a link) of the links that it moves; what stands for the other links stays as it is.
    #[inline]
    pub fn write(
        &self,
        i: usize,
        scale: f64,
        by_gravity: &mut [f64],
        by_coordinate: &mut [f64],
        by_inertia: &mut [f64],
    ) -> f64 {
        let n = self.bodies.len();
        debug_assert_eq!([by_gravity.len(), by_coordinate.len(), by_inertia.len()], [3, n, INERTIA * n]);
        let body = &self.bodies[i];
        let sensitivity = body.sensitivity(&self.gravity);
        let direct = body.torque_by_gravity();
        by_gravity.iter_mut().zip(direct.as_slice()).for_each(|(entry, by)| *entry = scale * by);
        self.write_by_coordinate(i, scale, &sensitivity, by_coordinate);
        self.write_by_inertia(i, scale, &sensitivity, by_inertia);
        body.torque(&sensitivity)
    }

    /// `w_i · v_j` for joints j beyond i, `w_j · v_i` for those before, zero for those on other branches.
    #[inline(always)]
    fn write_by_coordinate(&self, i: usize, scale: f64, sensitivity: &Sensitivity, row: &mut [f64]) {
        let ends = &self.chain.topology.ends;
        for (j, (entry, body)) in row.iter_mut().zip(self.bodies).enumerate() {
            let second = match j {
                _ if j >= i && j < ends[i] => sensitivity.to_moment.dot(&body.moment_rate),
                _ if j < i && i < ends[j] => body.sensitivity(&self.gravity).to_moment.dot(&self.bodies[i].moment_rate),
                _ => 0.0,
            };
            *entry = scale * second;
        }
    }

    /// `[∂τ_i/∂m_k, ∂τ_i/∂h_k]` of the links k from i on that it moves.
    #[inline(always)]
    fn write_by_inertia(&self, i: usize, scale: f64, sensitivity: &Sensitivity, row: &mut [f64]) {
        let moved = i..self.chain.topology.ends[i];
        let (point, to_moment) = (self.bodies[i].point, sensitivity.to_moment);
        for (entry, link) in row.as_chunks_mut::<INERTIA>().0[moved.clone()].iter_mut().zip(&self.bodies[moved]) {
            let by_moment = link.link_rotation.tr_mul(&to_moment);
            let by_mass = sensitivity.to_mass + to_moment.dot(&(link.link_origin - point));
            *entry = [by_mass, by_moment.x, by_moment.y, by_moment.z].map(|by| scale * by);
        }
    }
}

fn torques(bodies: &[BodyBeyond], gravity: [f64; 3], torque: &mut [f64]) {
    let gravity = Vector3::from(gravity);
    for (torque, body) in torque.iter_mut().zip(bodies) {
        *torque = body.torque(&body.sensitivity(&gravity));
    }
}

#[cfg(test)]
mod tests;
