//! Whether another start leads to a likelier end: the joint problem solved from random starts.
//!
//! With the root mean square residual `r_j` of joint j over `N_j` readings,
//!
//! ```text
//!     − ln L = Σ_j N_j ln r_j              where the noise is taken from the residuals
//!     − ln L = Σ_j N_j r_j² / (2 σ_j²)     where it is stated
//! ```
//!
//! The joint estimator's solution rests at what is declared along what the readings leave open, and its joints share their noise where nothing tells
//! them apart: it lies above the minimum of − ln L by that. So it is a start, too, followed as all others are.

use std::path::Path;

use gravcal_calibration::joint::{MeasurementSet, Signals, State, build_problem, select, solve};
use gravcal_estimation::{SolveContext, Solver, Values};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::Session;
use gravcal_robot_model::session::ReadingId;
use gravcal_session::read_session;
use gravcal_solvers::{LevenbergMarquardt, StoppingRules};
use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64;

use gravcal_benches::population::draw::normal;
use gravcal_benches::population::truth::{GRAVITY, Truth};

/// Rounds in which the noise follows the residuals, and iterations of each.
const ROUNDS: usize = 5;
const ITERATIONS: usize = 60;
/// Ends as likely as this are the same.
pub const SAME: f64 = 1.0;

/// By how much − ln L where the joint estimator's solution leads exceeds the lowest that random starts lead to; below zero where none is as low. Nothing where
/// there is no solution.
///
/// # Errors
/// Where the session cannot be read or built.
pub fn above_lowest(truth: &Truth, session: &Path, starts: u64, seed: u64) -> Result<Option<f64>, String> {
    let session = read_session(session).map_err(|error| error.to_string())?;
    let (solver, readings) = (LevenbergMarquardt::default(), select(&session, Signals::All));
    let Ok(solution) = solve(&session, &readings, None, &SolveEnvironment::new(&solver, &|_| {})) else {
        return Ok(None);
    };
    let Some(reached) = from(truth, &session, solution.state(&State::nominal(&session))) else { return Ok(None) };
    let mut lowest = f64::INFINITY;
    for start in 0..starts {
        let mut random = Pcg64::new(u128::from(seed), u128::from(start));
        // A start that leads nowhere says nothing of the others.
        if let Some(end) = from(truth, &session, random_start(&session, truth, &mut random)) {
            lowest = lowest.min(end);
        }
    }
    Ok(Some(reached - lowest))
}

/// Anywhere in the hemisphere that is declared, with sensors near their nominal values and any bodies.
fn random_start(session: &Session, truth: &Truth, random: &mut Pcg64) -> State {
    let nominal = State::nominal(session);
    let mut gravity = Vector3::from_fn(|_, _| normal(random)).normalize() * GRAVITY;
    if truth.said.hemisphere && gravity.dot(&truth.gravity) < 0.0 {
        gravity = -gravity;
    }
    let sensors = nominal.sensors.iter().map(|[gain, bias, position_gain, offset]| {
        let mut near = |spread: f64| spread * normal(random);
        [gain * (1.0 + near(0.1)), *bias, position_gain + near(0.02), offset + near(0.1)]
    });
    let sensors = sensors.collect();
    let body = |joint: usize, random: &mut Pcg64| {
        let mass = random.random_range(0.5..5.0) / (1.0 + 0.3 * joint as f64);
        let mut moment = || mass * random.random_range(-0.2..0.2);
        [mass, moment(), moment(), moment()]
    };
    let inertia = (0..truth.arm.joint_count()).map(|joint| body(joint, random)).collect();
    State { gravity: gravity.into(), sensors, inertia, ..nominal }
}

/// − ln L where a start leads, if it leads somewhere.
fn from(truth: &Truth, session: &Session, start: State) -> Option<f64> {
    let mut readings = select(session, Signals::All);
    let (mut values, mut end) = (None, None);
    for _ in 0..if truth.said.std { 1 } else { ROUNDS } {
        let by_joint = solved(session, &readings, &start, &mut values)?;
        for (joint, (_, rms)) in by_joint.iter().enumerate() {
            readings.noise[joint] = *rms;
        }
        end = Some(minus_log_likelihood(truth, by_joint.into_iter()));
    }
    end
}

/// Solves from `values`, at first a start, which become the end; number of readings and root mean square residual of each joint.
fn solved(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    values: &mut Option<Values>,
) -> Option<Vec<(f64, f64)>> {
    let solver = LevenbergMarquardt { stopping: StoppingRules { max_iterations: ITERATIONS, ..Default::default() } };
    let built = build_problem(session, readings, start).ok()?;
    let from = values.as_ref().unwrap_or(&built.initial);
    let estimate = solver.solve(&built.problem, from, &mut SolveContext::default()).ok()?;
    let residuals = built.problem.residuals(&estimate.values).ok()?;
    let mut sums = vec![(0.0, 0.0); session.joints.len()];
    for (ReadingId { pose, channel: joint }, residual) in built.rows.iter().zip(residuals) {
        let std = session.poses[*pose].torque[*joint].and_then(|reading| reading.std).unwrap_or(readings.noise[*joint]);
        sums[*joint].0 += 1.0;
        sums[*joint].1 += (residual * std).powi(2);
    }
    *values = Some(estimate.values);
    Some(sums.into_iter().map(|(count, squares): (f64, f64)| (count, (squares / count).sqrt())).collect())
}

fn minus_log_likelihood(truth: &Truth, by_joint: impl Iterator<Item = (f64, f64)>) -> f64 {
    let of_joint = |((count, rms), noise): ((f64, f64), &f64)| match truth.said.std {
        true => 0.5 * count * (rms / noise).powi(2),
        false => count * rms.ln(),
    };
    by_joint.zip(&truth.noise).map(of_joint).sum()
}
