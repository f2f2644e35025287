//! Which of a robot's parameters the data determine: what is asked for, and its limits of use.
//!
//! Beyond these a number would mislead: 10 % of a gain (of its estimated value, and of its nominal one), 0.1 rad of an angle (10 mm of a
//! displacement), half the spread of the readings for a bias, 0.1 rad of gravity's direction. An upright base is never estimated as
//! exactly upright. Noise may then be explained by a sensor that hardly reads anything, with a gain that is zero but for its error: precise
//! beside the nominal value, and of no use, not even for its sign.

use gravcal_estimation::{Problem, Values};
use gravcal_identification::Parameter;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;
use gravcal_robot_model::session::parameters::GAIN_LIMIT;

use crate::joint::VariableIndex;

/// Share of its magnitude by which gravity's direction may be off.
const GRAVITY_LIMIT: f64 = 0.1;

/// What a user asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Asked {
    /// Gravity's direction.
    Gravity,
    /// A parameter of a sensor.
    Parameter(ParameterId),
}

impl From<ParameterId> for Asked {
    fn from(id: ParameterId) -> Asked {
        Asked::Parameter(id)
    }
}

/// What the data say of gravity and the parameters.
pub(crate) type Judgement = gravcal_identification::Judgement<Asked>;

/// A combination of parameters that is not determined.
#[derive(Clone, Debug)]
pub(crate) struct Combination {
    /// Parameter and coefficient: relative change of a gain, change of any other in units of its limit.
    pub parameters: Vec<(ParameterId, f64)>,
    /// Whether gravity takes part.
    pub gravity: bool,
    /// Standard deviation in units of the limit; `None` where there is no information at all.
    pub std_over_limit: Option<f64>,
}

impl From<&gravcal_identification::Combination<Asked>> for Combination {
    fn from(combination: &gravcal_identification::Combination<Asked>) -> Combination {
        let of_parameter = |(id, coefficient): &(Asked, f64)| match id {
            Asked::Gravity => None,
            Asked::Parameter(id) => Some((*id, *coefficient)),
        };
        Combination {
            parameters: combination.parameters.iter().filter_map(of_parameter).collect(),
            gravity: combination.contains(Asked::Gravity),
            std_over_limit: combination.std_over_limit,
        }
    }
}

/// Gravity and every parameter with their limits of use at these values. `spreads`: largest less smallest torque reading of each joint.
pub(crate) fn asked(
    session: &Session,
    variables: &VariableIndex,
    values: &Values,
    spreads: &[f64],
) -> Vec<Parameter<Asked>> {
    let positive = |v: f64| v.max(f64::MIN_POSITIVE);
    let of_gravity = GRAVITY_LIMIT * session.gravity.magnitude;
    let gravity = Parameter { id: Asked::Gravity, block: variables.gravity, limit: of_gravity, unit: of_gravity };
    let of = |id: ParameterId| {
        let block = variables.block(id);
        let value = values.scalar(block);
        let limit = limit(session, id, value, spreads);
        let unit = own_limit(id, value).unwrap_or(limit);
        Parameter { id: Asked::Parameter(id), block, limit: positive(limit), unit: positive(unit) }
    };
    std::iter::once(gravity).chain(session.parameters().into_iter().map(of)).collect()
}

/// Column and limit of use of gravity and every parameter.
pub(crate) fn limits_of_use(
    session: &Session,
    (problem, values): (&Problem, &Values),
    variables: &VariableIndex,
    spreads: &[f64],
) -> Vec<(usize, f64)> {
    gravcal_identification::limits_of_use(problem, &asked(session, variables, values, spreads))
}

/// Standard deviation beyond which the number found for a parameter would mislead, in its unit.
fn limit(session: &Session, id: ParameterId, value: f64, spreads: &[f64]) -> f64 {
    let limit = session.limit(id, spreads);
    own_limit(id, value).map_or(limit, |own| limit.min(own))
}

/// The limit of a gain that comes from its own value.
fn own_limit(id: ParameterId, value: f64) -> Option<f64> {
    let is_gain = matches!(id, ParameterId::Sensor(_, SensorParameter::TorqueGain | SensorParameter::PositionGain));
    is_gain.then(|| GAIN_LIMIT * value.abs())
}
