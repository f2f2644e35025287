//! What the session's constraints demand of the joint problem's unknowns.
//!
//! ```text
//!     m ≥ 0                        masses = "positive"
//!     ‖h‖ ≤ m R                    center_of_mass_within_m = R, h = m · centre of mass in the link's frame
//!     |k − k₀| ≤ share · |k₀|      torque_gains_within = share
//! ```
//!
//! All are convex. A start outside is moved inside before the problem is built; the solver keeps it there. What an active
//! one holds is taken as known exactly when the solution is judged ([`along_constraints`](gravcal_estimation::statistics::along_constraints)).

use gravcal_estimation::{ActiveConstraint, Affine, BlockId, Constraint, Problem};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::error::BuildError;
use crate::joint::problem::JointProblem;
use crate::joint::variables::{State, VariableIndex};
use crate::result;

/// The joint problem with the session's constraints on what is free in it.
pub(in crate::joint) fn constrained(session: &Session, built: JointProblem) -> Result<JointProblem, BuildError> {
    let all = of_links(session, &built.variables).into_iter().chain(of_gains(session, &built.variables));
    let free = all.filter(|(block, _)| built.problem.block(*block).fixed.is_none());
    let problem = built.problem.with_constraints(free.map(|(_, constraint)| constraint).collect())?;
    Ok(built.with_problem(problem))
}

fn of_links(session: &Session, variables: &VariableIndex) -> Vec<(BlockId, Constraint)> {
    let demanded = &session.constraints;
    let mut constraints = Vec::new();
    for (index, (link, id)) in session.robot.chain.links().iter().zip(&variables.inertia).enumerate() {
        if demanded.positive_masses {
            let name = format!("{}.mass is at least 0", link.name);
            constraints.push((*id, Constraint::bound(name, *id, 0, 0.0, f64::INFINITY)));
        }
        if let Some(radius) = demanded.radius(index) {
            let name = format!("{}.center_of_mass is within {radius} m of the link's frame", link.name);
            let moment = (1..=3).map(|component| Affine::component(*id, component)).collect();
            constraints.push((*id, Constraint::cone(name, moment, Affine::default().plus(*id, 0, radius))));
        }
    }
    constraints
}

fn of_gains(session: &Session, variables: &VariableIndex) -> Vec<(BlockId, Constraint)> {
    let Some(share) = session.constraints.torque_gains_within else { return Vec::new() };
    let joints = session.robot.chain.joints().iter().zip(&variables.sensors).enumerate();
    let of_joint = |(index, (joint, ids)): (usize, (&gravcal_dynamics::Joint, &[BlockId; 4]))| {
        let id = ids[SensorParameter::TorqueGain as usize];
        let nominal = session.joints[index].of(SensorParameter::TorqueGain).nominal;
        let (name, room) = (SensorParameter::TorqueGain.name(&joint.name), share * nominal.abs());
        let name = format!("{name} is within {} % of {nominal}", 100.0 * share);
        (id, Constraint::bound(name, id, 0, nominal - room, nominal + room))
    };
    joints.map(of_joint).collect()
}

/// Moves values inside: masses up to zero, moments towards the frame's origin, gains to the nearest that is allowed.
pub(in crate::joint) fn respect(session: &Session, values: &mut State) {
    let demanded = &session.constraints;
    for (link, inertia) in values.inertia.iter_mut().enumerate() {
        let (radius, [mass, moment @ ..]) = (demanded.radius(link), inertia);
        if demanded.positive_masses || radius.is_some() {
            *mass = mass.max(0.0);
        }
        let length = moment.iter().map(|h| h * h).sum::<f64>().sqrt();
        if let Some(allowed) = radius.map(|radius| radius * *mass).filter(|allowed| length > *allowed) {
            moment.iter_mut().for_each(|h| *h *= allowed / length);
        }
    }
    if let Some(share) = demanded.torque_gains_within {
        for (joint, values) in session.joints.iter().zip(&mut values.sensors) {
            let nominal = joint.of(SensorParameter::TorqueGain).nominal;
            let room = share * nominal.abs();
            let gain = &mut values[SensorParameter::TorqueGain as usize];
            *gain = gain.max(nominal - room).min(nominal + room);
        }
    }
}

/// The active constraints in words and numbers.
pub(in crate::joint) fn report(problem: &Problem, active: &[ActiveConstraint]) -> Vec<result::ActiveConstraint> {
    let reported = active.iter().map(|active| result::ActiveConstraint {
        constraint: active.name.clone(),
        multiplier: active.multiplier,
        unit: unit(problem, active),
    });
    reported.collect()
}

/// The unit of what a constraint holds: that of a cone is its moment's.
fn unit(problem: &Problem, active: &ActiveConstraint) -> String {
    let terms = active.holds.first().map_or(&[][..], |function| &function.terms);
    let moment = terms.iter().find(|(_, component, _)| *component > 0);
    let term = moment.or_else(|| terms.first());
    term.map_or_else(String::new, |(id, component, _)| problem.block(*id).units[*component].clone())
}
