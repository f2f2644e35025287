//! Readings and what they were predicted to be, channel by channel.

use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};

use crate::explanation::Explained;
use crate::plot::{Mark, series};
use crate::poses::PoseTimes;
use crate::recording::CalibrationRecording;
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
        let read = |pose: usize| Some((pose, session.reading(pose, channel)?.value));
        let (numbers, readings): (Vec<usize>, Vec<f64>) = (0..session.poses.len()).filter_map(read).unzip();
        let mark = ("measured", style::colour(style::MEASURED), Mark::Dots(2.5));
        series(stream, path(&name, "measured"), mark, poses.columns(numbers), readings)?;
        for explanation in calibration.explanations() {
            let predict = |one: Explained| Some((one.pose, session.reading(one.pose, channel)?.value + one.residual));
            let (numbers, values): (Vec<usize>, Vec<f64>) = explanation.of_channel(channel).filter_map(predict).unzip();
            let mark = (explanation.name, style::of(explanation.name), Mark::Line(1.5));
            series(stream, path(&name, explanation.name), mark, poses.columns(numbers), values)?;
        }
    }
    Ok(())
}
