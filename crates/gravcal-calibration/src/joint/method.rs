//! The joint estimator from readings to a verdict: the method, read from top to bottom.
//!
//! All unknowns `x` together explain every reading `y` once, as well as its noise `Σ` lets it be explained, with what is known beforehand as
//! readings of its own (`building/`):
//!
//! ```text
//!     x̂ = argmin ½ χ²(x),      χ²(x) = (y − f(x))ᵀ Σ⁻¹ (y − f(x)) + what knowledge costs
//! ```
//!
//! χ² has many minima, of which some are images of each other; noise may be unknown; and readings may leave unknowns open. So the solution is
//! looked for, then doubted, and only then judged. What is not determined has no value.
//!
//! | step | where | ends with |
//! |---|---|---|
//! | start | `starting/` | values of all unknowns, from a sample of the readings |
//! | swapped columns | `mistakes/evident.rs` | what makes all that follows pointless, where a part of the readings tells it |
//! | fit with noise | `solving/solve_from.rs` | a minimum, with the noise that no reading states; of many readings that of a part first |
//! | images | `ends/symmetries/` | the one that is likelier, or as declared |
//! | other starts | `solving/other_starts.rs`, `ends/other_ends.rs` | the likeliest end, and those that are about as likely |
//! | end of the judge | `ends/of_judge.rs` | a place that does not hang on the method, where something is open |
//! | mistakes | `mistakes/` | what the session may have got wrong, where it explains what the solution does not: no value is told then |
//! | rest, places nearby | `ends/resting.rs`, `ends/nearby.rs` | values that do not hang on where a fit ended; where readings say less |
//! | profiles | `ends/profiles.rs` | how far values may be off where the problem is not linear |
//! | uncertainty | `identifiability/uncertainty.rs`, `identifiability/widening.rs` | standard deviations |
//! | judgement | `identifiability/judged.rs` | what is determined: of use by rank and standard deviation |
//! | residual tests | `judgement/residual_tests/` | what the model lacks, and by how much that widens intervals; friction in tables: all again, with it as an unknown (`model_error/in_tables.rs`) |
//! | findings, verdict | `reporting/conclusion.rs` | what a reader must know before any number |

use std::borrow::Cow;

use gravcal_estimation::{Solver, Termination};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::ends::other_ends::or_other_end;
use crate::joint::ends::symmetries::{in_hemisphere, settled};
use crate::joint::error::EstimateError;
use crate::joint::identifiability::untold_noise::untold_beside_earlier;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::mistakes::evident::evident_mistake;
use crate::joint::mistakes::search::contradicting_mistake;
use crate::joint::model_error::bending_in_motion::UnresolvedBending;
use crate::joint::model_error::settling::LeftToSettle;
use crate::joint::order::Order;
use crate::joint::reporting::answer::{Answer, LookedForMistakes};
use crate::joint::reporting::conclusion::Conclusion;
use crate::joint::solved::Solved;
use crate::joint::solving::other_starts::{is_doubtful, likeliest_of_other_starts};
use crate::joint::solving::solve_from::{solve_briefly, solve_from};
use crate::joint::starting::sample::{Sample, telling_part};
use crate::joint::starting::start::{best_start, start_around};
use crate::joint::variables::State;
use crate::judgement::{ResidualTests, TestsWanted, residual_tests};

/// Solves for everything, from `known` values if they start the problem better than the nominal ones; noise that no
/// reading states is estimated from the residuals of each joint; the readings' loss is heeded.
///
/// # Errors
/// Where there is no answer at all; not converging is a [`Termination`].
pub fn solve(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let start = start(session, readings, known, environment)?;
    solve_after(start, session, readings, known, environment)
}

/// Where a solve starts.
struct Start {
    /// A part of the readings.
    sample: Sample,
    values: State,
}

