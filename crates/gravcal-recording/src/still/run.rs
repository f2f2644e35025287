//! Runs of blocks in which every joint stays where it is: what may be a standstill.
//!
//! Roughly only: a joint stays as long as a block's mean is near that of the blocks before it. A single block that is elsewhere
//! interrupts nothing, two in succession end the run. The run still holds the end of the motion before it, what settles, and the
//! beginning of the next motion; [`super::judge`] looks closer.

use std::collections::VecDeque;

use crate::motion::approach::Approach;
use crate::motion::block::Block;
use crate::motion::rough_noise::Scales;

/// Blocks of a run at most; then every two become one, of twice the length.
const MOST_BLOCKS: usize = 256;
/// How far from its mean a joint that stays may be, in units of the noise of a block's mean, which is known roughly.
const GATE: f64 = 8.0;
/// Gates by which a joint is plainly elsewhere, and blocks that are remembered for that.
const AWAY: f64 = 5.0;
const PAST: usize = 64;
/// Blocks over which the place where a joint stays is a mean.
const MEMORY: f64 = 50.0;

/// What may be a standstill.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// Of even length, but for gaps within.
    pub blocks: Vec<Block>,
    /// How often two blocks became one.
    pub doublings: u32,
    /// From which side each joint came: 1, −1, or 0 where it has not moved yet.
    pub direction: Vec<f64>,
    /// Whether the recording is interrupted before it, and after it; and whether it begins or ends there.
    pub interrupted: [bool; 2],
    /// When the last block before it ended in which a joint was plainly elsewhere, s.
    pub moved_until: f64,
    /// The joint whose leaving ended it.
    pub left_by: Option<usize>,
}

/// Finds them in successive blocks.
#[derive(Clone, Debug)]
pub(super) struct Runs {
    joints: usize,
    approach: Approach,
    current: Option<Standing>,
    /// The last block, if it was elsewhere.
    elsewhere: Option<Block>,
    /// Where the joints were in the last blocks, each with its end.
    past: VecDeque<(f64, Vec<f64>)>,
}

#[derive(Clone, Debug)]
struct Standing {
    run: Run,
    /// Mean position of each joint, and of how many blocks.
    level: Vec<(f64, f64)>,
    /// Blocks that are to become one with the next.
    partial: Option<(Block, u32)>,
}

impl Runs {
    /// `gains`: of each joint, rad or m in a unit of its position reading.
    pub fn new(gains: &[f64]) -> Runs {
        Runs {
            joints: gains.len(),
            approach: Approach::new(gains),
            current: None,
            elsewhere: None,
            past: VecDeque::new(),
        }
    }

    /// How far each joint may be from where it stays.
    pub fn gates(joints: usize, scales: &Scales) -> Vec<f64> {
        let gate = |joint: usize| GATE * scales.mean[joint] + 1.2 * scales.quantum[joint] + scales.immaterial[joint];
        (0..joints).map(gate).collect()
    }

    /// Takes the next block, which follows the one before without a gap. Gives the run that it ends.
    pub fn take(&mut self, block: Block, gates: &[f64]) -> Option<Run> {
        self.approach.take(&block, gates);
        if self.past.len() == PAST {
            self.past.pop_front();
        }
        let places = block.sums[..self.joints].iter();
        let places = places.map(|sum| if sum.count > 0.0 { sum.mean } else { f64::NAN }).collect();
        self.past.push_back((block.until, places));
        let Some(standing) = &mut self.current else {
            self.begin(block, gates, true);
            return None;
        };
        let leaves = standing.leaves(&block, gates);
        if leaves.is_none() {
            if let Some(elsewhere) = self.elsewhere.take() {
                standing.push(elsewhere);
            }
            standing.settle_level(&block);
            standing.push(block);
            standing.run.direction.copy_from_slice(self.approach.direction());
            return None;
        }
        let Some(before) = self.elsewhere.take() else {
            standing.run.left_by = leaves;
            self.elsewhere = Some(block);
            return None;
        };
        let ended = self.end(false);
        self.begin(before, gates, false);
        if let Some(standing) = self.current.as_mut().filter(|standing| standing.leaves(&block, gates).is_none()) {
            standing.settle_level(&block);
            standing.push(block);
        } else {
            self.begin(block, gates, false);
        }
        ended
    }

    /// Ends what is going on, because the recording is interrupted or at its end.
    pub fn interrupt(&mut self) -> Option<Run> {
        self.elsewhere = None;
        self.past.clear();
        self.end(true)
    }

    fn begin(&mut self, block: Block, gates: &[f64], interrupted: bool) {
        let mut standing = Standing {
            run: Run {
                blocks: Vec::new(),
                doublings: 0,
                direction: self.approach.direction().to_vec(),
                interrupted: [interrupted, false],
                moved_until: self.moved_until(&block, gates),
                left_by: None,
            },
            level: vec![(0.0, 0.0); self.joints],
            partial: None,
        };
        standing.settle_level(&block);
        standing.push(block);
        self.current = Some(standing);
    }

    /// When some joint was last plainly away from where it is in this block, as far as is remembered.
    fn moved_until(&self, block: &Block, gates: &[f64]) -> f64 {
        let away = |(_, places): &&(f64, Vec<f64>)| {
            let mut places = places.iter().zip(&block.sums).zip(gates);
            places.any(|((place, sum), gate)| sum.count > 0.0 && (sum.mean - place).abs() > AWAY * gate)
        };
        let last = self.past.iter().rev().find(away).or(self.past.front());
        last.map_or(block.from, |(until, _)| until.min(block.from))
    }

    fn end(&mut self, interrupted: bool) -> Option<Run> {
        let mut run = self.current.take()?.run;
        run.interrupted[1] = interrupted;
        Some(run)
    }
}

impl Standing {
    /// A joint that is elsewhere in this block.
    fn leaves(&self, block: &Block, gates: &[f64]) -> Option<usize> {
        self.level.iter().zip(gates).zip(&block.sums).position(|(((level, blocks), gate), sum)| {
            sum.count > 0.0 && *blocks > 0.0 && (sum.mean - level).abs() > gate * (1.0 + 1.0 / blocks).sqrt()
        })
    }

    fn settle_level(&mut self, block: &Block) {
        for ((level, blocks), sum) in self.level.iter_mut().zip(&block.sums) {
            if sum.count > 0.0 {
                *blocks = (*blocks + 1.0).min(MEMORY);
                *level += (sum.mean - *level) / *blocks;
            }
        }
    }

    fn push(&mut self, block: Block) {
        let (mut whole, mut of) = (block, 1);
        if let Some((mut partial, count)) = self.partial.take() {
            partial.join(&whole);
            (whole, of) = (partial, count + 1);
        }
        if of < 1 << self.run.doublings {
            self.partial = Some((whole, of));
            return;
        }
        self.run.blocks.push(whole);
        if self.run.blocks.len() == MOST_BLOCKS {
            let halved = self.run.blocks.chunks_exact(2).map(|pair| {
                let mut joined = pair[0].clone();
                joined.join(&pair[1]);
                joined
            });
            self.run.blocks = halved.collect();
            self.run.doublings += 1;
        }
    }
}
