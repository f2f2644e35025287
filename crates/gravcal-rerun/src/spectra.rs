//! Spectra of what the deciding estimate leaves of the readings of an arm in motion, as `report.html` has them.

use std::collections::BTreeMap;

use gravcal_calibration::result::ReadingResidual;
use gravcal_report::{MotionSpectra, motion_spectra};
use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};
use re_sdk_types::archetypes::BarChart;
use re_sdk_types::datatypes::TensorData;

use crate::contents::CalibrationRecording;
use crate::style;

/// Where the spectrum of a channel is logged.
pub fn path(channel: &str) -> EntityPath {
    entity_path!["spectra", channel]
}

/// Channels with windows enough for a spectrum, and theirs.
pub fn of_channels(calibration: &CalibrationRecording<'_>) -> Vec<(usize, MotionSpectra)> {
    let fit = calibration.deciding().and_then(|result| result.fit.as_ref());
    let mut by_channel: BTreeMap<usize, BTreeMap<usize, &ReadingResidual>> = BTreeMap::new();
    for row in fit.iter().flat_map(|fit| &fit.residuals) {
        by_channel.entry(row.id.channel).or_default().insert(row.id.pose, row);
    }
    let of_channel =
        |(channel, own): (usize, BTreeMap<_, _>)| Some((channel, motion_spectra(calibration.session, &own)?));
    by_channel.into_iter().filter_map(of_channel).collect()
}

/// Logs them: amplitudes over frequencies.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    for (channel, spectra) in of_channels(calibration) {
        let bars = BarChart::new(TensorData::from(spectra.residual_amplitudes()))
            .with_abscissa(TensorData::from(spectra.frequency))
            .with_color(style::numbered(channel));
        stream.log_static(path(&calibration.session.channel_name(channel)), &bars)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gravcal_recording::{Course, MotionWindows};
    use gravcal_robot_model::session::Searched;

    use crate::testing::Calibrated;

    /// The poses of the shoulder as if they were windows every tenth of a second.
    fn in_motion() -> Calibrated {
        let mut calibrated = Calibrated::sarcos_shoulder().clone();
        for (number, pose) in calibrated.session.poses.iter_mut().enumerate() {
            pose.conditions.time = Some(0.1 * number as f64);
            pose.course = Some(Arc::new(Course::of(&[])));
            pose.table = 0;
        }
        let windows = Some(Box::new(MotionWindows { length: 0.64, ..MotionWindows::default() }));
        let path = "moving.csv".into();
        calibrated.session.searched = vec![Searched { path, windows, ..Searched::default() }];
        calibrated
    }

    #[test]
    fn an_arm_in_motion_has_a_spectrum_for_each_joint_and_poses_have_none() {
        let rows = in_motion().read_back().rows();
        for joint in ["joint1", "joint2", "joint3"] {
            assert_eq!(rows[&format!("/spectra/{joint}")].get("static"), Some(&1), "{:?}", rows.keys());
        }
        let of_poses = Calibrated::sarcos_shoulder().read_back().rows();
        assert!(!of_poses.keys().any(|path| path.starts_with("/spectra")), "{:?}", of_poses.keys());
    }
}
