//! Blocks in, strokes out: one joint moves one way while the others stand.

use std::collections::BTreeMap;

use super::line::Line;
use super::{RejectedStroke, SparseBins, StrokeReason, SweepRule, Travel};
use crate::motion::approach::Approach;
use crate::motion::block::Block;
use crate::motion::channels::Channels;
use crate::motion::sampler::Heard;

/// Fewest blocks in a bin.
const LEAST_BLOCKS: f64 = 4.0;
/// A bin should hold so many times the fewest blocks at the speed of its stroke, which is not the same everywhere.
const AMPLE: f64 = 1.1;
/// Fewest bins of a stroke that is worth a word.
const LEAST_BINS: usize = 5;
/// Blocks without a new furthest place after which the joint has stopped.
const STOPPED: usize = 500;
/// A bin's speed is at least this part of that of its neighbours, and at most its inverse.
const EVEN: f64 = 0.6;

/// What was read while the joint was in a bin.
#[derive(Clone, Debug)]
pub(super) struct Bin {
    pub row: u64,
    /// First and last time, s.
    pub interval: [f64; 2],
    /// Position of the joint over time, from the first.
    speed: Line,
    /// Every channel over the joint's position.
    pub channels: Vec<Line>,
    /// Samples at an end of the sensor's range, and all, by channel.
    pub ends: Vec<(f64, f64)>,
}

/// One joint moves one way.
#[derive(Clone, Debug)]
pub(super) struct Stroke {
    pub joint: usize,
    /// 1 rising, −1 falling.
    pub direction: f64,
    /// Strokes of one station have the other joints at one place.
    pub station: u64,
    /// From which side the other joints came.
    pub approach: Vec<f64>,
    pub bins: BTreeMap<i64, Bin>,
    /// How many times as wide as the rule says they are.
    pub times: i64,
    pub interval: [f64; 2],
    /// What makes its bins hold too few samples, if they do.
    pub sparse: Option<SparseBins>,
}

/// Finds them.
pub(super) struct Strokes<'a> {
    rule: &'a SweepRule,
    columns: Vec<String>,
    channels: usize,
    tolerances: Vec<f64>,
    /// Of samples, Hz.
    rate: f64,
    approach: Approach,
    station: u64,
    /// Where joints were when none moved.
    place: Option<Vec<f64>>,
    open: Option<Open>,
    found: Vec<Stroke>,
    rejected: Vec<RejectedStroke>,
}

/// A stroke that goes on.
struct Open {
    stroke: Stroke,
    furthest: f64,
    /// Blocks since the joint was furthest: it may have turned.
    pending: Vec<Block>,
}

