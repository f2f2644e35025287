//! Friction that drives its joint, which none does.
//!
//! With `θ̇ = s q̇`, a friction `f sgn(q̇)` in a reading `k τ + b + …` takes the power `f s |q̇| / k` from the joint, and a viscous one
//! `v s q̇² / k`: coefficients have the sign of `k s`.

use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::sensors::friction::{COULOMB, PRESLIDING, VISCOUS};
use gravcal_robot_model::session::Session;

use crate::result::ParameterResult;

/// So many standard deviations beyond zero are told.
pub(super) const SIGNIFICANT: f64 = 2.0;

const CHECK: &str = "no friction does. See whether torques, positions and velocities (or directions) have one clock and the signs \
                     that the session says, whether the torque sensor has the friction in it at all (one behind the gear has \
                     not, and a drive may compensate it), and whether noise passes for motion \
                     (readings.select.joint.speed_above)";

/// Coefficients of friction that are significantly of the wrong sign.
pub(crate) fn driving_friction_notes(session: &Session, parameters: &[ParameterResult]) -> Vec<String> {
    let models = session.terms.models().filter(|model| [COULOMB, VISCOUS, PRESLIDING].contains(&model.name));
    // The first of its parameters; a travel has no sign.
    let coefficients = models.flat_map(|model| model.places().take(1).map(move |place| (model.joint, place)));
    coefficients
        .filter_map(|(joint, place)| {
            let name = session.parameter_name(ParameterId::Further(place));
            let reported = parameters.iter().find(|reported| reported.name == name && reported.held.is_none())?;
            let (value, std) = (reported.value?, reported.std?);
            let sign = [SensorParameter::TorqueGain, SensorParameter::PositionGain]
                .map(|gain| session.joints[joint].of(gain).nominal);
            let along = value * sign.map(f64::signum).iter().product::<f64>();
            (along < -SIGNIFICANT * std).then(|| {
                let unit = &reported.unit;
                format!("{name} came out as {value:.4} ± {std:.4} {unit}, a friction that drives the joint: {CHECK}.")
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::sensors::Options;

    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::{estimate, shoulder, with_model};

    /// What is told of a friction that is truly this; the sensors of the second joint turned by these signs.
    fn reported(model: &str, truth: f64, [torque, position]: [f64; 2]) -> Vec<String> {
        let mut simulation = shoulder();
        let prior = &mut simulation.template.joints[1];
        prior.parameters[0].nominal *= torque;
        prior.parameters[2].nominal *= position;
        prior.torque_sign_declared = true;
        simulation.truth.sensors[1][0] *= torque;
        simulation.truth.sensors[1][2] *= position;
        let result = estimate(&with_model(simulation, 1, model, &Options::default(), &[truth]).session(0));
        result.notes.into_iter().filter(|note| note.contains("drives the joint")).collect()
    }

    #[test]
    fn friction_that_drives_is_reported_and_friction_that_brakes_is_not() {
        for (model, size, name) in [
            ("coulomb-friction", 3.0, "joint2.coulomb_friction came out as -"),
            ("viscous-friction", 120.0, "joint2.viscous_friction came out as -"),
        ] {
            let driving = reported(model, -size, [1.0, 1.0]);
            assert!(driving.len() == 1 && driving[0].starts_with(name), "{driving:?}");
            assert_eq!(reported(model, size, [1.0, 1.0]), Vec::<String>::new());
        }
        assert_eq!(reported("coulomb-friction", 0.0, [1.0, 1.0]), Vec::<String>::new(), "within its noise");
    }

    #[test]
    fn a_reversed_sensor_turns_the_sign_of_its_friction() {
        assert_eq!(sarcos_shoulder().template.joints[1].parameters[2].nominal, 1.0);
        for signs in [[-1.0, 1.0], [1.0, -1.0]] {
            assert_eq!(reported("coulomb-friction", -3.0, signs), Vec::<String>::new(), "{signs:?}");
            assert_eq!(reported("coulomb-friction", 3.0, signs).len(), 1, "{signs:?}");
        }
        assert_eq!(reported("coulomb-friction", 3.0, [-1.0, -1.0]), Vec::<String>::new());
    }
}
