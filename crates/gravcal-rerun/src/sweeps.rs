//! Each sweep's readings over the angle of the joint that sweeps, with what was predicted: a picture with one panel a channel.
//!
//! A panel is [`PANEL`] wide and high; y grows downwards in Rerun's pictures. A picture stands from the first pose of its sweep to the
//! last, on the timeline `pose`.

use std::collections::BTreeMap;

use gravcal_robot_model::Session;
use gravcal_robot_model::session::ReadingId;
use gravcal_robot_model::sweeps::{Sweep, find_sweeps};
use re_sdk::{RecordingStream, RecordingStreamError};
use re_sdk_types::archetypes::{LineStrips2D, Points2D};
use re_sdk_types::components::Radius;

use crate::arm::{coordinates, position_sensors};
use crate::contents::CalibrationRecording;
use crate::explanation::Explanation;
use crate::plot::{sequence, to_time};
use crate::style;

/// Width and height of a panel, and from one to the next, in units of the picture.
const PANEL: [f64; 2] = [160.0, 90.0];
const PITCH: [f64; 2] = [190.0, 125.0];
/// How many times more columns of panels there are than rows.
const ASPECT: f64 = 1.7;

/// Logs a picture for each sweep of the session.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    let sweeps = find_sweeps(calibration.session);
    let channels = calibration.channels();
    for (index, sweep) in sweeps.iter().enumerate() {
        let picture = Picture::of(calibration, sweep, &channels);
        stream.set_time_sequence("pose", to_time(sweep.poses[0]));
        picture.log(stream, calibration)?;
        let after = ends(sweep)[1] + 1;
        if sweeps.get(index + 1).is_none_or(|next| next.poses[0] > after) && after < calibration.session.poses.len() {
            stream.set_time_sequence("pose", to_time(after));
            clear(stream, calibration)?;
        }
    }
    stream.reset_time();
    Ok(())
}

/// Takes the picture away.
fn clear(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    for points in ["/sweeps/captions", "/sweeps/measured", "/sweeps/now"] {
        stream.log(points, &Points2D::clear_fields())?;
    }
    stream.log("/sweeps/frame", &LineStrips2D::clear_fields())?;
    for explanation in calibration.explanations() {
        stream.log(re_sdk::entity_path!["sweeps", explanation.name], &LineStrips2D::clear_fields())?;
    }
    Ok(())
}

/// One sweep.
struct Picture<'a> {
    sweep: &'a Sweep,
    title: String,
    /// Poses in the order of the angle, which stands beside them, in degrees.
    angles: Vec<(usize, f64)>,
    panels: Vec<Panel>,
}

/// What one channel reads during the sweep.
struct Panel {
    caption: String,
    channel: usize,
    /// Lower left corner in the picture.
    corner: [f64; 2],
    /// Ends of the axes, degrees and units of the reading.
    horizontal: [f64; 2],
    vertical: [f64; 2],
}

