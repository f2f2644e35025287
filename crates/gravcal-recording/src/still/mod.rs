//! Static poses in a recording in motion: where the arm stands, and what its sensors say there.
//!
//! Nobody need say how noisy a sensor is, how fast it is sampled or how long the arm stands: the recording says it. It is read
//! once, from its beginning to its end, in memory that does not grow with its length:
//!
//! 1. Samples become blocks of a hundredth of a second, outliers left out ([`crate::motion::block`]).
//! 2. Low quantiles over the blocks say how noisy each channel is when nothing moves ([`crate::motion::rough_noise`]).
//! 3. Blocks in which every joint stays are a run ([`run`]); the side from which each joint came is known ([`crate::motion::approach`]).
//! 4. Many runs together say how noisy means are, by how long they are ([`mean_noise`]).
//! 5. Each run is judged ([`judge`], by [`series`] of means): its beginning is cut off while it settles, its end where the next motion begins; it is
//!    rejected, with the reason, where it moves, creeps or was touched.
//! 6. Where joints turn round the arm stands for a moment: what is much shorter than the others is left out ([`standstill`]).
//! 7. All standstills together say what is left of settling in their means ([`settling`]), and how many independent samples each mean is worth ([`autocorrelation`], [`converter`]).
//!
//! Standard errors hold noise with its autocorrelation, what a converter's step leaves of its error where noise does not smooth
//! it, and a drift that may be one. They do not hold what is the same during a standstill (friction, deflection, hysteresis), nor what is the same in all of them, as what is left of
//! settling is: [`Standstills::torque_settling`] tells that. Noise
//! whose correlation lasts as long as a standstill cannot be told from a constant.

mod autocorrelation;
mod converter;
mod judge;
mod mean_noise;
mod rejected;
mod run;
mod segments;
mod series;
mod settling;
mod standstill;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::error::ReadError;
use crate::mapping::PoseMapping;
use crate::motion::channels::Channels;
use crate::motion::reader::{Part, Reader};
use crate::motion::row_clock::RowClock;
use crate::rows::Rows;
use segments::Segments;
use standstill::{Assessed, Assessment};

pub use rejected::{Reason, Rejected};
pub use settling::{RemainingSettling, Settling};
pub use standstill::{Spread, Standstill};

/// What a standstill is, beyond what the recording says itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stillness {
    /// Shortest standstill, s, and never less than a few dozen samples. Without it a tenth of a second, and a third of the median of what is
    /// found: where joints turn round an arm stands for a moment, and holds the friction of motion.
    pub least_duration: Option<f64>,
    /// The part of the recording that counts.
    pub part: Part,
}

/// Shortest standstill, s, where nothing is said.
const LEAST_DURATION: f64 = 0.1;

/// The standstills of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standstills {
    /// In the order of the recording.
    pub found: Vec<Standstill>,
    /// What is left of settling in the means of each torque, by joint; of what is not read, nothing.
    pub torque_settling: Vec<Settling>,
    /// The same of each reading of an instrument.
    pub instrument_settling: Vec<Settling>,
    /// What seemed to be standstills and is none.
    pub rejected: Vec<Rejected>,
    /// How often each joint hardly moved, and moved on before it stood long enough to be looked at.
    pub moved_on: Vec<u64>,
    /// Rows with a time, from first to last, without those left out by [`Stillness`].
    pub rows: u64,
    /// Rows that say the same as the row before at the same time, and were left out.
    pub repeated: u64,
    /// Rows without a time, left out.
    pub without_time: u64,
    /// How often the clock jumped, or nothing was recorded for long; no standstill goes over that.
    pub interruptions: u64,
    /// Median time between two samples of the slowest column, s.
    pub interval: f64,
    /// How rows come by the clock.
    pub clock: RowClock,
    /// How often each joint's position jumps by about a full turn from row to row, as an angle that wraps; 0 of other units than rad and deg.
    pub wraps: Vec<u64>,
    /// Columns whose readings go back and forth from row to row by more than their noise, as where two sources fill them by turns.
    pub alternating: Vec<String>,
}

/// Finds the standstills in a recording. `path`: its name in errors; `mapping` as for a table of poses, its time the column
/// `time_s` where it names none. It says neither deviations nor counts of samples: these are found.
///
/// # Errors
///
/// The recording cannot be read, a column of the mapping is not in it, the mapping contradicts itself, or no row has a time.
pub fn static_poses(
    path: &Path,
    rows: &mut dyn Rows,
    mapping: &PoseMapping,
    stillness: &Stillness,
) -> Result<Standstills, ReadError> {
    mapping.check()?;
    let mut reader = Reader::new(path, rows, Channels::new(mapping), stillness.part);
    let (first, interval) = reader.first()?;
    let mut segments = Segments::new(&reader.channels, &first, interval);
    let least = stillness.least_duration.unwrap_or(LEAST_DURATION);
    let mut assessment = Assessment::new(&reader.channels, least);
    let mut runs = Vec::new();
    segments.take_first(&first, reader.values.len(), &mut runs);
    drop(first);
    while let Some((time, row)) = reader.next()? {
        segments.take(time, row, &reader.values, &mut runs);
        if !runs.is_empty() {
            assessment.take(&mut runs, &reader.channels, &segments);
        }
    }
    reader.check_columns()?;
    segments.finish(&mut runs);
    assessment.take(&mut runs, &reader.channels, &segments);
    let Assessed { found, rejected, torque_settling, instrument_settling } =
        assessment.finish(&reader.channels, &segments, stillness.least_duration.is_some());
    Ok(Standstills {
        found,
        torque_settling,
        instrument_settling,
        rejected,
        moved_on: segments.moved_on().to_vec(),
        rows: segments.sampler.usage.samples + segments.sampler.usage.repeated,
        repeated: segments.sampler.usage.repeated,
        without_time: reader.without_time,
        interruptions: segments.sampler.usage.interruptions,
        interval,
        clock: reader.clock(),
        wraps: reader.wraps.counts(),
        alternating: reader.alternating(),
    })
}
