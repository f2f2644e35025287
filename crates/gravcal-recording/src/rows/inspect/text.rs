//! An inspection as text of 80 columns.

use std::fmt;

use crate::counted::counted;
use crate::iso8601::{self, ISO_8601};

use super::{ColumnFound, Inspection, Meaning, TimeFound};

/// Longest name of a column that is told in full.
const NAME: usize = 29;
/// Rows that are nearer than this, s, are samples of a motion.
const SAMPLED: f64 = 0.2;
/// No reading of any sensor, in any unit, is beyond this.
const RUBBISH: f64 = 1e30;

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, {} rows", self.source.kind, self.rows)?;
        for (key, value) in &self.metadata {
            wrapped(f, "  ", &format!("{key} = {value}"))?;
        }
        for topic in &self.source.topics {
            let encoding = if topic.encoding.is_empty() { String::new() } else { format!(" in {}", topic.encoding) };
            wrapped(f, "  ", &format!("{}: {} messages, {}{encoding}", topic.name, topic.messages, topic.kind))?;
        }
        match &self.time {
            Some(time) => time_text(f, time)?,
            None => {
                writeln!(f, "No column is a clock: rows are taken to be equally far apart.")?;
                self.perhaps_clock().map_or(Ok(()), |perhaps| wrapped(f, "", &perhaps))?;
            }
        }
        if self.repeated > 0 {
            let rows = ["row repeats the row before it", "rows repeat the row before them"];
            writeln!(f, "{}.", counted(self.repeated, rows))?;
        }
        columns_text(f, &self.columns, self.time.as_ref())?;
        for doubt in self.pairing_doubt().into_iter().chain(self.topics_doubt()) {
            writeln!(f)?;
            wrapped(f, "", &doubt)?;
        }
        if !self.remarks.is_empty() {
            writeln!(f, "\nLost or left out")?;
        }
        self.remarks.iter().try_for_each(|remark| wrapped(f, "  - ", remark))
    }
}

/// Rows from which on it is no chance that a column only rises.
const RISING: u64 = 20;

impl Inspection {
    /// What may be a clock though its name does not tell it.
    fn perhaps_clock(&self) -> Option<String> {
        let rises = |column: &&ColumnFound| {
            column.rises && column.guess.meaning.is_none() && column.readings == self.rows && self.rows >= RISING
        };
        let column = self.columns.iter().find(rises)?;
        Some(format!(
            "`{0}` rises in every row: if it is one, call it `time_ms` (or _s, _us, _ns, by its unit), or say time = {{ column = \"{0}\", \
             unit = \"ms\" }} in [readings] of a session.",
            column.name
        ))
    }
}

fn time_text(f: &mut fmt::Formatter<'_>, time: &TimeFound) -> fmt::Result {
    let TimeFound { column, unit, from_s, to_s, interval_s, .. } = time;
    let from = instant(Some(time), *from_s);
    writeln!(f, "{:.3} s from {from} on, {} Hz (`{column}` in {unit})", to_s - from_s, rate(*interval_s))?;
    if time.stands() {
        let text = format!(
            "The clock stands: {} of {} rows have the time of the row before. `{column}` was written with too few digits (1.764144e+09 for \
             1764144012.345), or is no time of measurement. Write it again with all its decimals.",
            time.standing, time.rows
        );
        wrapped(f, "", &text)?;
    }
    if time.gaps > 0 {
        let gaps: Vec<String> = time
            .first_gaps
            .iter()
            .map(|gap| format!("{:.3} s at {}", gap.lasts_s, instant(Some(time), gap.at_s)))
            .collect();
        let more = if time.gaps > gaps.len() as u64 { ", …" } else { "" };
        wrapped(
            f,
            "",
            &format!("{} of more than five intervals: {}{more}.", counted(time.gaps, ["gap", "gaps"]), gaps.join(", ")),
        )?;
    }
    if let Some(row) = time.first_backwards {
        writeln!(f, "Time goes backwards {}, first at row {row}.", counted(time.backwards, ["time", "times"]))?;
    }
    if time.missing > 0 {
        writeln!(f, "{}.", counted(time.missing, ["row has no time", "rows have no time"]))?;
    }
    Ok(())
}

/// A time as its clock tells it.
fn instant(time: Option<&TimeFound>, seconds: f64) -> String {
    match time.is_some_and(|time| time.unit == ISO_8601) {
        true => iso8601::text(seconds),
        false => format!("{seconds:.3} s"),
    }
}

