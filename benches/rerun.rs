//! How fast a calibration becomes a recording for Rerun.
//!
//! `cargo run --release -p gravcal-benches --bin rerun`
//!
//! The joint estimate of seven joints (see `benches/README.md`), everything that `gravcal calibrate --rerun` shows of it, and the file written.
//! Counted are the numbers of the series alone (readings, predictions, residuals), not the links' poses.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gravcal_benches::program::ended;
use gravcal_benches::seven_joints::SevenJoints;
use gravcal_calibration::result::EstimatorResult;
use gravcal_calibration::{EstimatorName, Session, Workbench, calibrate};
use gravcal_recording::write_atomically;
use gravcal_rerun::CalibrationRecording;
use gravcal_solvers::LevenbergMarquardt;

/// Times the recording of a calibration for Rerun.
#[derive(Parser)]
struct Arguments {
    /// Number of poses.
    #[arg(long, default_value = "20000", value_parser = clap::value_parser!(u32).range(30..))]
    poses: u32,
    /// How often it is recorded.
    #[arg(long, default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let session = SevenJoints::simulate(arguments.poses as usize)?.session;
    let solver = LevenbergMarquardt::default();
    let results = calibrate(&session, &[EstimatorName::Joint], &Workbench::new(&solver, &|_| {}));
    let numbers = numbers(&results);
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    println!("{} poses, {numbers} numbers in series", session.poses.len());
    println!("   s recording    s with file    MiB    numbers/s");
    for _ in 0..arguments.runs {
        record(&session, &results, numbers, &folder.path().join("calibration.rrd"))?;
    }
    Ok(())
}

/// How many readings, predictions and residuals are shown.
fn numbers(results: &[EstimatorResult]) -> usize {
    let fits = results.iter().filter_map(|result| result.fit.as_ref());
    // Each reading once, and beside it what nominal sensors and the estimate say, with two residuals of either.
    fits.map(|fit| 7 * fit.residuals.len()).sum()
}

fn record(session: &Session, results: &[EstimatorResult], numbers: usize, path: &Path) -> Result<(), String> {
    let start = Instant::now();
    let bytes =
        CalibrationRecording { id: "bench", session, results, table: "" }.to_rrd().map_err(|e| e.to_string())?;
    let recorded = start.elapsed().as_secs_f64();
    write_atomically(path, &bytes).map_err(|e| e.to_string())?;
    let written = start.elapsed().as_secs_f64();
    let mebibytes = bytes.len() as f64 / (1 << 20) as f64;
    println!("{recorded:14.3} {written:14.3} {mebibytes:6.1} {:12.0}", numbers as f64 / written);
    Ok(())
}
