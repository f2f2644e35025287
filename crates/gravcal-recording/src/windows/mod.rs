//! An arm in motion as windows: weighted means of what the sensors read and of what the model says, over the same moments.
//!
//! The torque of an arm in motion depends on angles, velocities and accelerations, and only angles are read well. Whoever filters angles
//! and torques apart compares what belongs to different moments. So nothing is filtered before the model has been asked:
//!
//! ```text
//!     y_w = Σ_t h(t) y(t),   ŷ_w = Σ_s h(s) ŷ(θ(s), θ̇(s), θ̈(s)),      h(t) ∝ 1 + cos(2π (t − t_w)/L),   Σ h = 1
//! ```
//!
//! `t` are the moments at which the torque was sampled (each weighs as much as the time that it stands for), `s` moments, 25.6 steps a window: the
//! sum over a Hann window is then as good as the integral for all that is slower than `23/L`. A window of an arm that stands *is* a static pose, and its
//! torque that of the pose. Windows follow each other by `L/6.4`, a quarter of the period of their cut-off `1.6/L`.
//!
//! 1. Rows that repeat the one before are dropped; angles that wrap go on ([`unwrap`]); the clock is found ([`clock`]): recorders stamp
//!    late, or round.
//! 2. Where nothing is recorded for long, the recording falls into runs; no window goes over that.
//! 3. In each run a spline smooths the positions of each joint, as firmly as is most likely ([`spline`]), and tells velocities and accelerations.
//! 4. Windows ([`hann`]).
//!
//! **What a recorder did to torques.** Where it passed them through a filter and not the positions, the model's side passes one of the same
//! cut-off `f`, too: its window is a Hann window of `L` seen through one of `0.72/f`, which passes half of the power at `f`. Where torques come
//! late, their window is as much later.
//!
//! What a joint reads besides goes through the same window: the mean of the sign of its motion (`direction`; while it stands, that of its nearest
//! motion), of its velocity, of its acceleration; and, where it is asked for, how far friction has built up (`presliding.rs`).
//!
//! The recording is read once. Positions and torques are kept until the smoothing is done, 8 bytes a number.

mod clock;
mod course;
mod grid;
mod hann;
mod kept;
mod spline;
mod strays;
#[cfg(test)]
mod tests;
mod unwrap;
mod weight;

use std::path::Path;
use std::sync::Arc;

use crate::error::ReadError;
use crate::mapping::PoseMapping;
use crate::motion::channels::Channels;
use crate::motion::reader::{Part, Reader};
use crate::rows::Rows;
use crate::static_pose::StaticPose;
use clock::Recorded;

pub use clock::Clock;
pub use course::{Course, MotionSample, WeighedStretch};
pub use kept::Kept;
pub use strays::Stray;
pub use weight::FILTER_LENGTH;

/// How a recording becomes windows.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowRule {
    /// Length of a window, s.
    pub length: f64,
    /// Speed above which a joint moves, in each joint's position reading per second: below, friction has no known sign.
    pub moving: Vec<f64>,
    /// The joints whose friction builds up before they slide: that is followed then.
    pub presliding: Vec<usize>,
    /// A full turn in each joint's position reading; nothing of a joint that slides.
    pub turn: Vec<Option<f64>>,
    /// By how much torques come later than positions, s; negative where positions come later.
    pub torque_lag: f64,
    /// Cut-off of a filter that the recorder passed torques through and not positions: where half of the power passes (−3 dB), Hz.
    pub recorded_filter: Option<f64>,
    /// The part of the recording that counts.
    pub part: Part,
}

impl WindowRule {
    /// Length of what a window needs of a recording, s.
    fn reach(&self) -> f64 {
        let [before, after] = self.margins();
        before + self.length + after
    }

    /// How long before its start and after its end a window reaches, s.
    fn margins(&self) -> [f64; 2] {
        let filter = 0.5 * self.filter_length();
        [f64::max(filter, -self.torque_lag), f64::max(filter, self.torque_lag)]
    }

    /// Length of a Hann window of the recorder's cut-off, s.
    fn filter_length(&self) -> f64 {
        self.recorded_filter.map_or(0.0, |cut_off| FILTER_LENGTH / cut_off)
    }
}

/// The windows of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionWindows {
    /// In the order of the recording.
    pub found: Vec<MotionWindow>,
    /// Length of a window, s.
    pub length: f64,
    /// Which times were believed.
    pub clock: Clock,
    /// From sample to sample, s, on the median.
    pub interval: f64,
    /// Of each joint, what is left between its positions and the spline, in its position reading: standard deviation.
    pub position_noise: Vec<f64>,
    /// Of each joint, how often its reading wraps round to the other end of a turn.
    pub wraps: Vec<u64>,
    /// Rows that say the same as the row before, and were left out.
    pub repeated: u64,
    /// Rows that are zero in all columns behind one that is in none, as messages without content are, and were left out.
    pub empty: u64,
    /// Rows in which a joint is suddenly elsewhere and back in the next: its position is taken from the rows beside.
    pub strays: Vec<Stray>,
    /// Rows without a time, left out.
    pub without_time: u64,
    /// How often nothing was recorded for long.
    pub interruptions: u64,
    /// By how much torques were taken to come later than positions, s; see [`WindowRule`].
    pub torque_lag: f64,
    /// Cut-off of the filter that torques were taken to have passed, Hz.
    pub recorded_filter: Option<f64>,
    /// Columns whose readings go back and forth from row to row by more than their noise, as where two sources fill them by turns.
    pub alternating: Vec<String>,
}

