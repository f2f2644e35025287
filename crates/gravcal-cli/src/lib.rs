//! The program `gravcal`: arguments, choosing by name, progress, exit codes. What it does is in the libraries.
//!
//! Only here is anything printed, and the clock read. It is a library so that others can carry the program along, with more in its
//! [`Registry`] if they like, such as sensor models; names, provenance and failures are for those who do from elsewhere what it does.
//!
//! ```no_run
//! use std::process::ExitCode;
//!
//! use gravcal_robot_model::Registry;
//!
//! fn main() -> ExitCode {
//!     gravcal_cli::main(std::env::args_os(), &Registry::standard()).into()
//! }
//! ```

mod apply;
mod attached;
mod calibrate;
mod check;
mod columns;
mod compare;
mod exit;
mod export;
mod failure;
mod inspect;
mod interrupt;
mod names;
mod progress;
mod rerun;
mod shell;
mod simulate;
mod stopwatch;
mod study;
mod targets;
mod terminal;

use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use gravcal_robot_model::Registry;

pub use calibrate::provenance;
pub use exit::Exit;
pub use failure::Failure;
pub use names::{Choice, ChosenSolver};
pub use stopwatch::{Phase, Stopwatch};

/// Calibrates a robot's joint torque and position sensors, and gravity in its base frame, from static poses, slow sweeps or motion.
#[derive(Debug, Parser)]
#[command(name = "gravcal", version, after_help = AFTER_HELP, after_long_help = AFTER_LONG_HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Calibrate(calibrate::Arguments),
    Check(check::Arguments),
    Simulate(simulate::Arguments),
    Inspect(inspect::Arguments),
    Apply(apply::Arguments),
    Export(export::Arguments),
    Compare(compare::Arguments),
    Study(study::Arguments),
    Completions(shell::CompletionsArguments),
    Manual(shell::ManualArguments),
}

const AFTER_HELP: &str = "\
Start with: gravcal calibrate experiments/sarcos-shoulder/session.toml
`gravcal --help` tells what a session is, and what the exit codes mean.";

const AFTER_LONG_HELP: &str = "\
What a session is:
  A file such as session.toml that says all that is known beforehand: the robot,
  how strong gravity is and roughly where it points, known loads, units and
  nominal values of the sensors, and which tables of static poses belong to it.
  A static pose is one row of a CSV file: the joints' position and torque
  readings while the robot stands still. Or the tables are recordings (MCAP, ROS
  bags, Parquet, CSV) in which gravcal finds standstills, slow sweeps, or uses
  the whole motion. Paths in a session are relative to it.

From a robot to its calibration:
  1. Record a few poses.
     gravcal inspect recording.csv --robot robot.toml --session session.toml
     tells what is in a recording, and draws up a session of it to complete.
  2. gravcal check session.toml
     tells what these poses can and cannot determine, and what would cure it.
  3. Record the rest.
  4. gravcal calibrate session.toml
     finds gains, offsets and gravity, with their uncertainty.
  5. gravcal apply calibration.json recording.mcap calibrated.mcap
     gives the same recording with true torques and angles.
  6. gravcal export calibration.json --to ros2
     gives the numbers to a driver; others to C, Python, URDF, tables.
  7. gravcal compare last-week/calibration.json calibration.json
     tells which sensor has moved since.

Conventions of what comes out:
  reading = torque_gain * torque + torque_bias
  coordinate = position_gain * reading + position_offset

Exit codes:
  0  everything that is asked for is determined
  1  what was found could not be printed or shown in full; results that are
     written to files are complete
  2  bad input or usage; nothing is written
  3  solved, but something that is asked for is undetermined or cannot be
     relied on; of `gravcal compare`: a sensor moved
  4  no answer to rely on: no convergence, stopped by Ctrl-C, or readings that
     contradict the model";

