//! `gravcal inspect`: what is in a recording.

use std::path::PathBuf;

use clap::Args;
use gravcal_recording::inspect;

use crate::exit::Exit;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;

/// Tell what is in a recording
///
/// Topics, columns, rates, gaps, ranges and what they perhaps mean; sensors that are stuck or at an end of their range, rows that stand
/// twice, time that runs backwards, and what of the file is damaged. It reads CSV, MCAP (sensor_msgs/JointState in CDR or JSON), folders
/// of rosbag2 and Parquet.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The recording
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Print JSON instead of text
    #[arg(long)]
    json: bool,

    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal inspect recording.mcap
  gravcal inspect bag/ --json

Exit codes:
  0  the recording was read
  2  bad input or usage";

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    let progress = Progress::new(arguments.quiet);
    let mut watch =
        |share: f64| progress.stage(&format!("reading {}: {:.0} %", arguments.file.display(), 100.0 * share));
    let inspection = inspect(&arguments.file, &mut watch).map_err(|error| Failure::bad_input(&error))?;
    drop(progress);
    let text = match arguments.json {
        true => format!("{}\n", serde_json::to_string_pretty(&inspection).map_err(|error| Failure::bad_input(&error))?),
        false => inspection.to_string(),
    };
    terminal::print(&text)?;
    Ok(Exit::Determined)
}