fn start(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<Start, EstimateError> {
    environment.report("starting values");
    check_noise_told(session, readings)?;
    let sample = Sample::new(session, readings)?;
    let values = match (&readings.order, known) {
        (Order::Together, _) => best_start(session, &sample, known, environment)?,
        (Order::StepByStep(_), Some(of_steps)) => start_around(session, readings, of_steps)?,
        // What fewer readings show need not be so for all.
        _ => best_start(session, &Sample::new(session, &readings.first())?, known, environment)?,
    };
    Ok(Start { sample, values })
}

fn solve_after(
    Start { sample, values: start }: Start,
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let part = telling_part(session, readings);
    let solved = solve_from(session, &part, start, environment)?;
    let sample = sample.with_noise_of(session, solved.readings())?;
    let solved = settled(session, solved, &sample, environment)?;
    let (solved, of_part) = match part {
        Cow::Borrowed(_) => (solved, None),
        Cow::Owned(_) => (of_all(readings, &solved, session, environment)?, Some(solved)),
    };
    match is_doubtful(session, &solved)? {
        true => likeliest_of_other_starts(session, readings, &sample, (solved, of_part), known, environment),
        false => Ok(solved),
    }
}

/// The solution of all readings, from that of a part of them.
fn of_all(
    readings: &MeasurementSet,
    of_part: &Solved,
    session: &Session,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let MeasurementSet { noise, unexplained, .. } = of_part.readings().clone();
    let readings = MeasurementSet { noise, unexplained, ..readings.clone() };
    let solved = solve_from(session, &readings, of_part.state(&State::nominal(session)), environment)?;
    in_hemisphere(session, of_part.replaced_by(solved), environment)
}

/// Beside what is known from an earlier calibration, readings that tell no more numbers than they are have residuals of any size, and no noise that could be
/// estimated: its likelihood has no maximum.
fn check_noise_told(session: &Session, readings: &MeasurementSet) -> Result<(), EstimateError> {
    let found = session.noise_estimated().contains(&true);
    match found && untold_beside_earlier(session, readings)?.is_some() {
        true => Err(EstimateError::NoiseUntold { readings: readings.count() }),
        false => Ok(()),
    }
}

/// The solution after a look at where else the truth may lie, and with what is known there. One method of minimisation looks, whichever found the
/// solution: where the readings say next to nothing, methods end at different places of the same valley, and what is told must not depend on that.
fn look_elsewhere(
    solved: Solved,
    session: &Session,
    (readings, known): (&MeasurementSet, Option<&State>),
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let judge = judge_of(&solved, environment);
    let by_judge = judge.as_ref().map(|judge| environment.by(judge.as_ref()));
    let solved = match &by_judge {
        Some(judge) if solved.is_minimum_of_all() && !solved.open(session).is_empty() => {
            // What leads nowhere says nothing of the solution.
            match solve(session, readings, known, judge) {
                Ok(of_judge) => solved.or_end_of_judge(of_judge, session)?,
                Err(_) => solved,
            }
        }
        _ => solved,
    };
    or_other_end(solved, session, by_judge.as_ref().unwrap_or(environment))
}

/// How far values may be off where the problem is not linear, by the method that looks elsewhere.
fn look_nearby(solved: Solved, session: &Session, environment: &SolveEnvironment<'_>) -> Result<Solved, EstimateError> {
    environment.report("judging what is determined");
    let judge = judge_of(&solved, environment);
    let by_judge = judge.as_ref().map(|judge| environment.by(judge.as_ref()));
    let environment = by_judge.as_ref().unwrap_or(environment);
    solved.with_nearby(session, environment)?.with_profiles(session, environment)
}

/// The method of minimisation that judges, where it is another and takes such a problem.
fn judge_of(solved: &Solved, environment: &SolveEnvironment<'_>) -> Option<Box<dyn Solver>> {
    environment.solver().judge().filter(|judge| judge.check(&solved.built.problem).is_ok())
}

/// The solution, with what is determined of it, and how well; with friction and compliance as unknowns where residuals of tables show them.
/// `wanted`: which tests on residuals.
///
/// # Errors
/// Where there is no answer at all.
pub(super) fn answer(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    wanted: TestsWanted,
    environment: &SolveEnvironment<'_>,
) -> Result<Answer, EstimateError> {
    let first = answer_as_modelled(session, readings, known, wanted, environment)?;
    if first.mistakes.found.is_some() || environment.stopped() {
        return Ok(first);
    }
    let Some(shown) = first.solved.shown_by_tables(session, readings, &first.residual_tests)? else { return Ok(first) };
    let found = first.solved.state(&State::nominal(session));
    // The first names what it lacks: where the second leads nowhere, or is stopped, it stands.
    match answer_as_modelled(session, &shown, Some(&found), wanted, environment) {
        Ok(second) if second.solved.estimate.termination.converged() => Ok(second),
        _ => Ok(first),
    }
}

fn answer_as_modelled(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    wanted: TestsWanted,
    environment: &SolveEnvironment<'_>,
) -> Result<Answer, EstimateError> {
    let start = start(session, readings, known, environment)?;
    let evident = evident_mistake(session, &start.sample, &start.values, environment)?;
    let solved = match evident {
        Some(_) => solve_briefly(session, readings, &start.values, environment)?,
        None => {
            let solved = solve_after(start, session, readings, known, environment)?;
            look_elsewhere(solved, session, (readings, known), environment)?
        }
    };
    let doubtful = evident.is_some() || solved.may_hide_mistake(session)?;
    let mistake = match evident {
        None if doubtful => contradicting_mistake(session, &solved, environment)?,
        evident => evident,
    };
    // Where no value will be told, no interval is asked for.
    let explains_nothing = doubtful && solved.leaves_all_unexplained(session, &solved.judge(session))?;
    let solved =
        if mistake.is_some() || explains_nothing { solved } else { look_nearby(solved, session, environment)? };
    // What was stopped on its way explains the readings badly whatever the model.
    let misfit = solved.misfit(session)?.filter(|_| solved.estimate.termination != Termination::Stopped);
    let pose_errors = solved.pose_errors(session)?;
    let (uncertainty, origin) = solved.chosen_uncertainty(session, misfit, pose_errors.is_some(), environment)?;
    let solved = Solved { uncertainty, ..solved }.widened_beyond_linear(session);
    let judgement = solved.judge_for_report(session);
    environment.report("judging residuals");
    // What readings determine they determine; a term that the model lacks widens its interval.
    let ResidualTests { tests, moved, taken_as_exact } =
        residual_tests(session, &solved, &judgement, (&origin, pose_errors.is_some()), wanted)?;
    let LeftToSettle { moved: by_settling, told: settles } = solved.left_to_settle(session)?;
    let (by_speed, uneven) = solved.moved_by_uneven_sweeps(session)?;
    let (by_load, hidden) = (solved.moved_by_friction_of_load(session), solved.moved_by_hidden_friction(session));
    let UnresolvedBending { moved: by_bending, told: bends } = solved.unresolved_bending(session)?;
    let moved = [moved, by_load, hidden, by_settling, by_speed, by_bending].concat();
    let solved = solved.widened_by_missing_terms(&moved);
    let answer = Answer::of(session, solved, judgement, (misfit, pose_errors), (origin, tests))?;
    let mistakes = LookedForMistakes { doubtful, found: mistake };
    Ok(Answer { taken_as_exact, settles, bends, uneven, mistakes, ..answer })
}

/// The answer, and what it is worth.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub(super) fn conclude(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    wanted: TestsWanted,
    environment: &SolveEnvironment<'_>,
) -> Result<Conclusion, EstimateError> {
    let answer = answer(session, readings, known, wanted, environment)?;
    let findings = answer.looked_over(session, environment)?;
    Ok(Conclusion::of(session, answer, findings))
}
