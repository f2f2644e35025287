//! The joint problem: all residuals over all unknowns, every reading exactly once.
//!
//! For given gravity, gains, mountings and positions all of it is affine in the biases, the links' masses and moments and
//! the placements of loads that no distance reads: these blocks are marked as linear.

use gravcal_estimation::{BlockId, Factor, Noise, NoiseError, ProblemBuilder};
use gravcal_robot_model::residuals::{GravityNorm, LoadDistance, Prior};
use gravcal_robot_model::session::{ParameterPrior, PriorKind, Session};

use crate::joint::building::blocks::{add_blocks, add_unknown_blocks};
use crate::joint::building::constraints::{self, constrained};
use crate::joint::building::earlier::with_earlier;
use crate::joint::building::factors::{add_readings, fixed_positions, positions};
use crate::joint::building::inertia_priors::{LinkPrior, inertia_priors};
use crate::joint::building::modelled::add_residuals;
use crate::joint::building::placements::distances_left;
use crate::joint::building::position_unknowns::add_priors;
use crate::joint::building::reference::{reference, with_reference};
use crate::joint::error::BuildError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::problem::JointProblem;
use crate::joint::variables::{State, VariableIndex};

/// Standard deviation of an exact distance that cannot be held by the placements themselves, m.
const EXACT_DISTANCE_STD: f64 = 1e-6;

/// Builds the joint problem with the given readings, from the given start.
///
/// # Errors
/// Where there is nothing to measure or nothing unknown.
pub fn build_problem(session: &Session, readings: &MeasurementSet, start: &State) -> Result<JointProblem, BuildError> {
    let mut builder = ProblemBuilder::new();
    let variables = add_unknown_blocks(session, readings, start, &mut builder);
    let held = fixed_positions(&variables, &builder);
    let rows = add_readings(session, readings, &variables, held, &mut builder)?;
    let modelled = add_residuals(session, readings, &variables, &mut builder)?;
    add_parameter_priors(session, readings, &variables, &mut builder)?;
    let mut built = JointProblem::of(readings, builder.build()?, variables, rows);
    built.modelled = modelled;
    let built = with_reference(session, built);
    match &session.earlier {
        None => Ok(built),
        Some(earlier) => with_earlier(earlier, built),
    }
}

/// The same under the session's constraints, from the nearest start that obeys them.
///
/// # Errors
/// As [`build_problem`].
pub(crate) fn build_with_constraints(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
) -> Result<JointProblem, BuildError> {
    let mut start = start.clone();
    constraints::respect(session, &mut start);
    constrained(session, build_problem(session, readings, &start)?)
}

/// The same with the readings alone: no prior and nothing that needs one, no known norm, no known distance. A characteristic
/// that is bent is taken for straight, as it is where a start begins. What is linear is asked for: derivatives by position sensors may be missing.
///
/// # Errors
/// As [`build_problem`].
pub(crate) fn pose_readings_alone(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
) -> Result<JointProblem, BuildError> {
    let mut builder = ProblemBuilder::new();
    let variables = add_blocks(session, readings, start, false, &mut builder);
    let given = Some(positions(&variables, &builder));
    let rows = add_readings(session, readings, &variables, given, &mut builder)?;
    let (problem, initial) = builder.build()?;
    let mut nominal = ProblemBuilder::new();
    add_blocks(session, readings, &State::nominal(session), false, &mut nominal);
    let reference = reference(session, readings, &problem, &variables, nominal.initial());
    let problem = problem.with_reference(reference);
    Ok(JointProblem::of(readings, (problem, initial), variables, rows))
}

fn add_parameter_priors(
    session: &Session,
    readings: &MeasurementSet,
    variables: &VariableIndex,
    builder: &mut ProblemBuilder,
) -> Result<(), NoiseError> {
    // What an earlier calibration knows of gravity holds that already.
    let known = session.earlier.as_ref().is_some_and(|earlier| earlier.knows_any("gravity."));
    if let Some(std) = session.gravity.magnitude_std.filter(|_| !known) {
        let residual = GravityNorm::new(variables.gravity, session.gravity.magnitude);
        builder.add_factor(Factor::new(residual, Noise::independent(&[std])?));
    }
    for id in session.parameters() {
        if let ParameterPrior { nominal, kind: PriorKind::Gaussian { std } } = session.prior(id) {
            add_prior(builder, variables.block(id), vec![nominal], &[std])?;
        }
    }
    for LinkPrior { block, expected, std, .. } in inertia_priors(session, variables) {
        add_prior(builder, block, expected, &std)?;
    }
    for (load, placement) in session.loads.iter().zip(&variables.loads) {
        // A load with a position of its own is tied to no other: its placement is one block.
        if let (Some(position), Some(std), Some([id])) = (load.position, load.position_std, placement.as_deref()) {
            add_prior(builder, *id, position.to_vec(), &[std; 3])?;
        }
    }
    add_priors(variables, builder)?;
    for displaced in variables.lengths.iter().chain(&variables.axes) {
        displaced.add_prior(builder)?;
    }
    for (std, block) in readings.lasting_unknowns(session, variables) {
        add_prior(builder, block, vec![0.0], &[std])?;
    }
    let of_sides = variables.static_friction.iter().map(|friction| &friction.to_side);
    let of_sweeps = variables.static_friction.iter().flat_map(|friction| &friction.sweeps).map(|(_, unknown)| unknown);
    for unknown in
        of_sides.chain(of_sweeps).chain(&variables.at_rest).chain(&variables.growing_friction).chain(&variables.bending)
    {
        unknown.add_prior(builder)?;
    }
    for index in distances_left(session, &readings.carried(session)) {
        let known = &session.load_distances[index];
        if let [Some(a), Some(b)] = known.between.map(|load| variables.loads[load].clone()) {
            let residual = LoadDistance::new([a, b], known.distance);
            let std = known.std.unwrap_or(EXACT_DISTANCE_STD);
            builder.add_factor(Factor::new(residual, Noise::independent(&[std])?));
        }
    }
    Ok(())
}

fn add_prior(builder: &mut ProblemBuilder, block: BlockId, expected: Vec<f64>, std: &[f64]) -> Result<(), NoiseError> {
    builder.add_factor(Factor::new(Prior::new(block, expected), Noise::independent(std)?));
    Ok(())
}
