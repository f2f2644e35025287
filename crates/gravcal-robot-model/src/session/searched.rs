//! What was found in a file of poses, and what a user should know of it.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::PathBuf;

use gravcal_recording::{
    Clock, MotionWindows, PoseMapping, PositionUnit, RowClock, Standstill, Standstills, StaticPose, Sweep, Sweeps,
    SweptBin, counted, file_name,
};

use super::contents::Session;
use super::pose::Pose;
use crate::parameter::SensorParameter;

/// One file, or the part of one that a table takes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Searched {
    /// Index into [`Session::tables`].
    pub table: usize,
    /// The file.
    pub path: PathBuf,
    /// Its standstills, and what was none; `None` of a table whose rows are poses.
    pub standstills: Option<Standstills>,
    /// Its slow sweeps; `None` where none were looked for.
    pub sweeps: Option<Sweeps>,
    /// Its windows of the arm in motion; `None` where none were asked for.
    pub windows: Option<Box<MotionWindows>>,
    /// What the reader says of the file: what was lost, cells that are no numbers.
    pub remarks: Vec<String>,
    /// Those of them that tell of a part of the recording that is lost.
    pub lost: Vec<String>,
}

/// So many rejected intervals are told one by one.
const TOLD: usize = 5;

impl Searched {
    /// How many standstills, slow sweeps and windows it holds; of a table whose rows are poses none counts.
    pub fn found(&self) -> usize {
        let standstills = self.standstills.as_ref().map_or(0, |standstills| standstills.found.len());
        let windows = self.windows.as_ref().map_or(0, |windows| windows.found.len());
        standstills + windows + self.sweeps.as_ref().map_or(0, |sweeps| sweeps.found.len())
    }

    /// Columns whose readings go back and forth from row to row, as where two sources fill them by turns.
    pub fn alternating(&self) -> BTreeSet<&str> {
        let standstills = self.standstills.iter().flat_map(|found| &found.alternating);
        let sweeps = self.sweeps.iter().flat_map(|found| &found.alternating);
        let windows = self.windows.iter().flat_map(|found| &found.alternating);
        standstills.chain(sweeps).chain(windows).map(String::as_str).collect()
    }

    /// What seemed to be one and is none, in words.
    pub fn rejected(&self) -> Vec<String> {
        let standstills = self.standstills.iter().flat_map(|found| &found.rejected).map(ToString::to_string);
        let strokes = self.sweeps.iter().flat_map(|found| &found.rejected).map(ToString::to_string);
        standstills.chain(strokes).collect()
    }

    /// How its rows come by their clock, where standstills or sweeps were looked for.
    pub fn clock(&self) -> RowClock {
        let clock = self.standstills.as_ref().map(|found| &found.clock);
        clock.or(self.sweeps.as_ref().map(|found| &found.clock)).cloned().unwrap_or_default()
    }

    /// Its static poses: standstills, then the bins of sweeps; if `apart`, both ways of each.
    pub fn poses(&self, apart: bool) -> Vec<StaticPose> {
        let standstills = self.standstills.iter().flat_map(|found| &found.found).map(|found| found.pose.clone());
        let sweeps = self.sweeps.iter().flat_map(|found| &found.found).flat_map(|sweep| sweep.poses(apart));
        standstills.chain(sweeps).collect()
    }

    /// How many standstills and sweeps there are, of which length, with which friction, and what was rejected and why, for people.
    /// `mapping`: by which they were found.
    pub fn notes(&self, mapping: &PoseMapping) -> Vec<String> {
        let name = file_name(&self.path);
        let standstills = self.standstills.iter().flat_map(|found| standstill_notes(&name, found, mapping));
        let sweeps = self.sweeps.iter().flat_map(|found| sweep_notes(&name, found, mapping));
        let remarks = self.remarks.iter().map(|remark| format!("{name}: {remark}"));
        let windows = self.windows.iter().flat_map(|found| window_notes(&name, found, mapping));
        let looked_for = self.standstills.is_some() || self.sweeps.is_some();
        let clock = (looked_for && self.found() == 0).then(|| {
            let clock = self.clock();
            format!("{name}: {clock}; {}.", clock.advice())
        });
        standstills.chain(sweeps).chain(windows).chain(clock).chain(remarks).collect()
    }
}

