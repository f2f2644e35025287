//! A study in code: many simulated calibrations with known truth. How large are the errors, and do 95 % intervals hold?
//!
//! ```sh
//! cargo run --release -p gravcal --example study
//! ```

mod common;

use std::error::Error;

use gravcal::calibration::{EstimatorName, SolveEnvironment, calibrate_briefly};
use gravcal::solvers::SolverName;

const TRIALS: u64 = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let simulation = common::simulation()?;
    let solver = SolverName::LevenbergMarquardt.build();
    let (mut squares, mut held) = (0.0, 0_u32);
    for trial in 0..TRIALS {
        let session = simulation.session(trial);
        let environment = SolveEnvironment::new(solver.as_ref(), &|_stage| {});
        let briefs = calibrate_briefly(&session, &[EstimatorName::Joint], &environment);
        let brief = briefs.into_iter().next().ok_or("no estimator ran")??;
        let gain = brief.parameters.iter().find(|parameter| parameter.name == "joint2.torque_gain");
        let (value, interval) = gain.and_then(|gain| Some((gain.value?, gain.ci95?))).ok_or("not determined")?;
        squares += (value - 1.08_f64).powi(2);
        held += u32::from(interval[0] <= 1.08 && 1.08 <= interval[1]);
    }
    let (rms, share) = ((squares / TRIALS as f64).sqrt(), f64::from(held) / TRIALS as f64);
    println!("joint2.torque_gain: rms error {rms:.5} N·m/(N·m), {held} of {TRIALS} 95 % intervals hold the truth");
    // Of 40 intervals that hold with 95 %, fewer than 33 do in one of ten thousand studies.
    assert!(rms < 0.002 && share > 0.8);
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