/// Rate of an interval, with four digits.
fn rate(interval_s: f64) -> String {
    let rate = 1.0 / interval_s;
    match rate {
        _ if !rate.is_finite() => "-".to_owned(),
        1000.0.. => format!("{rate:.0}"),
        100.0.. => format!("{rate:.1}"),
        _ => format!("{rate:.2}"),
    }
}

fn columns_text(f: &mut fmt::Formatter<'_>, columns: &[ColumnFound], time: Option<&TimeFound>) -> fmt::Result {
    let clock = time.is_some();
    let width = columns.iter().map(|column| column.name.chars().count()).max().unwrap_or(0).clamp(6, NAME);
    let heading = if clock { "Hz" } else { "" };
    writeln!(f, "\n{:width$} {:>9} {heading:>7} {:>11} {:>11}  perhaps", "column", "readings", "lowest", "highest")?;
    for column in columns {
        let mut name = column.name.as_str();
        if name.chars().count() > width {
            writeln!(f, "{name}")?;
            name = "";
        }
        let rate = if clock { rate(column.interval_s) } else { String::new() };
        let [lowest, highest] = [column.lowest, column.highest].map(number);
        let unit = column.guess.unit.unwrap_or("-");
        writeln!(f, "{name:width$} {:>9} {rate:>7} {lowest:>11} {highest:>11}  {unit}", column.readings)?;
        if column.readings == 0 {
            continue;
        }
        match &column.stuck {
            Some(_) if column.lowest == column.highest => wrapped(f, "  ! ", "it never changes")?,
            Some(stuck) => {
                let from = instant(time, stuck.from_s);
                let text = format!("stuck at {} for {} readings from {from} on", stuck.at, stuck.readings);
                wrapped(f, "  ! ", &text)?;
            }
            None => {}
        }
        // From one static pose to the next a joint may turn by as much.
        if column.wraps > 0 && time.is_some_and(|time| time.interval_s < SAMPLED) {
            let text = format!(
                "jumps by about a full turn {} times, as an angle that wraps. With still = {{}} and motion = {{}} poses are taken as the joint goes \
                 on; where each row is a pose, add the turns yourself.",
                column.wraps
            );
            wrapped(f, "  ! ", &text)?;
        }
        if column.guess.commanded {
            wrapped(f, "  - ", "what was asked of the joint, as its name says: no reading of a sensor")?;
        }
        if column.guess.meaning == Some(Meaning::ForceTorque) {
            wrapped(f, "  - ", "of a force-torque sensor, as its name says: a [[force_torque_sensor]] of a session")?;
        }
        if column.guess.meaning == Some(Meaning::Orientation) {
            wrapped(f, "  - ", "part of an orientation, as its name says: [readings] orientation of a session")?;
        }
        if column.lowest.abs().max(column.highest.abs()) > RUBBISH {
            wrapped(
                f,
                "  ! ",
                "no sensor reads such numbers: see where they come from before anything is done with them",
            )?;
        }
        for end in &column.clipped {
            let text = format!("{} readings are {}, which may be an end of the sensor's range", end.readings, end.at);
            wrapped(f, "  ! ", &text)?;
        }
    }
    let is_effort = |column: &ColumnFound| column.guess.meaning == Some(Meaning::Torque) && !column.guess.unit_named;
    if columns.iter().any(is_effort) {
        let text = "Units that names do not tell are guesses. Whether an effort is a torque in N·m, a current in A or a share in %, and \
                    whether it was measured or reckoned from a model, no recording tells: the robot's driver does.";
        writeln!(f)?;
        wrapped(f, "", text)?;
    }
    Ok(())
}

/// A number in eleven letters at most.
fn number(number: f64) -> String {
    match number.abs() {
        _ if number.is_nan() => "-".to_owned(),
        0.0 => "0".to_owned(),
        1e-3..1e5 => format!("{number:.4}"),
        _ => format!("{number:.3e}"),
    }
}

/// Lines of 80 columns, the first after `start`, the others as far in; words longer than that stand alone.
fn wrapped(f: &mut fmt::Formatter<'_>, start: &str, text: &str) -> fmt::Result {
    let indent = start.chars().count();
    let mut line = start.to_owned();
    let mut length = indent;
    for word in text.split(' ') {
        let letters = word.chars().count();
        if length > indent && length + 1 + letters > 80 {
            writeln!(f, "{}", line.trim_end())?;
            (line, length) = (" ".repeat(indent), indent);
        }
        if length > indent {
            line.push(' ');
            length += 1;
        }
        line.push_str(word);
        length += letters;
    }
    writeln!(f, "{}", line.trim_end())
}
