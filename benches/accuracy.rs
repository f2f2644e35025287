//! Root-mean-square errors of the estimators on a simulation, beside the Cramér-Rao bound: one table.
//!
//! `cargo run --release -p gravcal-benches --bin accuracy -- experiments/sarcos-shoulder/simulation.toml --trials 2000`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::{ended, progress};
use gravcal_calibration::Session;
use gravcal_calibration::sequential::Plan;
use gravcal_calibration::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::{Accuracy, Column, ColumnAccuracy, accuracy};

/// Simulates many sessions, runs every estimator on each, and prints their rms errors beside the Cramér-Rao bound.
#[derive(Parser)]
struct Arguments {
    /// The simulation.
    simulation: PathBuf,
    /// How many sessions.
    #[arg(long, default_value_t = 2000, value_parser = clap::value_parser!(u64).range(2..))]
    trials: u64,
    /// Leave the converter out.
    #[arg(long)]
    without_converter: bool,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let mut simulation = Simulation::read(&arguments.simulation).map_err(|e| e.to_string())?;
    if arguments.without_converter {
        simulation.disturbance.converter = None;
    }
    let bar = progress(arguments.trials, "trials");
    let table = accuracy(&simulation, arguments.trials, &Column::ALL, &LevenbergMarquardt::default(), &|| bar.inc(1))
        .map_err(|e| e.to_string())?;
    bar.finish_and_clear();
    print_table(&simulation.session(0), &table);
    print_signals(&simulation.session(0));
    Ok(())
}

fn print_table(session: &Session, table: &Accuracy) {
    println!(
        "{} trials; rms error and, in brackets, its ratio to the Cramér-Rao bound of the readings used",
        table.trials
    );
    print!("{:24} {:>12}", "parameter", "unit");
    Column::ALL.iter().for_each(|column| print!(" {:>24}", column.name()));
    println!();
    for (quantity, columns) in &table.rows {
        print!("{:24} {:>12}", quantity.name(session), quantity.unit(session));
        columns.iter().for_each(|column| print!(" {:>24}", cell(column, table.trials)));
        println!();
    }
    if let Some(largest) = table.largest_sinusoid_residual {
        println!("largest residual of the sinusoids of step 1, mean over the trials: {largest:.2}");
    }
}

fn cell(column: &ColumnAccuracy, trials: u64) -> String {
    if column.answers == 0 {
        return "-".into();
    }
    let ratio = match column.bound {
        Some(bound) => format!(" ({:.3})", column.rms_error / bound),
        None => String::new(),
    };
    let answers = if column.answers as u64 == trials { String::new() } else { format!(" of {}", column.answers) };
    format!("{:.3e}{ratio}{answers}", column.rms_error)
}

/// Which torque readings each step reads, and which it throws away.
fn print_signals(session: &Session) {
    let plan = Plan::new(session);
    let name = |joint: usize| &session.robot.chain.joints()[joint].name;
    let all: usize = session.poses.iter().map(|p| p.torque.iter().flatten().count()).sum();
    let of = |sweeps: &[usize]| sweeps.iter().map(|s| plan.sweeps[*s].poses.len()).sum::<usize>();
    println!("\nreadings of torque that a step reads, of {all} in the session:");
    for (joint, sweeps) in plan.bias.iter().enumerate() {
        println!("  {0}.torque_bias, {0}.position_gain: {1} of {0}", name(joint), of(sweeps));
    }
    println!("  gravity: {} of {}", of(&plan.gravity), name(1));
    for (joint, pairs) in plan.gain.iter().enumerate().filter(|(_, pairs)| !pairs.is_empty()) {
        let sweeps: Vec<usize> = pairs.iter().flat_map(|pair| pair.sweeps).collect();
        println!("  {0}.torque_gain, {0}.position_offset: {1} of {0}", name(joint), of(&sweeps));
    }
    println!("  all steps together: {}", plan.readings().len());
}
