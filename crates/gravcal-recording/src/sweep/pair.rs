//! Strokes to and fro become sweeps, and bins that were passed both ways static poses.

use std::collections::{BTreeMap, BTreeSet};

use super::bend::bends;
use super::line::Line;
use super::noise::BlockNoise;
use super::stroke::{Bin, Stroke};
use super::{RejectedStroke, StrokeReason, SweepRule};
use crate::conditions::Conditions;
use crate::motion::channels::Channels;
use crate::motion::median;
use crate::static_pose::{Reading, StaticPose};

/// Standard errors of a half difference that is one.
const SURELY: f64 = 5.0;
/// Part of the samples at an end of the range from which on they say nothing.
const SATURATED: f64 = 0.01;

/// A joint moved slowly both ways while the others stood.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    /// Place of the joint.
    pub joint: usize,
    /// Column of its position.
    pub column: String,
    /// Its first and last time, s, on the recording's clock.
    pub interval: [f64; 2],
    /// How many strokes rise, and fall.
    pub strokes: [usize; 2],
    /// Width of its bins, rad.
    pub bin: f64,
    /// Bins of strokes that were passed one way only.
    pub one_way: usize,
    /// Bins that were passed both ways, in the order of the joint's position.
    pub bins: Vec<SweptBin>,
}

/// A bin that was passed both ways.
#[derive(Clone, Debug, PartialEq)]
pub struct SweptBin {
    /// What was read on the way up, and down, as static poses: the position of the swept joint is the centre of the bin, its direction
    /// that of the motion.
    pub sides: [StaticPose; 2],
}

impl Sweep {
    /// Its static poses: of each bin the mean of both sides, in which friction of the joint that sweeps cancels; or, if `apart`, both sides,
    /// with their directions and speeds, and those from which the others came.
    pub fn poses(&self, apart: bool) -> impl Iterator<Item = StaticPose> + '_ {
        let of_bin = move |bin: &SweptBin| if apart { bin.sides.to_vec() } else { vec![bin.mean(self.joint)] };
        self.bins.iter().flat_map(of_bin)
    }

    /// Friction of the swept joint, in the unit of its torque reading, where it exceeds what the readings of single poses may be off.
    pub fn shown_friction(&self) -> Option<f64> {
        let (half, _) = self.half_difference()?;
        let stds: Vec<f64> = self.bins.iter().filter_map(|bin| bin.std(self.joint)).collect();
        let of_a_pose = if stds.is_empty() { 0.0 } else { median(stds) };
        let size = half.value.abs();
        (size > of_a_pose.max(SURELY * half.std.unwrap_or(0.0))).then_some(size)
    }

    /// Half the difference of the swept joint's torque reading between both ways, mean over the bins with its standard error, and the
    /// standard deviation of the bins about it; `None` where its torque is not recorded.
    pub fn half_difference(&self) -> Option<(Reading, f64)> {
        let halves: Option<Vec<Reading>> = self.bins.iter().map(|bin| bin.half_difference(self.joint)).collect();
        let halves = halves.filter(|halves| !halves.is_empty())?;
        let count = halves.len() as f64;
        let value = halves.iter().map(|half| half.value).sum::<f64>() / count;
        let std = halves.iter().map(|half| half.std.unwrap_or(0.0).powi(2)).sum::<f64>().sqrt() / count;
        let scatter = (halves.iter().map(|half| (half.value - value).powi(2)).sum::<f64>() / count).sqrt();
        Some((Reading { value, std: Some(std).filter(|std| *std > 0.0) }, scatter))
    }
}

impl SweptBin {
    /// Half the difference of the torque reading of a joint between the way up and the way down.
    pub fn half_difference(&self, joint: usize) -> Option<Reading> {
        let [up, down] = [0, 1].map(|side: usize| self.sides[side].torque[joint]);
        combine(up, down, |up, down| 0.5 * (up - down))
    }

