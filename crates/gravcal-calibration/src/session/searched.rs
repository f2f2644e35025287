//! What was found in a file of poses, and what a user should know of it.

use std::path::PathBuf;

use gravcal_recording::{Standstill, Standstills};

/// One file.
#[derive(Clone, Debug, PartialEq)]
pub struct Searched {
    /// The file.
    pub path: PathBuf,
    /// Its standstills, and what was none; `None` of a table whose rows are poses.
    pub standstills: Option<Standstills>,
    /// What the reader says of the file: what was lost, cells that are no numbers.
    pub remarks: Vec<String>,
}

/// So many rejected intervals are told one by one.
const TOLD: usize = 5;

impl Searched {
    /// How many poses it gives; of a table whose rows are poses none counts.
    pub fn found(&self) -> usize {
        self.standstills.as_ref().map_or(0, |standstills| standstills.found.len())
    }

    /// How many standstills there are, of which length, and what was rejected and why, for people.
    pub fn notes(&self) -> Vec<String> {
        let name =
            self.path.file_name().map_or_else(|| self.path.display().to_string(), |n| n.to_string_lossy().into());
        let standstills = self.standstills.iter().flat_map(|found| standstill_notes(&name, found));
        standstills.chain(self.remarks.iter().map(|remark| format!("{name}: {remark}"))).collect()
    }
}

fn standstill_notes(name: &str, standstills: &Standstills) -> Vec<String> {
    let Standstills { found, rejected, .. } = standstills;
    let mut told = format!("{name}: {} standstills found{}", found.len(), length(found));
    if rejected.is_empty() {
        told.push('.');
    } else {
        told += &format!(", {} rejected:", rejected.len());
        for rejected in rejected.iter().take(TOLD) {
            told += &format!(" {rejected};");
        }
        told.pop();
        told += if rejected.len() > TOLD { "; …" } else { "." };
    }
    [told].into_iter().chain(oddities(name, standstills)).collect()
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

fn oddities(name: &str, standstills: &Standstills) -> Option<String> {
    let Standstills { repeated, without_time, interruptions, .. } = *standstills;
    let counts = [
        (repeated, "rows repeat the one before"),
        (without_time, "rows have no time"),
        (interruptions, "times the clock jumps or nothing is recorded for long"),
    ];
    let told: Vec<String> =
        counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    (!told.is_empty()).then(|| format!("{name}: {}.", told.join(", ")))
}
