//! Readings at an end of the sensor's or converter's range carry no equality: they are left out when a session is read
//! ([`gravcal_recording::is_saturated`]), and counted. Here is shown what they would do.

use gravcal_session::simulation::{Converter, Simulation};

use crate::testing::sarcos_shoulder;
use crate::testing::sensor_models::{errors, estimate};

/// The converter ends where joint 3 turns its load up.
fn saturating() -> Simulation {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance.converter = Some(Converter { bits: 12, range: [1900.0, 2200.0] });
    simulation
}

#[test]
fn saturated_readings_are_left_out_and_counted() {
    let simulation = saturating();
    let session = simulation.session(0);
    assert!(session.saturated.iter().any(|count| *count > 20), "{:?}", session.saturated);
    let missing = session.poses.iter().flat_map(|pose| &pose.torque).filter(|reading| reading.is_none()).count();
    assert_eq!(missing, session.saturated.iter().sum::<usize>());
    let found = estimate(&session);
    assert!(found.notes.iter().any(|note| note.contains("are at an end of the sensor's range")), "{:?}", found.notes);
    assert!(errors(&session, &simulation, &found).iter().all(|(_, error)| error.abs() < 4.0));
    assert!(found.fit.unwrap().p_value.unwrap() > 1e-3);
}

#[test]
fn taken_at_their_word_they_contradict_the_model() {
    let simulation = saturating();
    let mut session = simulation.session(0);
    let std = Some(simulation.stated_std(0));
    for reading in session.poses.iter_mut().flat_map(|pose| &mut pose.torque).filter(|reading| reading.is_none()) {
        *reading = Some(gravcal_recording::Reading { value: 1900.0, std });
    }
    let misfit = estimate(&session).fit.unwrap().p_value.unwrap();
    assert!(misfit < 1e-6, "{misfit}");
}