impl<'a> Strokes<'a> {
    /// `interval`: from sample to sample, s.
    pub fn new(channels: &Channels, rule: &'a SweepRule, interval: f64) -> Strokes<'a> {
        Strokes {
            rule,
            rate: interval.recip(),
            columns: channels.list[..channels.joints].iter().map(|channel| channel.column.clone()).collect(),
            channels: channels.list.len(),
            tolerances: rule.tolerances(),
            approach: Approach::new(&channels.position_gains),
            station: 0,
            place: None,
            open: None,
            found: Vec::new(),
            rejected: Vec::new(),
        }
    }

    pub fn hear(&mut self, heard: Heard<'_>) {
        match heard {
            Heard::Scales(_) => {}
            Heard::Block(block) => self.take(block),
            Heard::Interruption => {
                self.end();
                self.place = None;
            }
        }
    }

    /// Strokes with bins that count, and those without.
    pub fn finish(mut self) -> (Vec<Stroke>, Vec<RejectedStroke>) {
        self.end();
        (self.found, self.rejected)
    }

    fn take(&mut self, block: Block) {
        let joints = &block.sums[..self.columns.len()];
        if joints.iter().any(|sum| sum.count == 0.0) {
            return;
        }
        let at: Vec<f64> = joints.iter().map(|sum| sum.mean).collect();
        let gates: Vec<f64> = self.tolerances.iter().map(|tolerance| 0.5 * tolerance).collect();
        self.approach.take(&block, &gates);
        let Some(place) = &self.place else {
            self.leave(at);
            return;
        };
        let away: Vec<usize> =
            (0..at.len()).filter(|joint| (at[*joint] - place[*joint]).abs() > self.tolerances[*joint]).collect();
        match (&mut self.open, away.as_slice()) {
            (Some(open), _) => {
                let joint = open.stroke.joint;
                if away.iter().any(|other| *other != joint) {
                    self.leave(at);
                } else if open.stroke.direction * (open.furthest - at[joint]) > self.tolerances[joint] {
                    let direction = -open.stroke.direction;
                    self.end();
                    self.begin(joint, direction, block);
                } else if open.pending.len() == STOPPED {
                    // It stands: where it goes from here, it goes from this place.
                    self.end();
                    if let Some(place) = &mut self.place {
                        place[joint] = at[joint];
                    }
                } else {
                    let width = self.rule.width(joint);
                    open.take(block, width, self.channels);
                }
            }
            (None, []) => {}
            (None, [joint]) if matches!(self.rule.travel[*joint], Travel::Turns(_)) => {
                let direction = (at[*joint] - place[*joint]).signum();
                self.begin(*joint, direction, block);
            }
            (None, _) => self.leave(at),
        }
    }

    /// Other joints move: whatever comes is at another place.
    fn leave(&mut self, at: Vec<f64>) {
        self.end();
        self.place = Some(at);
        self.station += 1;
    }

    fn begin(&mut self, joint: usize, direction: f64, block: Block) {
        let stroke = Stroke {
            joint,
            direction,
            station: self.station,
            approach: self.approach.direction().to_vec(),
            bins: BTreeMap::new(),
            times: 1,
            interval: [block.from, block.until],
            sparse: None,
        };
        let mut open = Open { stroke, furthest: block.sums[joint].mean, pending: Vec::new() };
        open.put(&block, self.rule.width(joint), self.channels);
        self.open = Some(open);
    }

    fn end(&mut self) {
        let Some(Open { mut stroke, .. }) = self.open.take() else { return };
        if stroke.bins.len() < LEAST_BINS {
            return;
        }
        if let Some(speed) = stroke.speed(self.rule) {
            self.suit(&mut stroke, speed);
        }
        let indices: Vec<i64> = stroke.bins.keys().copied().collect();
        let steady: Vec<i64> = indices.into_iter().filter(|index| stroke.is_steady(*index, self.rule)).collect();
        stroke.bins.retain(|index, bin| steady.contains(index) && bin.speed.count >= LEAST_BLOCKS);
        // A few bins that happen to hold enough are no sweep.
        let is_sparse = stroke.sparse.is_some() && 2 * stroke.bins.len() < steady.len();
        if !stroke.bins.is_empty() && !is_sparse {
            self.found.push(stroke);
            return;
        }
        self.rejected.push(RejectedStroke {
            interval: stroke.interval,
            column: self.columns[stroke.joint].clone(),
            reason: stroke.sparse.map_or(StrokeReason::Unsteady, StrokeReason::Sparse),
        });
    }

    /// Makes the bins of a stroke as wide as its speed, rad/s, needs and the rule admits.
    fn suit(&self, stroke: &mut Stroke, speed: f64) {
        let blocks: f64 = stroke.bins.values().map(|bin| bin.speed.count).sum();
        let fewest = LEAST_BLOCKS * (stroke.interval[1] - stroke.interval[0]) / blocks;
        stroke.widen(self.rule.times(AMPLE * fewest * speed));
        let bin = self.rule.bin * stroke.times as f64;
        stroke.sparse = (bin < fewest * speed).then(|| SparseBins {
            speed,
            rate: self.rate,
            bin,
            samples: self.rate * bin / speed,
            fewest: self.rate * fewest,
            enough: AMPLE * fewest * speed,
        });
    }
}

impl SweepRule {
    /// Width of a bin in the reading of a joint.
    pub(super) fn width(&self, joint: usize) -> f64 {
        self.bin / self.radians(joint)
    }

    /// How many times as wide as said bins must be to have this width, rad; no more than is admitted. A power of two, so that bins of
    /// several strokes can become alike.
    fn times(&self, width: f64) -> i64 {
        let is_enough = |times: &i64| self.bin * *times as f64 >= width || self.bin * (2 * times) as f64 > self.widest;
        let powers = (0..i64::BITS - 2).map(|power| 1 << power);
        powers.into_iter().find(is_enough).unwrap_or(1)
    }

    /// rad for each unit of the reading of a joint that turns.
    fn radians(&self, joint: usize) -> f64 {
        match self.travel[joint] {
            Travel::Turns(scale) | Travel::Slides(scale) => scale,
        }
    }
}

impl Open {
    /// Takes a block that may be the last before the joint turns.
    fn take(&mut self, block: Block, width: f64, channels: usize) {
        let at = block.sums[self.stroke.joint].mean;
        if self.stroke.direction * (at - self.furthest) <= 0.0 {
            self.pending.push(block);
            return;
        }
        self.furthest = at;
        for block in std::mem::take(&mut self.pending) {
            self.put(&block, width, channels);
        }
        self.put(&block, width, channels);
    }

