//! Whether another start leads to a likelier end: the joint problem solved from random starts.
//!
//! Ends are compared as the joint estimator compares them: with the noise that each end shows, taken for that of all joints where nothing tells these
//! apart, and counted by the degrees of freedom that found it, with the leverage `h_i` of row i and its standard deviation `σ_i`,
//!
//! ```text
//!     − ln L = ½ χ² + Σ_i (1 − h_i) ln σ_i      where the noise is taken from the residuals
//!     − ln L = ½ χ²                             where it is stated
//! ```
//!
//! The estimator's solution rests at what is declared along what the readings leave open, and lies above the minimum by that: so it is a start, too,
//! followed as all others are.

use std::path::Path;

use gravcal_calibration::joint::{Signals, State, build_problem, select, solve};
use gravcal_estimation::{RankAnalysis, SolveContext, Solver};
use gravcal_identification::{ReadingResidual, RowResidual, SolveEnvironment, noise_by_squares, row_residuals};
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
    let alike = vec![Some(0); session.joints.len()];
    let (mut values, mut end) = (None, None);
    for _ in 0..if truth.said.std { 1 } else { ROUNDS } {
        let built = build_problem(session, &readings, &start).ok()?;
        let stopping = StoppingRules { max_iterations: ITERATIONS, ..Default::default() };
        let from = values.as_ref().unwrap_or(&built.initial);
        let estimate =
            LevenbergMarquardt { stopping }.solve(&built.problem, from, &mut SolveContext::default()).ok()?;
        let analysis = RankAnalysis::new(&built.problem, &estimate.values).ok()?;
        let rows = row_residuals(&built.problem, &estimate.values, &analysis, built.rows.len()).ok()?;
        let of_reading = |(id, row): (&ReadingId, RowResidual)| ReadingResidual {
            channel: id.channel,
            std: readings.std(session, *id),
            row,
        };
        let residuals: Vec<ReadingResidual> = built.rows.iter().zip(rows).map(of_reading).collect();
        let size = |ReadingResidual { std, row, .. }: &ReadingResidual| (1.0 - row.leverage).max(0.0) * std.ln();
        let by_noise = if truth.said.std { 0.0 } else { residuals.iter().map(size).sum() };
        end = Some(estimate.cost + by_noise);
        for (joint, noise) in noise_by_squares(&residuals, &alike).into_iter().enumerate() {
            readings.noise[joint] = noise.map_or(readings.noise[joint], |noise| noise.std);
        }
        values = Some(estimate.values);
    }
    end
}
