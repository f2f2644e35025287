//! The torque that moves an arm, and all its first derivatives.
//!
//! Every point `r` of link k moves at `v_k + ω_k × r`; a force on each of its masses makes it accelerate and carries it. By virtual work
//!
//! ```text
//!     τ_i = Σ_k ∫ ∂r/∂θ_i · (r̈ − g) dm          over all links k that axis i moves
//!         = S_i · F_i,    F_i = Σ_k F_k,    F_k = I_k a_k + v_k ×* I_k v_k = I_k a_k + B_k ω_k
//! ```
//!
//! the recursion of Newton and Euler (Luh, Walker and Paul 1980; Featherstone, *Rigid Body Dynamics Algorithms*, ch. 5), with all
//! motions and wrenches about the origin of the base and along its axes: motions outward (`link_motion.rs`), wrenches inward
//! (`moving_body.rs`). Gravity is taken off the base's acceleration. What hangs beyond a joint then adds up without a shift; rounding
//! grows with the square of the distance, in lengths of the arm, at which the arm stands from that origin.
//!
//! What a joint's motor turns behind a gear adds its rotor inertia, told at the joint (that of the rotor times the ratio squared), and
//! no more: `Ia_i θ̈_i`.
//!
//! `τ = Y(θ, θ̇, θ̈, g) π + diag(θ̈) Ia` is linear in the parameters `π`, ten a link ([`BodyInertia`](crate::BodyInertia)), and linear in
//! gravity; at rest it is the gravity torque. The sign is Pinocchio's, as is the order of the parameters. `Y` is in `regressor.rs`, the
//! other derivatives in `linearize.rs`. Where joints mimic others, all of it is computed by axes and then summed by joints, see
//! `../coupled.rs`; a rotor turns with its joint's own coordinate.

mod joint_motion;
mod linearize;
mod link_motion;
mod moving_body;
mod regressor;
mod spatial;

use link_motion::LinkMotion;
use moving_body::Beyond;
use spatial::Twist;

pub use joint_motion::JointMotion;

use crate::arithmetic::{Arithmetic, Stored};
use crate::body_inertia::BODY;
use crate::chain::{Chain, Drive};
use crate::coupled;
use crate::gravity::{Bodies, INERTIA};

/// What resists, in all samples alike.
#[derive(Clone, Copy, Debug)]
pub struct DynamicParameters<'a> {
    /// Ten numbers a link, loads added: [`BodyInertia::parameters`](crate::BodyInertia::parameters).
    pub links: &'a [f64],
    /// Of each joint with a coordinate of its own, kg·m² (kg for a prismatic joint): its motor's, at the joint.
    pub rotor_inertia: &'a [f64],
}

/// The torques of one sample (`L = f64`) or of some at once (`L = [f64; LANES]`) with their derivatives, all row-major; a workspace to be reused.
///
/// n is the number of joints that have a coordinate of their own, l that of links. `torque`, and every derivative, is in N·m (N for a
/// prismatic joint) over the unit of what it is derived by.
#[derive(Clone, Debug)]
pub struct InverseDynamics<L = f64> {
    /// Torques, n.
    pub torque: Vec<L>,
    /// By the joint coordinates (rad or m), n × n.
    pub by_coordinate: Vec<L>,
    /// By the joint velocities, n × n.
    pub by_velocity: Vec<L>,
    /// By the joint accelerations, n × n: the joint-space inertia matrix, rotors included; symmetric.
    pub by_acceleration: Vec<L>,
    /// By gravity in base coordinates (m/s²), n × 3.
    pub by_gravity: Vec<L>,
    /// By the links' parameters, n × 10 l: the regressor. Zero for links that the joint does not move. (By the rotor inertias, it is the
    /// diagonal matrix of the accelerations.)
    pub by_parameters: Vec<L>,
    /// The regressor by gravity (m/s²): for each axis of the base n × 4 l, by the links' masses and first moments; tensors feel no gravity.
    pub regressor_by_gravity: Vec<L>,
    bodies: Bodies<L>,
    motions: Vec<LinkMotion<L>>,
    /// Ψ̈ of each axis.
    axis_changes: Vec<Twist<L>>,
    beyond: Vec<Beyond<L>>,
    /// The same by axes, where some joints mimic others.
    axes: Option<Box<Axes<L>>>,
}