impl Session {
    /// What was found in the files of poses that enter the fit.
    pub fn fitted_recordings(&self) -> impl Iterator<Item = &Searched> {
        let tables: BTreeSet<usize> = self.poses.iter().map(|pose| pose.table).collect();
        self.searched.iter().filter(move |searched| tables.contains(&searched.table))
    }

    /// The coordinates of all joints in a pose by nominal gains and offsets, rad or m.
    pub fn nominal_coordinates(&self, pose: &Pose) -> Vec<f64> {
        let of_joint = |(joint, reading): (usize, &f64)| {
            let [gain, offset] = [SensorParameter::PositionGain, SensorParameter::PositionOffset]
                .map(|quantity| self.joints[joint].of(quantity).nominal);
            gain * reading + offset
        };
        pose.position.iter().enumerate().map(of_joint).collect()
    }

    /// File and line of a pose.
    pub fn row_of(&self, pose: usize) -> (String, u64) {
        let Pose { table, line, .. } = self.poses[pose];
        (file_name(&self.tables[table].path), line)
    }
}

/// The end of a sentence that tells what was rejected.
fn reported_rejected(rejected: &[impl ToString]) -> String {
    if rejected.is_empty() {
        return ".".to_owned();
    }
    let first: Vec<String> = rejected.iter().take(TOLD).map(ToString::to_string).collect();
    let more = if rejected.len() > TOLD { "; …" } else { "." };
    format!(", {} rejected: {}{more}", rejected.len(), first.join("; "))
}

fn sweep_notes(name: &str, sweeps: &Sweeps, mapping: &PoseMapping) -> Vec<String> {
    let Sweeps { found, rejected, repeated, without_time, interruptions, .. } = sweeps;
    let sweeps = counted(found.len() as u64, ["slow sweep", "slow sweeps"]);
    let reported = format!("{name}: {sweeps} found{}", reported_rejected(rejected));
    let notes = found.iter().map(|sweep| sweep_note(name, sweep, mapping));
    [reported].into_iter().chain(notes).chain(oddities(name, *repeated, *without_time, *interruptions)).collect()
}

/// One sweep, with its friction: half the difference of the torque readings of both ways.
fn sweep_note(name: &str, sweep: &Sweep, mapping: &PoseMapping) -> String {
    let unit = mapping.positions[sweep.joint].unit.si();
    let (scale, unit) = if unit == PositionUnit::Radian { (180.0 / PI, PositionUnit::Degree) } else { (1.0, unit) };
    let at = |bin: Option<&SweptBin>| bin.map_or(0.0, |bin| scale * bin.sides[0].position[sweep.joint]);
    let (lowest, highest) = (at(sweep.bins.first()), at(sweep.bins.last()));
    let [up, down] = sweep.strokes;
    let (up, angles) =
        (counted(up as u64, ["stroke", "strokes"]), counted(sweep.bins.len() as u64, ["angle", "angles"]));
    let mut reported = format!(
        "{name}: `{}` from {lowest:.1} to {highest:.1} {unit} in {up} up and {down} down: {angles} both ways, in bins of {:.3} deg",
        sweep.column,
        sweep.bin.to_degrees()
    );
    if let (Some((half, scatter)), Some((_, unit))) = (sweep.half_difference(), &mapping.torques[sweep.joint]) {
        let std = half.std.map_or_else(String::new, |std| format!(" ± {std:.2e}"));
        reported += &format!(
            ", half the difference of the ways (friction) {:.4}{std} {unit}, scattered by {scatter:.2e}",
            half.value
        );
    }
    reported + "."
}

