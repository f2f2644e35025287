//! The residual of one pose, and its derivatives.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{Bodies, Chain, GravityTorque, Single};
use gravcal_estimation::{Batched, BlockId, EvaluateError, LANES, LocalValues, Residual, RowsMut, Sample};
use gravcal_recording::Conditions;

use super::model::{GRAVITY, INERTIA, LoadState, PoseTorqueModel, inertia_column, sensor_column};
use super::terms::Slopes;
use super::{batch, compliance};
use crate::parameter::SensorParameter;
use crate::sensors::Moment;

/// The torque readings of one pose.
#[derive(Clone, Debug)]
pub struct PoseTorque {
    pub(super) model: Arc<PoseTorqueModel>,
    /// Position reading of every joint.
    pub(super) position: Vec<f64>,
    /// Joint and torque reading of each row.
    pub(super) readings: Vec<(usize, f64)>,
    /// What terms of the sensors read besides.
    pub(super) conditions: Conditions,
}

/// What an evaluation computes on the way, kept by each thread from one pose to the next.
pub(super) struct Workspace {
    pub(super) coordinates: Vec<f64>,
    pub(super) inertia: Vec<f64>,
    pub(super) torque: GravityTorque,
    pub(super) bodies: Bodies,
    pub(super) batch: batch::Workspace,
    /// A row of the Jacobian, for terms of sensors that read other joints' torques.
    pub(super) row: Vec<f64>,
    pub(super) slopes: Slopes,
}

impl Workspace {
    fn new(joints: usize, links: usize) -> Self {
        Workspace {
            coordinates: vec![0.0; joints],
            inertia: vec![0.0; INERTIA * links],
            torque: GravityTorque::new(joints, links),
            bodies: Bodies::new(links),
            batch: batch::Workspace::new(joints, links),
            row: Vec::new(),
            slopes: Slopes::default(),
        }
    }

    fn is_for(&self, chain: &Chain) -> bool {
        (self.coordinates.len(), self.inertia.len()) == (chain.joint_count(), INERTIA * chain.link_count())
    }
}

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::new(Workspace::new(0, 0));
}

impl PoseTorque {
    /// `position`: reading of every joint; `readings`: joint and torque reading, one a row.
    pub fn new(model: Arc<PoseTorqueModel>, position: Vec<f64>, readings: Vec<(usize, f64)>) -> Self {
        PoseTorque { model, position, readings, conditions: Conditions::default() }
    }

    /// The same, read under these conditions.
    #[must_use]
    pub fn under(self, conditions: Conditions) -> Self {
        PoseTorque { conditions, ..self }
    }

    /// Does something in this thread's workspace.
    fn with_workspace<T>(&self, task: impl FnOnce(&mut Workspace) -> T) -> T {
        WORKSPACE.with_borrow_mut(|workspace| {
            let chain = &self.model.chain;
            if !workspace.is_for(chain) {
                *workspace = Workspace::new(chain.joint_count(), chain.link_count());
            }
            task(workspace)
        })
    }

    /// The joint whose reading a row is.
    pub(crate) fn joint_of_row(&self, row: usize) -> usize {
        self.readings[row].0
    }

