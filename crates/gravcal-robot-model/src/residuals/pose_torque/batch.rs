//! Poses whose torques are evaluated in a batch, by vector instructions: those of one model that read the same joints. Terms of their sensors are
//! evaluated one by one: see [`super::batch_terms`].

use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{Arithmetic, Bodies, Vectorized};
use gravcal_estimation::LANES;
use pulp::{Arch, Simd, WithSimd};

use super::batch_terms::{self, Lane};
use super::instructions::batch_instructions;
use super::model::sensor_column;
use super::residual::{self, PoseTorque};
use crate::parameter::SensorParameter;

const _: () = assert!(gravcal_estimation::LANES == gravcal_dynamics::LANES, "as many poses as a register has lanes");

/// What an evaluation computes on the way.
pub(super) struct Workspace {
    /// Nothing where no vector instructions have so many lanes.
    instructions: Option<Arch>,
    /// Of each joint.
    position: Vec<[f64; LANES]>,
    coordinates: Vec<[f64; LANES]>,
    bodies: Bodies<[f64; LANES]>,
    /// For the terms of sensors.
    lanes: [Lane; LANES],
}

impl Workspace {
    pub fn new(joints: usize, links: usize) -> Self {
        Workspace {
            instructions: batch_instructions(),
            position: vec![[0.0; LANES]; joints],
            coordinates: vec![[0.0; LANES]; joints],
            bodies: Bodies::new(links),
            lanes: std::array::from_fn(|_| Lane::new(joints)),
        }
    }
}

/// Poses that can be evaluated in a batch.
pub(super) struct Poses<'a>([&'a PoseTorque; LANES]);

impl<'a> Poses<'a> {
    /// These, if they are.
    pub fn of(poses: [&'a PoseTorque; LANES]) -> Option<Self> {
        let (a, others) = (poses[0], &poses[1..]);
        let joint = |(joint, _): &(usize, f64)| *joint;
        let same_joints = |pose: &PoseTorque| pose.readings.iter().map(joint).eq(a.readings.iter().map(joint));
        let alike = |pose: &PoseTorque| Arc::ptr_eq(&pose.model, &a.model) && same_joints(pose);
        (a.model.goes_in_batch() && others.iter().copied().all(alike)).then_some(Poses(poses))
    }

    /// As [`Batched::evaluate_batch`](gravcal_estimation::Batched::evaluate_batch).
    pub fn evaluate(
        &self,
        workspace: &mut residual::Workspace,
        all: [&[f64]; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool {
        let residual::Workspace { inertia, batch, .. } = workspace;
        let Some(instructions) = batch.instructions.filter(|_| self.differ_by_offset_or_bias_only(all)) else {
            return false;
        };
        let (pose, x) = (self.0[0], all[0]);
        let gains = pose.sensors(x, SensorParameter::PositionGain);
        for (lane, (pose, x)) in self.0.iter().zip(all).enumerate() {
            let offsets = pose.sensors(x, SensorParameter::PositionOffset);
            for (joint, q) in pose.position.iter().enumerate() {
                batch.position[joint][lane] = *q;
                batch.coordinates[joint][lane] = gains[joint] * q + offsets[joint];
            }
        }
        pose.set_inertia(&x[..pose.model.affine_columns], inertia);
        if let Some(terms) = &pose.model.terms {
            let Workspace { coordinates, lanes, .. } = &mut *batch;
            batch_terms::move_joints(terms, &self.0, (x, jacobian.is_some()), coordinates, lanes);
        }
        instructions.dispatch(Evaluation { poses: &self.0, batch, inertia, all, residual, jacobian })
    }

    /// Whether all read the same numbers but for offsets of position sensors and biases of torque sensors, which readings are shifted by.
    fn differ_by_offset_or_bias_only(&self, all: [&[f64]; LANES]) -> bool {
        let joints = self.0[0].position.len();
        let column = |quantity, joint| sensor_column(joints, quantity, joint);
        let shifted = [SensorParameter::TorqueBias, SensorParameter::PositionOffset];
        let [bias, offset] = shifted.map(|quantity| column(quantity, 0)..column(quantity, joints));
        let same = |x: &[f64]| {
            let first = all[0];
            let same = |range: Range<usize>| x[range.clone()] == first[range];
            same(0..bias.start) && same(bias.end..offset.start) && same(offset.end..self.0[0].model.columns)
        };
        all[1..].iter().all(|x| std::ptr::eq(*x, all[0]) || same(x))
    }
}

struct Evaluation<'a> {
    poses: &'a [&'a PoseTorque; LANES],
    batch: &'a mut Workspace,
    inertia: &'a [f64],
    /// What each of them reads.
    all: [&'a [f64]; LANES],
    residual: &'a mut [[f64; LANES]],
    jacobian: Option<&'a mut [[f64; LANES]]>,
}

impl WithSimd for Evaluation<'_> {
    /// Whether there are instructions for so many lanes, and rows for such a chain.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Some(on) = Vectorized::new(simd) else { return false };
        let Evaluation { poses, batch, inertia, all, residual, jacobian } = self;
        let x = all[0];
        let (pose, gravity) = (poses[0], [x[0], x[1], x[2]]);
        let load = pose.load(x);
        let Workspace { position, coordinates, bodies, lanes, .. } = batch;
        let (chain, terms) = (&pose.model.chain, pose.model.terms.as_ref());
        let Some(torques) = chain.gravity_torque_rows(on, coordinates, gravity, inertia, bodies) else { return false };
        let mut jacobian = jacobian.map(|jacobian| jacobian.chunks_exact_mut(x.len()));
        for (row, residual) in residual.iter_mut().enumerate() {
            let (joint, _) = pose.readings[row];
            let torque = torques.of_joint(joint);
            let gain = pose.sensors(x, SensorParameter::TorqueGain)[joint];
            let entries = jacobian.as_mut().and_then(Iterator::next);
            let wanted = (x, entries.is_some());
            let read = |terms| batch_terms::read(terms, poses, (joint, on.store(torque.torque())), wanted, lanes);
            let further = terms.filter(|terms| terms.has(joint)).map(read);
            if let Some(entries) = entries {
                let (affine, by_terms) = entries.split_at_mut(pose.model.affine_columns);
                let gain = match &further {
                    Some(further) => on.load(further.by_torque.map(|by_torque| gain + by_torque)),
                    None => on.constant(gain),
                };
                pose.write_affine(on, &torque, gain, (position, load), affine);
                if let Some(terms) = terms {
                    batch_terms::write(terms, poses, joint, lanes, (affine, by_terms));
                }
            }
            let bias = all.map(|x| pose.sensors(x, SensorParameter::TorqueBias)[joint]);
            let predicted = pose.predict_affine(on, &torque, [[gain; LANES], bias]);
            let mut reading = [0.0; LANES];
            reading.iter_mut().zip(poses).for_each(|(reading, pose)| *reading = pose.readings[row].1);
            *residual = on.store(predicted - on.load(reading));
            if let Some(further) = further {
                residual.iter_mut().zip(further.value).for_each(|(residual, value)| *residual += value);
            }
        }
        true
    }
}
