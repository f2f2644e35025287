//! Hann windows over a run.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::clock::Recorded;
use super::grid::Grid;
use super::spline::{Run, Splines};
use super::weight::Weighing;
use super::{FEWEST, MotionWindow, OVERLAP, TURNS_ROUND, WindowRule};
use crate::columns::is_saturated;
use crate::conditions::Conditions;
use crate::motion::channels::Channels;
use crate::presliding::{DahlFriction, Presliding};
use crate::static_pose::{Reading, StaticPose};

/// Appends the windows of a run.
pub(super) fn windows(
    recorded: &Recorded,
    splines: &Splines,
    run: &Run,
    channels: &Channels,
    rule: &WindowRule,
    found: &mut Vec<MotionWindow>,
) {
    let times = &recorded.times[run.rows.clone()];
    let ([before, _], reach) = (rule.margins(), rule.reach());
    let (Some(begin), Some(end)) = (times.first(), times.last()) else { return };
    let signs: Vec<Vec<f64>> =
        (0..channels.joints).map(|joint| signs(&run.states[joint], rule.moving[joint], splines.noise[joint])).collect();
    let stands: Vec<Vec<bool>> =
        (0..channels.joints).map(|joint| stands(&run.states[joint], times, rule.moving[joint])).collect();
    let follow = |(joint, states): (usize, _)| {
        rule.presliding.contains(&joint).then(|| Followed::new(states, channels.position_gains[joint]))
    };
    let mut presliding: Vec<Option<Followed>> = match rule.presliding.is_empty() {
        true => Vec::new(),
        false => run.states.iter().map(Vec::as_slice).enumerate().map(follow).collect(),
    };
    let count = ((end - begin - reach) * OVERLAP / rule.length).floor();
    let at = |start: f64| Window { recorded, run, channels, rule, signs: &signs, stands: &stands, start };
    let first = begin + before;
    let mut grid = Grid::new(recorded, run, channels.joints, at(first).of_model().start, rule.length);
    for number in 0..=count.max(0.0) as usize {
        let window = at(first + number as f64 * rule.length / OVERLAP);
        found.extend(window.reported(&mut presliding, &mut grid));
    }
}

struct Window<'a> {
    recorded: &'a Recorded,
    run: &'a Run,
    channels: &'a Channels,
    rule: &'a WindowRule,
    /// Of each joint's motion, by row of the run.
    signs: &'a [Vec<f64>],
    /// Of each joint, by row of the run, whether it stands.
    stands: &'a [Vec<bool>],
    start: f64,
}

/// The sign of a joint's motion at each moment. Where it is too slow to tell, that of the motion before until it has turned round, and of the
/// motion after from there; before it first moves, of that motion. 0 of a joint that never moves. `noise`: of its position readings.
fn signs(states: &[[f64; 3]], moving: f64, noise: f64) -> Vec<f64> {
    let mut signs = vec![0.0; states.len()];
    let mut latest: Option<usize> = None;
    for (row, [_, velocity, _]) in states.iter().enumerate().filter(|(_, [_, velocity, _])| velocity.abs() > moving) {
        let sign = velocity.signum();
        let turned = match latest {
            Some(latest) if signs[latest] != sign => {
                let turned = turned(states, latest..row, signs[latest], noise);
                let before = signs[latest];
                signs[latest..turned].fill(before);
                turned
            }
            Some(latest) => latest,
            None => 0,
        };
        signs[turned..=row].fill(sign);
        latest = Some(row);
    }
    if let Some(latest) = latest {
        let after = signs[latest];
        signs[latest..].fill(after);
    }
    signs
}

/// At each moment, whether a joint stands: it is slow for longer than it takes to turn round.
fn stands(states: &[[f64; 3]], times: &[f64], moving: f64) -> Vec<bool> {
    let slow = |row: &usize| states[*row][1].abs() <= moving;
    let rows: Vec<usize> = (0..states.len()).collect();
    let stretches = rows.chunk_by(|a, b| slow(a) == slow(b));
    stretches
        .flat_map(|stretch| {
            let (first, last) = (stretch[0], stretch[stretch.len() - 1]);
            let stands = slow(&first) && times[last] - times[first] > TURNS_ROUND;
            std::iter::repeat_n(stands, stretch.len())
        })
        .collect()
}

/// The first of some rows, between two that move, at which a joint that went one way goes the other: where it has gone farthest. Where it rests
/// there, noise says which row that is, so it is the middle of those that noise does not tell apart.
fn turned(states: &[[f64; 3]], rows: Range<usize>, before: f64, noise: f64) -> usize {
    let way = |row: usize| before * states[row][0];
    let farthest = rows.clone().map(way).fold(f64::NEG_INFINITY, f64::max);
    let alike = |row: &usize| way(*row) >= farthest - noise;
    let (first, last) = (rows.clone().find(alike), rows.clone().rfind(alike));
    let middle = first.zip(last).map_or(rows.start, |(first, last)| usize::midpoint(first, last));
    middle + usize::from(before * states[middle][1] > 0.0)
}

