//! The main job without any file: a robot and arrays in; gains, biases, offsets and gravity out.
//!
//! ```sh
//! cargo run --release -p gravcal --example without_files
//! ```

mod common;

use std::error::Error;

use gravcal::calibration::session::PoseArrays;
use gravcal::calibration::{EstimatorName, Workbench, calibrate};
use gravcal::solvers::SolverName;

fn main() -> Result<(), Box<dyn Error>> {
    let mut session = common::nothing_recorded()?;
    for (load, name) in [(None, "bare"), (Some(0), "with the plate")] {
        let (positions, torques) = recorded(load)?;
        let (positions, torques) = (&positions[..], &torques[..]);
        session.add_poses(&PoseArrays { name, load, positions, torques, torque_std: Some(&[common::STD; 3]) })?;
    }
    let solver = SolverName::LevenbergMarquardt.build();
    let results = calibrate(&session, &[EstimatorName::Joint], &Workbench::new(solver.as_ref(), &|_stage| {}));
    let [result] = results.as_slice() else { return Err("one estimator was asked, one answers".into()) };

    println!("{}: {:?}", session.robot.name, result.verdict);
    for parameter in &result.parameters {
        match (parameter.value, parameter.std) {
            (Some(value), Some(std)) => println!("{:<24} {value:>9.5} ± {std:.5} {}", parameter.name, parameter.unit),
            _ => println!("{:<24} undetermined", parameter.name),
        }
    }
    for name in ["joint2.torque_gain", "joint2.torque_bias"] {
        let truth = if name.ends_with("gain") { 1.08 } else { 0.7 };
        let found = result.parameter(name).and_then(|found| Some((found.value? - truth, found.std?)));
        let (error, std) = found.ok_or("the fault is not determined")?;
        assert!(error.abs() < 4.0 * std, "{name} is off by {error}");
    }
    Ok(())
}

/// What a driver would give: the positions (rad) and torques (N·m) of all joints, pose after pose.
fn recorded(load: Option<usize>) -> Result<(Vec<f64>, Vec<f64>), Box<dyn Error>> {
    let poses = common::simulation()?.session(0).poses;
    let poses: Vec<_> = poses.iter().filter(|pose| pose.load == load).collect();
    let positions = poses.iter().flat_map(|pose| pose.position.clone()).collect();
    let torques = poses.iter().flat_map(|pose| &pose.torque).map(|reading| reading.map_or(f64::NAN, |r| r.value));
    Ok((positions, torques.collect()))
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
