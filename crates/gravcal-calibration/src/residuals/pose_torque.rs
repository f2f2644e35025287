//! All torque readings of one static pose.
//!
//! ```text
//!     y_i = k_i τ_i(θ; g, moments, load) + b_i,     θ_j = s_j q_j + o_j
//! ```
//!
//! `τ_i = z_{i−1} · (g × M_i)` is the chain's gravity torque (see `gravcal-kinematics`). A load of mass `m_L` at
//! `r_L` adds `(m_L, m_L r_L)` to the mass and first moment of the link that carries it. Joints without a usable
//! reading have no row.

use std::sync::Arc;

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use gravcal_kinematics::{Chain, GravityTorque};

/// Blocks of a [`PoseTorque`], shared by all poses.
#[derive(Clone, Debug)]
pub struct PoseTorqueBlocks {
    /// g in base coordinates, m/s².
    pub gravity: BlockId,
    /// `[k, b, s, o]` of each joint.
    pub sensors: Vec<[BlockId; 4]>,
    /// `(m, h_x, h_y, h_z)` of each link.
    pub inertia: Vec<BlockId>,
}

/// A load that hangs on the robot during a pose.
#[derive(Clone, Debug)]
pub struct CarriedLoad {
    /// Blocks whose sum is its centre of mass in the link's frame, m.
    pub position: Vec<BlockId>,
    /// kg.
    pub mass: f64,
    /// Index of the link.
    pub link: usize,
}

/// The torque readings of one pose.
#[derive(Clone, Debug)]
pub struct PoseTorque {
    chain: Arc<Chain>,
    blocks: Vec<BlockId>,
    /// Position reading of every joint.
    position: Vec<f64>,
    /// Joint and torque reading of each row.
    readings: Vec<(usize, f64)>,
    load: Option<CarriedLoad>,
}

impl PoseTorque {
    /// `position`: reading of every joint; `readings`: joint and torque reading, one a row.
    pub fn new(
        chain: Arc<Chain>,
        blocks: &PoseTorqueBlocks,
        position: Vec<f64>,
        readings: Vec<(usize, f64)>,
        load: Option<CarriedLoad>,
    ) -> Self {
        let mut order = vec![blocks.gravity];
        order.extend(blocks.sensors.iter().flatten());
        order.extend(&blocks.inertia);
        order.extend(load.iter().flat_map(|l| &l.position));
        PoseTorque { chain, blocks: order, position, readings, load }
    }

    /// Local block index of the first sensor parameter of a joint.
    fn sensor_block(joint: usize) -> usize {
        1 + 4 * joint
    }

    fn inertia_block(&self) -> usize {
        1 + 4 * self.position.len()
    }

    fn load_block(&self) -> usize {
        self.inertia_block() + self.position.len()
    }

    /// True coordinates of all joints.
    fn coordinates(&self, x: LocalValues<'_>) -> Vec<f64> {
        self.position
            .iter()
            .enumerate()
            .map(|(joint, q)| {
                let block = Self::sensor_block(joint);
                x.scalar(block + 2) * q + x.scalar(block + 3)
            })
            .collect()
    }

    /// Masses and moments of all links, the load's included.
    fn inertia(&self, x: LocalValues<'_>) -> Vec<f64> {
        let start = x.column(self.inertia_block());
        let mut inertia = x.as_slice()[start..start + 4 * self.position.len()].to_vec();
        if let Some(load) = &self.load {
            let carried = &mut inertia[4 * load.link..4 * load.link + 4];
            carried[0] += load.mass;
            for part in 0..load.position.len() {
                let position = x.block(self.load_block() + part);
                carried[1..].iter_mut().zip(position).for_each(|(h, r)| *h += load.mass * r);
            }
        }
        inertia
    }

    fn fill_row(&self, x: LocalValues<'_>, joint: usize, torque: &GravityTorque, row: &mut [f64]) {
        let n = self.position.len();
        let gain = x.scalar(Self::sensor_block(joint));
        let by_gravity = &torque.by_gravity[3 * joint..3 * joint + 3];
        row[..3].iter_mut().zip(by_gravity).for_each(|(entry, by)| *entry = gain * by);
        for other in 0..n {
            let by_coordinate = gain * torque.by_coordinate[n * joint + other];
            let column = x.column(Self::sensor_block(other));
            row[column + 2] = by_coordinate * self.position[other];
            row[column + 3] = by_coordinate;
        }
        let own = x.column(Self::sensor_block(joint));
        row[own] = torque.torque[joint];
        row[own + 1] = 1.0;
        let by_inertia = &torque.by_inertia[4 * n * joint..4 * n * (joint + 1)];
        let inertia = x.column(self.inertia_block());
        // Links before the joint do not load it: their entries stay zero.
        for k in 4 * joint..4 * n {
            row[inertia + k] = gain * by_inertia[k];
        }
        if let Some(load) = &self.load {
            for part in 0..load.position.len() {
                let column = x.column(self.load_block() + part);
                for axis in 0..3 {
                    row[column + axis] = gain * load.mass * by_inertia[4 * load.link + 1 + axis];
                }
            }
        }
    }
}

impl Residual for PoseTorque {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.readings.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let n = self.position.len();
        let coordinates = self.coordinates(x);
        let inertia = self.inertia(x);
        let gravity = [x.block(0)[0], x.block(0)[1], x.block(0)[2]];
        let mut torque = GravityTorque::new(n);
        if jacobian.is_some() {
            self.chain.linearize_gravity_torque(&coordinates, gravity, &inertia, &mut torque);
        } else {
            self.chain.gravity_torque(&coordinates, gravity, &inertia, &mut torque.torque);
        }
        for (row, (joint, reading)) in self.readings.iter().enumerate() {
            let block = Self::sensor_block(*joint);
            residual[row] = x.scalar(block) * torque.torque[*joint] + x.scalar(block + 1) - reading;
        }
        if let Some(mut rows) = jacobian {
            for (row, (joint, _)) in self.readings.iter().enumerate() {
                self.fill_row(x, *joint, &torque, rows.row(row));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use gravcal_kinematics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};

    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    #[test]
    fn derivatives() {
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
        let chain = Arc::new(chain_from_dh("base", DhConvention::Standard, &rows).unwrap());
        let mut lengths = vec![3];
        lengths.extend([1; 12]);
        lengths.extend([4, 4, 4, 3, 3]);
        let ids = ids(&lengths);
        let blocks = PoseTorqueBlocks {
            gravity: ids[0],
            sensors: (0..3).map(|j| std::array::from_fn(|k| ids[1 + 4 * j + k])).collect(),
            inertia: ids[13..16].to_vec(),
        };
        let load = CarriedLoad { position: ids[16..18].to_vec(), mass: 1.7, link: 1 };
        let readings = vec![(0, 3.0), (2, 1.0)];
        let residual = PoseTorque::new(chain, &blocks, vec![0.3, 0.2, -0.8], readings, Some(load));
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }
}
