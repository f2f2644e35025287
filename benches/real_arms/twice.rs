//! Two recordings of one arm, calibrated and compared as `gravcal compare` does it: what is named where nothing moved, and where a sensor did.

use std::fs;
use std::path::Path;

use clap::ValueEnum;
use gravcal_calibration::comparison::{Comparison, compare};
use gravcal_calibration::result::EstimatorResult;
use gravcal_recording::{EarlierEstimate, read_earlier};
use gravcal_report::{CalibrationFile, Options, Provenance};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};

use crate::arms::Arm;
use crate::judge::{arm_of, calibrated, recorded};
use crate::line::{Line, Moved, Recording, Setting};

/// What moves, in turn.
const MOVES: [SensorParameter; 3] =
    [SensorParameter::TorqueGain, SensorParameter::TorqueBias, SensorParameter::PositionOffset];

/// What a comparison of two recordings says.
pub struct Compared {
    /// Whether intervals of either calibration are in doubt.
    doubted: bool,
    /// Sensors that are named as moved.
    named: Vec<String>,
    /// The sensor that did.
    moved: Option<String>,
}

/// Simulates, calibrates and compares two recordings of one arm. `moved_stds`: by how many of its standard deviations in the first calibration a sensor
/// moves before the second recording.
///
/// # Errors
/// Where files cannot be written, the simulation is refused, or a calibration comes to nothing that can be compared.
pub fn compare_two(
    setting: &Setting,
    (seed, number): (u64, u64),
    folder: &Path,
    moved_stds: Option<f64>,
) -> Result<Compared, String> {
    let arm = arm_of(setting, number)?;
    let first = Recording { seed, number, take: 0, moved: None };
    let (simulation, session) = recorded(setting, &arm, first, &folder.join("first"))?;
    let result = calibrated(&session)?;
    let moved = moved_stds.and_then(|stds| Some((stds, moving(&arm, number)?)));
    let moved = moved.and_then(|(stds, (joint, parameter))| {
        let name = simulation.template.parameter_name(ParameterId::Sensor(joint, parameter));
        Some(Moved { joint, parameter, by: stds * result.parameter(&name)?.std? })
    });
    let (_, session) = recorded(setting, &arm, Recording { take: 1, moved, ..first }, &folder.join("second"))?;
    let both = [(result, "first"), (calibrated(&session)?, "second")]
        .map(|(result, which)| earlier(result, &folder.join(which)));
    let [first, second] = both;
    let comparison = compare(&[&first?, &second?]).map_err(|error| error.to_string())?;
    Ok(Compared::of(&comparison, moved.map(|moved| sensor_name(&arm, moved))))
}

/// Which sensor of an arm moves in a session: each joint's in turn, and of each joint its gain, its bias and its offset.
fn moving(arm: &Arm, number: u64) -> Option<(usize, SensorParameter)> {
    let place = usize::try_from(number).ok()? / 3;
    let parameter = MOVES[place % MOVES.len()];
    let joint = place / MOVES.len() % arm.joints.len();
    // The first joint's position offset is what the base frame is.
    Some(if joint == 0 && parameter == SensorParameter::PositionOffset { (1, parameter) } else { (joint, parameter) })
}

fn sensor_name(arm: &Arm, moved: Moved) -> String {
    let sensor = if moved.parameter == SensorParameter::PositionOffset { "position" } else { "torque" };
    format!("{} {sensor}", arm.joints[moved.joint])
}

/// A result as its `calibration.json` hands it on.
fn earlier(result: EstimatorResult, folder: &Path) -> Result<EarlierEstimate, String> {
    let options =
        Options { estimators: vec![result.name.clone()], solver: String::new(), solver_options: Default::default() };
    let (name, provenance) = (result.name.clone(), Provenance::new(Vec::new(), options));
    let file = CalibrationFile { doubts: &[], estimators: &[result], provenance: &provenance };
    let path = folder.join("calibration.json");
    fs::write(&path, file.to_json().map_err(|error| error.to_string())?).map_err(|error| error.to_string())?;
    read_earlier(&path, &name).map_err(|error| error.to_string())
}

impl Compared {
    fn of(comparison: &Comparison, moved: Option<String>) -> Compared {
        let named = comparison.moved().map(|sensor| sensor.name.clone()).collect();
        Compared { doubted: comparison.doubts.iter().any(|doubts| !doubts.is_empty()), named, moved }
    }
}

/// What the columns of a row are.
pub fn heading() -> String {
    format!(
        "{:10} {:>8} {:>5}  {:>20}  {:>20}  {:>20}  {:>20}",
        "line",
        "friction",
        "pairs",
        "intervals in doubt",
        "a sensor is named",
        "of these in doubt",
        "the one that moved"
    )
}

/// One row.
pub fn row(line: Line, friction: f64, pairs: &[Compared]) -> String {
    let count = |of: &dyn Fn(&Compared) -> bool| pairs.iter().filter(|pair| of(pair)).count();
    let right = |pair: &Compared| pair.moved.as_ref().is_some_and(|moved| pair.named.contains(moved));
    let moved = count(&|pair| pair.moved.is_some());
    format!(
        "{:10} {friction:>8} {:>5}  {:>20}  {:>20}  {:>20}  {:>20}",
        line.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned()),
        pairs.len(),
        count(&|pair| pair.doubted),
        count(&|pair| !pair.named.is_empty()),
        count(&|pair| pair.doubted && !pair.named.is_empty()),
        if moved > 0 { format!("{} of {moved}", count(&right)) } else { "-".to_owned() },
    )
}
