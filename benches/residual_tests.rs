//! How often tests on residuals name something that is not there, and how often what is.
//!
//! `cargo run --release -p gravcal-benches --bin residual_tests -- --sessions 2000 --seed 1`
//!
//! Sessions are those of the populations (robots of the shared data and random arms; noise stated or not; with a load, with a wrist
//! sensor), right in every other way, or with one error: a zero that drifts, a coordinate that runs unevenly, errors that neighbouring
//! poses share. Exit code 1 where right models are blamed in more than 2 of 100 sessions, or an error is named in fewer than 90.

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gravcal_benches::program::progress;
use gravcal_calibration::result::{ResidualTest, ResidualTestKind, Verdict};
use gravcal_solvers::SolverName;
use rayon::prelude::*;

use gravcal_benches::population::arm::Arm;
use gravcal_benches::population::arms::Arms;
use gravcal_benches::population::calibrate::calibrate;
use gravcal_benches::population::draw::{Kind, draw};
use gravcal_benches::population::truth::Truth;
use gravcal_benches::population::write::{readings, write_session};

/// The program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Of right models, at most so many are blamed.
const FALSE_ALARMS: f64 = 0.02;
/// Of errors that are there, at least so many are named.
const POWER: f64 = 0.9;

/// Simulates sessions, calibrates them, and counts what tests on residuals name.
#[derive(Parser)]
struct Arguments {
    /// How many.
    #[arg(long, default_value_t = 200)]
    sessions: u64,
    /// Number of the first one.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of the random numbers; session k of a seed is the same whatever else is asked.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What is wrong with them.
    #[arg(long, value_enum, default_value_t = Wrong::Nothing)]
    wrong: Wrong,
    /// How wrong: standard deviations of a reading over the session, rad of a harmonic, or the correlation of neighbours [default: 3, 0.001, 0.6].
    #[arg(long)]
    size: Option<f64>,
    /// Which arms: a number's arm depends on this, too.
    #[arg(long, value_enum, default_value_t = Arms::All)]
    arms: Arms,
}

/// An error of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Wrong {
    /// The model is right.
    Nothing,
    /// The zero of one joint's torque sensor drifts evenly over the session.
    Trend,
    /// The coordinate of the second joint runs unevenly twice a turn.
    Harmonic,
    /// The errors of one joint are alike in neighbouring poses.
    Neighbours,
}

