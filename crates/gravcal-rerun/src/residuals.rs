//! Residuals by channel, in the unit of the reading and in standard deviations.

use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};

use crate::contents::CalibrationRecording;
use crate::explanation::Explained;
use crate::plot::{Mark, series};
use crate::poses::PoseTimes;
use crate::style;

/// Where residuals in the unit of the reading are logged.
pub fn in_unit(estimator: &str, channel: &str) -> EntityPath {
    entity_path!["residuals", "in_unit", estimator, channel]
}

/// Where residuals of all channels in standard deviations are logged.
pub fn in_std(estimator: &str) -> EntityPath {
    entity_path!["residuals", "in_std", estimator]
}

/// Logs both.
pub fn log(
    stream: &RecordingStream,
    calibration: &CalibrationRecording<'_>,
    poses: &PoseTimes,
) -> Result<(), RecordingStreamError> {
    for channel in calibration.channels() {
        let name = calibration.session.channel_name(channel);
        for explanation in calibration.explanations() {
            let by = explanation.name;
            let own: Vec<Explained> = explanation.of_channel(channel).collect();
            let times = poses.columns(own.iter().map(|one| one.pose));
            let mark = (by, style::of(by), Mark::Dots(2.5));
            series(stream, in_unit(by, &name), mark, times.clone(), own.iter().map(|one| one.residual).collect())?;
            let mark = (name.as_str(), style::numbered(channel), Mark::Dots(2.5));
            let relative = own.iter().map(|one| one.residual / one.std).collect();
            series(stream, in_std(by).join(&name.as_str().into()), mark, times, relative)?;
        }
    }
    Ok(())
}