/// How many windows there are, whose times were believed, and how noisy positions are.
fn window_notes(name: &str, windows: &MotionWindows, mapping: &PoseMapping) -> Vec<String> {
    let MotionWindows {
        found,
        clock,
        interval,
        position_noise,
        wraps,
        repeated,
        empty,
        strays,
        without_time,
        interruptions,
        ..
    } = windows;
    let length = found.first().map_or(0.0, |window| window.interval[1] - window.interval[0]);
    let clock = match clock {
        Clock::Stamps => "as they are stamped",
        Clock::Even => "taken as evenly spaced, because positions are smoother so than by their stamps",
        Clock::Rounded => "taken as whole steps apart, because positions are smoother so than by their stamps",
    };
    let reported = format!(
        "{name}: {} of {length:.2} s in motion, of rows {:.1} ms apart, {clock}.",
        counted(found.len() as u64, ["window", "windows"]),
        1e3 * interval
    );
    let noisiest = position_noise.iter().zip(&mapping.positions).max_by(|a, b| a.0.total_cmp(b.0));
    let noise = noisiest.map(|(noise, column)| {
        format!(
            "{name}: positions scatter about their splines by {noise:.1e} {} at most (`{}`).",
            column.unit.si(),
            column.column
        )
    });
    let wrapping = wrapping(wraps, mapping).map(|columns| {
        format!("{name}: positions wrap ({columns}); full turns are added, so that each joint goes on.")
    });
    let messages = [
        "row is zero in all columns, as a message without content is, and is",
        "rows are zero in all columns, as messages without content are, and are",
    ];
    let empty = (*empty > 0).then(|| format!("{name}: {} left out.", counted(*empty, messages)));
    let strays = strays.first().map(|first| {
        let messages = ["row has", "rows have"];
        format!(
            "{name}: {} a joint that is suddenly elsewhere and back in the next (row {}: `{}` by {:.2} of a turn{}): its position there is taken from the rows beside. \
             Look at what wrote it.",
            counted(strays.len() as u64, messages),
            first.row,
            mapping.positions[first.joint].column,
            first.turns,
            if strays.len() > 1 { ", …" } else { "" }
        )
    });
    let oddities = oddities(name, *repeated, *without_time, *interruptions);
    [reported].into_iter().chain(noise).chain(wrapping).chain(empty).chain(strays).chain(oddities).collect()
}

fn standstill_notes(name: &str, standstills: &Standstills, mapping: &PoseMapping) -> Vec<String> {
    let Standstills { found, rejected, repeated, without_time, interruptions, wraps, .. } = standstills;
    let standstills = counted(found.len() as u64, ["standstill", "standstills"]);
    let reported = format!("{name}: {standstills} found{}{}", length(found), reported_rejected(rejected));
    let wrapping = wrapping(wraps, mapping).map(|columns| {
        format!(
            "{name}: positions jump by about a full turn ({columns}), as angles that wrap. A standstill right there has no mean."
        )
    });
    let oddities = oddities(name, *repeated, *without_time, *interruptions);
    [reported].into_iter().chain(wrapping).chain(oddities).collect()
}

/// Columns of the positions that wrap, and how often; `None` where none does.
fn wrapping(wraps: &[u64], mapping: &PoseMapping) -> Option<String> {
    let wrapping = wraps.iter().zip(&mapping.positions).filter(|(wraps, _)| **wraps > 0);
    let wrapping: Vec<String> =
        wrapping.map(|(wraps, column)| format!("`{}` {}", column.column, counted(*wraps, ["time", "times"]))).collect();
    (!wrapping.is_empty()).then(|| wrapping.join(", "))
}

/// How long they are, and what a mean is worth.
fn length(found: &[Standstill]) -> String {
    let mut durations: Vec<f64> = found.iter().map(|found| found.interval[1] - found.interval[0]).collect();
    let spreads = found.iter().flat_map(|found| found.torque.iter().chain(&found.instruments).flatten());
    let (mut samples, mut effective): (Vec<f64>, Vec<f64>) = spreads.map(|s| (s.samples, s.effective)).unzip();
    let middle = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let middles = (middle(&mut durations), middle(&mut samples), middle(&mut effective));
    let (Some(duration), Some(samples), Some(effective)) = middles else { return String::new() };
    format!(" (of {duration:.2} s and {samples:.0} samples, worth {effective:.0} independent ones, on the median)")
}

fn oddities(name: &str, repeated: u64, without_time: u64, interruptions: u64) -> Option<String> {
    let counts = [
        (repeated, ["row repeats the one before", "rows repeat the one before"]),
        (without_time, ["row has no time", "rows have no time"]),
        (
            interruptions,
            [
                "time the clock jumps or nothing is recorded for long",
                "times the clock jumps or nothing is recorded for long",
            ],
        ),
    ];
    let reported: Vec<String> =
        counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(*count, *what)).collect();
    (!reported.is_empty()).then(|| format!("{name}: {}.", reported.join(", ")))
}
