//! The KUKA LWR4+ in motion, by gravcal and by FIGAROH: what each leaves of the torques that it fitted, how well each predicts others, and the time from
//! files to results.
//!
//! `cargo run --release -p gravcal-benches --bin figaroh -- ../shared/data/kuka_lwr4`
//!
//! FIGAROH runs where `python3` has it (`benches/peers/figaroh`). Its errors are those of all filtered rows, ours those of all windows in which a joint does not
//! rest, both at a cut-off of 2 Hz. Times are processor times of one thread.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use cpu_time::ProcessTime;
use gravcal_benches::program::ended;
use gravcal_calibration::result::JointFit;
use gravcal_calibration::{SolveEnvironment, calibrate, calibrate_briefly};
use gravcal_robot_model::{EstimatorName, Session};
use gravcal_session::read_session;
use gravcal_solvers::LevenbergMarquardt;
use serde::Deserialize;

const PEER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/figaroh/identify.py");
/// Recordings that are fitted, and the one that is predicted.
const TASKS: [(&[usize], usize); 2] = [(&[1, 3], 2), (&[1], 3)];

/// Shows errors and times as tables in Markdown.
#[derive(Parser)]
struct Arguments {
    /// The folder with recordings and URDF.
    folder: PathBuf,
    /// Leave FIGAROH out.
    #[arg(long)]
    without_peers: bool,
}

/// What a program makes of a task, N·m by joint, and the time that it takes, s.
#[derive(Deserialize)]
struct Outcome {
    seconds: f64,
    fitted: Vec<f64>,
    predicted: Vec<f64>,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| error.to_string())?;
    for (fitted, other) in TASKS {
        let names: Vec<String> = fitted.iter().map(ToString::to_string).collect();
        println!("fitted: {}; predicted: {other}\n", names.join(" and "));
        println!("| rms, N·m | 1 | 2 | 3 | 4 | 5 | 6 | 7 | mean | s |\n|---|---|---|---|---|---|---|---|---|---|");
        let (own, briefly) = pool.install(|| ours(&arguments.folder, fitted, other))?;
        show("gravcal", &own);
        if !arguments.without_peers {
            match theirs(&arguments.folder, fitted, other) {
                Ok(outcome) => show("FIGAROH", &outcome),
                Err(message) => println!("FIGAROH is left out: {message}\n  to install it: pip install figaroh"),
            }
        }
        println!("\ngravcal without tests of residuals, smaller models and held-out windows: {briefly:.2} s\n");
    }
    Ok(())
}

fn show(name: &str, Outcome { seconds, fitted, predicted }: &Outcome) {
    for (what, errors, time) in [("fitted", fitted, format!("{seconds:.2}")), ("predicted", predicted, String::new())] {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let cells: Vec<String> = errors.iter().map(|error| format!("{error:.3}")).collect();
        println!("| {name}, {what} | {} | {mean:.3} | {time} |", cells.join(" | "));
    }
}

fn recording(folder: &Path, number: usize) -> Result<PathBuf, String> {
    fs::canonicalize(folder.join(format!("recording_{number}.csv"))).map_err(|error| error.to_string())
}

/// What gravcal makes of it, and the time in which batches have sensors and gravity alone.
fn ours(folder: &Path, fitted: &[usize], other: usize) -> Result<(Outcome, f64), String> {
    let written = tempfile::tempdir().map_err(|error| error.to_string())?;
    let path = written.path().join("session.toml");
    fs::write(&path, session(folder, fitted, other)?).map_err(|error| error.to_string())?;
    let (solver, estimators) = (LevenbergMarquardt::default(), [EstimatorName::Joint]);
    let environment = SolveEnvironment::new(&solver, &|_: &str| {});
    let read = || -> Result<Session, String> { read_session(&path).map_err(|error| error.to_string()) };
    let start = ProcessTime::now();
    let results = calibrate(&read()?, &estimators, &environment);
    let seconds = start.elapsed().as_secs_f64();
    let start = ProcessTime::now();
    calibrate_briefly(&read()?, &estimators, &environment).remove(0).map_err(|error| error.to_string())?;
    let briefly = start.elapsed().as_secs_f64();
    let fit = results.iter().find_map(|result| result.fit.as_ref()).ok_or("there is no fit")?;
    let held_out = fit.held_out.as_ref().ok_or("nothing was predicted")?;
    let rms = |joints: &[JointFit]| joints.iter().map(|joint| joint.rms).collect();
    Ok((Outcome { seconds, fitted: rms(&fit.joints), predicted: rms(&held_out.joints) }, briefly))
}

/// As that of `experiments/kuka-lwr4-in-motion`.
fn session(folder: &Path, fitted: &[usize], other: usize) -> Result<String, String> {
    let columns = |start: &str, end: &str| {
        let all: Vec<String> = (1..=7).map(|joint| format!("\"{start}{joint}_{end}\"")).collect();
        all.join(", ")
    };
    let urdf = fs::canonicalize(folder.join("kuka_lwr4.urdf")).map_err(|error| error.to_string())?;
    let table = |of: &str, number: usize| -> Result<String, String> {
        Ok(format!("[[{of}]]\nfile = {:?}\n", recording(folder, number)?))
    };
    let fitted = fitted.iter().map(|number| table("poses", *number)).collect::<Result<String, String>>()?;
    Ok(format!(
        "robot = {{ urdf = {urdf:?}, base = \"lwr_base_link\", tip = \"lwr_7_link\" }}\n\
         [gravity]\nmagnitude_m_per_s2 = 9.81\nhemisphere = [0.0, 0.0, -1.0]\n[inertia]\nlinks = \"unknown\"\n[readings]\n\
         time = {{ column = \"time_s\", unit = \"s\" }}\nposition = {{ columns = [{}], unit = \"rad\" }}\n\
         torque = {{ columns = [{}], unit = \"N·m\" }}\nmotion = {{ window_s = 0.8 }}\n[joints]\ntorque_sign = \"normal\"\n\
         torque_gain = {{ fixed = 1.0, unit = \"N·m/(N·m)\" }}\nposition_gain = {{ fixed = 1.0, unit = \"rad/rad\" }}\n\
         position_offset = {{ fixed = 0.0, unit = \"rad\" }}\n\
         sensor_models = [{{ kind = \"coulomb-friction\" }}, {{ kind = \"viscous-friction\" }}]\n\
         [deflection]\ncompliance_std_rad_per_newton_metre = 0\n{fitted}{}",
        columns("q", "rad"),
        columns("tau", "Nm"),
        table("validation", other)?,
    ))
}

fn theirs(folder: &Path, fitted: &[usize], other: usize) -> Result<Outcome, String> {
    let mut command = Command::new("python3");
    command.arg(PEER).arg(folder.join("kuka_lwr4.urdf")).arg("2").arg(recording(folder, other)?);
    for number in fitted {
        command.arg(recording(folder, *number)?);
    }
    let output = command.env("OPENBLAS_NUM_THREADS", "1").output().map_err(|error| error.to_string())?;
    let printed = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&printed).map_err(|_| String::from_utf8_lossy(&output.stderr).trim().to_owned())
}
