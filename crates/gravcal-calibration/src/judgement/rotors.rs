//! Rotor inertias below zero, which none is.

use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use super::friction::SIGNIFICANT;
use crate::result::ParameterResult;

/// Rotor inertias that are significantly negative.
pub(crate) fn negative_rotor_notes(session: &Session, parameters: &[ParameterResult]) -> Vec<String> {
    let negative = session.rotors.iter().flatten().filter_map(|place| {
        let name = session.parameter_name(ParameterId::Further(*place));
        let reported = parameters.iter().find(|reported| reported.name == name && reported.held.is_none())?;
        let (value, std) = (reported.value?, reported.std?);
        (value < -SIGNIFICANT * std).then(|| format!("{name} ({value:.4} ± {std:.4} {})", reported.unit))
    });
    let negative: Vec<String> = negative.collect();
    if negative.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "No rotor has an inertia below zero, and these came out so: {}. It stands for something else, such as a torque that is filtered, late, or \
         read behind the gear, or friction that changes with the load: do not believe it, and leave rotor_inertia out of these joints.",
        negative.join(", ")
    )]
}
