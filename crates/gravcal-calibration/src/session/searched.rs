//! What was found in a recording in motion, and what a user should know of it.

use std::path::PathBuf;

use gravcal_recording::Standstills;

/// One recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Searched {
    /// The file.
    pub path: PathBuf,
    /// What was found, and what was not a standstill.
    pub standstills: Standstills,
    /// What the reader says of the file: what was lost, cells that are no numbers.
    pub remarks: Vec<String>,
}

/// So many rejected intervals are told one by one.
const TOLD: usize = 5;

impl Searched {
    /// For people.
    pub(crate) fn notes(&self) -> Vec<String> {
        let Standstills { found, rejected, .. } = &self.standstills;
        let name =
            self.path.file_name().map_or_else(|| self.path.display().to_string(), |n| n.to_string_lossy().into());
        let mut told = format!("{name}: {} standstills found{}", found.len(), self.length());
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
        [told]
            .into_iter()
            .chain(self.oddities(&name))
            .chain(self.remarks.iter().map(|r| format!("{name}: {r}")))
            .collect()
    }

    /// How long they are, and what a mean is worth.
    fn length(&self) -> String {
        let found = &self.standstills.found;
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

    fn oddities(&self, name: &str) -> Option<String> {
        let Standstills { repeated, without_time, interruptions, .. } = self.standstills;
        let counts = [
            (repeated, "rows repeat the one before"),
            (without_time, "rows have no time"),
            (interruptions, "times the clock jumps or nothing is recorded for long"),
        ];
        let told: Vec<String> =
            counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
        (!told.is_empty()).then(|| format!("{name}: {}.", told.join(", ")))
    }
}
