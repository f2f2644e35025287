//! What the session's constraints demand of the joint problem's unknowns.
//!
//! ```text
//!     m ≥ 0                        masses = "positive"
//!     ‖h‖ ≤ m R                    center_of_mass_within_m = R, h = m · centre of mass in the link's frame
//!     |k − k₀| ≤ share · |k₀|      torque_gains_within = share
//! ```
//!
//! All are convex. A start outside is moved inside before the problem is posed; the solver keeps it there. What an active
//! one holds is taken as known exactly when the solution is judged ([`holding`]): to first order the estimate moves only along it.

use gravcal_estimation::{ActiveConstraint, Affine, BlockId, Constraint, Estimate, Factor, Noise, Problem, Spectrum};

use super::problem::{JointProblem, PosingError};
use super::{Layout, Unknowns};
use crate::parameter::Quantity;
use crate::residuals::{KnownQuantity, LinearKnowledge};
use crate::result;
use crate::session::Session;

/// How much stiffer a held function is than the data make the unknowns it reads: enough to stand for exact, and little
/// enough to leave weak directions to be told from empty ones.
const STIFFNESS: f64 = 1e3;
/// A function whose slope is but for this share that of others follows from them.
const DEPENDENT: f64 = 1e-6;

/// The joint problem with the session's constraints on what is free in it.
pub(super) fn constrained(session: &Session, posed: JointProblem) -> Result<JointProblem, PosingError> {
    let all = of_links(session, &posed.layout).into_iter().chain(of_gains(session, &posed.layout));
    let free = all.filter(|(block, _)| posed.problem.block(*block).held.is_none());
    let problem = posed.problem.with_constraints(free.map(|(_, constraint)| constraint).collect())?;
    Ok(JointProblem { problem, ..posed })
}

fn of_links(session: &Session, layout: &Layout) -> Vec<(BlockId, Constraint)> {
    let demanded = &session.constraints;
    let mut constraints = Vec::new();
    for (index, (link, id)) in session.robot.chain.links().iter().zip(&layout.inertia).enumerate() {
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

fn of_gains(session: &Session, layout: &Layout) -> Vec<(BlockId, Constraint)> {
    let Some(share) = session.constraints.torque_gains_within else { return Vec::new() };
    let joints = session.robot.chain.joints().iter().zip(&layout.sensors).enumerate();
    let of_joint = |(index, (joint, ids)): (usize, (&gravcal_kinematics::Joint, &[BlockId; 4]))| {
        let id = ids[Quantity::TorqueGain as usize];
        let nominal = session.joints[index].of(Quantity::TorqueGain).nominal;
        let (name, room) = (Quantity::TorqueGain.name(&joint.name), share * nominal.abs());
        let name = format!("{name} is within {} % of {nominal}", 100.0 * share);
        (id, Constraint::bound(name, id, 0, nominal - room, nominal + room))
    };
    joints.map(of_joint).collect()
}

/// Moves values inside: masses up to zero, moments towards the frame's origin, gains to the nearest that is allowed.
pub(super) fn respect(session: &Session, values: &mut Unknowns) {
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
            let nominal = joint.of(Quantity::TorqueGain).nominal;
            let room = share * nominal.abs();
            let gain = &mut values[Quantity::TorqueGain as usize];
            *gain = gain.max(nominal - room).min(nominal + room);
        }
    }
}

/// The problem with what the active constraints hold as all but exact readings; nothing where none is active.
pub(super) fn holding(
    problem: &Problem,
    estimate: &Estimate,
    spectrum: &Spectrum,
) -> Result<Option<Problem>, PosingError> {
    if estimate.active.is_empty() {
        return Ok(None);
    }
    let mut factors = problem.factors().to_vec();
    for (function, norm) in independent(problem, &estimate.active, spectrum) {
        let noise = Noise::independent(&[norm / STIFFNESS])?;
        let held = KnownQuantity::held(function, &estimate.values);
        factors.push(Factor::new(LinearKnowledge::new(vec![held]), noise));
    }
    Ok(Some(problem.with_factors(factors)?))
}

/// The held functions that do not follow from those before them, each with the norm of its slope by columns that count
/// in what one standard deviation of the data makes of them.
fn independent<'a>(problem: &Problem, active: &'a [ActiveConstraint], spectrum: &Spectrum) -> Vec<(&'a Affine, f64)> {
    let mut found: Vec<(&Affine, f64)> = Vec::new();
    let mut directions: Vec<nalgebra::DVector<f64>> = Vec::new();
    for function in active.iter().flat_map(|constraint| &constraint.holds) {
        let mut slope = nalgebra::DVector::zeros(problem.columns().len());
        for (id, component, c) in &function.terms {
            if let Some(column) = problem.columns_of(*id).nth(*component) {
                slope[column] += c / spectrum.column_scale(column);
            }
        }
        let norm = slope.norm();
        directions.iter().for_each(|other| slope -= other * other.dot(&slope));
        if slope.norm() > DEPENDENT * norm {
            directions.push(slope.normalize());
            found.push((function, norm));
        }
    }
    found
}

/// The active constraints in words and numbers.
pub(super) fn tell(problem: &Problem, active: &[ActiveConstraint]) -> Vec<result::ActiveConstraint> {
    let told = active.iter().map(|active| result::ActiveConstraint {
        constraint: active.name.clone(),
        multiplier: active.multiplier,
        unit: unit(problem, active),
    });
    told.collect()
}

/// The unit of what a constraint holds: that of a cone is its moment's.
fn unit(problem: &Problem, active: &ActiveConstraint) -> String {
    let terms = active.holds.first().map_or(&[][..], |function| &function.terms);
    let moment = terms.iter().find(|(_, component, _)| *component > 0);
    let term = moment.or_else(|| terms.first());
    term.map_or_else(String::new, |(id, component, _)| problem.block(*id).units[*component].clone())
}
