//! The reference prior of the joint problem: where unknowns rest of which the readings say nothing.
//!
//! ```text
//!     ½ Σ ((x − nominal)/(κ · limit))²         what is asked for; limit: the standard deviation beyond which a number would mislead
//!     ½ Σ ((x − nominal)/(10 · typical))²      biases of joints, masses, moments and placements
//! ```
//!
//! None on directions (gravity, vectors of known length), and none on what the session states with a standard deviation. It is
//! no information: what the readings determine is judged without it, and [`super::fit`] takes its pull away.

use gravcal_estimation::{Problem, ProblemBuilder, Reference, Values};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};

use crate::joint::building::blocks::add_unknown_blocks;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::problem::JointProblem;
use crate::joint::variables::{State, VariableIndex};

/// κ. Wide beside what would be of use, so that it hides nothing that can be known, and narrow enough that no gain reaches zero.
pub(in crate::joint) const WIDTH: f64 = 3.0;
/// So many times as firm, it lets what is asked for vary by its limits of use.
pub(in crate::joint) const WITHIN_USE: f64 = WIDTH;
/// Widths of what is not asked for, in typical sizes; between 0.2 and 1000 of them make hardly a difference.
const WIDE: f64 = 10.0;
/// Distance of a centre of mass from its link's origin, and of a link's end from it, m.
const TYPICAL_LEVER: f64 = 0.1;
const TYPICAL_LENGTH: f64 = 0.3;
/// Standard gravity, m/s².
const STANDARD_GRAVITY: f64 = 9.80665;

/// The problem with its reference about nominal values.
pub(in crate::joint) fn with_reference(session: &Session, built: JointProblem) -> JointProblem {
    let readings = built.readings();
    let mut builder = ProblemBuilder::new();
    add_unknown_blocks(session, readings, &State::nominal(session), &mut builder);
    let reference = reference(session, readings, &built.problem, &built.variables, builder.initial());
    let problem = built.problem.with_reference(reference);
    built.with_problem(problem)
}

/// That of a problem with these blocks.
pub(in crate::joint) fn reference(
    session: &Session,
    readings: &MeasurementSet,
    problem: &Problem,
    variables: &VariableIndex,
    nominal: Values,
) -> Reference {
    let mut reference = Reference::new(nominal);
    let typical = Typical::of(session, readings);
    for id in session.parameters() {
        let width = match id {
            // What spreads a joint's readings says nothing of where they lie.
            ParameterId::Sensor(joint, SensorParameter::TorqueBias) => {
                let gain = session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
                WIDE * typical.moment * STANDARD_GRAVITY * gain
            }
            _ => WIDTH * session.limit(id, &readings.spreads),
        };
        if !matches!(session.prior(id).kind, PriorKind::Gaussian { .. }) {
            reference = reference.with(variables.block(id), &[width]);
        }
    }
    let inertia = [typical.mass, typical.moment, typical.moment, typical.moment].map(|size| WIDE * size);
    for id in &variables.inertia {
        reference = reference.with(*id, &inertia);
    }
    for with in variables.with_payloads.iter().flatten() {
        reference = reference.with(with.moments, &inertia);
    }
    for id in
        variables.tensors.iter().chain(variables.with_payloads.iter().flatten().filter_map(|with| with.tensor.as_ref()))
    {
        reference = reference.with(*id, &[WIDE * typical.moment * TYPICAL_LENGTH; 6]);
    }
    for id in &variables.sweep_moments {
        reference = reference.with(*id, &vec![WIDE * typical.mass.max(typical.moment); problem.block(*id).len()]);
    }
    for id in variables.loads.iter().flatten().flatten() {
        reference = reference.with(*id, &[WIDE * TYPICAL_LEVER; 3]);
    }
    reference
}

/// Sizes of a robot's masses, kg, and first moments, kg·m.
struct Typical {
    mass: f64,
    moment: f64,
}

impl Typical {
    /// The larger of what the robot's file assumes and of what swings the readings as widely as they do.
    fn of(session: &Session, readings: &MeasurementSet) -> Typical {
        let assumed = session.robot.chain.links().iter().filter_map(|link| link.inertia.as_ref());
        let (mut mass, mut moment): (f64, f64) = (0.0, 0.0);
        for inertia in assumed {
            let length = inertia.first_moment.iter().map(|h| h * h).sum::<f64>().sqrt();
            (mass, moment) = (mass.max(inertia.mass), moment.max(length).max(TYPICAL_LEVER * inertia.mass));
        }
        for joint in 0..session.joints.len() {
            let gain = session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
            let swing = 0.5 * readings.spreads[joint] / gain / STANDARD_GRAVITY;
            if swing.is_finite() {
                moment = moment.max(swing);
            }
        }
        let mass = mass.max(moment / TYPICAL_LENGTH);
        if mass > 0.0 { Typical { mass, moment } } else { Typical { mass: 1.0, moment: TYPICAL_LEVER } }
    }
}
