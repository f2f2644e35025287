//! Samples in, runs out, in memory that does not grow with the recording.

use super::judge::LEAST_BLOCKS;
use super::run::{Run, Runs};
use crate::motion::channels::Channels;
use crate::motion::rough_noise::Scales;
use crate::motion::sampler::{Heard, Sampler, Samples};

/// Where a joint stays for so many blocks it hardly moves; in a motion no two in succession are alike.
const HARDLY_MOVED: usize = 4;

/// Finds runs in samples.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    pub sampler: Sampler,
    finder: Finder,
}

/// Finds runs in blocks.
#[derive(Clone, Debug)]
struct Finder {
    joints: usize,
    gates: Vec<f64>,
    runs: Runs,
    moved_on: Vec<u64>,
}

impl Segments {
    /// Made for a recording that begins with these samples, which it has not yet taken. `interval`: from sample to sample, s.
    pub fn new(channels: &Channels, first: &Samples, interval: f64) -> Segments {
        let sampler = Sampler::new(channels, first, interval);
        let joints = channels.joints;
        let gates = Runs::gates(joints, &sampler.scales);
        Segments {
            sampler,
            finder: Finder { joints, gates, runs: Runs::new(&channels.position_gains), moved_on: vec![0; joints] },
        }
    }

    /// Takes the first samples.
    pub fn take_first(&mut self, first: &Samples, channels: usize, runs: &mut Vec<Run>) {
        self.sampler.take_first(first, channels, &mut |heard| self.finder.hear(heard, runs));
    }

    /// Takes a sample; a run that ends is added to `runs`.
    pub fn take(&mut self, time: f64, row: u64, values: &[f64], runs: &mut Vec<Run>) {
        self.sampler.take(time, row, values, &mut |heard| self.finder.hear(heard, runs));
    }

    /// Ends the run that is going on.
    pub fn finish(&mut self, runs: &mut Vec<Run>) {
        self.sampler.finish(&mut |heard| self.finder.hear(heard, runs));
    }

    /// How noisy channels are, as far as is known.
    pub fn scales(&self) -> &Scales {
        &self.sampler.scales
    }

    /// How often each joint moved on before it stood long enough to be looked at.
    pub fn moved_on(&self) -> &[u64] {
        &self.finder.moved_on
    }

    /// How far each joint may be from where it stays.
    pub fn gates(&self) -> &[f64] {
        &self.finder.gates
    }
}

impl Finder {
    fn hear(&mut self, heard: Heard<'_>, runs: &mut Vec<Run>) {
        match heard {
            Heard::Scales(scales) => self.gates = Runs::gates(self.joints, scales),
            Heard::Block(block) => {
                if let Some(run) = self.runs.take(block, &self.gates) {
                    self.keep(run, runs);
                }
            }
            Heard::Interruption => runs.extend(self.runs.interrupt().filter(is_long)),
        }
    }

    fn keep(&mut self, run: Run, runs: &mut Vec<Run>) {
        if is_long(&run) {
            runs.push(run);
        } else if let (true, Some(joint)) = (run.blocks.len() >= HARDLY_MOVED, run.left_by) {
            self.moved_on[joint] += 1;
        }
    }
}

/// Whether a run has enough blocks to be looked at, besides its first and last.
fn is_long(run: &Run) -> bool {
    run.blocks.len() >= LEAST_BLOCKS + 2
}
