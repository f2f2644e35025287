//! How fast a calibration becomes something to look at: a recording for Rerun, and the page.
//!
//! `cargo run --release -p gravcal-benches --bin shown`
//!
//! The joint estimate of seven joints (see `benches/README.md`), everything that `gravcal calibrate --rerun` shows of it with the file
//! written, and `report.html` likewise. Counted are the numbers of the recording's series alone (readings, predictions, residuals), not
//! the links' poses.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gravcal_benches::program::ended;
use gravcal_benches::seven_joints::SevenJoints;
use gravcal_calibration::result::EstimatorResult;
use gravcal_calibration::{SolveEnvironment, calibrate};
use gravcal_recording::write_atomically;
use gravcal_report::{CalibrationPage, Options, Provenance};
use gravcal_rerun::CalibrationRecording;
use gravcal_robot_model::{EstimatorName, Session};
use gravcal_solvers::LevenbergMarquardt;

/// Times the recording of a calibration for Rerun, and its page.
#[derive(Parser)]
struct Arguments {
    /// Number of poses.
    #[arg(long, default_value = "20000", value_parser = clap::value_parser!(u32).range(30..))]
    poses: u32,
    /// How often both are made.
    #[arg(long, default_value = "5", value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let session = SevenJoints::simulate(arguments.poses as usize)?.session;
    let solver = LevenbergMarquardt::default();
    let results = calibrate(&session, &[EstimatorName::Joint], &SolveEnvironment::new(&solver, &|_| {}));
    let numbers = numbers(&results);
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    println!("{} poses, {numbers} numbers in series", session.poses.len());
    println!("recording: s    MiB   numbers/s    page: s    MiB");
    for _ in 0..arguments.runs {
        let [recorded, size] = timed(&folder.path().join("calibration.rrd"), || recording(&session, &results))?;
        let [drawn, page_size] = timed(&folder.path().join("report.html"), || page(&session, &results))?;
        println!("{recorded:12.3} {size:6.1} {:11.0} {drawn:10.3} {page_size:6.1}", numbers as f64 / recorded);
    }
    Ok(())
}

/// How many readings, predictions and residuals are shown.
fn numbers(results: &[EstimatorResult]) -> usize {
    let fits = results.iter().filter_map(|result| result.fit.as_ref());
    // Each reading once, and beside it what nominal sensors and the estimate say, with two residuals of either.
    fits.map(|fit| 7 * fit.residuals.len()).sum()
}

/// Seconds for making a file and writing it, and its MiB.
fn timed(path: &Path, make: impl FnOnce() -> Result<Vec<u8>, String>) -> Result<[f64; 2], String> {
    let start = Instant::now();
    let bytes = make()?;
    write_atomically(path, &bytes).map_err(|e| e.to_string())?;
    Ok([start.elapsed().as_secs_f64(), bytes.len() as f64 / (1 << 20) as f64])
}

fn recording(session: &Session, results: &[EstimatorResult]) -> Result<Vec<u8>, String> {
    CalibrationRecording { id: "bench", session, results, table: "" }.to_rrd().map_err(|e| e.to_string())
}

fn page(session: &Session, results: &[EstimatorResult]) -> Result<Vec<u8>, String> {
    let options = Options {
        estimators: vec!["joint".into()],
        solver: "levenberg-marquardt".into(),
        solver_options: Default::default(),
    };
    let provenance = Provenance::new(Vec::new(), options);
    let page = CalibrationPage { session, results, provenance: &provenance };
    Ok(page.to_html().map_err(|e| e.to_string())?.into_bytes())
}