/// Runs the program with these arguments, its own name first, and gives its exit code. What it says goes to the standard output and error;
/// `registry` says what sessions and simulations may name.
pub fn main(arguments: impl IntoIterator<Item = OsString>, registry: &Registry) -> u8 {
    let matches = with_names(Arguments::command(), registry).try_get_matches_from(arguments);
    let arguments = match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => arguments,
        // Help, and the version, are told by an error, too.
        Err(reported) => {
            let _: std::io::Result<()> = reported.print();
            return if reported.use_stderr() { Exit::BadInput.code() } else { Exit::Determined.code() };
        }
    };
    match run_command(&arguments.command, registry) {
        Ok(exit) => exit.code(),
        Err(failure) => {
            terminal::complain(&failure.to_string());
            failure.exit.code()
        }
    }
}

fn run_command(command: &Command, registry: &Registry) -> Result<Exit, Failure> {
    match command {
        Command::Calibrate(arguments) => calibrate::run(arguments, registry),
        Command::Check(arguments) => check::run(arguments, registry),
        Command::Simulate(arguments) => simulate::run(arguments, registry),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Apply(arguments) => apply::run(arguments, registry),
        Command::Export(arguments) => export::run(arguments, registry),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Study(arguments) => study::run(arguments, registry),
        Command::Completions(arguments) => shell::complete(arguments, with_names(Arguments::command(), registry)),
        Command::Manual(arguments) => shell::write_manual(arguments, with_names(Arguments::command(), registry)),
    }
}

/// What the registry knows, behind the long help of the program.
fn with_names(command: clap::Command, registry: &Registry) -> clap::Command {
    let sensors: Vec<_> = registry.sensor_models().map(|model| (model.name(), model.help())).collect();
    let residuals: Vec<_> = registry.residual_models().map(|model| (model.name(), model.help())).collect();
    let solvers: Vec<_> = registry.solvers().map(|solver| (solver.name(), solver.help())).collect();
    let help = [
        AFTER_LONG_HELP.to_owned(),
        listed("Sensor models that sessions may name (sensor_models = [{ kind = \"...\" }] in [[joint]]):", &sensors),
        listed("Residuals that sessions may name ([[residual]] kind = \"...\"):", &residuals),
        listed("Methods that this program adds (solver = \"...\" in a session, --solver):", &solvers),
    ];
    let solver = |argument: clap::Arg| argument.value_parser(names::solver_parser(registry));
    command.mut_subcommand("calibrate", |calibrate| calibrate.mut_arg("solver", solver)).after_long_help(help.concat())
}

/// Names with what they mean under a heading; nothing where there are none.
fn listed(heading: &str, names: &[(&str, &str)]) -> String {
    let width = names.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines: String = names.iter().map(|(name, help)| format!("\n  {name:width$}  {help}")).collect();
    if names.is_empty() { String::new() } else { format!("\n\n{heading}{lines}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn an_output_has_one_name_everywhere() {
        fn shorts(command: &clap::Command) -> Vec<Option<char>> {
            let own = command.get_arguments().filter(|argument| argument.get_long() == Some("output"));
            own.map(clap::Arg::get_short).chain(command.get_subcommands().flat_map(shorts)).collect()
        }
        let shorts = shorts(&Arguments::command());
        assert_eq!(shorts, vec![Some('o'); 5], "calibrate, simulate, export, study run and submit");
    }

    #[test]
    fn the_help_lists_the_sensor_models() {
        let help = with_names(Arguments::command(), &Registry::standard()).render_long_help().to_string();
        for model in Registry::standard().sensor_models() {
            assert!(help.contains(&format!("\n  {} ", model.name())) && help.contains(model.help()), "{help}");
        }
    }

    #[test]
    fn usage_errors_exit_with_the_code_of_bad_input() {
        for line in [&["gravcal", "calibrate"][..], &["gravcal", "fly"], &["gravcal", "check", "a", "--colour"]] {
            let error = Arguments::try_parse_from(line).unwrap_err();
            assert_eq!(error.exit_code(), i32::from(Exit::BadInput.code()), "{line:?}");
        }
    }

    #[test]
    fn help_tells_every_exit_code() {
        let help = Arguments::command().render_long_help().to_string();
        for exit in Exit::ALL {
            assert!(help.contains(&format!("\n  {}  ", exit.code())), "{exit:?}");
        }
    }
}
