//! Runs are judged, and standstills become static poses.

use super::autocorrelation::Autocorrelation;
use super::converter::rounding_of_readings;
use super::judge::{Dwell, Judge, Standing};
use super::mean_noise::MeanNoise;
use super::rejected::{Reason, Rejected};
use super::run::Run;
use super::segments::Segments;
use super::settling::{Courses, Settling};
use crate::conditions::Conditions;
use crate::motion::block::Sum;
use crate::motion::channels::Channels;
use crate::motion::median;
use crate::motion::rough_noise::Scales;
use crate::static_pose::{Reading, StaticPose};

/// Runs that are judged together.
const BATCH: usize = 64;
/// A joint that is back where it was within this time, s, was not sent away.
const BACK: f64 = 0.5;
/// Part of the median duration below which a standstill is a moment in which joints turn round: a move of least jerk over d rad in T s stays
/// within x of its end for about T (x / 10 d)^(1/3), a tenth of T for a thousandth of the way.
const BRIEF: f64 = 1.0 / 3.0;
/// Fewest standstills that have a median.
const LEAST_STANDSTILLS: usize = 5;
/// Part of the samples at an end of the range from which on their mean says nothing.
const SATURATED: f64 = 0.01;

/// One standstill.
#[derive(Clone, Debug, PartialEq)]
pub struct Standstill {
    /// Its first and last time, s, on the recording's clock: settled, and before the next motion.
    pub interval: [f64; 2],
    /// Means of all readings, with standard errors as `std`; `line` is the row in the file at which it begins, `merged` the number
    /// of samples.
    pub pose: StaticPose,
    /// What the mean position of each joint is worth.
    pub position: Vec<Spread>,
    /// The same of each torque reading.
    pub torque: Vec<Option<Spread>>,
    /// The same of each reading of an instrument.
    pub instruments: Vec<Option<Spread>>,
}

/// What a mean over a standstill is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Number of samples that count.
    pub samples: f64,
    /// As many independent samples would have the same standard error.
    pub effective: f64,
    /// Standard deviation of a sample, unit of the reading.
    pub std: f64,
    /// Standard error of the mean, unit of the reading.
    pub standard_error: f64,
    /// Change from beginning to end along the straight line, unit of the reading.
    pub drift: f64,
}

/// Judges runs, as many together as are needed to know their noise.
pub(super) struct Assessment {
    least_duration: f64,
    batch: Vec<Run>,
    noise: MeanNoise,
    autocorrelation: Autocorrelation,
    /// By channel.
    courses: Vec<Courses>,
    found: Vec<Unfinished>,
    rejected: Vec<Rejected>,
    before: Option<Before>,
}

/// What all runs come to.
pub(super) struct Assessed {
    pub found: Vec<Standstill>,
    pub rejected: Vec<Rejected>,
    /// By joint, and by reading of an instrument.
    pub torque_settling: Vec<Settling>,
    pub instrument_settling: Vec<Settling>,
}

/// A standstill whose standard errors are not yet known.
struct Unfinished {
    interval: [f64; 2],
    row: u64,
    tested: Vec<Standing>,
    /// Of the channels that need not stand.
    others: Vec<Sum>,
    direction: Vec<f64>,
}

/// What all standstills say of a channel.
struct Common {
    /// Integrated autocorrelation time, samples.
    time: f64,
    /// Mean square error that rounding leaves in a mean.
    rounding: f64,
}

/// The run before.
struct Before {
    until: f64,
    level: Vec<f64>,
    /// The joint that ended it.
    left_by: Option<usize>,
    interval: [f64; 2],
    was_found: bool,
}

impl Assessment {
    pub fn new(channels: &Channels, least_duration: f64) -> Assessment {
        Assessment {
            least_duration,
            batch: Vec::new(),
            noise: MeanNoise::new(channels.tested()),
            autocorrelation: Autocorrelation::new(channels.tested()),
            courses: vec![Courses::default(); channels.tested()],
            found: Vec::new(),
            rejected: Vec::new(),
            before: None,
        }
    }

    /// Takes runs, and judges them once there are enough.
    pub fn take(&mut self, runs: &mut Vec<Run>, channels: &Channels, segments: &Segments) {
        self.batch.append(runs);
        if self.batch.len() >= BATCH {
            self.judge(channels, segments);
        }
    }

    /// What is left of settling in the means of these channels.
    fn settling(&self, channels: &[Option<usize>]) -> Vec<Settling> {
        let of_channel =
            |channel: &Option<usize>| channel.map_or_else(Settling::default, |it| self.courses[it].settling());
        channels.iter().map(of_channel).collect()
    }

