//! Stating something that is known: no pose is recorded for it.

use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::PriorKind;

use super::addition::Addition;
use crate::check::hypothetical::Hypothetical;

/// Standard deviation of a torque gain that is stated, as a share of it.
const GAIN_KNOWN: f64 = 0.01;
/// The same of a load's position, m.
const POSITION_KNOWN: f64 = 1e-3;

/// Gravity's rough direction.
pub fn hemisphere(now: &Hypothetical) -> Vec<Addition> {
    if now.session.gravity.hemisphere.is_some() {
        return Vec::new();
    }
    let words = "state gravity's rough direction ([gravity] hemisphere)";
    vec![Addition::new(words.into(), |hypothetical| {
        let norm = hypothetical.session.gravity.magnitude;
        hypothetical.session.gravity.hemisphere = Some(hypothetical.values.gravity.map(|component| component / norm));
    })]
}

/// The torque gain of one joint.
pub fn torque_gain(now: &Hypothetical) -> Vec<Addition> {
    let open = |joint: &usize| {
        now.noise[*joint].is_some()
            && now.session.fixed_reason(*joint, SensorParameter::TorqueGain).is_none()
            && now.session.joints[*joint].of(SensorParameter::TorqueGain).kind == PriorKind::Flat
    };
    let state = |joint: usize| {
        let id = ParameterId::Sensor(joint, SensorParameter::TorqueGain);
        let name = now.session.parameter_name(id);
        let words = format!("state {name} within {:.0} % (its std in [[joint]])", 100.0 * GAIN_KNOWN);
        let make = move |hypothetical: &mut Hypothetical| {
            let prior = hypothetical.session.prior_mut(id);
            prior.kind = PriorKind::Gaussian { std: GAIN_KNOWN * prior.nominal.abs() };
        };
        Addition { states: Some(name), ..Addition::new(words, make) }
    };
    (0..now.session.joints.len()).filter(open).map(state).collect()
}

/// Where a load hangs in its link.
pub fn placement(now: &Hypothetical) -> Vec<Addition> {
    let hangs = |load: &usize| now.session.poses.iter().any(|pose| pose.load == Some(*load));
    let open = |load: &usize| {
        now.session.loads[*load].position.is_none() && !now.session.loads[*load].is_unknown() && hangs(load)
    };
    let state = |load: usize| {
        let name = &now.session.loads[load].name;
        let words =
            format!("state the position of load `{name}` in its link within {} mm (position_m)", 1e3 * POSITION_KNOWN);
        Addition::new(words, move |hypothetical| {
            hypothetical.session.loads[load].position = Some(hypothetical.values.loads[load]);
            hypothetical.session.loads[load].position_std = Some(POSITION_KNOWN);
        })
    };
    (0..now.session.loads.len()).filter(open).map(state).collect()
}
