//! Sensor parameters of an arm in motion: how often 95 % intervals hold the truth under coloured errors, and how near errors under white noise
//! come to the Cramér-Rao bound.
//!
//! `cargo run --release -p gravcal-benches --bin in_motion -- --line coverage --draws 1000`
//! `cargo run --release -p gravcal-benches --bin in_motion -- --line bound --draws 1000 --upright`

mod arm;
mod bound;

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gravcal_benches::program::{ended, progress};
use gravcal_calibration::result::Brief;
use gravcal_calibration::{SolveEnvironment, calibrate_briefly};
use gravcal_robot_model::EstimatorName;
use gravcal_robot_model::session::{PoseBlocks, Session, UncertaintyChoice};
use gravcal_solvers::LevenbergMarquardt;
use rand::RngExt;
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use arm::{Arm, DURATION, JOINTS, QUANTITIES, RATE};
use bound::bound;

/// Noise of a sample, N·m.
const NOISE: f64 = 0.1;

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Line {
    /// How often 95 % intervals hold the truth; errors of neighbouring samples are alike.
    Coverage,
    /// Errors beside the Cramér-Rao bound of the samples; errors are white.
    Bound,
}

/// Simulates seven joints in motion many times, bare and with a load of known mass.
#[derive(Parser)]
struct Arguments {
    /// What is measured.
    #[arg(long)]
    line: Line,
    /// How many draws of the errors.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    draws: u64,
    /// With `coverage`: the time over which errors are alike, s.
    #[arg(long, default_value_t = 0.2)]
    correlation_s: f64,
    /// Whether gravity is parallel to the first joint's axis.
    #[arg(long)]
    upright: bool,
}

/// An estimated number: which it is, its truth, value, and 95 % interval.
struct Found {
    quantity: &'static str,
    /// Its place among the truth's numbers; nothing of gravity's components.
    place: Option<usize>,
    truth: f64,
    value: f64,
    interval: [f64; 2],
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let arm = Arm::new(arguments.upright)?;
    let exact = arm.readings(&arm.truth);
    let mut session = arm.session(&exact);
    if arguments.line == Line::Coverage {
        session.uncertainty = UncertaintyChoice::Jackknife { blocks: PoseBlocks::Found };
    }
    let correlation = if arguments.line == Line::Coverage { arguments.correlation_s } else { 0.0 };
    println!(
        "{JOINTS} joints, {DURATION} s bare and {DURATION} s loaded at {RATE} Hz, {}; errors of {NOISE} N·m, {}; {} draws",
        if arguments.upright { "upright" } else { "tilted" },
        if correlation > 0.0 { format!("alike over {correlation} s") } else { "white".into() },
        arguments.draws
    );
    let bar = progress(arguments.draws, "draws");
    let draw = |index: u64| -> Result<Vec<Found>, String> {
        let mut random = Pcg64::new(7, u128::from(index));
        let noise = coloured(exact.len(), correlation, &mut random);
        let read: Vec<[f64; JOINTS]> =
            exact.iter().zip(&noise).map(|(exact, noise)| std::array::from_fn(|j| exact[j] + noise[j])).collect();
        let found = found(&arm, &arm.with_readings(&session, &read))?;
        bar.inc(1);
        Ok(found)
    };
    let draws: Vec<Vec<Found>> = (0..arguments.draws).into_par_iter().map(draw).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    match arguments.line {
        Line::Coverage => report_coverage(&draws),
        Line::Bound => report_bound(&draws, &bound(&arm)),
    }
    Ok(())
}

