//! Recordings of arms as they are, with friction at rest and what else no session knows of, calibrated and held against the truth.
//!
//! `cargo run --release -p gravcal-benches --bin real_arms -- --line still --friction-nm 0.1 --sessions 200 --seed 1`
//!
//! A recording of an arm that stands is 25 bare and 25 loaded poses, dwells of 1.5 s at 200 Hz, noise of 0.03 N·m a sample rounded to 0.005. A line prints how
//! many sessions ended with which exit code, how often 95 % intervals hold the truth (all but biases, and biases), the root mean square
//! of errors in standard deviations, the same of sessions that ended with exit code 0, the parameter whose interval holds the truth least
//! often, and how wide intervals are. With `--twice` each arm is recorded twice, and both calibrations are compared.

mod arms;
mod judge;
mod line;
mod spoilt;
mod tally;
mod twice;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use gravcal_benches::program::{ended, progress};
use rayon::ThreadPoolBuilder;

use judge::judge;
use line::{Line, Setting, Source};
use twice::compare_two;

/// The program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Simulates recordings of arms with friction at rest, calibrates them, and prints a line for each kind and size.
#[derive(Parser)]
struct Arguments {
    /// What the recordings are like; may be given several times.
    #[arg(long = "line", value_enum, default_values = ["still"])]
    lines: Vec<Line>,
    /// Coulomb friction of every joint, N·m; may be given several times.
    #[arg(long, default_values = ["0.1"], value_parser = not_negative)]
    friction_nm: Vec<f64>,
    /// Where poses come from.
    #[arg(long = "poses", value_enum, default_value_t = Source::Standstills)]
    from: Source,
    /// Speed of slow sweeps, degrees a second.
    #[arg(long, default_value_t = 4.0)]
    speed_deg_per_s: f64,
    /// How many sessions a line.
    #[arg(long, default_value_t = 200)]
    sessions: u64,
    /// Number of the first one.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Seed of the random numbers; session k of a seed is the same whatever else is asked.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of threads [default: one for each processor].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// A word of what a session should name; counts sessions whose report has it.
    #[arg(long, value_name = "TEXT", conflicts_with = "twice")]
    named: Option<String>,
    /// Sessions say that readings have no errors beyond their noise and that joints do not bend: how wide intervals of a right model are.
    #[arg(long)]
    exact: bool,
    /// Records each arm twice, compares both calibrations as `gravcal compare` does, and counts pairs in which a sensor is named.
    #[arg(long)]
    twice: bool,
    /// A sensor of the second recording has moved by so many of its standard deviations in the first: each joint's in turn, and of each its torque gain, torque bias and position offset.
    #[arg(long, value_name = "STDS", requires = "twice", value_parser = not_negative)]
    moved_stds: Option<f64>,
    /// Folder that keeps each session with its truth, for `gravcal calibrate`.
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn not_negative(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err("expected zero or more".to_owned()) }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let of_motion = [Line::Still, Line::Elastic, Line::Harmonics];
    if arguments.from == Source::Motion && arguments.lines.iter().any(|line| !of_motion.contains(line)) {
        return Err(
            "--poses motion goes with the lines still, elastic and harmonics: the others are of arms that stand".into(),
        );
    }
    if arguments.from != Source::Standstills && arguments.lines.contains(&Line::LabelSome) {
        return Err(
            "the line label-some goes with --poses standstills: it says from when to when the load is there".into()
        );
    }
    let Arguments { seed, twice, moved_stds, .. } = *arguments;
    println!("{}", if twice { twice::heading() } else { tally::heading() });
    for line in &arguments.lines {
        for friction in &arguments.friction_nm {
            let from = (arguments.from, arguments.speed_deg_per_s);
            let setting = Setting::of(*line, *friction, from, arguments.exact);
            let row = match twice {
                true => {
                    let pair = |number, folder: &Path| compare_two(&setting, (seed, number), folder, moved_stds);
                    twice::row(*line, *friction, &sessions(arguments, &setting, pair)?)
                }
                false => {
                    let named = arguments.named.as_deref();
                    let session = |number, folder: &Path| judge(&setting, seed, number, folder, named);
                    tally::row(*line, *friction, &sessions(arguments, &setting, session)?)
                }
            };
            println!("{row}");
        }
    }
    Ok(())
}

/// Judges the sessions of one line on several threads. Each has a pool of its own with one thread, in which calibrations run. `judge`: one session, by its
/// number and the folder for its files.
fn sessions<J: Send>(
    arguments: &Arguments,
    setting: &Setting,
    judge: impl Fn(u64, &Path) -> Result<J, String> + Sync,
) -> Result<Vec<J>, String> {
    let threads =
        arguments.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let (next, end) = (AtomicU64::new(arguments.first), arguments.first + arguments.sessions);
    let bar = progress(arguments.sessions, "sessions");
    let some = || -> Result<Vec<(u64, J)>, String> {
        let alone = ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| error.to_string())?;
        let mut judged = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= end {
                return Ok(judged);
            }
            let temporary = tempfile::tempdir().map_err(|error| error.to_string())?;
            let folder =
                arguments.keep.as_deref().unwrap_or(temporary.path()).join(format!("{}-{number}", setting.name()));
            judged.push((number, alone.install(|| judge(number, &folder))?));
            bar.inc(1);
        }
    };
    let parts: Vec<Result<_, String>> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(some)).collect();
        running.into_iter().map(|one| one.join().unwrap_or_else(|_| Err("a thread panicked".into()))).collect()
    });
    bar.finish_and_clear();
    let mut judged: Vec<(u64, J)> = parts.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    judged.sort_by_key(|(number, _)| *number);
    Ok(judged.into_iter().map(|(_, judged)| judged).collect())
}
