//! Another displacement: only its length is known of the vector between two placements. Each joint carries a part of it, times a gain that may
//! be any: where few joints move, two directions explain the readings, with gains that are many times apart between joints
//! ([`gains_disagree`]).
//!
//! Which of such is right nothing tells, and they are no images of each other: both are kept ([`otherwise_displaced`]), as ends of other starts
//! are.

use gravcal_identification::median;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};
use nalgebra::Vector3;

use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// Torque gains, each by its nominal value, that are so many times apart are no scatter of sensors.
const DISAGREES: f64 = 3.0;

/// Whether some torque gain is many times farther from its nominal value than most are, as where the vector between two placements of a known
/// distance came out in another direction.
pub(in crate::joint) fn gains_disagree(session: &Session, solved: &Solved) -> bool {
    if session.pair_of_free_placements().is_none() {
        return false;
    }
    let found = solved.state(&State::nominal(session));
    let gains = (0..session.joints.len()).map(|joint| ParameterId::Sensor(joint, SensorParameter::TorqueGain));
    let free = gains.filter(|id| session.prior(*id).kind == PriorKind::Flat && session.fixed(*id).is_none());
    let mut ratios: Vec<f64> = free.map(|id| (found.value(id) / session.nominal(id)).abs()).collect();
    let Some(middle) = median(&mut ratios) else { return false };
    ratios.iter().any(|ratio| ratio * DISAGREES < middle || *ratio > DISAGREES * middle)
}

/// The same with the vector between two placements of a known distance reversed along some of the link's axes.
pub(in crate::joint) fn otherwise_displaced(session: &Session, values: &State) -> Vec<State> {
    let Some(known) = session.pair_of_free_placements() else { return Vec::new() };
    let [p, q] = known.between.map(|load| Vector3::from(values.loads[load]));
    let (middle, half) = ((p + q) / 2.0, (q - p) / 2.0);
    let displaced = |signs: usize| {
        let reversed = Vector3::from_fn(|axis, _| if signs >> axis & 1 == 1 { -half[axis] } else { half[axis] });
        let mut other = values.clone();
        let [a, b] = known.between;
        (other.loads[a], other.loads[b]) = ((middle - reversed).into(), (middle + reversed).into());
        other
    };
    (1..8).map(displaced).collect()
}