/// What is computed by axes before it is by joints.
#[derive(Clone, Debug)]
struct Axes<L> {
    coordinates: Vec<L>,
    velocities: Vec<L>,
    accelerations: Vec<L>,
    dynamics: InverseDynamics<L>,
}

impl<L: Stored> InverseDynamics<L> {
    /// A workspace for a chain, all zero.
    pub fn new(chain: &Chain) -> Self {
        let axes = chain.drives.as_ref().map(|drives| Box::new(Axes::new(drives.len())));
        InverseDynamics { axes, ..Self::with_size(chain.joint_count(), chain.link_count()) }
    }

    fn with_size(joints: usize, links: usize) -> Self {
        InverseDynamics {
            torque: vec![L::ZERO; joints],
            by_coordinate: vec![L::ZERO; joints * joints],
            by_velocity: vec![L::ZERO; joints * joints],
            by_acceleration: vec![L::ZERO; joints * joints],
            by_gravity: vec![L::ZERO; joints * 3],
            by_parameters: vec![L::ZERO; joints * links * BODY],
            regressor_by_gravity: vec![L::ZERO; 3 * joints * links * INERTIA],
            bodies: Bodies::new(links),
            motions: vec![LinkMotion::still(); links],
            axis_changes: vec![Twist::ZERO; links],
            beyond: vec![Beyond::nothing(); links],
            axes: None,
        }
    }

    fn assert_size(&self, chain: &Chain, sample: JointMotion<'_, L>) {
        let n = chain.joint_count();
        let JointMotion { coordinates, velocities, accelerations } = sample;
        assert_eq!([coordinates.len(), velocities.len(), accelerations.len()], [n; 3], "one number for each joint");
        assert_eq!((self.torque.len(), self.motions.len()), (n, chain.link_count()), "a workspace for this chain");
        assert_eq!(self.axes.is_some(), chain.drives.is_some(), "a workspace for this chain");
    }

    /// Places and moves all links. `sample`: of each link's mover.
    #[inline(always)]
    fn sweep<A: Arithmetic<Stored = L>>(
        &mut self,
        on: A,
        chain: &Chain,
        sample: JointMotion<'_, L>,
        gravity: [f64; 3],
    ) {
        self.bodies.place(on, chain, sample.coordinates);
        link_motion::sweep(on, chain, &self.bodies, sample, gravity, &mut self.motions);
    }

    /// What hangs beyond each axis, and the torque about it.
    #[inline(always)]
    fn gather<A: Arithmetic<Stored = L>>(&mut self, on: A, chain: &Chain, links: &[f64]) {
        moving_body::gather(on, chain, &self.bodies, &self.motions, links, &mut self.beyond);
        for ((torque, motion), beyond) in self.torque.iter_mut().zip(&self.motions).zip(&self.beyond) {
            *torque = on.store(motion.axis.load(on).dot(&beyond.wrench.load(on)));
        }
    }

    /// `τ_i += Ia_i θ̈_i`.
    #[inline(always)]
    fn add_rotors<A: Arithmetic<Stored = L>>(&mut self, on: A, sample: JointMotion<'_, L>, rotor_inertia: &[f64]) {
        for ((torque, rate), inertia) in self.torque.iter_mut().zip(sample.accelerations).zip(rotor_inertia) {
            *torque = on.store(on.load(*torque) + on.constant(*inertia) * on.load(*rate));
        }
    }
}

impl<L: Stored> Axes<L> {
    fn new(count: usize) -> Self {
        let zeros = || vec![L::ZERO; count];
        let dynamics = InverseDynamics::with_size(count, count);
        Axes { coordinates: zeros(), velocities: zeros(), accelerations: zeros(), dynamics }
    }

