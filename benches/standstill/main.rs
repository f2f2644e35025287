//! Standstills in simulated recordings in motion: what a calibration from them is worth, how many are found, how true their standard
//! errors are, and how fast that is. Three tables.
//!
//! `cargo run --release -p gravcal-benches --bin standstill -- experiments/sarcos-shoulder/simulation.toml`

mod many;
mod paper;
mod speed;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::ended;
use gravcal_session::simulation::Simulation;

/// Records the paper's procedure in motion, finds its standstills and calibrates from them; then many recordings of varied noise and
/// speed; then the time that a row takes.
#[derive(Parser)]
struct Arguments {
    /// The simulation of the paper's procedure.
    simulation: PathBuf,
    /// How many recordings of varied noise and speed.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    recordings: u64,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let simulation = Simulation::read(&arguments.simulation).map_err(|error| error.to_string())?;
    paper::run(&simulation)?;
    many::run(&simulation, arguments.recordings)?;
    speed::run(&simulation)
}

/// A simulation whose tables are recordings of this kind.
fn recorded(simulation: &Simulation) -> Simulation {
    let mut simulation = simulation.clone();
    simulation.template.tables.iter_mut().for_each(|table| {
        table.path.set_extension("mcap");
    });
    simulation
}
