//! Moments at even steps over a run, at which the model is asked how the arm moves: windows that overlap ask at the same ones.

use std::collections::VecDeque;
use std::sync::Arc;

use super::clock::Recorded;
use super::course::{Course, MotionSample, STRETCH, WeighedStretch};
use super::spline::Run;
use super::weight::Weighing;
use super::{Kept, OVERLAP};

/// Steps from window to window.
const STEPS: f64 = 4.0;

/// The moments of a run, in stretches, kept as long as windows reach back.
pub(super) struct Grid<'a> {
    recorded: &'a Recorded,
    run: &'a Run,
    joints: usize,
    /// Of moment 0, s.
    begin: f64,
    /// From moment to moment, s.
    step: f64,
    /// Number of the first stretch that is kept.
    first: usize,
    kept: VecDeque<Arc<[MotionSample]>>,
}

impl<'a> Grid<'a> {
    /// From the beginning of the first window on; `length`: of a window without a filter, s.
    pub fn new(recorded: &'a Recorded, run: &'a Run, joints: usize, begin: f64, length: f64) -> Grid<'a> {
        Grid { recorded, run, joints, begin, step: length / OVERLAP / STEPS, first: 0, kept: VecDeque::new() }
    }

    /// Those of a window that begins no earlier than any before, which count as much as `weighing` says.
    pub fn course(&mut self, weighing: &Weighing) -> Course {
        let moment = |time: f64| ((time - self.begin) / self.step).max(0.0);
        let stretches =
            moment(weighing.start).floor() as usize / STRETCH..=moment(weighing.end()).ceil() as usize / STRETCH;
        while self.first < *stretches.start() && self.kept.pop_front().is_some() {
            self.first += 1;
        }
        if self.kept.is_empty() {
            self.first = *stretches.start();
        }
        for number in self.first + self.kept.len()..=*stretches.end() {
            let stretch = (STRETCH * number..STRETCH * (number + 1)).map(|moment| self.moment(moment)).collect();
            self.kept.push_back(stretch);
        }
        let weighed = |number: usize| WeighedStretch {
            moments: Arc::clone(&self.kept[number - self.first]),
            weights: (STRETCH * number..STRETCH * (number + 1)).map(|moment| weighing.at(self.time(moment))).collect(),
        };
        let mut stretches: Vec<WeighedStretch> = stretches.map(weighed).collect();
        stretches.retain(|stretch| stretch.weights.iter().any(|weight| *weight > 0.0));
        let sum: f64 = stretches.iter().flat_map(|stretch| &stretch.weights).sum();
        stretches.iter_mut().flat_map(|stretch| &mut stretch.weights).for_each(|weight| *weight /= sum);
        Course { stretches, kept: Kept::default() }
    }

    fn time(&self, moment: usize) -> f64 {
        self.begin + self.step * moment as f64
    }

    /// How the arm moves there; beyond the ends of the run, where nothing counts, as at them.
    fn moment(&self, moment: usize) -> MotionSample {
        let rows = &self.run.rows;
        let times = &self.recorded.times;
        let even = self.time(moment);
        let time = even.clamp(times[rows.start], times[rows.end - 1]);
        let row = rows.start + times[rows.clone()].partition_point(|earlier| *earlier < time);
        let row = row.saturating_sub(1).clamp(rows.start, rows.end - 2);
        let states: Vec<[f64; 3]> = (0..self.joints).map(|joint| self.run.between(times, joint, row, time)).collect();
        let part = |part: usize| states.iter().map(|state| state[part]).collect();
        MotionSample { time: even, position: part(0), velocity: part(1), acceleration: part(2) }
    }
}
