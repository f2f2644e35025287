//! All torque readings of one static pose.
//!
//! ```text
//!     y_i = k_i τ_i(θ; g, moments, load) + b_i,     θ_j = s_j q_j + o_j
//! ```
//!
//! `τ_i = z_{i−1} · (g × M_i)` is the chain's gravity torque (see `gravcal-kinematics`). A load of mass `m_L` at
//! `r_L` adds `(m_L, m_L r_L)` to the mass and first moment of the link that carries it. Joints without a usable
//! reading have no row. What sensors do beyond this is in [`crate::sensors`]; where all are affine it costs nothing.
//! Joints that give way under their torque are where `compliance.rs` finds them.

mod compliance;
mod model;
mod terms;

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use gravcal_kinematics::{Chain, GravityTorque, GravityTorqueRows};
use gravcal_recording::Conditions;

pub(crate) use model::joined;
pub use model::{CarriedLoad, PoseTorqueBlocks, PoseTorqueModel};
use model::{GRAVITY, INERTIA, inertia_column, sensor_column};

use crate::parameter::Quantity;

/// The torque readings of one pose.
#[derive(Clone, Debug)]
pub struct PoseTorque {
    model: Arc<PoseTorqueModel>,
    /// Position reading of every joint.
    position: Vec<f64>,
    /// Joint and torque reading of each row.
    readings: Vec<(usize, f64)>,
    /// What terms of the sensors read besides.
    conditions: Conditions,
    /// The joint that sweeps, and so does not deflect like those that stand.
    sweeping: Option<usize>,
}

/// What an evaluation computes on the way, kept by each thread from one pose to the next.
struct Workspace {
    coordinates: Vec<f64>,
    inertia: Vec<f64>,
    torque: GravityTorque,
    /// A row of the Jacobian, for terms of sensors that read other joints' torques.
    row: Vec<f64>,
}

