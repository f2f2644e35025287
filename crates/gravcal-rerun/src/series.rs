//! Readings and what they were predicted to be, channel by channel.

use gravcal_calibration::result::Prediction;
use rerun::{EntityPath, RecordingStream, RecordingStreamError, entity_path};

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
        series(stream, path(&name, "measured"), mark, poses.columns(&numbers), readings)?;
        for (by, predictions) in calibration.predictions() {
            let (numbers, values) = of_channel(predictions, channel, |one| one.predicted);
            let mark = (by, style::of(by), Mark::Line(1.5));
            series(stream, path(&name, by), mark, poses.columns(&numbers), values)?;
        }
    }
    Ok(())
}

/// Poses and a number of each prediction of one channel.
pub fn of_channel(
    predictions: &[Prediction],
    channel: usize,
    number: impl Fn(&Prediction) -> f64,
) -> (Vec<usize>, Vec<f64>) {
    predictions.iter().filter(|one| one.channel == channel).map(|one| (one.pose, number(one))).unzip()
}