    /// `A q + c`, `A q̇`, `A q̈`.
    #[inline(always)]
    fn spread<A: Arithmetic<Stored = L>>(&mut self, on: A, drives: &[Drive], sample: JointMotion<'_, L>) {
        for (axis, Drive { joint, multiplier, offset }) in drives.iter().enumerate() {
            let times = on.constant(*multiplier);
            self.coordinates[axis] = on.store(times * on.load(sample.coordinates[*joint]) + on.constant(*offset));
            self.velocities[axis] = on.store(times * on.load(sample.velocities[*joint]));
            self.accelerations[axis] = on.store(times * on.load(sample.accelerations[*joint]));
        }
    }

    /// The workspace by axes, and the motion of each.
    #[inline(always)]
    fn parts(&mut self) -> (&mut InverseDynamics<L>, JointMotion<'_, L>) {
        let Axes { coordinates, velocities, accelerations, dynamics } = self;
        (dynamics, JointMotion { coordinates, velocities, accelerations })
    }
}

impl Chain {
    /// The torque of every joint that moves the arm so, into `out.torque`; what else is there stays as it is. Allocates nothing.
    ///
    /// `on`: one sample, or several at once. `gravity`: m/s² in base coordinates; it and the parameters are those of all samples.
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `out` was made for another chain.
    #[inline(always)]
    pub fn inverse_dynamics<A: Arithmetic>(
        &self,
        on: A,
        sample: JointMotion<'_, A::Stored>,
        gravity: [f64; 3],
        parameters: DynamicParameters<'_>,
        out: &mut InverseDynamics<A::Stored>,
    ) {
        out.assert_size(self, sample);
        parameters.assert_size(self);
        if self.joints().is_empty() {
            return;
        }
        if let (Some(drives), Some(axes)) = (&self.drives, &mut out.axes) {
            axes.spread(on, drives, sample);
            let (dynamics, by_axis) = axes.parts();
            dynamics.sweep(on, self, by_axis, gravity);
            dynamics.gather(on, self, parameters.links);
            coupled::gather(on, drives, &dynamics.torque, &mut out.torque);
        } else {
            out.sweep(on, self, sample, gravity);
            out.gather(on, self, parameters.links);
        }
        out.add_rotors(on, sample, parameters.rotor_inertia);
    }

    /// The regressor into `out.by_parameters`; what else is there stays as it is. For the rest see [`Chain::inverse_dynamics`]. Allocates
    /// nothing.
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `out` was made for another chain.
    #[inline(always)]
    pub fn inverse_dynamics_regressor<A: Arithmetic>(
        &self,
        on: A,
        sample: JointMotion<'_, A::Stored>,
        gravity: [f64; 3],
        out: &mut InverseDynamics<A::Stored>,
    ) {
        out.assert_size(self, sample);
        if self.joints().is_empty() {
            return;
        }
        if let (Some(drives), Some(axes)) = (&self.drives, &mut out.axes) {
            axes.spread(on, drives, sample);
            let (dynamics, by_axis) = axes.parts();
            dynamics.sweep(on, self, by_axis, gravity);
            let InverseDynamics { bodies, motions, by_parameters, .. } = dynamics;
            regressor::write(on, self, bodies, motions, by_parameters);
            coupled::gather(on, drives, by_parameters, &mut out.by_parameters);
        } else {
            out.sweep(on, self, sample, gravity);
            regressor::write(on, self, &out.bodies, &out.motions, &mut out.by_parameters);
        }
    }

    /// The regressor without gravity into `out.by_parameters`, and its derivative by gravity into `out.regressor_by_gravity`; what else is
    /// there stays as it is. With both the regressor is known under any gravity: `Y = Y_0 + Σ_a g_a Y_a`. For the rest see
    /// [`Chain::inverse_dynamics`]. Allocates nothing.
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `out` was made for another chain.
    #[inline(always)]
    pub fn affine_regressor<A: Arithmetic>(
        &self,
        on: A,
        sample: JointMotion<'_, A::Stored>,
        out: &mut InverseDynamics<A::Stored>,
    ) {
        self.inverse_dynamics_regressor(on, sample, [0.0; 3], out);
        if self.joints().is_empty() {
            return;
        }
        if let (Some(drives), Some(axes)) = (&self.drives, &mut out.axes) {
            let InverseDynamics { bodies, motions, regressor_by_gravity, .. } = &mut axes.dynamics;
            regressor::write_by_gravity(on, self, bodies, motions, regressor_by_gravity);
            let by_axes = regressor_by_gravity.chunks_exact(regressor_by_gravity.len() / 3);
            let by_joints = out.regressor_by_gravity.len() / 3;
            for (own, by_joint) in by_axes.zip(out.regressor_by_gravity.chunks_exact_mut(by_joints)) {
                coupled::gather(on, drives, own, by_joint);
            }
        } else {
            regressor::write_by_gravity(on, self, &out.bodies, &out.motions, &mut out.regressor_by_gravity);
        }
    }

