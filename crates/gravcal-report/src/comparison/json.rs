//! A comparison for programs.

use gravcal_calibration::comparison::{ComparedParameter, HomogeneityTest, LeftOut, SIGNIFICANCE, SensorComparison};
use serde::Serialize;

use super::ComparisonReport;
use crate::json::JsonError;

#[derive(Serialize)]
struct Document<'a> {
    format: &'static str,
    files: &'a [String],
    shared_inputs: &'a [String],
    different_robots: &'a [String],
    /// By calibration, why its intervals may not hold.
    doubts: &'a [Vec<String>],
    significance: f64,
    moved: Vec<&'a str>,
    /// What may have moved unnoticed.
    not_seen: Vec<&'a str>,
    /// Offsets that define the base frame: gravity seems to move with them.
    gravity_stands_for: &'a [String],
    sensors: Vec<SensorDocument<'a>>,
}

#[derive(Serialize)]
struct SensorDocument<'a> {
    name: &'a str,
    test: Option<TestDocument>,
    parameters: Vec<ParameterDocument<'a>>,
    left_out: Vec<String>,
    in_all: bool,
    models_differ_in: &'a [String],
    beside_others: Option<BesideDocument<'a>>,
}

/// Where it moved beside the others only.
#[derive(Serialize)]
struct BesideDocument<'a> {
    p_value: f64,
    /// Sensors that may have moved in its stead.
    or: &'a [String],
}

#[derive(Serialize)]
struct TestDocument {
    chi_squared: f64,
    degrees_of_freedom: usize,
    p_value: f64,
    corrected_p_value: f64,
    moved: bool,
    /// Numbers of two calibrations, counted from 1.
    largest_step: [usize; 2],
}

#[derive(Serialize)]
struct ParameterDocument<'a> {
    name: &'a str,
    unit: &'a str,
    values: &'a [f64],
    stds: &'a [f64],
}

pub(super) fn json(report: &ComparisonReport<'_>) -> Result<String, JsonError> {
    crate::json::json(&Document {
        format: "gravcal-comparison/1",
        files: report.files,
        shared_inputs: report.shared,
        different_robots: report.robots,
        doubts: &report.comparison.doubts,
        significance: SIGNIFICANCE,
        moved: report.comparison.moved().map(|sensor| sensor.name.as_str()).collect(),
        not_seen: report.comparison.not_seen(),
        gravity_stands_for: &report.comparison.base_frame,
        sensors: report.comparison.sensors.iter().map(sensor).collect(),
    })
}

fn sensor(sensor: &SensorComparison) -> SensorDocument<'_> {
    let SensorComparison { name, parameters, left_out, in_all, models_differ_in, test, beside_others } = sensor;
    SensorDocument {
        name,
        test: test.as_ref().map(reported),
        parameters: parameters.iter().map(parameter).collect(),
        left_out: left_out.iter().map(LeftOut::to_string).collect(),
        in_all: *in_all,
        models_differ_in,
        beside_others: beside_others.as_ref().map(|beside| BesideDocument { p_value: beside.p_value, or: &beside.or }),
    }
}

fn reported(test: &HomogeneityTest) -> TestDocument {
    let HomogeneityTest { chi_squared, degrees_of_freedom, p_value, corrected_p_value, moved, largest_step } = *test;
    let largest_step = [largest_step.0 + 1, largest_step.0 + 2];
    TestDocument { chi_squared, degrees_of_freedom, p_value, corrected_p_value, moved, largest_step }
}

fn parameter(parameter: &ComparedParameter) -> ParameterDocument<'_> {
    let ComparedParameter { name, unit, values, stds } = parameter;
    ParameterDocument { name, unit, values, stds }
}
