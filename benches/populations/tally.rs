//! What a population comes to: one table.

use std::fmt::Write;

use gravcal_calibration::result::Verdict;

use crate::starts::SAME;
use gravcal_benches::population::judge::{Cause, Judged};

/// A session, its answer and what is wrong with it.
#[derive(Clone, Debug)]
pub struct Trial {
    /// `bare-1-17-ur10`.
    pub name: String,
    /// None where the session is refused.
    pub verdict: Option<Verdict>,
    /// Processor time.
    pub seconds: f64,
    /// How the answer is judged.
    pub judged: Judged,
    /// Solves, by whichever method, that ended without an answer.
    pub failed: usize,
    /// By how much − ln L exceeds the lowest that random starts lead to, where that was looked for.
    pub above_lowest: Option<f64>,
}

/// A session should take no longer.
const SLOW: f64 = 1.0;

/// The table, in Markdown.
pub fn table(title: &str, trials: &[Trial]) -> String {
    let mut text = format!("{title}\n\n| | |\n|---|---|\n");
    for (what, value) in rows(trials) {
        let _ = writeln!(text, "| {what} | {value} |");
    }
    text
}

fn rows(trials: &[Trial]) -> Vec<(String, String)> {
    let count = |is: &dyn Fn(&Trial) -> bool| trials.iter().filter(|trial| is(trial)).count();
    let verdict = |verdict| count(&|trial| trial.verdict == Some(verdict));
    let mut rows = vec![
        ("sessions".to_owned(), trials.len().to_string()),
        (
            "determined, partly determined, failed, refused".to_owned(),
            format!(
                "{}, {}, {}, {}",
                verdict(Verdict::Determined),
                verdict(Verdict::PartlyDetermined),
                verdict(Verdict::Failed),
                count(&|trial| trial.verdict.is_none()),
            ),
        ),
        ("**wrong**".to_owned(), format!("**{}**", count(&is_wrong))),
    ];
    let of_cause = |cause| count(&|trial| trial.judged.causes().contains(&cause));
    rows.extend(Cause::ALL.map(|cause| (cause.to_string(), of_cause(cause).to_string())));
    rows.extend([
        (
            "told what rank denies only if unknowns have no end".to_owned(),
            count(&|trial| !trial.judged.denied_without_end.is_empty()).to_string(),
        ),
        (
            "std below half the bound only if unknowns have no end".to_owned(),
            count(&|trial| !trial.judged.narrow_without_end.is_empty()).to_string(),
        ),
        ("told of what is determined well enough to be of use".to_owned(), reported(trials)),
        ("within the 95 % interval".to_owned(), covered(trials)),
        ("largest error, standard deviations".to_owned(), largest(trials)),
        ("processor time of a session: median, largest".to_owned(), times(trials)),
        (format!("sessions above {SLOW} s"), count(&|trial| trial.seconds > SLOW).to_string()),
        (
            "solves without an answer, of all methods".to_owned(),
            trials.iter().map(|trial| trial.failed).sum::<usize>().to_string(),
        ),
    ]);
    rows.extend(lowest(trials));
    rows
}

/// How many answers lie no higher than the lowest end of random starts, and which lies highest.
fn lowest(trials: &[Trial]) -> Option<(String, String)> {
    let above: Vec<(f64, &Trial)> = trials.iter().filter_map(|trial| Some((trial.above_lowest?, trial))).collect();
    let (most, highest) = above.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let as_low = above.iter().filter(|(above, _)| *above <= SAME).count();
    let share = percent(as_low, above.len());
    let value = format!("{as_low} of {} ({share:.1} %); most above: {most:.1} ({})", above.len(), highest.name);
    Some(("as likely as the likeliest of the random starts".to_owned(), value))
}

/// Whether anything is wrong.
pub fn is_wrong(trial: &Trial) -> bool {
    !trial.judged.wrong.is_empty()
}

fn reported(trials: &[Trial]) -> String {
    let [all, reported] = [0, 1].map(|which| trials.iter().map(|trial| trial.judged.of_use[which]).sum::<usize>());
    format!("{reported} of {all} ({:.1} %)", percent(reported, all))
}

fn covered(trials: &[Trial]) -> String {
    let errors = || trials.iter().flat_map(|trial| &trial.judged.errors);
    let (held, all) = (errors().filter(|(_, held)| *held).count(), errors().count());
    format!("{held} of {all} ({:.1} %)", percent(held, all))
}

fn percent(part: usize, all: usize) -> f64 {
    100.0 * part as f64 / all.max(1) as f64
}

fn largest(trials: &[Trial]) -> String {
    let errors = trials.iter().flat_map(|trial| trial.judged.errors.iter().map(move |(error, _)| (error.abs(), trial)));
    errors
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or("–".to_owned(), |(error, trial)| format!("{error:.1} ({})", trial.name))
}

fn times(trials: &[Trial]) -> String {
    let mut by_time: Vec<&Trial> = trials.iter().collect();
    by_time.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let (Some(median), Some(slowest)) = (by_time.get(by_time.len() / 2), by_time.last()) else {
        return "–".to_owned();
    };
    format!("{:.3} s, {:.2} s ({})", median.seconds, slowest.seconds, slowest.name)
}
