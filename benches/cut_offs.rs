//! How well an arm that was identified in motion predicts the torques of another motion, by the cut-off of its windows.
//!
//! `cargo run --release -p gravcal-benches --bin cut_offs`
//!
//! Seven joints with friction are recorded for 20 s at 200 Hz with noise of 0.1 N·m, identified, and predict a second recording of another motion, which
//! has no noise: its residuals are the errors of the prediction.

use std::fs;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use gravcal_benches::program::{ended, progress};
use gravcal_calibration::{SolveEnvironment, calibrate};
use gravcal_robot_model::EstimatorName;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

/// Hz; a window of cut-off f is 1.6/f long.
const CUT_OFFS: [f64; 5] = [1.5, 3.0, 6.0, 12.0, 25.0];
/// Noise of the encoders, rad.
const POSITION_NOISE: [f64; 2] = [0.0, 3e-4];
/// What torques and positions of the predicted recording are read with: their last digits.
const EXACT: f64 = 1e-9;

/// Simulates, identifies and predicts; a table in Markdown.
#[derive(Parser)]
struct Arguments {
    /// How many recordings the errors are averaged over.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    draws: u64,
}

fn main() -> ExitCode {
    ended(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    println!("error of predicted torques, mN·m, mean over the joints of the rms; {} recordings", arguments.draws);
    println!("| encoder noise, mrad | {} |", CUT_OFFS.map(|cut_off| format!("{cut_off} Hz")).join(" | "));
    println!("|---|{}", "---|".repeat(CUT_OFFS.len()));
    let bar = progress(arguments.draws * (CUT_OFFS.len() * POSITION_NOISE.len()) as u64, "calibrations");
    for noise in POSITION_NOISE {
        let mut squares = [0.0; CUT_OFFS.len()];
        for draw in 0..arguments.draws {
            let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
            let path = folder.path();
            fs::write(path.join("robot.toml"), robot()).map_err(|error| error.to_string())?;
            record(path, "fitted.csv", Recorded { seed: draw + 1, torque_std: 0.1, position_std: noise, motion: 1 })?;
            record(path, "other.csv", Recorded { seed: 1, torque_std: EXACT, position_std: 0.0, motion: 2 })?;
            for (square, cut_off) in squares.iter_mut().zip(CUT_OFFS) {
                *square += predicted(path, cut_off)?.powi(2);
                bar.inc(1);
            }
        }
        let errors = squares.map(|sum| format!("{:.2}", 1e3 * (sum / arguments.draws as f64).sqrt()));
        bar.suspend(|| println!("| {} | {} |", 1e3 * noise, errors.join(" | ")));
    }
    bar.finish_and_clear();
    Ok(())
}

/// How a recording is made.
struct Recorded {
    seed: u64,
    /// N·m.
    torque_std: f64,
    /// rad.
    position_std: f64,
    /// Seed of the motion.
    motion: u64,
}

/// Writes a recording of 20 s, in two stretches.
fn record(folder: &Path, file: &str, recorded: Recorded) -> Result<(), String> {
    let Recorded { seed, torque_std, position_std, motion } = recorded;
    let position_std = if position_std > 0.0 { format!("std = {position_std:e}") } else { String::new() };
    let joint = |number: usize| {
        format!(
            "[[joint]]\nname = \"joint{number}\"\nsensor_models = [\n\
             \x20   {{ kind = \"coulomb-friction\", parameters = {{ coulomb_friction = {{ value = {}, unit = \"N·m\" }} }} }},\n\
             \x20   {{ kind = \"viscous-friction\", parameters = {{ viscous_friction = {{ value = {}, unit = \"N·m/(rad/s)\" }} }} }},\n]\n",
            0.8 - 0.1 * number as f64,
            0.5 - 0.05 * number as f64,
        )
    };
    let text = format!(
        "robot = \"robot.toml\"\nseed = {seed}\ngravity = {{ direction = [0.1, -0.2, -3], magnitude_m_per_s2 = 9.81 }}\n\
         torque = {{ unit = \"N·m\", std = {torque_std:e} }}\n[position]\nunit = \"rad\"\n{position_std}\n\
         [recording]\nrate_hz = 200\nsamples = 2000\nmove_s = 1\nmotion = {{ harmonics = 5, period_s = 10, seed = {motion} }}\n\
         [[random]]\nfile = \"{file}\"\nposes = 2\n{}",
        (1..=7).map(joint).collect::<String>()
    );
    let path = folder.join("simulation.toml");
    fs::write(&path, text).map_err(|error| error.to_string())?;
    let simulation = Simulation::read(&path).map_err(|error| error.to_string())?;
    let made = folder.join(format!("{motion}"));
    fs::create_dir_all(&made).map_err(|error| error.to_string())?;
    write_session(&simulation, 0, &made, true).map_err(|error| error.to_string())?;
    fs::rename(made.join(file), folder.join(file)).map_err(|error| error.to_string())
}

/// Root-mean-square error of the torques of the other recording, mean over the joints, N·m.
fn predicted(folder: &Path, cut_off: f64) -> Result<f64, String> {
    let columns = |kind: &str| {
        let all: Vec<String> = (1..=7).map(|joint| format!("\"joint{joint}.{kind}\"")).collect();
        all.join(", ")
    };
    let text = format!(
        "robot = \"robot.toml\"\nestimators = [\"joint\"]\n[gravity]\nmagnitude_m_per_s2 = 9.81\nhemisphere = [0, 0, -1]\n\
         [inertia]\nlinks = \"unknown\"\n[readings]\ntime = {{ column = \"time_s\", unit = \"s\" }}\n\
         position = {{ columns = [{}], unit = \"rad\" }}\ntorque = {{ columns = [{}], unit = \"N·m\" }}\n\
         motion = {{ window_s = {} }}\n[joints]\ntorque_sign = \"normal\"\n\
         torque_gain = {{ fixed = 1.0, unit = \"N·m/(N·m)\" }}\nposition_gain = {{ fixed = 1.0, unit = \"rad/rad\" }}\n\
         position_offset = {{ fixed = 0.0, unit = \"rad\" }}\n\
         sensor_models = [{{ kind = \"coulomb-friction\" }}, {{ kind = \"viscous-friction\" }}]\n\
         [[poses]]\nfile = \"fitted.csv\"\n[[validation]]\nfile = \"other.csv\"\n",
        columns("position"),
        columns("effort"),
        1.6 / cut_off
    );
    let path = folder.join("session.toml");
    fs::write(&path, text).map_err(|error| error.to_string())?;
    let session = read_session(&path).map_err(|error| error.to_string())?;
    let solver = LevenbergMarquardt::default();
    let results = calibrate(&session, &[EstimatorName::Joint], &SolveEnvironment::new(&solver, &|_: &str| {}));
    let held_out = results.iter().find_map(|result| result.fit.as_ref()?.held_out.as_ref());
    let held_out = held_out.ok_or_else(|| format!("nothing was predicted at {cut_off} Hz"))?;
    Ok(held_out.joints.iter().map(|joint| joint.rms).sum::<f64>() / held_out.joints.len() as f64)
}

/// Links of 0.3 m, crosswise.
fn robot() -> String {
    let joint = |number: usize| {
        let (size, alpha) = (1.0 / number as f64, if number % 2 == 1 { 90.0 } else { -90.0 });
        format!(
            "[[joint]]\nname = \"joint{number}\"\na_m = 0.05\nalpha_deg = {alpha:?}\nd_m = 0.3\nlimits_deg = [-90.0, 90.0]\n\
             mass_kg = {:?}\ncenter_of_mass_m = [0.03, {:?}, 0.05]\n\
             inertia_kg_m2 = {{ xx = {:?}, yy = {:?}, zz = {:?}, xy = {:?} }}\n",
            4.0 * size,
            0.1 * size,
            0.04 * size,
            0.03 * size,
            0.02 * size,
            0.002 * size,
        )
    };
    format!("name = \"seven-joints\"\nconvention = \"standard-dh\"\n{}", (1..=7).map(joint).collect::<String>())
}
