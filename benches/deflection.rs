//! What half a degree of deflection of standing joints does to the estimates, and what mends it: three tables.
//!
//! `cargo run --release -p gravcal-benches --bin deflection -- experiments/sarcos-shoulder/simulation.toml`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::{ended, progress};
use gravcal_robot_model::Session;
use gravcal_session::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::{DeflectionColumn, DeflectionStudy, Treatment, deflection_study};

/// Deflection of a standing joint, or noise of a position reading, degrees: one standard deviation.
const DEFLECTION_DEG: f64 = 0.5;
/// Compliance of every joint, rad/(N·m): half a degree under some 30 N·m.
const COMPLIANCE: f64 = 3e-4;

/// Simulates many sessions whose standing joints deflect, and prints rms errors beside the Cramér-Rao bound of the model with
/// deflection, and how often the 95 % intervals hold the truth.
#[derive(Parser)]
struct Arguments {
    /// The simulation, of sweeps.
    simulation: PathBuf,
    /// How many sessions of each kind of deflection.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(2..))]
    trials: u64,
    /// How many threads.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let mut simulation = Simulation::read(&arguments.simulation).map_err(|e| e.to_string())?;
    simulation.disturbance.converter = None;
    let pool =
        rayon::ThreadPoolBuilder::new().num_threads(arguments.threads.into()).build().map_err(|e| e.to_string())?;
    pool.install(|| {
        by_hold(&simulation, arguments.trials)?;
        by_pose(&simulation, arguments.trials)?;
        by_compliance(&simulation, arguments.trials)
    })
}

fn by_hold(plain: &Simulation, trials: u64) -> Result<(), String> {
    let mut simulation = plain.clone();
    let std = DEFLECTION_DEG.to_radians();
    simulation.disturbance.deflection.hold_std = std;
    let heading = format!("every standing joint deflects by ±{DEFLECTION_DEG}°, the same in all poses of a sweep");
    print(&heading, &simulation, &|session| session.deflection.hold_std = Some(std), trials)
}

fn by_pose(plain: &Simulation, trials: u64) -> Result<(), String> {
    let mut simulation = plain.clone();
    let std = DEFLECTION_DEG.to_radians();
    simulation.disturbance.deflection.pose_std = std;
    let heading = format!("every standing joint deflects by ±{DEFLECTION_DEG}°, differently in each pose");
    print(&heading, &simulation, &|session| session.deflection.pose_std = Some(std), trials)
}

fn by_compliance(plain: &Simulation, trials: u64) -> Result<(), String> {
    let mut simulation = plain.clone();
    let joints = simulation.template.joints.len();
    simulation.disturbance.deflection.compliance = vec![COMPLIANCE; joints];
    let heading = format!("every standing joint gives way by {COMPLIANCE} rad/(N·m); known beforehand: 0 ± 0.001");
    print(&heading, &simulation, &|session| session.let_joints_give_way(&vec![1e-3; joints]), trials)
}

fn print(
    heading: &str,
    simulation: &Simulation,
    model: &(dyn Fn(&mut Session) + Sync),
    trials: u64,
) -> Result<(), String> {
    let bar = progress(trials, "trials");
    let solver = LevenbergMarquardt::default();
    let study = deflection_study(simulation, model, trials, &solver, &|| bar.inc(1)).map_err(|e| e.to_string())?;
    bar.finish_and_clear();
    print_table(heading, &simulation.session(0), &study);
    Ok(())
}

fn print_table(heading: &str, session: &Session, study: &DeflectionStudy) {
    println!("{heading}; {} trials", study.trials);
    println!(
        "mean error / rms error, in units of the bound of the model with deflection; per cent of 95 % intervals that hold"
    );
    print!("{:22} {:>11} {:>9}", "parameter", "unit", "bound");
    Treatment::ALL.iter().for_each(|treatment| print!("  {:>20}", treatment.name()));
    println!();
    for (quantity, bound, columns) in &study.rows {
        let bound = bound.unwrap_or(f64::NAN);
        print!("{:22} {:>11} {bound:>9.2e}", quantity.name(session), quantity.unit(session));
        columns.iter().for_each(|column| print!("  {:>20}", cell(column, bound, study.trials)));
        println!();
    }
    println!();
}

fn cell(column: &DeflectionColumn, bound: f64, trials: u64) -> String {
    if column.answers == 0 {
        return "-".into();
    }
    let missing = if column.answers as u64 == trials { String::new() } else { format!(" of {}", column.answers) };
    let [mean, rms] = [column.mean_error, column.rms_error].map(|error| error / bound);
    format!("{mean:.2} / {rms:.2} {:>4.1}{missing}", 100.0 * column.coverage)
}
