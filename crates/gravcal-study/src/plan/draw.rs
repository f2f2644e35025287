//! A truth of its own for each trial.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_session::simulation::Simulation;
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::drawn::direction_within;

/// Half-widths of the uniform distributions about the simulation's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Draw {
    /// Relative to the gain.
    pub torque_gain: f64,
    /// Unit of the torque reading.
    pub torque_bias: f64,
    /// Relative to the gain.
    pub position_gain: f64,
    /// rad.
    pub position_offset: f64,
    /// rad.
    pub gravity: f64,
}

/// Keeps the truth's stream of random numbers apart from those of the readings.
const STREAM: u128 = 0x7472_7574_6800;

impl Draw {
    /// The truth of this trial.
    pub fn draw(&self, simulation: &mut Simulation, seed: u64, trial: u64) {
        let mut random = Pcg64::new(u128::from(seed) ^ (STREAM << 64), u128::from(trial));
        let mut within = |half: f64| if half > 0.0 { random.random_range(-half..half) } else { 0.0 };
        for joint in 0..simulation.truth.sensors.len() {
            let held = simulation.template.fixed_reason(joint, SensorParameter::PositionOffset).is_some();
            let sensor = &mut simulation.truth.sensors[joint];
            sensor[SensorParameter::TorqueGain as usize] *= 1.0 + within(self.torque_gain);
            sensor[SensorParameter::TorqueBias as usize] += within(self.torque_bias);
            sensor[SensorParameter::PositionGain as usize] *= 1.0 + within(self.position_gain);
            let offset = within(self.position_offset);
            sensor[SensorParameter::PositionOffset as usize] += if held { 0.0 } else { offset };
        }
        if self.gravity > 0.0 {
            let length = simulation.template.gravity.magnitude;
            let direction = simulation.truth.gravity.map(|component| component / length);
            let drawn = direction_within(&mut random, direction, [0.0, self.gravity]);
            simulation.truth.gravity = drawn.map(|component| length * component);
        }
    }
}