    fn put(&mut self, block: &Block, width: f64, channels: usize) {
        let at = block.sums[self.stroke.joint].mean;
        self.stroke.interval[1] = block.until;
        let index = (at / width).floor() as i64;
        self.stroke.bins.entry(index).or_insert_with(|| Bin::new(block, channels)).take(block, at);
    }
}

impl Bin {
    fn new(block: &Block, channels: usize) -> Bin {
        Bin {
            row: block.row,
            interval: [block.from, block.until],
            speed: Line::default(),
            channels: vec![Line::default(); channels],
            ends: vec![(0.0, 0.0); channels],
        }
    }

    fn take(&mut self, block: &Block, at: f64) {
        self.interval[1] = block.until;
        self.speed.take(0.5 * (block.from + block.until) - self.interval[0], at);
        for ((line, ends), sum) in self.channels.iter_mut().zip(&mut self.ends).zip(&block.sums) {
            if sum.count > 0.0 {
                line.take(at, sum.mean);
                *ends = (ends.0 + sum.ends, ends.1 + sum.count);
            }
        }
    }

    /// Of the joint, its reading's unit a second.
    pub fn speed(&self) -> f64 {
        self.speed.slope()
    }

    /// When it was passed, s, and where: means over its blocks.
    fn middle(&self) -> (f64, f64) {
        let (time, at) = self.speed.middle();
        (self.interval[0] + time, at)
    }

    /// Two neighbours as one.
    fn join(self, other: Bin) -> Bin {
        let (before, after) = if self.interval[0] <= other.interval[0] { (self, other) } else { (other, self) };
        let pairs = before.channels.into_iter().zip(after.channels);
        let ends = before.ends.into_iter().zip(after.ends);
        Bin {
            row: before.row,
            interval: [before.interval[0], after.interval[1]],
            speed: before.speed.join(after.speed, after.interval[0] - before.interval[0]),
            channels: pairs.map(|(line, next)| line.join(next, 0.0)).collect(),
            ends: ends.map(|(one, other)| (one.0 + other.0, one.1 + other.1)).collect(),
        }
    }
}

impl Stroke {
    /// The speed that most of its slow bins do not exceed, rad/s; none where most are not slow.
    fn speed(&self, rule: &SweepRule) -> Option<f64> {
        let middles: Vec<(f64, f64)> = self.bins.values().map(Bin::middle).collect();
        let radians = rule.radians(self.joint);
        let speed = |pair: &[(f64, f64)]| radians * ((pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).abs();
        let speeds: Vec<f64> = middles.windows(2).map(speed).collect();
        let mut slow: Vec<f64> = speeds.iter().copied().filter(|speed| speed * speed <= rule.acceleration).collect();
        slow.sort_by(f64::total_cmp);
        slow.get(slow.len() * 3 / 4).copied().filter(|_| 2 * slow.len() >= speeds.len())
    }

    /// Makes its bins so many times as wide.
    fn widen(&mut self, times: i64) {
        self.times *= times;
        for (index, bin) in std::mem::take(&mut self.bins) {
            let index = index.div_euclid(times);
            let bin = match self.bins.remove(&index) {
                Some(neighbour) => neighbour.join(bin),
                None => bin,
            };
            self.bins.insert(index, bin);
        }
    }

    /// Makes its bins as wide as so many times the rule's, of those of which every part is there.
    pub fn widen_to(&mut self, times: i64) {
        let parts = times / self.times;
        let whole = |index: &i64| {
            let first = index.div_euclid(parts) * parts;
            (first..first + parts).all(|part| self.bins.contains_key(&part))
        };
        let whole: Vec<i64> = self.bins.keys().copied().filter(whole).collect();
        self.bins.retain(|index, _| whole.contains(index));
        self.widen(parts);
    }

    /// Whether the joint moves evenly through a bin and both its neighbours, and slowly.
    fn is_steady(&self, index: i64, rule: &SweepRule) -> bool {
        let radians = rule.radians(self.joint);
        let speed = |index: i64| self.bins.get(&index).map(|bin| (bin.speed() * radians).abs());
        let (Some(before), Some(here), Some(after)) = (speed(index - 1), speed(index), speed(index + 1)) else {
            return false;
        };
        let bin = rule.bin * self.times as f64;
        let acceleration = (after * after - before * before).abs() / (4.0 * bin);
        let beside = 0.5 * (before + after);
        acceleration <= rule.acceleration
            && here * here <= rule.acceleration
            && (EVEN * beside..=beside / EVEN).contains(&here)
    }
}