/// How far friction has built up over a run, kept as long as windows reach back.
struct Followed<'a> {
    positions: &'a [[f64; 3]],
    friction: DahlFriction,
    /// The row of the first that is kept.
    first: usize,
    kept: VecDeque<Option<Presliding>>,
}

impl<'a> Followed<'a> {
    fn new(positions: &'a [[f64; 3]], gain: f64) -> Followed<'a> {
        Followed { positions, friction: DahlFriction::new(gain), first: 0, kept: VecDeque::new() }
    }

    /// The mean over rows of the run, which begin no earlier than any before; nothing where it is not known in all of them.
    fn mean(&mut self, rows: Range<usize>, weights: &[f64]) -> Option<Presliding> {
        for [position, ..] in &self.positions[self.first + self.kept.len()..rows.end] {
            self.friction.go(*position);
            self.kept.push_back(self.friction.state());
        }
        self.kept.drain(..rows.start - self.first);
        self.first = rows.start;
        let states: Vec<Presliding> = self.kept.iter().take(rows.len()).copied().collect::<Option<_>>()?;
        Some(Presliding::mean(weights.iter().copied().zip(states)))
    }
}

/// The rows of a window, and how much each counts.
struct Weighed {
    rows: Range<usize>,
    weights: Vec<f64>,
}

impl Weighed {
    fn mean(&self, value: impl Fn(usize) -> f64) -> f64 {
        let counts = self.rows.clone().zip(&self.weights).filter(|(_, weight)| **weight > 0.0);
        counts.map(|(row, weight)| weight * value(row)).sum()
    }
}

impl Window<'_> {
    fn reported(&self, presliding: &mut [Option<Followed>], grid: &mut Grid<'_>) -> Option<MotionWindow> {
        let (joints, length) = (self.channels.joints, self.rule.length);
        let model = self.weighed(&self.of_model(), |_| true)?;
        let state =
            |joint: usize, part: usize| model.mean(|row| self.run.states[joint][row - self.run.rows.start][part]);
        let gain = |joint: usize| self.channels.position_gains[joint];
        let sign = |joint: usize, row: usize| self.signs[joint][row - self.run.rows.start];
        let rests = |joint: usize, row: usize| {
            let speed = self.run.states[joint][row - self.run.rows.start][1];
            f64::from(u8::from(speed.abs() <= self.rule.moving[joint]))
        };
        let stands = |joint: usize, row: usize| f64::from(u8::from(self.stands[joint][row - self.run.rows.start]));
        let mut saturated = Vec::new();
        let mut torque: Vec<Option<Reading>> = vec![None; joints];
        for (joint, channel) in self.channels.torques.iter().enumerate() {
            let Some(channel) = *channel else { continue };
            let value = |row: usize| self.recorded.value(row, channel);
            let Some(weighed) = self.weighed(&self.of_torques(), |row| !value(row).is_nan()) else { continue };
            let [lowest, highest] = self.channels.list[channel].range.map(Some);
            if weighed.rows.clone().any(|row| is_saturated(value(row), lowest, highest)) {
                saturated.push(joint);
                continue;
            }
            torque[joint] = Some(Reading { value: weighed.mean(value), std: None });
        }
        let from = |row: usize| row - self.run.rows.start;
        let built_up = |followed: &mut Option<Followed>| {
            followed.as_mut()?.mean(from(model.rows.start)..from(model.rows.end), &model.weights)
        };
        let others =
            |channels: &[usize]| channels.iter().map(|c| model.mean(|row| self.recorded.value(row, *c))).collect();
        Some(MotionWindow {
            pose: StaticPose {
                line: self.recorded.rows[model.rows.start + model.rows.len() / 2],
                position: (0..joints).map(|joint| state(joint, 0)).collect(),
                orientation: None,
                torque,
                instruments: vec![None; self.channels.instruments.len()],
                saturated,
                sweep: None,
                conditions: Conditions {
                    time: Some(self.start + 0.5 * length),
                    temperature: others(&self.channels.temperature),
                    velocity: (0..joints).map(|joint| gain(joint) * state(joint, 1)).collect(),
                    acceleration: (0..joints).map(|joint| gain(joint) * state(joint, 2)).collect(),
                    direction: (0..joints)
                        .map(|joint| gain(joint).signum() * model.mean(|row| sign(joint, row)))
                        .collect(),
                    presliding: presliding.iter_mut().map(built_up).collect(),
                    further: others(&self.channels.further),
                },
                merged: model.rows.len() as u32,
            },
            course: Arc::new(grid.course(&self.of_model())),
            interval: self.interval(),
            resting: (0..joints).map(|joint| model.mean(|row| rests(joint, row))).collect(),
            standing: (0..joints).map(|joint| model.mean(|row| stands(joint, row))).collect(),
        })
    }