    /// Torques and all their derivatives; see [`InverseDynamics`] for shapes, [`Chain::inverse_dynamics`] for the rest. Allocates nothing. The
    /// torques are bit for bit those of [`Chain::inverse_dynamics`], the regressor is that of [`Chain::inverse_dynamics_regressor`].
    ///
    /// # Panics
    ///
    /// When a slice has another length, or `out` was made for another chain.
    #[inline(always)]
    pub fn linearize_inverse_dynamics<A: Arithmetic>(
        &self,
        on: A,
        sample: JointMotion<'_, A::Stored>,
        gravity: [f64; 3],
        parameters: DynamicParameters<'_>,
        out: &mut InverseDynamics<A::Stored>,
    ) {
        out.assert_size(self, sample);
        parameters.assert_size(self);
        if self.joints().is_empty() {
            return;
        }
        if let (Some(drives), Some(mut axes)) = (&self.drives, out.axes.take()) {
            axes.spread(on, drives, sample);
            let (dynamics, by_axis) = axes.parts();
            dynamics.linearize(on, self, by_axis, gravity, parameters.links);
            out.gather_axes(on, drives, dynamics);
            out.axes = Some(axes);
        } else {
            out.linearize(on, self, sample, gravity, parameters.links);
        }
        out.add_rotors(on, sample, parameters.rotor_inertia);
        for (joint, inertia) in parameters.rotor_inertia.iter().enumerate() {
            let entry = &mut out.by_acceleration[joint * (self.joint_count() + 1)];
            *entry = on.store(on.load(*entry) + on.constant(*inertia));
        }
    }
}

impl<L: Stored> InverseDynamics<L> {
    /// Torques and all derivatives, as if every axis had a coordinate of its own.
    #[inline(always)]
    fn linearize<A: Arithmetic<Stored = L>>(
        &mut self,
        on: A,
        chain: &Chain,
        sample: JointMotion<'_, L>,
        gravity: [f64; 3],
        links: &[f64],
    ) {
        self.sweep(on, chain, sample, gravity);
        self.gather(on, chain, links);
        linearize::write(on, chain, gravity, self);
        regressor::write(on, chain, &self.bodies, &self.motions, &mut self.by_parameters);
    }

    /// Everything by joints, from everything by axes.
    #[inline(always)]
    fn gather_axes<A: Arithmetic<Stored = L>>(&mut self, on: A, drives: &[Drive], axes: &InverseDynamics<L>) {
        coupled::gather(on, drives, &axes.torque, &mut self.torque);
        coupled::gather(on, drives, &axes.by_gravity, &mut self.by_gravity);
        coupled::gather(on, drives, &axes.by_parameters, &mut self.by_parameters);
        coupled::gather_both(on, drives, &axes.by_coordinate, &mut self.by_coordinate);
        coupled::gather_both(on, drives, &axes.by_velocity, &mut self.by_velocity);
        coupled::gather_both(on, drives, &axes.by_acceleration, &mut self.by_acceleration);
    }
}

impl DynamicParameters<'_> {
    fn assert_size(&self, chain: &Chain) {
        assert_eq!(self.links.len(), BODY * chain.link_count(), "ten numbers for each link");
        assert_eq!(self.rotor_inertia.len(), chain.joint_count(), "one rotor inertia for each joint");
    }
}

#[cfg(test)]
mod tests;