    /// Standard error of the mean of both ways.
    fn std(&self, joint: usize) -> Option<f64> {
        self.half_difference(joint)?.std
    }

    fn mean(&self, swept: usize) -> StaticPose {
        let [up, down] = &self.sides;
        let middle = |a: f64, b: f64| 0.5 * (a + b);
        let each = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| middle(*a, *b)).collect();
        let readings = |a: &[Option<Reading>], b: &[Option<Reading>]| {
            a.iter().zip(b).map(|(a, b)| combine(*a, *b, middle)).collect::<Vec<_>>()
        };
        let saturated: BTreeSet<usize> = up.saturated.iter().chain(&down.saturated).copied().collect();
        // A side that is the same both ways is one: that of a joint that stands.
        let direction = up.conditions.direction.iter().zip(&down.conditions.direction).enumerate();
        let direction = direction.map(|(joint, (a, b))| if a == b && joint != swept { *a } else { 0.0 });
        StaticPose {
            line: up.line.min(down.line),
            position: each(&up.position, &down.position),
            orientation: None,
            torque: readings(&up.torque, &down.torque),
            instruments: readings(&up.instruments, &down.instruments),
            saturated: saturated.into_iter().collect(),
            sweep: up.sweep.clone(),
            conditions: Conditions {
                time: up.conditions.time.zip(down.conditions.time).map(|(a, b)| middle(a, b)),
                temperature: each(&up.conditions.temperature, &down.conditions.temperature),
                velocity: vec![0.0; up.conditions.velocity.len()],
                acceleration: Vec::new(),
                direction: direction.collect(),
                presliding: Vec::new(),
                further: each(&up.conditions.further, &down.conditions.further),
            },
            merged: up.merged + down.merged,
        }
    }
}

/// A combination of two independent readings, each with half its weight.
fn combine(a: Option<Reading>, b: Option<Reading>, value: impl Fn(f64, f64) -> f64) -> Option<Reading> {
    let (a, b) = (a?, b?);
    Some(Reading { value: value(a.value, b.value), std: a.std.zip(b.std).map(|(a, b)| 0.5 * a.hypot(b)) })
}

/// Strokes of one joint at one station are a sweep.
pub(super) fn sweeps(
    strokes: Vec<Stroke>,
    channels: &Channels,
    rule: &SweepRule,
    rejected: &mut Vec<RejectedStroke>,
) -> Vec<Sweep> {
    let noise = Noise::of(&strokes, channels);
    let mut stations: BTreeMap<(u64, usize), Vec<Stroke>> = BTreeMap::new();
    strokes.into_iter().for_each(|stroke| stations.entry((stroke.station, stroke.joint)).or_default().push(stroke));
    let mut found = Vec::new();
    for ((_, joint), mut strokes) in stations {
        let times = strokes.iter().map(|stroke| stroke.times).max().unwrap_or(1);
        strokes.iter_mut().for_each(|stroke| stroke.widen_to(times));
        let maker = Maker {
            joint,
            channels,
            bin: times as f64 * rule.bin,
            width: times as f64 * rule.width(joint),
            noise: &noise,
            label: format!("{} {}", channels.list[joint].column, found.len() + 1),
        };
        let sweep = maker.sweep(&strokes);
        if sweep.bins.is_empty() {
            let both_ways = sweep.strokes.iter().all(|strokes| *strokes > 0);
            let rejection = |stroke: &Stroke| RejectedStroke {
                interval: stroke.interval,
                column: channels.list[joint].column.clone(),
                // Where some bins hold enough, those of the other way may be others.
                reason: stroke.sparse.filter(|_| both_ways).map_or(StrokeReason::OneWay, StrokeReason::Sparse),
            };
            rejected.extend(strokes.iter().map(rejection));
        } else {
            found.push(sweep);
        }
    }
    found
}

/// Variance of a block of each channel, while its own joint sweeps and while another does.
struct Noise {
    own: Vec<f64>,
    others: Vec<f64>,
}

