//! Unknowns of single poses: time and memory over the number of poses, and the result beside that without elimination.
//!
//! `cargo run --release -p gravcal-benches --bin structure`
//!
//! The joint problem of seven joints (see `benches/README.md`), with the error of every joint's position in every pose as a
//! further unknown: seven eliminated unknowns a pose, known beforehand to half a milliradian. One thread.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gravcal_benches::program::ended;
use gravcal_benches::seven_joints::{POSITION_ERROR, SevenJoints};
use gravcal_estimation::{Estimate, Problem, RankAnalysis, SolveContext, Solver, Values};
use gravcal_solvers::LevenbergMarquardt;

/// Shows that unknowns of single poses cost time and memory in proportion to their number, and change no result.
#[derive(Parser)]
struct Arguments {
    /// Numbers of poses.
    #[arg(long, value_delimiter = ',', default_value = "100,1000,10000,100000", value_parser = clap::value_parser!(u32).range(30..))]
    poses: Vec<u32>,
    /// Number of poses for which the result is compared with that without elimination.
    #[arg(long, default_value = "100", value_parser = clap::value_parser!(u32).range(30..=300))]
    compare: u32,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    one_thread.install(|| {
        println!("   poses  unknowns  iterations  seconds  µs/(pose·it.)  judged s  MiB  KiB/pose   cosine");
        arguments.poses.iter().try_for_each(|poses| measure(*poses as usize))?;
        compare(arguments.compare as usize)
    })
}

/// Solves and judges one number of poses, and prints what it took.
fn measure(poses: usize) -> Result<(), String> {
    let (problem, initial) = SevenJoints::simulate(poses)?.with_position_errors(true)?;
    let before = memory_mib()?;
    let start = Instant::now();
    let estimate = solve(&problem, &initial)?;
    let seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let analysis = RankAnalysis::new(&problem, &estimate.values).map_err(|e| e.to_string())?;
    let covariance = analysis.covariance();
    let deviation = covariance.std(problem.columns().len() - 1);
    let judged = start.elapsed().as_secs_f64();
    if !(deviation > 0.0 && deviation <= POSITION_ERROR) {
        return Err(format!("the last position error has a standard deviation of {deviation} rad"));
    }
    let memory = memory_mib()? - before;
    let iterations = estimate.iterations.len() - 1;
    println!(
        "{poses:8} {:9} {iterations:11} {seconds:8.3} {:14.1} {judged:9.2} {memory:4.0} {:9.1} {:8.1e}",
        problem.columns().len(),
        1e6 * seconds / (poses * iterations) as f64,
        memory * 1024.0 / poses as f64,
        estimate.iterations[iterations].cosine,
    );
    Ok(())
}

/// Largest difference of any unknown from the result without elimination, in standard deviations.
fn compare(poses: usize) -> Result<(), String> {
    let (eliminated, initial) = SevenJoints::simulate(poses)?.with_position_errors(true)?;
    let (plain, _) = SevenJoints::simulate(poses)?.with_position_errors(false)?;
    let (one, other) = (solve(&eliminated, &initial)?, solve(&plain, &initial)?);
    let analysis = RankAnalysis::new(&plain, &other.values).map_err(|e| e.to_string())?;
    let reduced = RankAnalysis::new(&eliminated, &one.values).map_err(|e| e.to_string())?;
    if analysis.rank() != reduced.rank() {
        return Err(format!("rank {} without elimination, {} with it", analysis.rank(), reduced.rank()));
    }
    let (dense, sparse) = (analysis.covariance(), reduced.covariance());
    let (mut of_values, mut of_deviations) = (0.0_f64, 0.0_f64);
    for id in plain.block_ids() {
        let all: Vec<usize> = plain.columns_of(id).collect();
        // What the data do not determine has no result to compare.
        if analysis.null_space_within(&all).is_empty() {
            let (a, b) = (one.values.get(id), other.values.get(id));
            let difference = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            let smallest = all.iter().map(|column| dense.std(*column)).fold(f64::INFINITY, f64::min);
            of_values = of_values.max(difference / smallest);
            let relative = |column: &usize| (sparse.std(*column) / dense.std(*column) - 1.0).abs();
            of_deviations = all.iter().map(relative).fold(of_deviations, f64::max);
        }
    }
    println!(
        "{poses} poses with and without elimination: values differ by at most {of_values:.1e} standard deviations, \
         standard deviations by {of_deviations:.1e} of themselves (rank {} of {} unknowns)",
        analysis.rank(),
        plain.columns().len(),
    );
    Ok(())
}

fn solve(problem: &Problem, initial: &Values) -> Result<Estimate, String> {
    let solver = LevenbergMarquardt::default();
    let estimate = solver.solve(problem, initial, &mut SolveContext::default()).map_err(|e| e.to_string())?;
    match estimate.termination {
        end if end.converged() => Ok(estimate),
        end => Err(end.to_string()),
    }
}

/// Largest memory that the process has held so far, MiB.
fn memory_mib() -> Result<f64, String> {
    let status = std::fs::read_to_string("/proc/self/status").map_err(|e| format!("/proc/self/status: {e}"))?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = peak.and_then(|rest| rest.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
    kib.map(|kib| kib / 1024.0).ok_or_else(|| "this system does not tell the peak of memory (VmHWM)".into())
}
