//! `gravcal simulate`: writes a session with known truth.

use std::path::{Path, PathBuf};

use clap::Args;
use gravcal_robot_model::Registry;
use gravcal_session::simulation::{Simulation, session_files, write_session};

use crate::exit::Exit;
use crate::failure::Failure;
use crate::{targets, terminal};

/// Write a session of simulated poses with known truth
///
/// A simulation file says which robot, which poses, which true values, and what disturbs the readings. The same
/// file and trial give the same bytes.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The simulation, such as experiments/sarcos-shoulder/simulation.toml
    #[arg(value_name = "SIMULATION")]
    simulation: PathBuf,

    /// Folder for the session [default: that of the simulation]
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Number of the draw of everything random
    #[arg(long, value_name = "K", default_value_t = 0)]
    trial: u64,

    /// Replace files in the output folder
    #[arg(long)]
    overwrite: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal simulate simulation.toml
  gravcal simulate simulation.toml --trial 7 --output /tmp/trial-7
  gravcal calibrate /tmp/trial-7/session.toml

Exit codes:
  0  the session is written
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage; nothing is written";

/// Runs the command.
pub fn run(arguments: &Arguments, registry: &Registry) -> Result<Exit, Failure> {
    let simulation =
        Simulation::read_with(&arguments.simulation, registry).map_err(|error| Failure::bad_input(&error))?;
    let beside = || folder_of(&arguments.simulation);
    let folder = arguments.output.clone().unwrap_or_else(beside);
    targets::check(simulation.template.input_paths(), &session_files(&simulation, &folder))?;
    let files = write_session(&simulation, arguments.trial, &folder, arguments.overwrite)
        .map_err(|error| Failure::bad_input(&error))?;
    let reported: String = files.iter().map(|file| format!("{}\n", file.display())).collect();
    terminal::print(&reported)?;
    Ok(Exit::Determined)
}

fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_is_written_beside_its_simulation() {
        assert_eq!(folder_of(Path::new("a/simulation.toml")), Path::new("a"));
        assert_eq!(folder_of(Path::new("simulation.toml")), Path::new("."));
    }
}
