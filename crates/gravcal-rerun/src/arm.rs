//! The arm in 3D, pose by pose.

use gravcal_dynamics::Transform;
use gravcal_robot_model::parameter::SensorParameter;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};
use re_sdk_types::archetypes::{Points3D, Transform3D, ViewCoordinates};
use re_sdk_types::components::{Color, RotationQuat, Translation3D};

use crate::contents::CalibrationRecording;
use crate::poses::PoseTimes;
use crate::shape::{Shape, quaternion, small};
use crate::{loads, style};

/// Corners of the space about the arm, as shares of its reach, and about what is drawn at its base, as shares of its size.
const ABOUT_ARM: [[f64; 3]; 2] = [[-0.4, -0.4, -0.15], [0.4, 0.4, 0.9]];
const ABOUT_BASE: [[f64; 3]; 2] = [[-0.2, -0.2, -0.2], [0.2, 0.2, 0.1]];

/// Logs the links' shapes, their poses, and the loads.
pub fn log(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    poses: &PoseTimes,
) -> Result<(), RecordingStreamError> {
    let chain = &calibration.session.robot.chain;
    let placements = loads::placements(calibration);
    let shape = shape(calibration);
    stream.log_static("/", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    if !shape.base.is_empty() {
        let base = shape.capsules(&shape.base, style::colour(style::LINK));
        stream.log_static(entity_path!["arm", chain.base(), "body"], &base)?;
    }
    for link in 0..chain.link_count() {
        let path = path(calibration, link);
        let body = shape.capsules(&shape.links[link], style::colour(style::LINK));
        stream.log_static(path.join(&"body".into()), &body)?;
        let housing = shape.housing(chain, link, style::numbered(link)).with_show_labels(false);
        stream.log_static(path.join(&"axis".into()), &housing)?;
    }
    let frames = frames(calibration);
    log_extent(stream, &shape)?;
    log_poses(stream, calibration, &frames, poses)?;
    loads::log(stream, calibration, &placements)
}

/// Frames of all links, pose by pose.
fn frames(calibration: &CalibrationRecording<'_>) -> Vec<Vec<Transform>> {
    let session = calibration.session;
    let sensors = position_sensors(calibration);
    let poses = session.poses.iter().enumerate();
    poses
        .map(|(index, pose)| pose.link_frames(&session.robot.chain, &coordinates(calibration, &sensors, index)))
        .collect()
}

/// Corners of the space about the arm, not to be seen: the viewer looks from where they fit into the picture.
fn log_extent(stream: &RecordingStream, shape: &Shape) -> Result<(), RecordingStreamError> {
    let scaled = |corners: [[f64; 3]; 2], by: f64| corners.map(|corner| small(corner.map(|part| part * by)));
    let corners = [scaled(ABOUT_ARM, shape.reach), scaled(ABOUT_BASE, shape.size)].concat();
    let corners = Points3D::new(corners).with_radii([0.0]);
    stream.log_static("/arm/extent", &corners.with_colors([Color::from_unmultiplied_rgba(0, 0, 0, 0)]))
}

/// Where a link is logged.
pub fn path(calibration: &CalibrationRecording<'_>, link: usize) -> EntityPath {
    entity_path!["arm", calibration.session.robot.chain.links()[link].name]
}

/// Shape of the arm with what is attached.
pub fn shape(calibration: &CalibrationRecording<'_>) -> Shape {
    let placements = loads::placements(calibration);
    let distances = placements.iter().flatten().map(|position| nalgebra::Vector3::from(*position).norm());
    Shape::of(&calibration.session.robot.chain, distances)
}

/// Poses of all links as columns.
fn log_poses(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    frames: &[Vec<Transform>],
    poses: &PoseTimes,
) -> Result<(), RecordingStreamError> {
    for link in 0..calibration.session.robot.chain.link_count() {
        let own = || frames.iter().map(|links| &links[link]);
        let moved = Transform3D::update_fields()
            .with_many_translation(own().map(|frame| Translation3D::from(small(frame.translation()))))
            .with_many_quaternion(own().map(|frame| RotationQuat::from(quaternion(rotation(frame)))));
        stream.send_columns(
            path(calibration, link),
            poses.columns(0..frames.len()),
            moved.columns_of_unit_batches()?,
        )?;
    }
    Ok(())
}

fn rotation(frame: &Transform) -> UnitQuaternion<f64> {
    let [a, b, c] = frame.rotation();
    let matrix = Matrix3::new(a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// Gain and offset of each joint's position sensor: as found, where they were, else nominal.
pub fn position_sensors(calibration: &CalibrationRecording<'_>) -> Vec<[f64; 2]> {
    let session = calibration.session;
    let joints = session.robot.chain.joints().iter().zip(&session.joints);
    let value = |joint: &str, quantity: SensorParameter, nominal: f64| {
        let found = calibration.deciding().and_then(|result| result.parameter(&quantity.name(joint)));
        found.and_then(|parameter| parameter.value).unwrap_or(nominal)
    };
    let both = [SensorParameter::PositionGain, SensorParameter::PositionOffset];
    joints.map(|(joint, known)| both.map(|quantity| value(&joint.name, quantity, known.of(quantity).nominal))).collect()
}

/// Coordinates of all joints in a pose, rad or m.
pub fn coordinates(calibration: &CalibrationRecording<'_>, sensors: &[[f64; 2]], pose: usize) -> Vec<f64> {
    let readings = &calibration.session.poses[pose].position;
    readings.iter().zip(sensors).map(|(reading, [gain, offset])| gain * reading + offset).collect()
}
