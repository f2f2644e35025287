//! Rows of an arm in motion that are taken as static poses.
//!
//! Neighbouring static poses are far apart, or one joint sweeps while the others stand. Of an arm in motion nearly all of the way that
//! its joints travel is in steps far shorter than where they go, and either several joints travel at once or the steps are so short
//! that nobody stops after each.

use std::path::Path;

use gravcal_recording::{Selection, file_name};

use crate::parameter::SensorParameter;
use crate::session::Session;

/// Fewer rows may be anything.
const ROWS: usize = 200;
/// So many static poses nobody records.
const STATIC_POSES: usize = 3000;
/// A short step, as a share of the joint's range, and one so short that nobody stops after it.
const SHORT: f64 = 1.0 / 50.0;
const TINY: f64 = 1.0 / 400.0;
/// Share of the way that is in short steps, and most of it that is due to the joint that moves most.
const JOINED: f64 = 0.9;
const ALONE: f64 = 0.8;
/// Joints that move over less than this share of the largest range say nothing but noise.
const MOVES: f64 = 0.1;

/// Adds up the ways of joints from row to row.
#[derive(Clone, Debug)]
pub struct Joined {
    /// Of each joint, 0 where it hardly moves.
    ranges: Vec<f64>,
    last: Vec<f64>,
    rows: usize,
    way: f64,
    short: f64,
    /// Ways of the joint that moves most in each row, and their squares.
    leading: f64,
    squares: f64,
}

impl Joined {
    /// `ranges`: from the lowest to the highest position of each joint, in one unit.
    pub fn new(ranges: impl Iterator<Item = f64>) -> Joined {
        let ranges: Vec<f64> = ranges.collect();
        let largest = ranges.iter().copied().fold(0.0, f64::max);
        let ranges = ranges.into_iter().map(|range| if range > MOVES * largest { range } else { 0.0 }).collect();
        Joined { ranges, last: Vec::new(), rows: 0, way: 0.0, short: 0.0, leading: 0.0, squares: 0.0 }
    }

    /// The positions of a row.
    pub fn take(&mut self, positions: &[f64]) {
        self.rows += 1;
        let mut leading: f64 = 0.0;
        for ((at, before), range) in
            positions.iter().zip(&self.last).zip(&self.ranges).filter(|(_, range)| **range > 0.0)
        {
            let step = (at - before).abs() / range;
            if step.is_nan() {
                continue;
            }
            self.way += step;
            self.short += if step < SHORT { step } else { 0.0 };
            leading = leading.max(step);
        }
        self.leading += leading;
        self.squares += leading * leading;
        self.last.clear();
        self.last.extend_from_slice(positions);
    }

    /// Why rows of a file are no static poses, and what to do about it; `None` where they look like such.
    pub fn report(&self, file: &Path, has_clock: bool) -> Option<String> {
        let why = match self.is_motion() {
            true => "neighbours differ by little and in order, as those of an arm in motion do",
            false if self.rows > STATIC_POSES => "nobody lets an arm stand so often",
            false => return None,
        };
        let name = file_name(file);
        let clock = match has_clock {
            false => "give it a clock (a column of times, and [readings] time = { column = …, unit = … }) and ",
            true => "",
        };
        Some(format!(
            "Each of the {} rows of {name} is taken as a static pose, but {why}. If it is a recording of an arm in motion, {clock}say \
             still = {{}} (poses are where it stands), sweeps = {{}} (where one joint moves slowly), motion = {{}} (every moment, by the \
             whole dynamics) or select (limits of motion) in [readings].",
            self.rows
        ))
    }

    /// Whether the rows join up into motion.
    fn is_motion(&self) -> bool {
        let together = self.leading < ALONE * self.way;
        let tiny = self.squares < TINY * self.leading;
        self.rows >= ROWS && self.short > JOINED * self.way && (together || tiny)
    }
}

/// A note for each table whose rows are no static poses by the look of them.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    // Who looks for standstills, or limits the motion, knows that the arm moves.
    let knows = session.readings.selection != Selection::default()
        || session.has_windows()
        || session.searched.iter().any(|searched| searched.standstills.is_some() || searched.sweeps.is_some());
    if knows { Vec::new() } else { (0..session.tables.len()).filter_map(|table| doubt(session, table)).collect() }
}

fn doubt(session: &Session, table: usize) -> Option<String> {
    let gains: Vec<f64> = session.joints.iter().map(|joint| joint.of(SensorParameter::PositionGain).nominal).collect();
    let rows = || {
        let poses = session.poses.iter().filter(move |pose| pose.table == table);
        poses.map(|pose| pose.position.iter().zip(&gains).map(|(at, gain)| at * gain).collect::<Vec<f64>>())
    };
    let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; gains.len()];
    for row in rows() {
        ends.iter_mut().zip(row).for_each(|([low, high], at)| (*low, *high) = (low.min(at), high.max(at)));
    }
    let mut joined = Joined::new(ends.iter().map(|[low, high]| high - low));
    rows().for_each(|row| joined.take(&row));
    joined.report(&session.tables[table].path, session.readings.conditions.time.is_some())
}