    /// How much moments count to the model.
    fn of_model(&self) -> Weighing {
        let filter = self.rule.filter_length();
        Weighing { start: self.start - 0.5 * filter, length: self.rule.length, filter }
    }

    /// How much moments count to torques.
    fn of_torques(&self) -> Weighing {
        Weighing { start: self.start + self.rule.torque_lag, length: self.rule.length, filter: 0.0 }
    }

    /// From the first moment that counts to the last.
    fn interval(&self) -> [f64; 2] {
        let both = [self.of_model(), self.of_torques()];
        [
            both.iter().map(|weighing| weighing.start).fold(f64::INFINITY, f64::min),
            both.iter().map(Weighing::end).fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    /// Those within a window, and the last one before.
    fn rows(&self, weighing: &Weighing) -> Range<usize> {
        let times = &self.recorded.times[self.run.rows.clone()];
        let first = times.partition_point(|time| *time <= weighing.start).saturating_sub(1);
        let last = times.partition_point(|time| *time <= weighing.end());
        self.run.rows.start + first..self.run.rows.start + last
    }

    /// Rows that say something count as much as the time that each stands for; none where they are too few for a mean.
    fn weighed(&self, weighing: &Weighing, says: impl Fn(usize) -> bool) -> Option<Weighed> {
        let (times, rows) = (&self.recorded.times, self.rows(weighing));
        let said: Vec<usize> = rows.clone().filter(|row| says(*row)).collect();
        if (said.len() as f64) < FEWEST - 1.0 {
            return None;
        }
        let mut weights = vec![0.0; rows.len()];
        for (number, row) in said.iter().enumerate() {
            let before = said[number.saturating_sub(1)];
            let after = said[(number + 1).min(said.len() - 1)];
            weights[row - rows.start] = (times[after] - times[before]) * weighing.at(times[*row]);
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        (sum > 0.0).then_some(Weighed { rows, weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It leaves its upper end faster than it comes to it: the middle of the slow rows is not where it turns.
    #[test]
    fn a_joint_turns_round_where_it_has_gone_farthest() {
        let slow = [0.09, 0.01, 0.005, -0.03, -0.2];
        let mut position = 0.0;
        let states: Vec<[f64; 3]> = slow
            .map(|velocity| {
                position += 0.01 * velocity;
                [position, velocity, 0.0]
            })
            .into();
        assert_eq!(signs(&states, 0.05, 0.0), [1.0, 1.0, 1.0, -1.0, -1.0]);
        let back: Vec<[f64; 3]> = states.iter().map(|state| state.map(|of| -of)).collect();
        assert_eq!(signs(&back, 0.05, 0.0), [-1.0, -1.0, -1.0, 1.0, 1.0]);
    }

    /// It rests from the second row to the eighth, and noise of 1 mrad makes the seventh the farthest.
    #[test]
    fn a_joint_that_rests_turns_round_in_the_middle_of_its_rest() {
        let positions = [0.0, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1005, 0.1, 0.0];
        let mut states: Vec<[f64; 3]> = positions.map(|position| [position, 0.0, 0.0]).into();
        (states[0][1], states[8][1]) = (0.1, -0.1);
        assert_eq!(signs(&states, 0.05, 1e-3), [1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0]);
    }

    #[test]
    fn a_joint_stands_where_it_is_slow_for_longer_than_it_takes_to_turn_round() {
        let states = |slow: usize| [vec![[0.0, 1.0, 0.0]; 3], vec![[0.0; 3]; slow], vec![[0.0, -1.0, 0.0]; 3]].concat();
        let times: Vec<f64> = (0..40).map(|row| 0.01 * f64::from(row)).collect();
        let standing = |slow: usize| stands(&states(slow), &times, 0.05).iter().filter(|stands| **stands).count();
        assert_eq!([5, 10, 13, 30].map(standing), [0, 0, 13, 30]);
    }

    #[test]
    fn a_joint_that_goes_on_has_one_sign_and_one_that_stands_has_none() {
        let going: Vec<[f64; 3]> = [0.0, 0.1, -0.01, 0.1, 0.0].map(|velocity| [0.0, velocity, 0.0]).into();
        assert_eq!(signs(&going, 0.05, 0.0), [1.0; 5]);
        assert_eq!(signs(&[[1.0, 0.001, 0.0]; 3], 0.05, 0.0), [0.0; 3]);
    }
}
