//! Populations of simulated sessions with known truth, judged by a model, a rank and bounds that share no code with what is judged.
//!
//! `cargo run --release -p gravcal-benches --bin populations -- --kind bare --sessions 1000 --seed 1`
//!
//! Wrong is: a session that is refused or has no answer; a value told though exact rank at the truth says that the readings do not
//! determine it; a value more than 6 of its standard deviations from the truth; a standard deviation below half the independent
//! Cramér-Rao bound; gravity upside down.

mod run;
mod starts;
mod tally;

use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::progress;
use gravcal_solvers::SolverName;

use gravcal_benches::population::arms::Arms;
use gravcal_benches::population::draw::Kind;
use run::Population;
use tally::{Trial, is_wrong, table};

/// The program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Simulates sessions, calibrates them, and judges the joint estimate independently. Exit code 1 if any is wrong.
#[derive(Parser)]
struct Arguments {
    /// What kind of sessions.
    #[arg(long, value_enum)]
    kind: Kind,
    /// How many.
    #[arg(long, default_value_t = 100)]
    sessions: u64,
    /// Number of the first one.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// This number alone.
    #[arg(long, conflicts_with_all = ["sessions", "first"])]
    only: Option<u64>,
    /// Seed of the random numbers; session k of a seed is the same whatever else is asked.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of threads [default: one for each processor].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Folder that keeps each session with its truth, for `gravcal calibrate`.
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    /// The method that solves each session.
    #[arg(long, value_parser = named_solver, default_value = SolverName::LevenbergMarquardt.as_str())]
    solver: SolverName,
    /// Solve each session by all methods: none may end without an answer, and all must tell the same parameters.
    #[arg(long)]
    methods: bool,
    /// Hold each answer's likelihood against those that so many random starts lead to.
    #[arg(long, value_name = "N", default_value_t = 0)]
    starts: u64,
    /// Which arms: a number's arm depends on this, too.
    #[arg(long, value_enum, default_value_t = Arms::All)]
    arms: Arms,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

fn named_solver(name: &str) -> Result<SolverName, String> {
    SolverName::ALL.into_iter().find(|solver| solver.as_str() == name).ok_or_else(|| {
        let names: Vec<&str> = SolverName::ALL.iter().map(|solver| solver.as_str()).collect();
        format!("no such method; there are {}", names.join(", "))
    })
}

/// Whether nothing is wrong.
fn run(arguments: &Arguments) -> Result<bool, String> {
    let Arguments { kind, seed, threads, keep, .. } = arguments;
    let population = Population {
        kind: *kind,
        seed: *seed,
        robots: arguments.arms.robots()?,
        keep: keep.clone(),
        methods: if arguments.methods { SolverName::ALL.into() } else { vec![arguments.solver] },
        starts: arguments.starts,
    };
    let numbers = numbers(arguments);
    let bar = progress(numbers.end - numbers.start, "sessions");
    let threads = threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let trials = population.run(numbers.clone(), threads, &|trial| {
        if is_wrong(trial) {
            bar.suspend(|| println!("{}", in_words(trial)));
        }
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    let Range { start, end } = numbers;
    println!(
        "\n{}",
        table(&format!("{}, seed {seed}, sessions {start} to {}", kind.as_str(), end.saturating_sub(1)), &trials)
    );
    Ok(!trials.iter().any(is_wrong))
}

fn numbers(arguments: &Arguments) -> Range<u64> {
    match arguments.only {
        Some(number) => number..number + 1,
        None => arguments.first..arguments.first + arguments.sessions,
    }
}

fn in_words(trial: &Trial) -> String {
    let words: Vec<String> = trial.judged.wrong.iter().map(|(cause, words)| format!("{cause}: {words}")).collect();
    let more = words.len().saturating_sub(4);
    let shown = words.into_iter().take(4).collect::<Vec<_>>().join("; ");
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    format!("{}: {shown}{more}", trial.name)
}