impl<'a> Picture<'a> {
    fn of(calibration: &CalibrationRecording<'_>, sweep: &'a Sweep, channels: &[usize]) -> Picture<'a> {
        let session = calibration.session;
        let sensors = position_sensors(calibration);
        let angle = |pose: &usize| (*pose, coordinates(calibration, &sensors, *pose)[sweep.swept].to_degrees());
        let mut angles: Vec<(usize, f64)> = sweep.poses.iter().map(angle).collect();
        angles.sort_by(|a, b| a.1.total_cmp(&b.1));
        let horizontal = range(angles.iter().map(|(_, angle)| *angle)).unwrap_or([0.0, 1.0]);
        let columns = (ASPECT * channels.len() as f64).sqrt().ceil().max(1.0) as usize;
        let panel = |(place, channel): (usize, &usize)| {
            let numbers = values(calibration, sweep, *channel);
            let vertical = range(numbers.into_iter())?;
            let unit = session.channel_unit(*channel);
            Some(Panel {
                caption: format!(
                    "{}: {} … {} {unit}",
                    session.channel_name(*channel),
                    short(vertical[0]),
                    short(vertical[1])
                ),
                channel: *channel,
                corner: [PITCH[0] * (place % columns) as f64, PITCH[1] * (place / columns) as f64],
                horizontal,
                vertical,
            })
        };
        let panels = channels.iter().enumerate().filter_map(panel).collect();
        let swept = &session.robot.chain.joints()[sweep.swept].name;
        let load = sweep.load.map_or("nothing attached".into(), |load| session.loads[load].name.clone());
        let title = format!("{swept} sweeps {:.0}° … {:.0}°, {load}", horizontal[0], horizontal[1]);
        Picture { sweep, title, angles, panels }
    }

    fn log(
        &self,
        stream: &RecordingStream,
        calibration: &CalibrationRecording<'_>,
    ) -> Result<(), RecordingStreamError> {
        self.log_frame(stream)?;
        let readings = self.panels.iter().flat_map(|panel| {
            let read =
                |(pose, angle): &(usize, f64)| Some(panel.place(*angle, panel.reading(calibration.session, *pose)?));
            self.angles.iter().filter_map(read)
        });
        let dots = Points2D::new(readings.collect::<Vec<_>>()).with_colors([style::colour(style::MEASURED)]);
        stream.log("/sweeps/measured", &dots.with_radii([Radius::new_ui_points(2.0)]))?;
        for explanation in calibration.explanations() {
            let line = |panel| self.line(panel, calibration.session, &explanation);
            let lines = LineStrips2D::new(self.panels.iter().map(line).collect::<Vec<_>>());
            let lines = lines.with_colors([style::of(explanation.name)]).with_radii([Radius::new_ui_points(1.2)]);
            stream.log(re_sdk::entity_path!["sweeps", explanation.name], &lines)?;
        }
        self.log_now(stream, calibration)
    }

    fn line(&self, panel: &Panel, session: &Session, explanation: &Explanation<'_>) -> Vec<[f32; 2]> {
        let reported = explanation.between(ends(self.sweep), panel.channel);
        let reported: BTreeMap<usize, f64> = reported.map(|one| (one.pose, one.residual)).collect();
        let point = |(pose, angle): &(usize, f64)| {
            Some(panel.place(*angle, panel.reading(session, *pose)? + reported.get(pose)?))
        };
        self.angles.iter().filter_map(point).collect()
    }

    fn log_frame(&self, stream: &RecordingStream) -> Result<(), RecordingStreamError> {
        let boxes: Vec<Vec<[f32; 2]>> = self.panels.iter().map(Panel::frame).collect();
        let frame = LineStrips2D::new(boxes).with_colors([style::colour(style::FRAME)]);
        stream.log("/sweeps/frame", &frame.with_radii([Radius::new_ui_points(0.5)]))?;
        let places =
            self.panels.iter().map(|panel| panel.above(18.0)).chain(self.panels.first().map(|p| p.above(38.0)));
        // The title stands above the captions.
        let texts = self.panels.iter().map(|panel| panel.caption.clone()).chain([self.title.clone()]);
        let captions = Points2D::new(places.collect::<Vec<_>>())
            .with_labels(texts.collect::<Vec<_>>())
            .with_show_labels(true)
            .with_radii([0.0])
            .with_colors([style::colour(style::FRAME)]);
        stream.log("/sweeps/captions", &captions)
    }

    /// Where each pose of the sweep is in each panel, as columns.
    fn log_now(
        &self,
        stream: &RecordingStream,
        calibration: &CalibrationRecording<'_>,
    ) -> Result<(), RecordingStreamError> {
        let mut by_pose = self.angles.clone();
        by_pose.sort_by_key(|(pose, _)| *pose);
        let marks = |(pose, angle): &(usize, f64)| {
            let read = |panel: &Panel| Some(panel.place(*angle, panel.reading(calibration.session, *pose)?));
            self.panels.iter().filter_map(read).collect::<Vec<_>>()
        };
        let marks: Vec<Vec<[f32; 2]>> = by_pose.iter().map(marks).collect();
        let lengths: Vec<usize> = marks.iter().map(Vec::len).collect();
        let dots = Points2D::update_fields().with_positions(marks.concat());
        let times = [sequence("pose", by_pose.iter().map(|(pose, _)| *pose))];
        stream.send_columns("/sweeps/now", times, dots.columns(lengths)?)?;
        let look = Points2D::update_fields().with_colors([style::colour(style::NOW)]);
        stream.log_static("/sweeps/now", &look.with_radii([Radius::new_ui_points(4.0)]))
    }
}

impl Panel {
    /// What its channel reads in a pose.
    fn reading(&self, session: &Session, pose: usize) -> Option<f64> {
        Some(session.reading(ReadingId { pose, channel: self.channel })?.value)
    }

    /// Place of an angle, degrees, and a reading.
    fn place(&self, angle: f64, reading: f64) -> [f32; 2] {
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        let x = self.corner[0] + PANEL[0] * share(angle, self.horizontal);
        let y = self.corner[1] - PANEL[1] * share(reading, self.vertical);
        [x as f32, y as f32]
    }

    /// A point this far above the panel.
    fn above(&self, distance: f64) -> [f32; 2] {
        [(self.corner[0] + 0.5 * PANEL[0]) as f32, (self.corner[1] - PANEL[1] - distance) as f32]
    }

    fn frame(&self) -> Vec<[f32; 2]> {
        let [[left, right], [low, high]] = [self.horizontal, self.vertical];
        [(left, low), (right, low), (right, high), (left, high), (left, low)].map(|(x, y)| self.place(x, y)).into()
    }
}

/// All numbers of one channel in a sweep: readings and predictions.
fn values(calibration: &CalibrationRecording<'_>, sweep: &Sweep, channel: usize) -> Vec<f64> {
    let reading = |pose: usize| Some(calibration.session.reading(ReadingId { pose, channel })?.value);
    let readings = sweep.poses.iter().filter_map(|pose| reading(*pose));
    let explanations = calibration.explanations();
    let reported = explanations.iter().flat_map(|explanation| explanation.between(ends(sweep), channel));
    readings.chain(reported.filter_map(|one| Some(reading(one.pose)? + one.residual))).collect()
}

/// First and last pose.
fn ends(sweep: &Sweep) -> [usize; 2] {
    [sweep.poses[0], sweep.poses[sweep.poses.len() - 1]]
}

/// A number with four digits or so.
fn short(number: f64) -> String {
    let decimals = (3 - number.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{number:.decimals$}")
}

/// Smallest and largest number, apart; nothing where there is none.
fn range(numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let widen = |[low, high]: [f64; 2], number: f64| [low.min(number), high.max(number)];
    let [low, high] = numbers.map(|number| [number, number]).reduce(|a, b| widen(a, b[0]))?;
    Some(if high > low { [low, high] } else { [low - 0.5, low + 0.5] })
}
