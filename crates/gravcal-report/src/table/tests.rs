use super::*;
use crate::testing::{determined, fit, held, result, undetermined};
use crate::text::{WIDTH, width};
use gravcal_calibration::result::{ParameterResult, Undetermined, Verdict};

fn with_nominal(nominal: f64, parameter: ParameterResult) -> ParameterResult {
    ParameterResult { nominal, ..parameter }
}

fn sequential() -> EstimatorResult {
    let mut sequential = result("sequential");
    sequential.verdict = Verdict::PartlyDetermined;
    sequential.termination = "three steps, each with the results of the steps before frozen".into();
    sequential.iterations = 41;
    sequential.parameters = vec![
        with_nominal(6.69, undetermined("joint1.torque_gain")),
        with_nominal(2048.0, determined("joint1.torque_bias", "count", 2075.02, 0.283)),
        with_nominal(1.0, determined("joint1.position_gain", "rad/rad", 0.9912, 0.00335)),
        held("joint1.position_offset", "zero by definition of the base frame"),
    ];
    sequential.parameters[0].unit = "count/(N·m)".into();
    sequential.undetermined = vec![Undetermined {
        combination: "joint1.torque_gain".into(),
        parameters: vec!["joint1.torque_gain".into()],
        why: "no pair of sweeps with two placements".into(),
        cure: "sweep joint2 with the load at two placements".into(),
    }];
    sequential.notes = vec!["joint1.position_offset is zero by definition of the base frame.".into()];
    sequential
}

fn joint() -> EstimatorResult {
    let mut joint = result("joint");
    joint.parameters = vec![
        with_nominal(6.69, determined("joint1.torque_gain", "count/(N·m)", 7.118_13, 0.0204)),
        with_nominal(2048.0, determined("joint1.torque_bias", "count", 2075.123, 0.118)),
        with_nominal(1.0, determined("joint1.position_gain", "rad/rad", 0.988_12, 0.000_45)),
        held("joint1.position_offset", "zero by definition of the base frame"),
    ];
    joint.fit = Some(fit());
    joint.notes = sequential().notes;
    joint
}

#[test]
fn the_whole_table() {
    let table = CalibrationTable { robot: "arm", doubts: &[], results: &[sequential(), joint()] }.to_string();
    assert_eq!(
        table,
        "\
Calibration of arm
  sequential  partly determined: not joint1.torque_gain
              three steps, each with the results of the steps before frozen; 41
              iterations
  joint       determined: everything that is asked for
              converged: steps too small to matter (1.0e-12); 6 iterations

Gravity and sensor parameters, value ± standard deviation
                   unit         nominal  sequential estimator    joint estimator
gravity in base coordinates
  x                m/s²                      -3.4312 ± 0.0031  -3.4312 ± 0.0031
  y                m/s²                      -5.9411 ± 0.0029  -5.9411 ± 0.0029
  z                m/s²                      -7.0009 ± 0.0027  -7.0009 ± 0.0027
  cone95           deg                         0.053             0.053
  tilt             deg                        44.421            44.421
joint1
  torque_gain      count/(N·m)     6.69          undetermined    7.118 ± 0.020
  torque_bias      count           2048      2075.02 ± 0.28    2075.12 ± 0.12
  position_gain    rad/rad            1       0.9912 ± 0.0034  0.98812 ± 0.00045
  position_offset  deg                0             fixed [1]          fixed [1]

[1] fixed: zero by definition of the base frame
Standard deviations: from the stated noise
reading = torque_gain * torque + torque_bias
coordinate = position_gain * reading + position_offset
cone95: half-angle of the cone about gravity that holds its true direction with
95 % probability. tilt: angle between gravity and the base's -z axis.

Undetermined
  joint1.torque_gain (sequential)
    why  no pair of sweeps with two placements
    cure sweep joint2 with the load at two placements

Fit: residuals of the torque readings, in their unit
  joint: χ² 101.30 for 95 degrees of freedom, p = 0.31
    held out: 4 poses in 2 stretches that a second fit did not see, χ² 9.1000
    for 8 readings
                                    fitted           held out
            unit   readings  noise     rms  largest       rms  largest  of range
    joint1  count        37   0.80   0.791     2.12     0.912     1.43    0.20 %

Notes
  - joint1.position_offset is zero by definition of the base frame.
"
    );
}

#[test]
fn lines_fit_the_width() {
    let table = CalibrationTable { robot: "arm", doubts: &[], results: &[sequential(), joint()] }.to_string();
    assert!(table.lines().all(|line| width(line) <= WIDTH && !line.ends_with(' ')));
}