    /// Standstills with their standard errors, and what is none. `brief`: whether such as are much shorter than others count.
    pub fn finish(mut self, channels: &Channels, segments: &Segments, brief: bool) -> Assessed {
        self.judge(channels, segments);
        if !brief {
            self.leave_out_brief();
        }
        let common: Vec<Common> =
            (0..channels.tested()).map(|channel| self.common(channel, segments.scales())).collect();
        Assessed {
            found: self.found.iter().map(|unfinished| unfinished.finish(channels, &common)).collect(),
            torque_settling: self.settling(&channels.torques),
            instrument_settling: self.settling(&channels.instruments),
            rejected: self.rejected,
        }
    }

    /// Where joints turn round the arm stands for a moment, and friction is what it is in motion.
    fn leave_out_brief(&mut self) {
        if self.found.len() < LEAST_STANDSTILLS {
            return;
        }
        let usual = median(self.found.iter().map(Unfinished::duration).collect());
        let (long, brief) =
            std::mem::take(&mut self.found).into_iter().partition(|found| found.duration() >= BRIEF * usual);
        self.found = long;
        let rejected = |found: Unfinished| Rejected { interval: found.interval, reason: Reason::Brief { usual } };
        self.rejected.extend(brief.into_iter().map(rejected));
        self.rejected.sort_by(|a, b| a.interval[0].total_cmp(&b.interval[0]));
    }

    fn common(&self, channel: usize, scales: &Scales) -> Common {
        let variances = || self.found.iter().map(|found| variance(&found.tested[channel].sum));
        let mean = variances().sum::<f64>() / self.found.len() as f64;
        // Readings that do not change at all in a standstill are on a grid, even if motion is too fast to show it.
        let constant = scales.quantum[channel] == 0.0 && variances().any(|variance| variance == 0.0);
        let step = if constant { scales.least_step[channel] } else { scales.quantum[channel] };
        Common { time: self.autocorrelation.time(channel), rounding: rounding_of_readings(step, mean) }
    }

    fn judge(&mut self, channels: &Channels, segments: &Segments) {
        let runs = std::mem::take(&mut self.batch);
        runs.iter().for_each(|run| self.noise.hear(run));
        let (tested, samples) = (channels.tested(), segments.sampler.samples_per_block);
        let judge = Judge {
            columns: channels.list[..tested].iter().map(|channel| channel.column.as_str()).collect(),
            joints: channels.joints,
            curves: self.noise.curves(segments.scales().mean[..tested].iter().map(|noise| (*noise, samples))),
            scales: segments.scales(),
            least_duration: self.least_duration,
        };
        for run in &runs {
            let judged = judge.judge(run);
            self.keep(run, judged, channels, segments.gates());
        }
    }

    fn keep(&mut self, run: &Run, judged: Result<Option<Dwell>, Rejected>, channels: &Channels, gates: &[f64]) {
        let interval = match &judged {
            Ok(None) => return,
            Ok(Some(dwell)) => [run.blocks[dwell.blocks.start].from, run.blocks[dwell.blocks.end - 1].until],
            Err(rejected) => rejected.interval,
        };
        let level: Vec<f64> = (0..channels.joints).map(|joint| mean_of(run, joint)).collect();
        let back = self.before.take().filter(|before| {
            let same = before.level.iter().zip(&level).zip(gates).all(|((a, b), gate)| (a - b).abs() <= *gate);
            same && before.was_found
                && !run.interrupted[0]
                && (0.0..BACK).contains(&(run.blocks[0].from - before.until))
        });
        let touched = back.as_ref().and_then(|before| Some((before.left_by?, before.until)));
        if let Some((joint, at)) = touched {
            let reason = || Reason::Touched { column: channels.list[joint].column.clone(), at };
            if let Some(before) = back {
                self.found.pop();
                self.rejected.push(Rejected { interval: before.interval, reason: reason() });
            }
            self.rejected.push(Rejected { interval, reason: reason() });
        }
        let mut was_found = false;
        match judged {
            _ if touched.is_some() => {}
            Ok(Some(dwell)) => {
                was_found = true;
                self.find(run, dwell, interval, channels);
            }
            Ok(None) => {}
            Err(rejected) => self.reject(rejected),
        }
        let until = run.blocks.last().map_or(interval[1], |block| block.until);
        let left_by = run.left_by.filter(|_| !run.interrupted[1]);
        self.before = Some(Before { until, level, left_by, interval, was_found });
    }

    /// A slow motion is many runs: it is told once.
    fn reject(&mut self, rejected: Rejected) {
        let moving = |reason: &Reason| match reason {
            Reason::Moving { column } | Reason::Short { joint: column, .. } => Some(column.clone()),
            _ => None,
        };
        match self.rejected.last_mut() {
            Some(last)
                if moving(&last.reason).is_some()
                    && moving(&last.reason) == moving(&rejected.reason)
                    && (0.0..BACK).contains(&(rejected.interval[0] - last.interval[1])) =>
            {
                last.interval[1] = rejected.interval[1];
                // What goes on from one run to the next is no standstill that is too short.
                last.reason = moving(&last.reason).map_or(rejected.reason, |column| Reason::Moving { column });
            }
            _ => self.rejected.push(rejected),
        }
    }

