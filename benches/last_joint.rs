//! How often the 95 % interval of the last joint's torque gain holds the truth: one table in Markdown.
//!
//! `cargo run --release -p gravcal-benches --bin last_joint`

use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::progress;
use gravcal_dynamics::ChainError;
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::last_joint::{LastJoint, last_joint};

/// Calibrates simulated arms with the paper's sweeps and two placements, all torques read, and counts how often the 95 %
/// interval of the last joint's torque gain holds the truth.
#[derive(Parser)]
struct Arguments {
    /// How many arms of each number of joints.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    draws: u64,
    /// Numbers of joints.
    #[arg(long, value_delimiter = ',', default_values_t = [3, 6, 7])]
    joints: Vec<usize>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), ChainError> {
    println!("| joints | draws | determined | truth within the interval | rms standard deviation | rms error / std |");
    println!("|---|---|---|---|---|---|");
    for joints in &arguments.joints {
        let bar = progress(arguments.draws, "arms");
        let found =
            last_joint(*joints, arguments.draws, arguments.seed, &LevenbergMarquardt::default(), &|| bar.inc(1))?;
        bar.finish_and_clear();
        print_row(&found);
    }
    Ok(())
}

fn print_row(found: &LastJoint) {
    let determined = found.determined();
    println!(
        "| {} | {} | {determined} | {} ({:.1} %) | {:.2} % | {:.3} |",
        found.joints,
        found.errors_in_std.len(),
        found.within,
        100.0 * found.within as f64 / determined as f64,
        100.0 * found.relative_std,
        (found.chi_squared() / determined as f64).sqrt()
    );
}
