//! Residuals by channel, in the unit of the reading and in standard deviations.

use rerun::{EntityPath, RecordingStream, RecordingStreamError, entity_path};

use crate::plot::{Mark, series};
use crate::poses::PoseTimes;
use crate::recording::CalibrationRecording;
use crate::series::of_channel;
use crate::style;

/// Where residuals in the unit of the reading are logged.
pub fn in_unit(estimator: &str, channel: &str) -> EntityPath {
    entity_path!["residuals", "in_unit", estimator, channel]
}

/// Logs both.
pub fn log(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    poses: &PoseTimes,
) -> Result<(), RecordingStreamError> {
    for channel in calibration.channels() {
        let name = calibration.session.channel_name(channel);
        for (by, predictions) in calibration.predictions() {
            let (numbers, plain) = of_channel(predictions, channel, |one| one.residual());
            let (_, relative) = of_channel(predictions, channel, |one| one.residual() / one.std);
            let times = poses.columns(&numbers);
            let mark = (by, style::of(by), Mark::Dots(2.5));
            series(stream, in_unit(by, &name), mark, times.clone(), plain)?;
            let mark = (name.as_str(), style::numbered(channel), Mark::Dots(2.5));
            series(stream, entity_path!["residuals", "in_std", by, name], mark, times, relative)?;
        }
    }
    Ok(())
}