/// Errors of all samples: each is `ρ` times the one before, and something of its own. The first of the second run has none before.
fn coloured(samples: usize, correlation: f64, random: &mut Pcg64) -> Vec<[f64; JOINTS]> {
    let kept = if correlation > 0.0 { (-1.0 / (RATE * correlation)).exp() } else { 0.0 };
    let mut last = [0.0; JOINTS];
    (0..samples)
        .map(|sample| {
            let begins = sample == 0 || sample == samples / 2;
            for last in &mut last {
                let own: f64 = NOISE * random.sample::<f64, _>(StandardNormal);
                *last = if begins { own } else { kept * *last + (1.0 - kept * kept).sqrt() * own };
            }
            last
        })
        .collect()
}

/// Everything that the estimate tells and that has an error.
fn found(arm: &Arm, session: &Session) -> Result<Vec<Found>, String> {
    let solver = LevenbergMarquardt::default();
    let environment = SolveEnvironment::new(&solver, &|_| {});
    let mut all = calibrate_briefly(session, &[EstimatorName::Joint], &environment);
    let brief: Brief = all.remove(0).map_err(|error| error.to_string())?;
    let mut found = Vec::new();
    for (joint, described) in arm.robot.chain.joints().iter().enumerate() {
        for (number, quantity) in QUANTITIES.iter().enumerate() {
            let name = format!("{}.{quantity}", described.name);
            let reported = brief.parameters.iter().find(|parameter| parameter.name == name);
            let reported = reported.ok_or_else(|| format!("nothing is told of {name}"))?;
            if let (Some(value), Some(interval), None) = (reported.value, reported.ci95, &reported.held) {
                let place = 2 + QUANTITIES.len() * joint + number;
                found.push(Found { quantity, place: Some(place), truth: arm.truth[place], value, interval });
            }
        }
    }
    let gravity = brief.gravity.as_ref().ok_or("gravity is not told")?;
    for (axis, truth) in arm.gravity(&[0.0, 0.0]).into_iter().enumerate().take(2) {
        let (value, interval) = (gravity.vector_m_per_s2[axis], gravity.ci95_m_per_s2[axis]);
        found.push(Found { quantity: "gravity", place: None, truth, value, interval });
    }
    Ok(found)
}

fn quantities() -> impl Iterator<Item = &'static str> {
    QUANTITIES.into_iter().chain(["gravity"])
}

fn report_coverage(draws: &[Vec<Found>]) {
    println!("{:18}  {:>9}  {:>8}", "", "intervals", "hold, %");
    let report = |name: &str, chosen: &dyn Fn(&&Found) -> bool| {
        let own: Vec<&Found> = draws.iter().flatten().filter(chosen).collect();
        let holds = own.iter().filter(|f| f.interval[0] <= f.truth && f.truth <= f.interval[1]).count();
        println!("{name:18}  {:>9}  {:>8.1}", own.len(), 100.0 * holds as f64 / own.len() as f64);
    };
    quantities().for_each(|quantity| report(quantity, &|found| found.quantity == quantity));
    report("all", &|_| true);
}

fn report_bound(draws: &[Vec<Found>], bound: &[f64]) {
    println!("{:18}  {:>9}  {:>27}", "", "told", "error / bound (rms; by joint)");
    for quantity in QUANTITIES {
        let ratio = |place: usize| {
            let own = draws.iter().flatten().filter(|found| found.place == Some(place));
            let squares: Vec<f64> = own.map(|f| ((f.value - f.truth) / (NOISE * bound[place])).powi(2)).collect();
            (squares.len(), squares.iter().sum::<f64>())
        };
        let places = (0..bound.len())
            .filter(|place| draws.iter().flatten().any(|f| f.place == Some(*place) && f.quantity == quantity));
        let each: Vec<(usize, f64)> = places.map(ratio).collect();
        let (count, sum) = each.iter().fold((0, 0.0), |(count, sum), (n, own)| (count + n, sum + own));
        let by_joint: Vec<String> = each.iter().map(|(n, own)| format!("{:.3}", (own / *n as f64).sqrt())).collect();
        println!("{quantity:18}  {count:>9}  {:>9.3}  {}", (sum / count as f64).sqrt(), by_joint.join(" "));
    }
}
