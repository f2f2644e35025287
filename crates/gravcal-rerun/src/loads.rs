//! Known loads: where they are or were found to be, while they are attached.

use gravcal_robot_model::session::Load;
use re_sdk::{RecordingStream, RecordingStreamError};
use re_sdk_types::archetypes::Ellipsoids3D;
use re_sdk_types::components::FillMode;

use crate::arm::path;
use crate::contents::CalibrationRecording;
use crate::plot::to_time;
use crate::shape::small;
use crate::style;

/// Density of steel, kg/m³: a load is drawn as a ball of it.
const STEEL: f64 = 7850.0;

/// Centre of mass of each load in its link's frame, m; of none that nobody knows.
pub fn placements(calibration: &CalibrationRecording<'_>) -> Vec<Option<[f64; 3]>> {
    let loads = &calibration.session.loads;
    loads.iter().map(|load| found(calibration, load, &mut Vec::new()).or(load.position)).collect()
}

/// Where the deciding result found a load: by itself, or displaced from another.
fn found<'s>(calibration: &CalibrationRecording<'s>, load: &'s Load, passed: &mut Vec<&'s str>) -> Option<[f64; 3]> {
    passed.push(&load.name);
    if let Some(position) = vector(calibration, &format!("load.{}.position", load.name)) {
        return Some(position);
    }
    calibration.session.loads.iter().find_map(|other| {
        let displacement = vector(calibration, &format!("load.{}.displacement_from.{}", load.name, other.name))?;
        let start = (!passed.contains(&other.name.as_str())).then(|| found(calibration, other, passed))??;
        Some(std::array::from_fn(|axis| start[axis] + displacement[axis]))
    })
}

/// A vector all of whose components are determined by themselves.
fn vector(calibration: &CalibrationRecording<'_>, name: &str) -> Option<[f64; 3]> {
    let moments = &calibration.deciding()?.moments;
    let component = |axis: &str| {
        moments.iter().find_map(|moment| match moment.terms.as_slice() {
            [(term, coefficient)] if *term == format!("{name}.{axis}") => Some(moment.value / coefficient),
            _ => None,
        })
    };
    Some([component("x")?, component("y")?, component("z")?])
}

/// Logs loads where poses begin and end to carry them.
pub fn log(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    placements: &[Option<[f64; 3]>],
) -> Result<(), RecordingStreamError> {
    let session = calibration.session;
    for (index, (load, placement)) in session.loads.iter().zip(placements).enumerate() {
        let Some(position) = placement else { continue };
        let path = path(calibration, load.link).join(&re_sdk::entity_path!["load", load.name]);
        let radius = (3.0 * load.mass / (4.0 * std::f64::consts::PI * STEEL)).cbrt() as f32;
        let ball = Ellipsoids3D::from_centers_and_half_sizes([small(*position)], [[radius; 3]])
            .with_colors([style::colour(style::LOAD)])
            .with_fill_mode(FillMode::Solid)
            .with_labels([format!("{} {} kg", load.name, load.mass)]);
        let mut before = false;
        for (pose, carries) in session.poses.iter().map(|pose| pose.load == Some(index)).enumerate() {
            if carries != before {
                stream.set_time_sequence("pose", to_time(pose));
                match carries {
                    true => stream.log(path.clone(), &ball)?,
                    false => stream.log(path.clone(), &Ellipsoids3D::clear_fields())?,
                }
            }
            before = carries;
        }
    }
    stream.reset_time();
    Ok(())
}