    fn find(&mut self, run: &Run, dwell: Dwell, interval: [f64; 2], channels: &Channels) {
        for (channel, standing) in dwell.channels.iter().enumerate() {
            self.autocorrelation.take(channel, &standing.windows, run.doublings, variance(&standing.sum));
        }
        for (joint, torque) in channels.torques.iter().enumerate() {
            if let Some(channel) = *torque {
                self.courses[channel].take(channel, run, &dwell.blocks, run.direction.get(joint).copied());
            }
        }
        for channel in channels.instruments.iter().flatten() {
            self.courses[*channel].take(*channel, run, &dwell.blocks, None);
        }
        let blocks = &run.blocks[dwell.blocks.clone()];
        let other = |channel: usize| blocks.iter().fold(Sum::default(), |all, block| all.join(block.sums[channel]));
        self.found.push(Unfinished {
            interval,
            row: blocks[0].row,
            tested: dwell.channels.into_iter().map(Standing::without_windows).collect(),
            others: (channels.tested()..channels.list.len()).map(other).collect(),
            direction: run.direction.clone(),
        });
    }
}

/// Mean of a channel over the middle of a run.
fn mean_of(run: &Run, channel: usize) -> f64 {
    let quarter = run.blocks.len() / 4;
    let middle = &run.blocks[quarter..run.blocks.len() - quarter];
    middle.iter().fold(Sum::default(), |all, block| all.join(block.sums[channel])).mean
}

fn variance(sum: &Sum) -> f64 {
    if sum.count > 1.0 { sum.squares / (sum.count - 1.0) } else { 0.0 }
}

impl Unfinished {
    /// s.
    fn duration(&self) -> f64 {
        self.interval[1] - self.interval[0]
    }

    fn finish(&self, channels: &Channels, common: &[Common]) -> Standstill {
        let spread = |channel: usize| spread(&self.tested[channel], &common[channel]);
        let said = |channel: &Option<usize>| channel.filter(|channel| self.tested[*channel].sum.count > 0.0);
        let is_saturated = |channel: usize| {
            let sum = self.tested[channel].sum;
            sum.ends > SATURATED * sum.count
        };
        let reading = |channel: &Option<usize>| {
            let channel = said(channel).filter(|channel| !is_saturated(*channel))?;
            let std = Some(spread(channel).standard_error).filter(|std| *std > 0.0);
            Some(Reading { value: self.tested[channel].sum.mean, std })
        };
        let other = |channel: &usize| {
            let sum = self.others[channel - channels.tested()];
            if sum.count > 0.0 { sum.mean } else { f64::NAN }
        };
        let saturated = |joint: &usize| said(&channels.torques[*joint]).is_some_and(is_saturated);
        let joints = 0..channels.joints;
        let velocity = if channels.velocity_is_slope {
            vec![0.0; channels.joints]
        } else {
            channels.velocity.iter().map(other).collect()
        };
        Standstill {
            interval: self.interval,
            pose: StaticPose {
                line: self.row,
                position: joints.clone().map(|joint| self.tested[joint].sum.mean).collect(),
                orientation: None,
                torque: channels.torques.iter().map(reading).collect(),
                instruments: channels.instruments.iter().map(reading).collect(),
                saturated: joints.clone().filter(saturated).collect(),
                sweep: None,
                conditions: Conditions {
                    time: Some(0.5 * (self.interval[0] + self.interval[1])),
                    temperature: channels.temperature.iter().map(other).collect(),
                    velocity,
                    acceleration: Vec::new(),
                    direction: self.direction.clone(),
                    presliding: Vec::new(),
                    further: channels.further.iter().map(other).collect(),
                },
                merged: joints.clone().map(|joint| self.tested[joint].sum.count).fold(1.0, f64::max) as u32,
            },
            position: joints.map(spread).collect(),
            torque: channels.torques.iter().map(|channel| said(channel).map(spread)).collect(),
            instruments: channels.instruments.iter().map(|channel| said(channel).map(spread)).collect(),
        }
    }
}

fn spread(standing: &Standing, common: &Common) -> Spread {
    let (samples, variance) = (standing.sum.count, variance(&standing.sum));
    let noise = variance * common.time / samples;
    let drift = if standing.drifts { standing.drift.powi(2) / 12.0 } else { 0.0 };
    let standard_error = (noise + common.rounding + drift).sqrt();
    let effective = if standard_error > 0.0 { (variance / standard_error.powi(2)).min(samples) } else { samples };
    Spread { samples, effective, std: variance.sqrt(), standard_error, drift: standing.drift }
}
