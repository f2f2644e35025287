//! Slow sweeps in a recording: one joint moves slowly in both directions while the others stand, and each angle that it passes both ways
//! is a static pose.
//!
//! A joint that moves at constant speed reads gravity and friction, which has the sign of the motion:
//!
//! ```text
//!     y(θ, ±) = k τ(θ) + b ± f(θ)
//!     mean            (y₊ + y₋) / 2 = k τ(θ) + b        the reading of the pose at rest
//!     half difference (y₊ − y₋) / 2 = f(θ)              friction, in the unit of the reading
//! ```
//!
//! 1. Blocks of samples in which one joint moves one way, and no other by more than half a bin, are a stroke ([`stroke`]). It has bins of
//!    the joint's angle; in each the straight line through the blocks gives the readings at its centre ([`line`]), so that both
//!    directions are compared at one angle; what readings bend within a bin is taken off ([`bend`]).
//! 2. Inertia acts both ways alike, so it does not cancel: a bin counts where the joint's acceleration, and its speed squared (by which it
//!    acts on the other joints), are small, and the speed is that of its neighbours. That leaves out the bins near turning points.
//! 3. Strokes of one joint with the others at one place are a sweep; bins that were passed both ways are its poses ([`pair`]).
//! 4. The scatter of the blocks about their lines, of all bins together, with the correlation from block to block, gives
//!    standard errors ([`noise`]).
//!
//! A joint that stands holds friction, too, of any size up to `f` and the same all through a sweep: what it reads while others sweep is off by that
//! ([`Sweep::shown_friction`]).
//!
//! What the half difference holds besides friction: where the position lags behind the torque by a time `δ`, or the gear has backlash,
//! the directions see the arm at different angles, which adds `k τ′(θ) θ̇ δ`; in the mean that cancels. A ripple of the torque whose
//! period is many bins is the same both ways, and stays in the mean.

mod bend;
mod line;
mod noise;
mod pair;
mod stroke;
#[cfg(test)]
mod tests;

use std::fmt;
use std::path::Path;

use crate::error::ReadError;
use crate::mapping::PoseMapping;
use crate::motion::channels::Channels;
use crate::motion::reader::{Part, Reader};
use crate::motion::row_clock::RowClock;
use crate::motion::sampler::Sampler;
use crate::rows::Rows;
use stroke::Strokes;

pub use pair::{Sweep, SweptBin};

/// What a slow sweep is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepRule {
    /// Width of a bin, rad.
    pub bin: f64,
    /// How wide bins may become where they hold too few samples, rad; not at all where it is less than twice `bin`.
    pub widest: f64,
    /// Largest acceleration of the joint, and largest square of its speed, rad/s².
    pub acceleration: f64,
    /// How each joint's reading becomes its coordinate.
    pub travel: Vec<Travel>,
    /// The part of the recording that counts.
    pub part: Part,
}

/// How far a joint travels for each unit of its position reading, roughly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Travel {
    /// rad; only such joints sweep.
    Turns(f64),
    /// m.
    Slides(f64),
}

/// The widest bin that nobody must ask for, rad. What a sinusoid bends within 4° is a 5,000th of its amplitude, which is taken off but for a
/// fifth at the ends of a sweep: a 25,000th.
pub const WIDEST_BIN: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// A joint that slides less than this stands, m.
const SLIDES: f64 = 1e-3;

impl SweepRule {
    /// Half a bin (or a millimetre) in the reading of each joint: what moves less stands.
    fn tolerances(&self) -> Vec<f64> {
        let of = |travel: &Travel| match travel {
            Travel::Turns(scale) => 0.5 * self.bin / scale,
            Travel::Slides(scale) => SLIDES / scale,
        };
        self.travel.iter().map(of).collect()
    }
}

/// The slow sweeps of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweeps {
    /// In the order of the recording.
    pub found: Vec<Sweep>,
    /// Strokes of which nothing is used.
    pub rejected: Vec<RejectedStroke>,
    /// Rows that say the same as the row before at the same time, and were left out.
    pub repeated: u64,
    /// Rows without a time, left out.
    pub without_time: u64,
    /// How often the clock jumped, or nothing was recorded for long; no stroke goes over that.
    pub interruptions: u64,
    /// How rows come by the clock.
    pub clock: RowClock,
    /// Step of each joint's position reading, SI or the sensor's own unit; 0 where none is seen.
    pub position_steps: Vec<f64>,
    /// Columns whose readings go back and forth from row to row by more than their noise, as where two sources fill them by turns.
    pub alternating: Vec<String>,
}