impl Noise {
    fn of(strokes: &[Stroke], channels: &Channels) -> Noise {
        let none = vec![BlockNoise::default(); channels.list.len()];
        let [mut own, mut others] = [none.clone(), none];
        for stroke in strokes {
            let swept = channels.torques[stroke.joint];
            for bin in stroke.bins.values() {
                for (channel, line) in bin.channels.iter().enumerate() {
                    let heard = if Some(channel) == swept { &mut own } else { &mut others };
                    heard[channel].hear(line);
                }
            }
        }
        let variances = |noise: Vec<BlockNoise>| noise.iter().map(BlockNoise::variance).collect();
        Noise { own: variances(own), others: variances(others) }
    }
}

/// Makes the sweep of a joint.
struct Maker<'a> {
    joint: usize,
    channels: &'a Channels,
    /// Width of a bin, rad, and in the joint's reading.
    bin: f64,
    width: f64,
    noise: &'a Noise,
    label: String,
}

impl Maker<'_> {
    fn sweep(&self, strokes: &[Stroke]) -> Sweep {
        let ways = [1.0, -1.0].map(|way| strokes.iter().filter(|stroke| stroke.direction == way).collect::<Vec<_>>());
        let indices: BTreeSet<i64> = strokes.iter().flat_map(|stroke| stroke.bins.keys().copied()).collect();
        let bent = [0, 1].map(|way: usize| self.bent(&ways[way]));
        let bin = |index: &i64| {
            let [up, down] = [0, 1].map(|way: usize| self.side(&ways[way], &bent[way], *index));
            Some(SweptBin { sides: [up?, down?] })
        };
        let bins: Vec<SweptBin> = indices.iter().filter_map(bin).collect();
        let ends = strokes.iter().map(|stroke| stroke.interval);
        Sweep {
            joint: self.joint,
            column: self.channels.list[self.joint].column.clone(),
            interval: ends
                .fold([f64::INFINITY, f64::NEG_INFINITY], |all, one| [all[0].min(one[0]), all[1].max(one[1])]),
            strokes: [ways[0].len(), ways[1].len()],
            bin: self.bin,
            one_way: indices.len() - bins.len(),
            bins,
        }
    }

    /// Second derivative of each channel over the joint's reading in each bin of strokes of one way.
    fn bent(&self, strokes: &[&Stroke]) -> Vec<BTreeMap<i64, f64>> {
        let indices: BTreeSet<i64> = strokes.iter().flat_map(|stroke| stroke.bins.keys().copied()).collect();
        let bins = |index: &i64| strokes.iter().filter_map(|stroke| stroke.bins.get(index)).collect::<Vec<&Bin>>();
        let passed: Vec<(i64, Vec<&Bin>)> = indices.iter().map(|index| (*index, bins(index))).collect();
        let of_channel = |channel: usize| {
            let said = passed.iter().filter(|(_, bins)| bins.iter().all(|bin| bin.channels[channel].count > 0.0));
            let values: Vec<(i64, f64)> =
                said.map(|(index, bins)| (*index, weighted(channel, bins, self.centre(*index)))).collect();
            let of_width = self.width.powi(-2);
            let bends = bends(&values).into_iter().map(|bend| bend * of_width);
            values.iter().map(|(index, _)| *index).zip(bends).collect()
        };
        (0..self.channels.list.len()).map(of_channel).collect()
    }

    /// The joint's reading at the centre of a bin.
    fn centre(&self, index: i64) -> f64 {
        (index as f64 + 0.5) * self.width
    }

    /// What strokes of one way say in a bin; nothing where none passed it.
    fn side(&self, strokes: &[&Stroke], bent: &[BTreeMap<i64, f64>], index: i64) -> Option<StaticPose> {
        let passed: Vec<(&Stroke, &Bin)> =
            strokes.iter().filter_map(|stroke| Some((*stroke, stroke.bins.get(&index)?))).collect();
        let (first, first_bin) = passed.first()?;
        let bins: Vec<&Bin> = passed.iter().map(|(_, bin)| *bin).collect();
        let centre = self.centre(index);
        let mean = |value: &dyn Fn(&Bin) -> f64| bins.iter().map(|bin| value(bin)).sum::<f64>() / bins.len() as f64;
        let joints = 0..self.channels.joints;
        let position =
            |joint: usize| if joint == self.joint { centre } else { mean(&|bin| bin.channels[joint].at(centre)) };
        let said = |channel: &Option<usize>| {
            channel.filter(|channel| bins.iter().all(|bin| bin.channels[*channel].count > 0.0))
        };
        let is_saturated =
            |channel: usize| bins.iter().any(|bin| bin.ends[channel].0 > SATURATED * bin.ends[channel].1);
        let reading = |channel: &Option<usize>| {
            let channel = said(channel).filter(|channel| !is_saturated(*channel))?;
            let bend = bent[channel].get(&index).copied().unwrap_or(0.0);
            Some(self.reading(channel, &bins, (centre, bend)))
        };
        let mut direction = first.approach.clone();
        let gain = self.channels.position_gains[self.joint];
        direction[self.joint] = first.direction * gain.signum();
        let speed = gain * mean(&|bin| bin.speed());
        let condition = |channel: &usize| {
            mean(&|bin| {
                let line = &bin.channels[*channel];
                if line.count > 0.0 { line.y } else { f64::NAN }
            })
        };
        let pose = StaticPose {
            line: first_bin.row,
            position: joints.clone().map(position).collect(),
            orientation: None,
            torque: self.channels.torques.iter().map(reading).collect(),
            instruments: self.channels.instruments.iter().map(reading).collect(),
            saturated: joints
                .clone()
                .filter(|joint| said(&self.channels.torques[*joint]).is_some_and(is_saturated))
                .collect(),
            sweep: Some(self.label.clone()),
            conditions: Conditions {
                time: Some(mean(&|bin| 0.5 * (bin.interval[0] + bin.interval[1]))),
                temperature: self.channels.temperature.iter().map(condition).collect(),
                velocity: joints.map(|joint| if joint == self.joint { speed } else { 0.0 }).collect(),
                acceleration: Vec::new(),
                direction,
                presliding: Vec::new(),
                further: self.channels.further.iter().map(condition).collect(),
            },
            merged: bins.iter().map(|bin| bin.ends[self.joint].1).sum::<f64>() as u32,
        };
        Some(pose)
    }

    /// The mean of lines at the centre of a bin, less what a reading with this second derivative bends within it.
    fn reading(&self, channel: usize, bins: &[&Bin], (centre, bend): (f64, f64)) -> Reading {
        let own = self.channels.torques[self.joint] == Some(channel);
        let block = if own { self.noise.own[channel] } else { self.noise.others[channel] };
        let above: f64 = shares(channel, bins).map(|(share, line)| share * line.above_parabola(centre)).sum();
        let value = weighted(channel, bins, centre) - 0.5 * bend * above;
        let variance: f64 = shares(channel, bins).map(|(share, line)| share.powi(2) * line.leverage(centre)).sum();
        Reading { value, std: Some((block * variance).sqrt()).filter(|std| *std > 0.0) }
    }
}

/// The mean of lines at the centre of a bin.
fn weighted(channel: usize, bins: &[&Bin], centre: f64) -> f64 {
    shares(channel, bins).map(|(share, line)| share * line.at(centre)).sum()
}

/// The lines of a channel, each with its share in the number of blocks.
fn shares<'b>(channel: usize, bins: &[&'b Bin]) -> impl Iterator<Item = (f64, &'b Line)> {
    let count: f64 = bins.iter().map(|bin| bin.channels[channel].count).sum();
    let share = move |bin: &&'b Bin| (bin.channels[channel].count / count, &bin.channels[channel]);
    bins.iter().map(share).collect::<Vec<_>>().into_iter()
}
