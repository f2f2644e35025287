//! The solver's way over its iterations, and the parameters on it.

use gravcal_calibration::result::{EstimatorResult, ParameterResult};
use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};

use crate::contents::CalibrationRecording;
use crate::plot::{Mark, iterations, series};
use crate::style;

/// Logs cost, cosine, step and damping, and the parameters with their intervals.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    for result in calibration.results {
        log_trace(stream, result)?;
        for (index, parameter) in result.parameters.iter().enumerate() {
            log_parameter(stream, result, index, parameter)?;
        }
    }
    Ok(())
}

fn log_trace(stream: &RecordingStream, result: &EstimatorResult) -> Result<(), RecordingStreamError> {
    let numbers = |number: fn(&gravcal_calibration::result::Iteration) -> f64| result.trace.iter().map(number);
    let lines = [
        ("log10_cost", numbers(|it| it.cost)),
        ("log10_cosine", numbers(|it| it.largest_cosine)),
        ("log10_step", numbers(|it| it.step)),
        ("log10_damping", numbers(|it| it.damping)),
    ];
    for (index, (name, values)) in lines.into_iter().enumerate() {
        // A step or a damping of zero is none.
        let seen = values.enumerate().filter(|(_, value)| *value > 0.0);
        let (numbers, values): (Vec<usize>, Vec<f64>) = seen.map(|(number, value)| (number, value.log10())).unzip();
        let mark = (name, style::numbered(index), Mark::Line(2.0));
        series(stream, entity_path!["trace", result.name, name], mark, [iterations(numbers)], values)?;
    }
    Ok(())
}

/// Where a parameter is logged.
fn path(estimator: &str, parameter: &ParameterResult, what: &str) -> EntityPath {
    let (owner, quantity) = parameter.name.rsplit_once('.').unwrap_or(("", &parameter.name));
    entity_path!["parameters", estimator, quantity, owner, what]
}

fn log_parameter(
    stream: &RecordingStream,
    result: &EstimatorResult,
    index: usize,
    parameter: &ParameterResult,
) -> Result<(), RecordingStreamError> {
    if result.detail.iterates.is_empty() || parameter.held.is_some() {
        return Ok(());
    }
    let estimator = result.name.as_str();
    let times = || [iterations(0..result.detail.iterates.len())];
    let owner = parameter.name.rsplit_once('.').map_or("", |(owner, _)| owner);
    let colour = style::numbered(index / 4);
    let values = result.detail.iterates.iter().map(|values| values[index]).collect();
    series(stream, path(estimator, parameter, "value"), (owner, colour, Mark::Line(2.0)), times(), values)?;
    for (what, end) in ["low", "high"].into_iter().zip(parameter.ci95.into_iter().flatten()) {
        let name = format!("{owner}, 95 % {what}");
        let ends = vec![end; result.detail.iterates.len()];
        series(stream, path(estimator, parameter, what), (&name, colour, Mark::Line(0.7)), times(), ends)?;
    }
    Ok(())
}
