//! What affine sensors read of the torques, of one pose or of several at once.

use gravcal_dynamics::{Arithmetic, GravityTorqueRow, Stored};

use super::model::{CarriedLoad, LoadState};
use super::residual::PoseTorque;

impl PoseTorque {
    /// What the sensor of a joint should read: `k τ + b`.
    #[inline(always)]
    pub(super) fn predict_affine<A: Arithmetic>(
        &self,
        on: A,
        torque: &GravityTorqueRow<'_, A>,
        [gain, bias]: [A::Stored; 2],
    ) -> A::Number {
        on.load(gain) * torque.torque() + on.load(bias)
    }

    /// Writes the row of its reading, straight from where the arm stands.
    ///
    /// `gain`: of the reading by the torque; `position`: reading of each joint; `load`: what all carry. What lies outside of the row's pattern stays as it is.
    #[inline(always)]
    pub(super) fn write_affine<A: Arithmetic>(
        &self,
        on: A,
        torque: &GravityTorqueRow<'_, A>,
        gain: A::Number,
        (position, load): (&[A::Stored], Option<LoadState>),
        row: &mut [A::Stored],
    ) {
        let (n, joint) = (self.position.len(), torque.joint());
        let [by_gravity, by_torque_sensors, by_position_gains, by_offsets, by_links, by_load] = self.parts(row);
        for (entry, by) in by_gravity.iter_mut().zip(torque.by_gravity()) {
            *entry = on.store(gain * by);
        }
        let positions = by_position_gains.iter_mut().zip(by_offsets).zip(position);
        for (((by_gain, by_offset), q), by) in positions.zip(torque.by_coordinate()) {
            let by = gain * by;
            (*by_offset, *by_gain) = (on.store(by), on.store(on.load(*q) * by));
        }
        let (mut by_position, mut by_load_mass) = ([A::Stored::ZERO; 3], A::Stored::ZERO);
        let links = &mut by_links.as_chunks_mut().0[torque.moved()];
        for (link, (entries, by)) in torque.moved().zip(links.iter_mut().zip(torque.by_inertia())) {
            let [m, x, y, z] = by;
            let [m, x, y, z] = [gain * m, gain * x, gain * y, gain * z];
            *entries = [on.store(m), on.store(x), on.store(y), on.store(z)];
            if let Some((_, load)) = self.model.load.as_ref().zip(load).filter(|(carried, _)| carried.link == link) {
                let (mass, [px, py, pz]) = (on.constant(load.mass), load.position.map(|r| on.constant(r)));
                by_position = [on.store(mass * x), on.store(mass * y), on.store(mass * z)];
                by_load_mass = on.store(m + px * x + py * y + pz * z);
            }
        }
        let positions = self.model.load.as_ref().map_or(0, CarriedLoad::position_columns);
        let (parts, by_mass) = by_load.split_at_mut(positions);
        parts.as_chunks_mut().0.fill(by_position);
        by_mass.fill(by_load_mass);
        by_torque_sensors[joint] = on.store(torque.torque());
        by_torque_sensors[n + joint] = on.store(on.constant(1.0));
    }
}
