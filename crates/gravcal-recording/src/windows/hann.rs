//! Hann windows over a run.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::clock::Recorded;
use super::spline::Run;
use super::{Course, FEWEST, MotionSample, MotionWindow, WindowRule};
use crate::conditions::Conditions;
use crate::motion::channels::Channels;
use crate::pose::{Reading, StaticPose};

/// In how many steps a window is divided, at whose ends the model is asked how the arm moves.
const STEPS: usize = 16;
/// Windows that begin in the length of one.
const OVERLAP: f64 = 6.4;
/// More samples at an end of the sensor's range than this share, and the mean is none.
const SATURATED: f64 = 0.0;

/// Appends the windows of a run.
pub(super) fn windows(
    recorded: &Recorded,
    run: &Run,
    channels: &Channels,
    rule: &WindowRule,
    found: &mut Vec<MotionWindow>,
) {
    let times = &recorded.times;
    let (begin, end) = (times[run.rows.start], times[run.rows.end - 1]);
    let count = ((end - begin - rule.length) * OVERLAP / rule.length).floor();
    let mut first = run.rows.start;
    for number in 0..=count.max(0.0) as usize {
        let start = begin + number as f64 * rule.length / OVERLAP;
        while first + 1 < run.rows.end && times[first + 1] <= start {
            first += 1;
        }
        let window = Window { recorded, run, channels, rule, start, first };
        found.extend(window.told());
    }
}

struct Window<'a> {
    recorded: &'a Recorded,
    run: &'a Run,
    channels: &'a Channels,
    rule: &'a WindowRule,
    start: f64,
    /// The last row that is not after the start.
    first: usize,
}

/// How much a moment counts, by the share of the window that has passed.
fn hann(share: f64) -> f64 {
    if (0.0..=1.0).contains(&share) { 1.0 - (TAU * share).cos() } else { 0.0 }
}

impl Window<'_> {
    fn told(&self) -> Option<MotionWindow> {
        let (joints, length) = (self.channels.joints, self.rule.length);
        let rows: Vec<usize> = self.rows();
        let weights = self.weights(&rows, |_| true)?;
        let mean =
            |value: &dyn Fn(usize) -> f64| -> f64 { rows.iter().zip(&weights).map(|(row, h)| h * value(*row)).sum() };
        let state = |joint: usize, part: usize| mean(&|row| self.run.states[joint][row - self.run.rows.start][part]);
        let sign = |joint: usize, row: usize| {
            let speed = self.run.states[joint][row - self.run.rows.start][1];
            if speed.abs() > self.rule.moving[joint] { speed.signum() } else { 0.0 }
        };
        let mut saturated = Vec::new();
        let mut torque: Vec<Option<Reading>> = vec![None; joints];
        for (joint, channel) in self.channels.torques.iter().enumerate() {
            let Some(channel) = *channel else { continue };
            let says = |row: usize| !self.recorded.value(row, channel).is_nan();
            let Some(weights) = self.weights(&rows, says) else { continue };
            let [lowest, highest] = self.channels.list[channel].range;
            let at_end = |row: &&usize| !(lowest..highest).contains(&self.recorded.value(**row, channel));
            let ends = rows.iter().filter(|row| says(**row)).filter(at_end).count();
            let bounded = lowest.is_finite() || highest.is_finite();
            if bounded && ends as f64 > SATURATED * rows.len() as f64 {
                saturated.push(joint);
                continue;
            }
            let of_row = |(row, h): (&usize, &f64)| if *h > 0.0 { h * self.recorded.value(*row, channel) } else { 0.0 };
            torque[joint] = Some(Reading { value: rows.iter().zip(&weights).map(of_row).sum(), std: None });
        }
        let others = |channels: &[usize]| channels.iter().map(|c| mean(&|row| self.recorded.value(row, *c))).collect();
        Some(MotionWindow {
            pose: StaticPose {
                line: self.recorded.rows[rows[rows.len() / 2]],
                position: (0..joints).map(|joint| state(joint, 0)).collect(),
                orientation: None,
                torque,
                instruments: vec![None; self.channels.instruments.len()],
                saturated,
                sweep: None,
                conditions: Conditions {
                    time: Some(self.start + 0.5 * length),
                    temperature: others(&self.channels.temperature),
                    velocity: (0..joints).map(|joint| state(joint, 1)).collect(),
                    acceleration: (0..joints).map(|joint| state(joint, 2)).collect(),
                    direction: (0..joints).map(|joint| mean(&|row| sign(joint, row))).collect(),
                    further: Vec::new(),
                },
                merged: rows.len() as u32,
            },
            course: Arc::new(self.course()),
            interval: [self.start, self.start + length],
            resting: (0..joints).map(|joint| mean(&|row| f64::from(u8::from(sign(joint, row) == 0.0)))).collect(),
        })
    }

    /// Those within the window.
    fn rows(&self) -> Vec<usize> {
        let end = self.start + self.rule.length;
        (self.first..self.run.rows.end).take_while(|row| self.recorded.times[*row] <= end).collect()
    }

    /// Weights of rows that say something, as much as the time that each stands for; none where they are too few for a mean.
    fn weights(&self, rows: &[usize], says: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
        let times = &self.recorded.times;
        let said: Vec<usize> = (0..rows.len()).filter(|place| says(rows[*place])).collect();
        if (said.len() as f64) < FEWEST - 1.0 {
            return None;
        }
        let mut weights = vec![0.0; rows.len()];
        for (number, place) in said.iter().enumerate() {
            let before = said[number.saturating_sub(1)];
            let after = said[(number + 1).min(said.len() - 1)];
            let stands_for = times[rows[after]] - times[rows[before]];
            weights[*place] = stands_for * hann((times[rows[*place]] - self.start) / self.rule.length);
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        (sum > 0.0).then_some(weights)
    }

    /// The moments at which the model is asked. Both ends weigh nothing.
    fn course(&self) -> Course {
        let mut row = self.first;
        let sample = |step: usize| {
            let share = step as f64 / STEPS as f64;
            let time = self.start + share * self.rule.length;
            while row + 2 < self.run.rows.end && self.recorded.times[row + 1] < time {
                row += 1;
            }
            let states: Vec<[f64; 3]> = (0..self.channels.joints)
                .map(|joint| self.run.between(&self.recorded.times, joint, row, time))
                .collect();
            let part = |part: usize| states.iter().map(|state| state[part]).collect();
            MotionSample {
                weight: hann(share) / STEPS as f64,
                position: part(0),
                velocity: part(1),
                acceleration: part(2),
            }
        };
        Course { samples: (1..STEPS).map(sample).collect() }
    }
}