    /// One parameter of every joint's sensors.
    pub(super) fn sensors<'x>(&self, x: &'x [f64], quantity: SensorParameter) -> &'x [f64] {
        let joints = self.position.len();
        &x[sensor_column(joints, quantity, 0)..sensor_column(joints, quantity, joints)]
    }

    /// True coordinates of all joints.
    fn set_coordinates(&self, x: &[f64], coordinates: &mut [f64]) {
        let (gains, offsets) =
            (self.sensors(x, SensorParameter::PositionGain), self.sensors(x, SensorParameter::PositionOffset));
        for (((coordinate, q), gain), offset) in coordinates.iter_mut().zip(&self.position).zip(gains).zip(offsets) {
            *coordinate = gain * q + offset;
        }
    }

    /// Masses and moments of all links, the load's included.
    pub(super) fn set_inertia(&self, x: &[f64], inertia: &mut [f64]) {
        let (links, beyond) = x[inertia_column(self.position.len(), 0)..].split_at(inertia.len());
        inertia.copy_from_slice(links);
        if let Some(load) = &self.model.load {
            let LoadState { mass, position } = load.at(beyond);
            let carried = &mut inertia[INERTIA * load.link..INERTIA * (load.link + 1)];
            carried[0] += mass;
            carried[1..].iter_mut().zip(position).for_each(|(h, r)| *h += mass * r);
        }
    }

    /// What it carries, at these values.
    pub(super) fn load(&self, x: &[f64]) -> Option<LoadState> {
        let first = inertia_column(self.position.len(), self.model.chain.link_count());
        self.model.load.as_ref().map(|load| load.at(&x[first..]))
    }

    /// The row of a joint's reading, times `gain`, from derivatives of all torques: where sensors have terms, joints give way or mimic
    /// others.
    pub(super) fn fill_row(
        &self,
        gain: f64,
        joint: usize,
        torque: &GravityTorque,
        load: Option<LoadState>,
        row: &mut [f64],
    ) {
        let (n, links) = (self.position.len(), self.model.chain.link_count());
        let [by_gravity, by_torque_sensors, by_position_gains, by_offsets, by_links, by_load] = self.parts(row);
        for (entry, by) in by_gravity.iter_mut().zip(&torque.by_gravity[3 * joint..]) {
            *entry = gain * by;
        }
        [by_torque_sensors[joint], by_torque_sensors[n + joint]] = [torque.torque[joint], 1.0];
        for (by_offset, by) in by_offsets.iter_mut().zip(&torque.by_coordinate[n * joint..]) {
            *by_offset = gain * by;
        }
        // Links before the joint do not load it: their entries stay zero, unless they make a joint give way.
        let felt = &self.model.links[joint];
        let felt = INERTIA * felt.start..INERTIA * felt.end;
        let by_inertia = &torque.by_inertia[INERTIA * links * joint..];
        by_links[felt.clone()].iter_mut().zip(&by_inertia[felt]).for_each(|(entry, by)| *entry = gain * by);
        self.finish_row(by_position_gains, by_offsets, by_links, (load, by_load));
    }

    /// The columns of gravity, torque gains and biases, position gains, offsets, links and load.
    #[inline(always)]
    pub(super) fn parts<'r, L>(&self, row: &'r mut [L]) -> [&'r mut [L]; 6] {
        let n = self.position.len();
        let (by_gravity, rest) = row.split_at_mut(GRAVITY);
        let (by_torque_sensors, rest) = rest.split_at_mut(2 * n);
        let (by_position_gains, rest) = rest.split_at_mut(n);
        let (by_offsets, rest) = rest.split_at_mut(n);
        let (by_links, by_load) = rest.split_at_mut(INERTIA * self.model.chain.link_count());
        [by_gravity, by_torque_sensors, by_position_gains, by_offsets, by_links, by_load]
    }

    /// What follows from the columns of offsets and links.
    #[inline(always)]
    pub(super) fn finish_row(
        &self,
        by_position_gains: &mut [f64],
        by_offsets: &[f64],
        by_links: &[f64],
        (load, by_load): (Option<LoadState>, &mut [f64]),
    ) {
        for ((by_gain, q), by_offset) in by_position_gains.iter_mut().zip(&self.position).zip(by_offsets) {
            *by_gain = q * by_offset;
        }
        if let Some((carried, LoadState { mass, position })) = self.model.load.as_ref().zip(load) {
            let [by_mass, by_moment @ ..] = by_links.as_chunks::<INERTIA>().0[carried.link];
            let (parts, rest) = by_load[..carried.columns()].split_at_mut(carried.position_columns());
            parts.as_chunks_mut().0.fill(by_moment.map(|by| mass * by));
            let [x, y, z] = [0, 1, 2].map(|axis| by_moment[axis] * position[axis]);
            rest.fill(by_mass + x + y + z);
        }
    }

    fn evaluate_in(
        &self,
        Workspace { coordinates, inertia, torque, bodies, row: scratch, slopes, .. }: &mut Workspace,
        x: &[f64],
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let terms = self.model.terms.as_ref();
        self.set_coordinates(x, coordinates);
        if let Some(terms) = terms {
            terms.fit(slopes);
            let slopes = jacobian.is_some().then_some(&mut *slopes);
            terms.add_to_coordinates((&self.position, &self.conditions), x, coordinates, slopes);
        }
        self.set_inertia(&x[..self.model.affine_columns], inertia);
        let (gravity, load) = ([x[0], x[1], x[2]], self.load(x));
        let (gain, bias) = (self.sensors(x, SensorParameter::TorqueGain), self.sensors(x, SensorParameter::TorqueBias));
        if let Some(rows) = jacobian.as_mut().filter(|_| self.model.is_affine())
            && let Some(torques) = self.model.chain.gravity_torque_rows(Single, coordinates, gravity, inertia, bodies)
        {
            for (row, (residual, (joint, reading))) in residual.iter_mut().zip(&self.readings).enumerate() {
                let torque = torques.of_joint(*joint);
                self.write_affine(Single, &torque, gain[*joint], (&self.position, load), rows.row(row));
                *residual = self.predict_affine(Single, &torque, [gain[*joint], bias[*joint]]) - reading;
            }
            return Ok(());
        }
        let compliance = self.model.compliance.map(|column| &x[column..column + self.position.len()]);
        if let Some(compliance) = compliance {
            compliance::settle(&self.model.chain, coordinates, gravity, inertia, compliance, torque)?;
        } else if jacobian.is_some() {
            self.model.chain.linearize_gravity_torque(coordinates, gravity, inertia, torque);
        } else {
            self.model.chain.update_gravity_torque(coordinates, gravity, inertia, torque);
        }
        let at = Moment::new(&torque.torque, coordinates, &self.position, &self.conditions);
        for (row, (residual, (joint, reading))) in residual.iter_mut().zip(&self.readings).enumerate() {
            let (gain, bias) = (gain[*joint], bias[*joint]);
            *residual = gain * torque.torque[*joint] + bias - reading;
            if let Some(terms) = terms {
                let slopes = jacobian.is_some().then_some(&mut *slopes);
                *residual += terms.reading(*joint, &at, x, slopes);
            }
            let Some(rows) = &mut jacobian else { continue };
            let row = rows.row(row);
            match terms {
                None => self.fill_row(gain, *joint, torque, load, row),
                Some(terms) => {
                    if let Some(compliance) = compliance {
                        slopes.with_compliance(terms.coordinates(*joint), compliance);
                    }
                    self.fill_row_with_terms((terms, slopes), gain, *joint, (torque, load), row, scratch);
                }
            }
            if let Some(column) = self.model.compliance {
                self.fill_compliances(column, torque, row);
            }
        }
        Ok(())
    }

    /// A compliance enters like its joint's offset, times the torque.
    fn fill_compliances(&self, column: usize, torque: &GravityTorque, row: &mut [f64]) {
        let joints = self.position.len();
        for (joint, torque) in torque.torque.iter().enumerate() {
            row[column + joint] = torque * row[sensor_column(joints, SensorParameter::PositionOffset, joint)];
        }
    }
}

impl Residual for PoseTorque {
    fn blocks(&self) -> &[BlockId] {
        &self.model.blocks
    }

    fn len(&self) -> usize {
        self.readings.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.model.patterns[self.readings[row].0])
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        self.with_workspace(|workspace| self.evaluate_in(workspace, x.as_slice(), residual, jacobian))
    }

    fn as_sample(&self) -> Option<Sample<'_>> {
        Some(Sample::of(self))
    }
}

impl Batched for PoseTorque {
    fn evaluate_batch(
        poses: [&PoseTorque; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool {
        let Some(alike) = batch::Poses::of(poses) else { return false };
        let x = x.map(|x| x.as_slice());
        poses[0].with_workspace(|workspace| alike.evaluate(workspace, x, residual, jacobian))
    }
}
