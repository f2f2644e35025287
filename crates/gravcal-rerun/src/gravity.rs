//! Gravity before and after, and the cone that holds its direction.

use gravcal_calibration::result::GravityResult;
use nalgebra::{Unit, Vector3};
use re_sdk::{RecordingStream, RecordingStreamError, entity_path};
use re_sdk_types::archetypes::{Arrows3D, LineStrips3D};
use re_sdk_types::components::Radius;

use crate::arm::shape;
use crate::contents::CalibrationRecording;
use crate::shape::small;
use crate::style;

/// Length of the arrows, and their thickness, as shares of the arm's size.
const LENGTH: f64 = 0.3;
const RADIUS: f64 = 0.008;
/// Corners of the cone's rim.
const CORNERS: usize = 48;

/// Logs arrows from the base's origin, and cones about those that were found.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    let size = shape(calibration).size;
    let known = calibration.session.gravity;
    if let Some(hemisphere) = known.hemisphere {
        log_arrow(stream, "nominal", hemisphere, size, ("gravity as stated".into(), false))?;
    }
    for result in calibration.results {
        let Some(gravity) = &result.gravity else { continue };
        let label = format!("gravity, {}: ±{:.2}° (95 %)", result.name, gravity.cone95_deg);
        let decides = calibration.deciding().is_some_and(|deciding| deciding.name == result.name);
        log_arrow(stream, &result.name, gravity.vector_m_per_s2, size, (label, decides))?;
        let rim = cone(gravity, LENGTH * size);
        let lines =
            LineStrips3D::new(rim).with_colors([style::of(&result.name)]).with_radii([Radius::new_ui_points(1.0)]);
        stream.log_static(entity_path!["gravity", result.name, "cone95"], &lines)?;
    }
    Ok(())
}

fn log_arrow(
    stream: &RecordingStream,
    name: &str,
    vector: [f64; 3],
    size: f64,
    (label, shown): (String, bool),
) -> Result<(), RecordingStreamError> {
    let direction = Unit::new_normalize(Vector3::from(vector));
    let arrow = Arrows3D::from_vectors([small((LENGTH * size * direction.into_inner()).into())])
        .with_radii([(RADIUS * size) as f32])
        .with_colors([style::of(name)])
        .with_labels([label])
        .with_show_labels(shown);
    stream.log_static(entity_path!["gravity", name], &arrow)
}

/// Rim and generatrices of the cone, true to scale.
fn cone(gravity: &GravityResult, length: f64) -> Vec<Vec<[f32; 3]>> {
    let axis = Unit::new_normalize(Vector3::from(gravity.vector_m_per_s2));
    let aside = Unit::new_normalize(axis.cross(&some_other(&axis)));
    let across = axis.cross(&aside);
    let (sin, cos) = gravity.cone95_deg.to_radians().sin_cos();
    let corner = |k: usize| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / CORNERS as f64).sin_cos();
        small((length * (cos * axis.into_inner() + sin * (c * aside.into_inner() + s * across))).into())
    };
    let rim = (0..=CORNERS).map(corner).collect();
    let lines = (0..CORNERS).step_by(CORNERS / 8).map(|k| vec![[0.0; 3], corner(k)]);
    [rim].into_iter().chain(lines).collect()
}

/// An axis that is far from parallel to `axis`.
fn some_other(axis: &Vector3<f64>) -> Vector3<f64> {
    if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() }
}