impl MotionWindows {
    /// From window to window, s.
    pub fn step(&self) -> f64 {
        self.length / OVERLAP
    }

    /// Beyond it windows let little pass, Hz: of the amplitude there an eighth.
    pub fn cut_off(&self) -> f64 {
        CUT_OFF / self.length
    }
}

/// One window.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionWindow {
    /// Its means as if it were a standstill: torques, positions, conditions.
    pub pose: StaticPose,
    /// How the arm moved in it.
    pub course: Arc<Course>,
    /// First and last moment, s, on the recording's clock.
    pub interval: [f64; 2],
    /// Of each joint, by how much of the window's weight it did not move.
    pub resting: Vec<f64>,
    /// The same where it did not for longer than it takes to turn round, 0.1 s.
    pub standing: Vec<f64>,
}

/// A joint that is slow for longer, s, stands there, and does not turn round.
const TURNS_ROUND: f64 = 0.1;
/// Windows that begin in the length of one.
const OVERLAP: f64 = 6.4;
/// Cut-off of a window of 1 s, Hz.
const CUT_OFF: f64 = 1.6;
/// Fewer samples in a window than this tell no mean.
const FEWEST: f64 = 8.0;
/// By so much of itself the interval of rows may be longer than a clock would have it.
const ROUNDED: f64 = 1e-3;

/// Windows of a recording; see [`static_poses`](crate::static_poses) for `path` and `mapping`.
///
/// # Errors
///
/// The recording cannot be read, a column of the mapping is not in it, the mapping contradicts itself; no row has a time, the clock runs
/// backwards, samples are too rare for such windows, a joint jumps farther than it can move, or the recording is shorter than one.
///
/// # Panics
///
/// If the rule has not as many joints as the mapping.
pub fn motion_windows(
    path: &Path,
    rows: &mut dyn Rows,
    mapping: &PoseMapping,
    rule: &WindowRule,
) -> Result<MotionWindows, ReadError> {
    mapping.check()?;
    assert_eq!(rule.moving.len(), mapping.positions.len(), "one speed for each joint");
    assert_eq!(rule.turn.len(), mapping.positions.len(), "a turn or none for each joint");
    let mut reader = Reader::new(path, rows, Channels::new(mapping), rule.part);
    let mut recorded = Recorded::new(reader.channels.joints, reader.channels.list.len(), reader.channels.tested());
    while let Some((time, row)) = reader.next()? {
        recorded.push(time, row, &reader.values).map_err(|(before, after)| ReadError::ClockRunsBackwards {
            path: path.to_owned(),
            column: reader.channels.clock().to_owned(),
            row,
            before,
            after,
        })?;
    }
    reader.check_dates()?;
    reader.check_columns()?;
    recorded.spread_equal_times();
    let path = || path.to_owned();
    let Some(interval) = recorded.interval() else {
        return Err(reader.nothing_recorded());
    };
    // Clocks are rounded.
    if interval * FEWEST > rule.length * (1.0 + ROUNDED) {
        return Err(ReadError::TooSlowForWindows {
            path: path(),
            clock: Box::new(reader.clock()),
            length: rule.length,
            least: FEWEST * interval,
            rate: FEWEST / rule.length,
        });
    }
    let strays = strays::take_from_neighbours(&mut recorded, &rule.turn);
    let names = || reader.channels.list.iter().map(|channel| channel.column.as_str());
    let wraps = unwrap::unwrap(&mut recorded, &rule.turn).map_err(|jump| ReadError::PositionJumps {
        path: path(),
        row: jump.row,
        column: names().nth(jump.joint).unwrap_or_default().to_owned(),
        turns: jump.turns,
    })?;
    let clock = recorded.find_clock();
    let splines = spline::of_joints(&recorded, rule.reach());
    let mut windows = MotionWindows {
        length: rule.length,
        clock,
        interval,
        position_noise: splines.noise.clone(),
        wraps,
        repeated: recorded.repeated,
        empty: recorded.empty,
        strays,
        without_time: reader.without_time,
        interruptions: splines.runs.len().saturating_sub(1) as u64,
        torque_lag: rule.torque_lag,
        recorded_filter: rule.recorded_filter,
        found: Vec::new(),
        alternating: reader.alternating(),
    };
    for run in &splines.runs {
        hann::windows(&recorded, &splines, run, &reader.channels, rule, &mut windows.found);
    }
    if windows.found.is_empty() {
        return Err(ReadError::ShorterThanWindow {
            path: path(),
            length: rule.reach(),
            clock: Box::new(reader.clock()),
        });
    }
    Ok(windows)
}
