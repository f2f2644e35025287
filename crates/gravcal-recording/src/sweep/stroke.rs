//! Blocks in, strokes out: one joint moves one way while the others stand.

use std::collections::BTreeMap;

use super::line::Line;
use super::{RejectedStroke, StrokeReason, SweepRule, Travel};
use crate::motion::approach::Approach;
use crate::motion::block::Block;
use crate::motion::channels::Channels;
use crate::motion::sampler::Heard;

/// Fewest blocks in a bin.
const LEAST_BLOCKS: f64 = 4.0;
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
    pub interval: [f64; 2],
}

/// Finds them.
pub(super) struct Strokes<'a> {
    rule: &'a SweepRule,
    columns: Vec<String>,
    channels: usize,
    tolerances: Vec<f64>,
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
    pub fn new(channels: &Channels, rule: &'a SweepRule) -> Strokes<'a> {
        Strokes {
            rule,
            columns: channels.list[..channels.joints].iter().map(|channel| channel.column.clone()).collect(),
            channels: channels.list.len(),
            tolerances: rule.tolerances(),
            approach: Approach::new(channels.joints),
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
            interval: [block.from, block.until],
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
        let has_enough = |bin: &Bin| bin.speed.count >= LEAST_BLOCKS;
        let is_sparse = stroke.bins.values().filter(|bin| has_enough(bin)).count() < LEAST_BINS;
        let steady: Vec<i64> =
            stroke.bins.keys().copied().filter(|index| stroke.is_steady(*index, self.rule)).collect();
        stroke.bins.retain(|index, bin| steady.contains(index) && has_enough(bin));
        if !stroke.bins.is_empty() {
            self.found.push(stroke);
            return;
        }
        let reason = if is_sparse { StrokeReason::Sparse } else { StrokeReason::Unsteady };
        self.rejected.push(RejectedStroke {
            interval: stroke.interval,
            column: self.columns[stroke.joint].clone(),
            reason,
        });
    }
}

impl SweepRule {
    /// Width of a bin in the reading of a joint.
    pub(super) fn width(&self, joint: usize) -> f64 {
        self.bin / self.radians(joint)
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
}

impl Stroke {
    /// Whether the joint moves evenly through a bin and both its neighbours, and slowly.
    fn is_steady(&self, index: i64, rule: &SweepRule) -> bool {
        let radians = rule.radians(self.joint);
        let speed = |index: i64| self.bins.get(&index).map(|bin| (bin.speed() * radians).abs());
        let (Some(before), Some(here), Some(after)) = (speed(index - 1), speed(index), speed(index + 1)) else {
            return false;
        };
        let acceleration = (after * after - before * before).abs() / (4.0 * rule.bin);
        let beside = 0.5 * (before + after);
        acceleration <= rule.acceleration
            && here * here <= rule.acceleration
            && (EVEN * beside..=beside / EVEN).contains(&here)
    }
}
