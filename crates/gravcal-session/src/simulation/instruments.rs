//! What instruments read in one simulated pose.

use gravcal_dynamics::Transform;
use gravcal_recording::Reading;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind};
use nalgebra::{Rotation3, Vector3};
use rand_pcg::Pcg64;

use super::experiment::Simulation;
use super::normal::normal;

/// Readings of all axes in a pose of a table, the joints at their true `coordinates`.
pub(super) fn read(
    simulation: &Simulation,
    coordinates: &[f64],
    (table, load): (usize, Option<usize>),
    random: &mut Pcg64,
) -> Vec<Option<Reading>> {
    if simulation.template.instruments.is_empty() {
        return Vec::new();
    }
    let links = simulation.template.robot.chain.forward(coordinates);
    let mut readings = Vec::new();
    for instrument in &simulation.template.instruments {
        let sensed = sensed(simulation, instrument, &links[instrument.link], load);
        let further = &simulation.truth.further;
        let mut values = further[instrument.biases_of_table(table)].to_vec();
        for ((reading, source), gain) in instrument.gains.iter().zip(&further[instrument.gain_parameters()]) {
            values[*reading] += gain * sensed[*source];
        }
        for ((value, unit), place) in values.into_iter().zip(&instrument.units).zip(instrument.readings()) {
            let std = simulation.disturbance.instrument_std[place];
            // Drawn for every axis, so that one that is not read does not shift the others' noise.
            let value = value + std * normal(random);
            readings.push(unit.as_ref().map(|_| Reading { value, std: Some(std) }));
        }
    }
    readings
}

/// Force and moment, or specific force, in the instrument's frame.
fn sensed(simulation: &Simulation, instrument: &AuxiliarySensor, link: &Transform, load: Option<usize>) -> Vec<f64> {
    let frame = link.compose(&instrument.mounting);
    let own = &simulation.truth.further[instrument.own_parameters()];
    let gravity = Vector3::from(frame.inverse().rotate_vector(simulation.truth.gravity));
    match instrument.kind {
        AuxiliarySensorKind::Accelerometer => {
            let turned = Rotation3::new(Vector3::from_column_slice(own)).inverse() * gravity;
            (-turned).as_slice().to_vec()
        }
        AuxiliarySensorKind::ForceTorque => {
            let mut body = (own[0], Vector3::from_column_slice(&own[1..]));
            if let Some(load) = load.filter(|load| simulation.template.loads[*load].link == instrument.link) {
                let mass = simulation.template.loads[load].mass;
                let position = instrument.mounting.inverse().transform_point(simulation.truth.loads[load]);
                body = (body.0 + mass, body.1 + mass * Vector3::from(position));
            }
            let (force, moment) = (-body.0 * gravity, gravity.cross(&body.1));
            force.iter().chain(&moment).copied().collect()
        }
    }
}
