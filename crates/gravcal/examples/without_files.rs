//! The main job without any file: a robot and arrays in; gains, biases, offsets and gravity out.
//!
//! ```sh
//! cargo run --release -p gravcal --example without_files
//! ```

mod common;

use std::error::Error;

use gravcal::calibration::parameter::SensorParameter;
use gravcal::calibration::result::ParameterResult;
use gravcal::calibration::session::PoseArrays;
use gravcal::calibration::{EstimatorName, SolveEnvironment, calibrate};
use gravcal::report::CalibrationSummary;
use gravcal::solvers::SolverName;

fn main() -> Result<(), Box<dyn Error>> {
    let mut session = common::nothing_recorded()?;
    for (load, name) in [(None, "bare"), (Some(0), "with the plate")] {
        let (positions, torques) = recorded(load)?;
        let (positions, torques) = (&positions[..], &torques[..]);
        session.add_poses(&PoseArrays { name, load, positions, torques, torque_std: Some(&[common::STD; 3]) })?;
    }
    let solver = SolverName::LevenbergMarquardt.build();
    let results = calibrate(&session, &[EstimatorName::Joint], &SolveEnvironment::new(solver.as_ref(), &|_stage| {}));
    let [result] = results.as_slice() else { return Err("one estimator was asked, one answers".into()) };

    println!("{}: {:?}", session.robot.name, result.verdict);
    for parameter in &result.parameters {
        match (parameter.value, parameter.std) {
            (Some(value), Some(std)) => println!("{:<24} {value:>9.5} ± {std:.5} {}", parameter.name, parameter.unit),
            _ => println!("{:<24} undetermined", parameter.name),
        }
    }
    let faulty = result.joints().nth(1).ok_or("the arm has three joints")?;
    for (parameter, truth) in [(faulty.torque_gain, 1.08), (faulty.torque_bias, 0.7)] {
        let (value, std) = parameter.estimate().ok_or("the fault is not determined")?;
        assert!((value - truth).abs() < 4.0 * std, "{} is {value}", parameter.name);
    }
    // The same by the joint's name.
    let gain = result.sensor("joint2", SensorParameter::TorqueGain).and_then(ParameterResult::estimate);
    assert_eq!(gain, faulty.torque_gain.estimate());
    assert_eq!(result.joints().map(|sensors| sensors.joint).collect::<Vec<_>>(), ["joint1", "joint2", "joint3"]);
    // What a terminal shows, and what calibration.json holds, is there for programs, too.
    print!("\n{}", CalibrationSummary { robot: &session.robot.name, results: &results, file: "calibration.json" });
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
