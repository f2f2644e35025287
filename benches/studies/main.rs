//! How many simulated calibrations a study runs a second, on one thread and on more.
//!
//! `cargo run --release -p gravcal-benches --bin studies`
//!
//! A trial is simulated, calibrated by the steps and jointly, and written. Runs on one thread and on more take turns, as machines are
//! not always equally fast.

use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Parser;
use cpu_time::ProcessTime;
use gravcal_benches::program::ended;
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::batch::{self, Helpers, Manifest, NamedSolver, Shard, StudyFolder};
use gravcal_study::plan::Study;

/// The program's own, of which studies make much use.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Times a study on one thread and on more.
#[derive(Parser)]
struct Arguments {
    /// The study.
    #[arg(value_name = "STUDY", default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/study.toml"))]
    study: String,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2], value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Vec<u16>,
    /// How often each runs.
    #[arg(long, default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let study = Study::read(Path::new(&arguments.study)).map_err(|error| error.to_string())?;
    let solvers: Vec<NamedSolver> = vec![("levenberg-marquardt".into(), Box::<LevenbergMarquardt>::default())];
    batch::check(&study, &solvers).map_err(|error| error.to_string())?;
    println!("threads   trials/s   a thread, of the first   processor ms/trial");
    for _ in 0..arguments.runs {
        let mut first = None;
        for threads in &arguments.threads {
            let (rate, processor) = timed(&study, &solvers, usize::from(*threads))?;
            let of_thread = rate / f64::from(*threads);
            let share = 100.0 * of_thread / *first.get_or_insert(of_thread);
            println!("{threads:7} {rate:10.0} {share:23.0} % {:20.2}", 1e3 * processor);
        }
    }
    Ok(())
}

/// Trials a second, and seconds of processor time for each.
fn timed(study: &Study, solvers: &[NamedSolver], threads: usize) -> Result<(f64, f64), String> {
    let temporary = tempfile::tempdir().map_err(|error| error.to_string())?;
    let names: Vec<String> = solvers.iter().map(|(name, _)| name.clone()).collect();
    let folder = StudyFolder::begin(&temporary.path().join("results"), Manifest::new(study, &names))
        .map_err(|error| error.to_string())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| error.to_string())?;
    let (began, processor) = (Instant::now(), ProcessTime::now());
    let clock = || began.elapsed().as_secs_f64();
    let helpers = Helpers { solvers, clock: &clock, progress: &|_, _| {}, stop: &AtomicBool::new(false) };
    let whole = Shard { number: 1, of: 1 };
    pool.install(|| batch::run(study, &folder, whole, &helpers)).map_err(|error| error.to_string())?;
    let (wall, processor) = (clock(), processor.elapsed().as_secs_f64());
    let trials = study.trials as f64 * study.points.len() as f64;
    Ok((trials / wall, processor / trials))
}