/// A stroke of which nothing is used.
#[derive(Clone, Debug, PartialEq)]
pub struct RejectedStroke {
    /// Its first and last time, s, on the recording's clock.
    pub interval: [f64; 2],
    /// Column of the joint's position.
    pub column: String,
    /// Why.
    pub reason: StrokeReason,
}

/// Why nothing of a stroke is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StrokeReason {
    /// There is none the other way with the other joints at the same place.
    OneWay,
    /// It is nowhere slow and steady enough.
    Unsteady,
    /// Its bins hold too few samples.
    Sparse(SparseBins),
}

/// Why bins hold too few samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SparseBins {
    /// Of the joint, rad/s.
    pub speed: f64,
    /// Of samples, Hz.
    pub rate: f64,
    /// Width of a bin, rad.
    pub bin: f64,
    /// How many samples a bin holds at this speed and rate.
    pub samples: f64,
    /// How many it must hold.
    pub fewest: f64,
    /// Width of a bin that holds enough, rad.
    pub enough: f64,
}

impl fmt::Display for RejectedStroke {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self.reason {
            StrokeReason::OneWay => {
                "has no stroke the other way over these angles with the other joints where they are".to_owned()
            }
            StrokeReason::Unsteady => "is nowhere slow and steady enough".to_owned(),
            StrokeReason::Sparse(bins) => format!("has too few samples in a bin: {bins}"),
        };
        write!(f, "{:.2} to {:.2} s, the stroke of `{}` {reason}", self.interval[0], self.interval[1], self.column)
    }
}

impl fmt::Display for SparseBins {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SparseBins { speed, rate, bin, samples, fewest, enough } = *self;
        let [speed_deg_per_s, bin_deg, enough_deg] = [speed, bin, enough].map(f64::to_degrees);
        write!(
            f,
            "at {speed_deg_per_s:.1} deg/s and {rate:.0} Hz, one of {} deg holds {samples:.0}, and {:.0} are needed; ",
            rounded(bin_deg),
            fewest.round()
        )?;
        if enough <= WIDEST_BIN {
            return write!(
                f,
                "set readings.sweeps.bin_deg = {}, or move more slowly",
                (10.0 * enough_deg).ceil() / 10.0
            );
        }
        let slower = WIDEST_BIN / enough;
        write!(
            f,
            "move at {} deg/s or less, or record at {:.0} Hz or more",
            (10.0 * slower * speed_deg_per_s).floor() / 10.0,
            (rate / slower).ceil()
        )
    }
}

/// Without the last digits, which are those of a conversion.
fn rounded(number: f64) -> f64 {
    (1e6 * number).round() / 1e6
}

/// Finds the slow sweeps in a recording; see [`static_poses`](crate::static_poses) for `path` and `mapping`.
///
/// # Errors
///
/// The recording cannot be read, a column of the mapping is not in it, the mapping contradicts itself, or no row has a time.
///
/// # Panics
///
/// If the rule has not as many joints as the mapping.
pub fn slow_sweeps(
    path: &Path,
    rows: &mut dyn Rows,
    mapping: &PoseMapping,
    rule: &SweepRule,
) -> Result<Sweeps, ReadError> {
    mapping.check()?;
    assert_eq!(rule.travel.len(), mapping.positions.len(), "one travel for each joint");
    let mut reader = Reader::new(path, rows, Channels::new(mapping), rule.part);
    let (first, interval) = reader.first()?;
    let mut sampler = Sampler::new(&reader.channels, &first, interval);
    let mut strokes = Strokes::new(&reader.channels, rule, interval);
    sampler.take_first(&first, reader.values.len(), &mut |heard| strokes.hear(heard));
    drop(first);
    while let Some((time, row)) = reader.next()? {
        sampler.take(time, row, &reader.values, &mut |heard| strokes.hear(heard));
    }
    reader.check_columns()?;
    sampler.finish(&mut |heard| strokes.hear(heard));
    let position_steps = sampler.scales.quantum[..reader.channels.joints].to_vec();
    let (strokes, mut rejected) = strokes.finish();
    let found = pair::sweeps(strokes, &reader.channels, rule, &mut rejected);
    rejected.sort_by(|a, b| a.interval[0].total_cmp(&b.interval[0]));
    Ok(Sweeps {
        found,
        rejected,
        repeated: sampler.usage.repeated,
        without_time: reader.without_time,
        interruptions: sampler.usage.interruptions,
        clock: reader.clock(),
        position_steps,
        alternating: reader.alternating(),
    })
}
