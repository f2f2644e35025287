//! Force and moment that carry what hangs beyond a six-axis sensor.
//!
//! ```text
//!     u = (f, n),    f = −m v,    n = v × h
//!     m = m_tool + m_L,    h = h_tool + m_L r_s,    r_s = R_mᵀ (r_L − p_m)
//! ```
//!
//! It is what the link exerts on the tool through the sensor, in the sensor's frame and about its origin: the sign of the
//! joints' holding torques, `τ = z · (g × M)`. `v` is gravity in that frame; `m_tool`, `h_tool` are mass and first moment
//! of what always hangs beyond the sensor; a load of mass `m_L` at `r_L` in the link's frame hangs there, too (`p_m`,
//! `R_m`: the sensor's mounting in that frame).
//!
//! The tool is part of the last link, whose whole mass and moment the joint torques see: the tool's own are unknowns that
//! only this sensor reads. The loads are read by both.

use gravcal_dynamics::Transform;
use gravcal_estimation::BlockId;
use nalgebra::{Matrix3, Vector3};

use super::sensed::{Sensed, SensedQuantity};
use crate::residuals::CarriedLoad;
use crate::residuals::pose_torque::LoadState;

/// What a six-axis force and torque sensor senses; N and N·m.
#[derive(Clone, Debug)]
pub struct Wrench {
    /// `[m, h_x, h_y, h_z]` of the tool, kg and kg·m in the sensor's frame.
    tool: [BlockId; 4],
    load: Option<CarriedLoad>,
    /// Rotation of the link's frame in the sensor's, and position of its origin there.
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
}

impl Wrench {
    /// `mounting`: the sensor's frame in the link's; `load`: what hangs on that link in the pose.
    pub fn new(mounting: &Transform, tool: [BlockId; 4], load: Option<CarriedLoad>) -> Self {
        let link = mounting.inverse();
        let rotation = link.rotation();
        Wrench {
            tool,
            load,
            rotation: Matrix3::from_fn(|i, j| rotation[i][j]),
            origin: Vector3::from(link.translation()),
        }
    }
}

impl SensedQuantity for Wrench {
    fn axes(&self) -> usize {
        6
    }

    fn blocks(&self) -> Vec<BlockId> {
        self.tool.into_iter().chain(self.load.iter().flat_map(CarriedLoad::blocks)).collect()
    }

    fn sense(&self, gravity: &Vector3<f64>, own: &[f64]) -> Sensed {
        let (tool, stored) = own.split_at(4);
        let nothing = LoadState { mass: 0.0, position: [0.0; 3] };
        let LoadState { mass: load_mass, position } = self.load.as_ref().map_or(nothing, |load| load.at(stored));
        let load_position = self.origin + self.rotation * Vector3::from(position);
        let mass = tool[0] + load_mass;
        let moment = Vector3::from_column_slice(&tool[1..]) + load_mass * load_position;
        let (force, torque) = (-mass * gravity, gravity.cross(&moment));
        // n = v × h: by v it is −[h], by h it is [v].
        let (force_by_gravity, torque_by_gravity) = (-mass * Matrix3::identity(), -moment.cross_matrix());
        let by_moment = gravity.cross_matrix();
        let by_position = load_mass * by_moment * self.rotation;
        let mass_column = self.load.as_ref().map(|load| 4 + load.position_columns()).filter(|place| *place < own.len());
        let by_load_mass = by_moment * load_position;
        let mut by_own = vec![vec![0.0; own.len()]; 6];
        for axis in 0..3 {
            by_own[axis][0] = -gravity[axis];
            for other in 0..3 {
                by_own[3 + axis][1 + other] = by_moment[(axis, other)];
                let parts = by_own[3 + axis][4..].chunks_exact_mut(3);
                parts.for_each(|part| part[other] = by_position[(axis, other)]);
            }
            if let Some(column) = mass_column {
                (by_own[axis][column], by_own[3 + axis][column]) = (-gravity[axis], by_load_mass[axis]);
            }
        }
        let rows = |matrix: Matrix3<f64>| (0..3).map(move |axis| matrix.row(axis).transpose());
        Sensed {
            value: force.iter().chain(&torque).copied().collect(),
            by_gravity: rows(force_by_gravity).chain(rows(torque_by_gravity)).collect(),
            by_own,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::tests::check;
    use super::*;
    use crate::residuals::LoadMass;
    use crate::residuals::testing::ids;

    fn mounting() -> Transform {
        Transform::from_xyz_rpy([0.01, -0.02, 0.1], [0.3, -0.2, 0.5])
    }

    #[test]
    fn derivatives() {
        let tool = |own: &[BlockId]| [own[0], own[1], own[2], own[3]];
        for full in [false, true] {
            check(6, full, &[1; 4], |own| Arc::new(Wrench::new(&mounting(), tool(own), None)));
            check(6, full, &[1, 1, 1, 1, 3, 3], |own| {
                let load = CarriedLoad { position: own[4..].to_vec(), mass: LoadMass::Known(1.7), link: 2 };
                Arc::new(Wrench::new(&mounting(), tool(own), Some(load)))
            });
            check(6, full, &[1, 1, 1, 1, 3, 3, 1], |own| {
                let load = CarriedLoad { position: own[4..6].to_vec(), mass: LoadMass::Unknown(own[6]), link: 2 };
                Arc::new(Wrench::new(&mounting(), tool(own), Some(load)))
            });
        }
    }

    #[test]
    fn the_link_holds_what_hangs_beyond_the_sensor() {
        let ids = ids(&[1, 1, 1, 1, 3]);
        let load = CarriedLoad { position: vec![ids[4]], mass: LoadMass::Known(2.0), link: 0 };
        let sensor = Wrench::new(&Transform::along([0.0, 0.0, 0.1]), [ids[0], ids[1], ids[2], ids[3]], Some(load));
        // A tool of 1 kg at the sensor's origin, the load 0.3 m along x of it; gravity points along −z.
        let sensed = sensor.sense(&Vector3::new(0.0, 0.0, -9.8), &[1.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.1]);
        let expected = [0.0, 0.0, 3.0 * 9.8, 0.0, -2.0 * 9.8 * 0.3, 0.0];
        for (value, expected) in sensed.value.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-14, "{:?}", sensed.value);
        }
        // As a joint about the sensor's y would hold it: τ = y · (g × M).
        let moment = Vector3::new(0.6, 0.0, 0.0);
        assert_eq!(sensed.value[4], Vector3::new(0.0, 0.0, -9.8).cross(&moment).y);
    }
}