impl Workspace {
    fn new(joints: usize, links: usize) -> Self {
        Workspace {
            coordinates: vec![0.0; joints],
            inertia: vec![0.0; INERTIA * links],
            torque: GravityTorque::new(joints, links),
            row: Vec::new(),
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
        PoseTorque { model, position, readings, conditions: Conditions::default(), sweeping: None }
    }

    /// The same, read under these conditions.
    pub fn under(self, conditions: Conditions) -> Self {
        PoseTorque { conditions, ..self }
    }

    /// The same in a sweep of this joint: where joints give way, it does not.
    pub fn sweeping(self, joint: Option<usize>) -> Self {
        PoseTorque { sweeping: joint, ..self }
    }

    /// The joint whose reading a row is.
    pub(crate) fn joint_of_row(&self, row: usize) -> usize {
        self.readings[row].0
    }

    /// One parameter of every joint's sensors.
    fn sensors<'x>(&self, x: &'x [f64], quantity: Quantity) -> &'x [f64] {
        let joints = self.position.len();
        &x[sensor_column(joints, quantity, 0)..sensor_column(joints, quantity, joints)]
    }

    /// True coordinates of all joints.
    fn set_coordinates(&self, x: &[f64], coordinates: &mut [f64]) {
        let (gains, offsets) = (self.sensors(x, Quantity::PositionGain), self.sensors(x, Quantity::PositionOffset));
        for (((coordinate, q), gain), offset) in coordinates.iter_mut().zip(&self.position).zip(gains).zip(offsets) {
            *coordinate = gain * q + offset;
        }
    }

    /// Masses and moments of all links, the load's included.
    fn set_inertia(&self, x: &[f64], inertia: &mut [f64]) {
        let (links, beyond) = x[inertia_column(self.position.len(), 0)..].split_at(inertia.len());
        inertia.copy_from_slice(links);
        if let Some(CarriedLoad { mass, link, ref position }) = self.model.load {
            let load = &beyond[..3 * position.len()];
            let carried = &mut inertia[INERTIA * link..INERTIA * (link + 1)];
            carried[0] += mass;
            for part in load.chunks_exact(3) {
                carried[1..].iter_mut().zip(part).for_each(|(h, r)| *h += mass * r);
            }
        }
    }

    /// The row of a joint's reading, times `gain`, from derivatives of all torques: where sensors have terms, joints give way or mimic
    /// others.
    fn fill_row(&self, gain: f64, joint: usize, torque: &GravityTorque, row: &mut [f64]) {
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
        self.finish_row(by_position_gains, by_offsets, by_links, by_load);
    }

    /// The same written straight from where the arm stands; gives the joint's torque.
    fn write_row(&self, gain: f64, joint: usize, torques: &GravityTorqueRows<'_>, row: &mut [f64]) -> f64 {
        let [by_gravity, by_torque_sensors, by_position_gains, by_offsets, by_links, by_load] = self.parts(row);
        let torque = torques.write(joint, gain, by_gravity, by_offsets, by_links);
        [by_torque_sensors[joint], by_torque_sensors[self.position.len() + joint]] = [torque, 1.0];
        self.finish_row(by_position_gains, by_offsets, by_links, by_load);
        torque
    }

    /// The columns of gravity, torque gains and biases, position gains, offsets, links and load.
    #[inline(always)]
    fn parts<'r>(&self, row: &'r mut [f64]) -> [&'r mut [f64]; 6] {
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
    fn finish_row(&self, by_position_gains: &mut [f64], by_offsets: &[f64], by_links: &[f64], by_load: &mut [f64]) {
        for ((by_gain, q), by_offset) in by_position_gains.iter_mut().zip(&self.position).zip(by_offsets) {
            *by_gain = q * by_offset;
        }
        if let Some(CarriedLoad { mass, link, ref position }) = self.model.load {
            let [_, by_moment @ ..] = by_links.as_chunks::<INERTIA>().0[link];
            for part in by_load[..3 * position.len()].as_chunks_mut().0 {
                *part = by_moment.map(|by| mass * by);
            }
        }
    }

    fn evaluate_in(
        &self,
        Workspace { coordinates, inertia, torque, row: scratch }: &mut Workspace,
        x: &[f64],
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let terms = self.model.terms.as_ref();
        self.set_coordinates(x, coordinates);
        if let Some(terms) = terms {
            terms.add_to_coordinates(&self.position, x, coordinates);
        }
        self.set_inertia(&x[..self.model.affine_columns], inertia);
        let gravity = [x[0], x[1], x[2]];
        let (gain, bias) = (self.sensors(x, Quantity::TorqueGain), self.sensors(x, Quantity::TorqueBias));
        let affine = terms.is_none() && self.model.compliance.is_none();
        if let Some(rows) = jacobian.as_mut().filter(|_| affine)
            && let Some(torques) = self.model.chain.gravity_torque_rows(coordinates, gravity, inertia, torque)
        {
            for (row, (residual, (joint, reading))) in residual.iter_mut().zip(&self.readings).enumerate() {
                let torque = self.write_row(gain[*joint], *joint, &torques, rows.row(row));
                *residual = gain[*joint] * torque + bias[*joint] - reading;
            }
            return Ok(());
        }
        if let Some(column) = self.model.compliance {
            let compliance = self.compliance(&x[column..]);
            compliance::settle(&self.model.chain, coordinates, gravity, inertia, &compliance, torque)?;
        } else if jacobian.is_some() {
            self.model.chain.linearize_gravity_torque(coordinates, gravity, inertia, torque);
        } else {
            self.model.chain.update_gravity_torque(coordinates, gravity, inertia, torque);
        }
        for (residual, (joint, reading)) in residual.iter_mut().zip(&self.readings) {
            let (gain, bias) = (gain[*joint], bias[*joint]);
            *residual = gain * torque.torque[*joint] + bias - reading;
            if let Some(terms) = terms {
                *residual += terms.reading(*joint, &torque.torque, &self.conditions, x);
            }
        }
        if let Some(mut rows) = jacobian {
            for (row, (joint, _)) in self.readings.iter().enumerate() {
                let row = rows.row(row);
                match terms {
                    None => self.fill_row(gain[*joint], *joint, torque, row),
                    Some(terms) => self.fill_row_with_terms(terms, x, *joint, torque, row, scratch),
                }
                if let Some(column) = self.model.compliance {
                    self.fill_compliances(column, torque, row);
                }
            }
        }
        Ok(())
    }

    /// `c` of each joint, 0 of the one that sweeps.
    fn compliance(&self, stored: &[f64]) -> Vec<f64> {
        let own = |(joint, c): (usize, &f64)| if self.sweeping == Some(joint) { 0.0 } else { *c };
        stored.iter().take(self.position.len()).enumerate().map(own).collect()
    }

    /// A compliance enters like its joint's offset, times the torque.
    fn fill_compliances(&self, column: usize, torque: &GravityTorque, row: &mut [f64]) {
        let joints = self.position.len();
        for (joint, torque) in torque.torque.iter().enumerate() {
            let by_offset = row[sensor_column(joints, Quantity::PositionOffset, joint)];
            row[column + joint] = if self.sweeping == Some(joint) { 0.0 } else { by_offset * torque };
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
        WORKSPACE.with_borrow_mut(|workspace| {
            let chain = &self.model.chain;
            if !workspace.is_for(chain) {
                *workspace = Workspace::new(chain.joint_count(), chain.link_count());
            }
            self.evaluate_in(workspace, x.as_slice(), residual, jacobian)
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use gravcal_kinematics::{
        Attachment, DhConvention, DhRow, Joint, JointKind, Link, Mimic, Transform, chain_from_dh,
    };

    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};
    use crate::sensors::SensorTerms;
    use crate::sensors::testing::every_term;

    /// Position readings of a pose of [`some_chain`].
    pub const READ_POSITIONS: [f64; 3] = [0.3, 0.2, -0.8];

    /// Turning, sliding and turning joint.
    pub fn some_chain() -> Chain {
        let row = |i: usize, kind, a, alpha, d| DhRow {
            name: format!("joint{i}"),
            kind,
            a,
            alpha,
            d,
            theta: 0.1,
            limits: None,
            link: Link { name: format!("link{i}"), inertia: None },
        };
        let rows = [
            row(1, JointKind::Revolute, 0.1, 1.2, 0.3),
            row(2, JointKind::Prismatic, 0.2, -0.7, 0.1),
            row(3, JointKind::Revolute, -0.3, 0.4, 0.2),
        ];
        chain_from_dh("base", DhConvention::Standard, &rows).unwrap()
    }

    /// A trunk with two branches of two joints; the last joint mimics the first of the other branch.
    fn branched_chain() -> Chain {
        let joint = |i: usize, kind| Joint {
            name: format!("joint{i}"),
            kind,
            before: Transform::from_xyz_rpy([0.1, 0.3 - 0.1 * i as f64, 0.2], [0.3, 0.2 * i as f64, -0.4]),
            axis: [0.0, 0.6, 0.8],
            after: Transform::about_x(0.5),
            limits: None,
        };
        let mut kinds = [JointKind::Revolute; 5];
        kinds[2] = JointKind::Prismatic;
        let joints = kinds.into_iter().enumerate().map(|(i, kind)| joint(i, kind)).collect();
        let links = (0..5).map(|i| Link { name: format!("link{i}"), inertia: None }).collect();
        let mut attachments =
            [None, Some(0), Some(1), Some(0), Some(3)].map(|parent| Attachment { parent, mimic: None });
        attachments[4].mimic = Some(Mimic { leader: 1, multiplier: -0.5, offset: 0.2 });
        Chain::branched("base", joints, links, &attachments).unwrap()
    }

    /// Readings of three of its four joints with a load on the last link, and so many compliances; lengths of the blocks.
    fn on_branches(compliances: usize) -> (PoseTorque, Vec<usize>) {
        let lengths = [vec![3], vec![1; 16], vec![4; 5], vec![3], vec![1; compliances]].concat();
        let ids = ids(&lengths);
        let blocks = PoseTorqueBlocks {
            gravity: ids[0],
            sensors: (0..4).map(|j| std::array::from_fn(|k| ids[1 + 4 * j + k])).collect(),
            inertia: ids[17..22].to_vec(),
            terms: Vec::new(),
            compliance: ids[23..].to_vec(),
        };
        let load = CarriedLoad { position: vec![ids[22]], mass: 1.7, link: 4 };
        let model = PoseTorqueModel::new(Arc::new(branched_chain()), &blocks, &SensorTerms::default(), Some(load));
        let readings = vec![(0, 2.0), (1, 1.0), (2, -1.0)];
        (PoseTorque::new(Arc::new(model), vec![0.3, 0.2, -0.8, 0.5], readings), lengths)
    }

    #[test]
    fn derivatives_on_branches() {
        let (residual, lengths) = on_branches(0);
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
        assert_rows_within_their_patterns(&residual, &lengths);
        // The sliding joint of one branch: its own sensors, positions of trunk and branch, its link, the load's columns.
        assert_eq!(residual.row_pattern(2).unwrap(), [0..3, 5..6, 9..10, 11..14, 15..18, 27..31, 39..42]);

        let (compliant, lengths) = on_branches(4);
        assert_rows_within_their_patterns(&compliant, &lengths);
        let width: usize = lengths.iter().sum();
        let mut x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
        x[width - 4..].iter_mut().for_each(|c| *c *= 0.01);
        gravcal_estimation::check_derivatives(&compliant, &lengths, &x, 1e-5).unwrap();
    }

    /// Lengths of the blocks of a chain of three joints with a load, and so many of one number beyond.
    pub fn lengths(beyond: usize) -> Vec<usize> {
        [vec![3], vec![1; 12], vec![4, 4, 4, 3, 3], vec![1; beyond]].concat()
    }

    /// A chain of three joints with a load on the second link; blocks after it are those of the terms, then compliances.
    pub fn model_of(chain: Chain, terms: &SensorTerms, ids: &[BlockId]) -> PoseTorqueModel {
        let blocks = PoseTorqueBlocks {
            gravity: ids[0],
            sensors: (0..3).map(|j| std::array::from_fn(|k| ids[1 + 4 * j + k])).collect(),
            inertia: ids[13..16].to_vec(),
            terms: ids[18..18 + terms.len()].to_vec(),
            compliance: ids[18 + terms.len()..].to_vec(),
        };
        let load = CarriedLoad { position: ids[16..18].to_vec(), mass: 1.7, link: 1 };
        PoseTorqueModel::new(Arc::new(chain), &blocks, terms, Some(load))
    }

    /// Readings of the given joints of [`some_chain`], and the lengths of the blocks.
    pub fn loaded(joints: &[usize]) -> (PoseTorque, Vec<usize>) {
        let lengths = lengths(0);
        let model = Arc::new(model_of(some_chain(), &SensorTerms::default(), &ids(&lengths)));
        let readings = joints.iter().map(|joint| (*joint, 2.0)).collect();
        (PoseTorque::new(model, READ_POSITIONS.to_vec(), readings), lengths)
    }

    #[test]
    fn derivatives() {
        let (residual, lengths) = loaded(&[0, 2]);
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    /// Joints that give way, the second one sweeping.
    fn compliant() -> (PoseTorque, Vec<usize>) {
        let lengths = lengths(3);
        let model = Arc::new(model_of(some_chain(), &SensorTerms::default(), &ids(&lengths)));
        let pose = PoseTorque::new(model, READ_POSITIONS.to_vec(), vec![(0, 2.0), (2, 1.0)]).sweeping(Some(1));
        (pose, lengths)
    }

    #[test]
    fn derivatives_of_joints_that_give_way() {
        let (residual, lengths) = compliant();
        let width: usize = lengths.iter().sum();
        let mut random = rand_pcg::Pcg64::seed_from_u64(3);
        for _ in 0..20 {
            let mut x: Vec<f64> = (0..width).map(|_| random.random_range(-1.5..2.5)).collect();
            // Differences are rough where much depends on a number as small as a compliance.
            x[33..].iter_mut().for_each(|c| *c *= 0.02);
            gravcal_estimation::check_derivatives(&residual, &lengths, &x, 1e-5).unwrap();
        }
    }

    /// A joint rests where its unloaded place and compliance times torque put it.
    #[test]
    fn joints_rest_where_their_torque_leaves_them() {
        let chain = some_chain();
        let (unloaded, inertia) = ([0.3, 0.2, -0.8], [1.0, 0.1, 0.2, 0.3].repeat(3));
        let (gravity, compliance) = ([1.0, -2.0, -9.0], [0.02, 0.0, 0.03]);
        let (mut coordinates, mut torque) = (unloaded, GravityTorque::new(3, 3));
        compliance::settle(&chain, &mut coordinates, gravity, &inertia, &compliance, &mut torque).unwrap();
        let mut expected = [0.0; 3];
        chain.gravity_torque(&coordinates, gravity, &inertia, &mut expected);
        for joint in 0..3 {
            assert!((torque.torque[joint] - expected[joint]).abs() < 1e-12);
            assert!((coordinates[joint] - unloaded[joint] - compliance[joint] * expected[joint]).abs() < 1e-12);
        }
        let error = compliance::settle(&chain, &mut coordinates, gravity, &inertia, &[f64::NAN; 3], &mut torque);
        assert!(error.unwrap_err().to_string().contains("no rest"));
    }

    /// The same with every sensor model on every joint that can have it; the lengths of its blocks.
    fn with_all_terms(compliances: usize) -> (PoseTorque, Vec<usize>) {
        let terms = every_term();
        let lengths = lengths(terms.len() + compliances);
        let model = Arc::new(model_of(some_chain(), &terms, &ids(&lengths)));
        let conditions = Conditions {
            time: Some(1.3),
            temperature: vec![24.0, 26.0, 29.0],
            velocity: vec![0.3, -0.2, 0.4],
            acceleration: Vec::new(),
            direction: vec![1.0, -1.0, 0.0],
        };
        let readings = vec![(0, 2.0), (1, 2.0), (2, 2.0)];
        (PoseTorque::new(model, READ_POSITIONS.to_vec(), readings).under(conditions), lengths)
    }

    #[test]
    fn derivatives_with_every_term() {
        let (residual, lengths) = with_all_terms(0);
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    #[test]
    fn joints_that_give_way_go_with_every_term() {
        let (residual, lengths) = with_all_terms(3);
        assert_rows_within_their_patterns(&residual, &lengths);
        let width: usize = lengths.iter().sum();
        let mut x: Vec<f64> = (0..width).map(|k| 0.5 + (k as f64).sin()).collect();
        x[width - 3..].iter_mut().for_each(|c| *c *= 0.01);
        gravcal_estimation::check_derivatives(&residual, &lengths, &x, 1e-5).unwrap();
    }

    #[test]
    fn rows_with_terms_touch_only_the_columns_of_their_pattern() {
        let (residual, lengths) = with_all_terms(0);
        assert_rows_within_their_patterns(&residual, &lengths);
    }

    #[test]
    fn rows_touch_only_the_columns_of_their_pattern() {
        let (residual, _) = compliant();
        assert_eq!(residual.row_pattern(0).unwrap(), [0..4, 6..7, 9..36]);
        let (residual, lengths) = loaded(&[0, 1, 2]);
        assert_eq!(residual.row_pattern(0).unwrap(), [0..4, 6..7, 9..33]);
        assert_eq!(residual.row_pattern(1).unwrap(), [0..3, 4..5, 7..8, 9..15, 19..33]);
        assert_eq!(residual.row_pattern(2).unwrap(), [0..3, 5..6, 8..15, 23..33]);
        assert_rows_within_their_patterns(&residual, &lengths);
    }

    fn assert_rows_within_their_patterns(residual: &PoseTorque, lengths: &[usize]) {
        let offsets: Vec<usize> = (0..=lengths.len()).map(|blocks| lengths[..blocks].iter().sum()).collect();
        let width: usize = lengths.iter().sum();
        // Small, so that joints that give way find a rest.
        let x: Vec<f64> = (0..width).map(|k| 0.2 + 0.1 * (k as f64).sin()).collect();
        let (mut values, mut jacobian) = ([0.0; 3], vec![0.0; 3 * width]);
        let rows = RowsMut::new(&mut jacobian, width);
        residual.evaluate(LocalValues::new(&x, &offsets), &mut values, Some(rows)).unwrap();
        for (row, entries) in jacobian.chunks(width).enumerate() {
            let pattern = residual.row_pattern(row).unwrap();
            let touched = entries.iter().enumerate().filter(|(_, entry)| **entry != 0.0);
            touched.for_each(|(column, _)| {
                assert!(pattern.iter().any(|range| range.contains(&column)), "{row}, {column}")
            });
        }
    }
}
