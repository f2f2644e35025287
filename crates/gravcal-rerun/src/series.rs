//! Readings and what they were predicted to be, channel by channel.

use gravcal_calibration::result::{ReadingResidual, TorqueParts};
use gravcal_robot_model::session::ReadingId;
use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};

use crate::contents::CalibrationRecording;
use crate::explanation::Explained;
use crate::plot::{Mark, series};
use crate::poses::PoseTimes;
use crate::style;

/// Where everything of a channel is logged.
pub fn folder(channel: &str) -> EntityPath {
    entity_path!["readings", channel]
}

/// Where what `name` says of a channel is logged.
pub fn path(channel: &str, name: &str) -> EntityPath {
    entity_path!["readings", channel, name]
}

/// Logs readings and predictions.
pub fn log(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    poses: &PoseTimes,
) -> Result<(), RecordingStreamError> {
    let session = calibration.session;
    for channel in calibration.channels() {
        let name = session.channel_name(channel);
        let read = |pose: usize| Some((pose, session.reading(ReadingId { pose, channel })?.value));
        let (numbers, readings): (Vec<usize>, Vec<f64>) = (0..session.poses.len()).filter_map(read).unzip();
        let mark = ("measured", style::colour(style::MEASURED), Mark::Dots(2.5));
        series(stream, path(&name, "measured"), mark, poses.columns(numbers), readings)?;
        for explanation in calibration.explanations() {
            let predict = |one: Explained| Some((one.pose, read(one.pose)?.1 + one.residual));
            let (numbers, values): (Vec<usize>, Vec<f64>) = explanation.of_channel(channel).filter_map(predict).unzip();
            let mark = (explanation.name, style::of(explanation.name), Mark::Line(1.5));
            series(stream, path(&name, explanation.name), mark, poses.columns(numbers), values)?;
        }
        log_parts(stream, calibration, channel, poses)?;
    }
    Ok(())
}

/// A part of a predicted reading, by its name.
type Part = (&'static str, fn(&TorqueParts) -> f64);
const PARTS: [Part; 2] = [("gravity", |torque| torque.gravity), ("inertia", |torque| torque.inertia)];

/// Logs of what the deciding estimate makes the readings of an arm in motion.
fn log_parts(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    channel: usize,
    poses: &PoseTimes,
) -> Result<(), RecordingStreamError> {
    let (session, deciding) = (calibration.session, calibration.deciding());
    let rows = deciding.iter().filter_map(|result| result.fit.as_ref()).flat_map(|fit| &fit.residuals);
    let moving: Vec<(&ReadingResidual, TorqueParts)> =
        rows.filter(|row| row.id.channel == channel).filter_map(|row| Some((row, row.torque?))).collect();
    if moving.is_empty() {
        return Ok(());
    }
    let name = session.channel_name(channel);
    let times = poses.columns(moving.iter().map(|(row, _)| row.id.pose));
    for (place, (part, value)) in PARTS.into_iter().enumerate() {
        let values = moving.iter().map(|(_, torque)| value(torque)).collect();
        series(stream, path(&name, part), (part, style::numbered(2 + place), Mark::Line(1.0)), times.clone(), values)?;
    }
    let rest = |(row, torque): &(&ReadingResidual, TorqueParts)| {
        let reading = session.reading(row.id).map_or(f64::NAN, |reading| reading.value);
        reading + row.residual - torque.gravity - torque.inertia - torque.bias
    };
    let mark = ("friction", style::numbered(2 + PARTS.len()), Mark::Line(1.0));
    series(stream, path(&name, "friction"), mark, times, moving.iter().map(rest).collect())
}