/// What became of a session.
struct Outcome {
    name: String,
    verdict: Verdict,
    tests: Vec<ResidualTest>,
    /// The joint that is wrong.
    joint: String,
    seconds: f64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// Whether the tests do what they should.
fn run(arguments: &Arguments) -> Result<bool, String> {
    let robots = arguments.arms.robots()?;
    let bar = progress(arguments.sessions, "sessions");
    let numbers = arguments.first..arguments.first + arguments.sessions;
    let outcomes: Vec<Option<Outcome>> = numbers
        .into_par_iter()
        .map(|number| {
            let outcome = session(arguments, &robots, number);
            bar.inc(1);
            outcome
        })
        .collect::<Result<_, String>>()?;
    bar.finish_and_clear();
    let outcomes: Vec<Outcome> = outcomes.into_iter().flatten().collect();
    Ok(report(arguments.wrong, &outcomes))
}

/// Nothing where there is no answer, or one that failed.
fn session(arguments: &Arguments, robots: &[Arm], number: u64) -> Result<Option<Outcome>, String> {
    let kinds: &[Kind] = match arguments.wrong {
        Wrong::Nothing => &[Kind::Bare, Kind::Ordinary, Kind::Noise, Kind::Wrist],
        _ => &[Kind::Bare, Kind::Ordinary],
    };
    let kind = kinds[(number % kinds.len() as u64) as usize];
    // Robots take turns by number; so kinds must not.
    let mut truth = draw(kind, robots, arguments.seed, number / kinds.len() as u64)?;
    let joint = (number / 3) as usize % truth.arm.joint_count();
    let joint = spoil(&mut truth, arguments.wrong, arguments.size, joint);
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    write_session(&truth, folder.path())?;
    let answer = calibrate(&folder.path().join("session.toml"), SolverName::LevenbergMarquardt);
    let name = format!("{}-{number}-{}", kind.as_str(), truth.arm.name);
    let Ok(result) = answer.result else { return Ok(None) };
    let joint = truth.arm.joints[joint].name.clone();
    let outcome =
        Outcome { name, verdict: result.verdict, tests: result.residual_tests, joint, seconds: answer.seconds };
    Ok(Some(outcome))
}

/// Makes a session wrong; gives the joint that is.
fn spoil(truth: &mut Truth, wrong: Wrong, size: Option<f64>, joint: usize) -> usize {
    let channels = truth.channels();
    let poses = truth.errors.len() / channels;
    match wrong {
        Wrong::Nothing => joint,
        Wrong::Trend => {
            let total = size.unwrap_or(3.0);
            for pose in 0..poses {
                truth.errors[pose * channels + joint] += total * (pose as f64 / (poses - 1) as f64 - 0.5);
            }
            joint
        }
        Wrong::Neighbours => {
            let correlation = size.unwrap_or(0.6);
            for pose in 1..poses {
                let before = truth.errors[(pose - 1) * channels + joint];
                let own = &mut truth.errors[pose * channels + joint];
                *own = correlation * before + (1.0 - correlation * correlation).sqrt() * *own;
            }
            joint
        }
        Wrong::Harmonic => {
            // What the torques would be where the coordinate is another: errors are in standard deviations.
            let amplitude = size.unwrap_or(1e-3);
            let exact = readings(truth);
            let mut uneven = truth.clone();
            for table in &mut uneven.tables {
                table.angles.iter_mut().for_each(|angles| angles[1] += amplitude * (2.0 * angles[1]).sin());
            }
            let noise = truth.noise.clone();
            for (place, (with, without)) in readings(&uneven).iter().zip(&exact).enumerate() {
                truth.errors[place] += (with - without) / noise[place % channels];
            }
            1
        }
    }
}

fn report(wrong: Wrong, outcomes: &[Outcome]) -> bool {
    let tested: Vec<&Outcome> =
        outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Failed && !outcome.tests.is_empty()).collect();
    let share = |is: &dyn Fn(&&&Outcome) -> bool| tested.iter().filter(is).count() as f64 / tested.len().max(1) as f64;
    let alarmed = |outcome: &&&Outcome| outcome.tests.iter().any(|test| test.named);
    let found = |outcome: &&&Outcome| outcome.tests.iter().any(|test| test.named && is_it(wrong, &outcome.joint, test));
    println!("{} sessions, {} tested", outcomes.len(), tested.len());
    println!("something is named in {:.2} %", 100.0 * share(&alarmed));
    let tests: Vec<&ResidualTest> = tested.iter().flat_map(|outcome| &outcome.tests).collect();
    println!("{:.1} tests a session", tests.len() as f64 / tested.len().max(1) as f64);
    for level in [1e-4, 1e-3, 0.01, 0.05, 0.5] {
        let below = tests.iter().filter(|test| test.p_value < level).count() as f64 / tests.len().max(1) as f64;
        println!("p < {level}: {below:.5} of all tests");
    }
    let seconds: f64 = outcomes.iter().map(|outcome| outcome.seconds).sum();
    println!("{:.2} s of a processor a session", seconds / outcomes.len().max(1) as f64);
    if wrong == Wrong::Nothing {
        for outcome in tested.iter().filter(alarmed) {
            let named = outcome.tests.iter().filter(|test| test.named);
            let reported: Vec<String> =
                named.map(|test| format!("{} {} p {:.1e}", test.channel, test.kind, test.corrected_p_value)).collect();
            println!("  {}: {}", outcome.name, reported.join("; "));
        }
        return share(&alarmed) <= FALSE_ALARMS;
    }
    println!("it is named in {:.1} %", 100.0 * share(&found));
    for outcome in tested.iter().filter(|outcome| !found(outcome)).take(20) {
        let named: Vec<String> = outcome
            .tests
            .iter()
            .filter(|test| test.named)
            .map(|test| format!("{} {}", test.channel, test.kind))
            .collect();
        println!("  not in {}, {}: [{}]", outcome.name, outcome.joint, named.join(", "));
    }
    share(&found) >= POWER
}

/// Whether a test names what is wrong.
fn is_it(wrong: Wrong, joint: &str, test: &ResidualTest) -> bool {
    let trend = matches!(
        test.kind,
        ResidualTestKind::Trend
            | ResidualTestKind::TrendCurve
            | ResidualTestKind::TrendInTables
            | ResidualTestKind::Tables { .. }
    );
    match wrong {
        Wrong::Nothing => false,
        Wrong::Trend => test.channel == joint && trend,
        Wrong::Neighbours => test.channel == joint && test.kind == ResidualTestKind::Neighbours,
        Wrong::Harmonic => {
            matches!(test.kind, ResidualTestKind::PositionHarmonic { .. } | ResidualTestKind::TorqueHarmonic { .. })
        }
    }
}
