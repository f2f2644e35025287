//! What a study comes to, on one screen: whether intervals hold, one line an estimator at a point, what has no estimate, what failed.
//!
//! Where there are more points than lines, the values of the last axes stand together in one line.

use std::collections::BTreeMap;
use std::fmt;

use gravcal_robot_model::number::{shortest, significant};
use gravcal_study::batch::Outcome;
use gravcal_study::measures::{QuantityMeasures, Series};

use super::StudyReport;
use super::ranges::{Range, coverage, over_bound};
use crate::grid::{Cell, Grid, Side};
use crate::summary::first_lines;
use crate::text::{WIDTH, plain, width, wrapped};

/// Lines at most, so that a screen of 25 has room for where the results are, and how long they took.
const MOST: usize = 23;
/// Of these at most: what is studied, whether intervals hold, what has no estimate, what failed, what the columns are.
const TEXTS: [usize; 5] = [2, 3, 2, 3, 3];
/// Intervals hold the truth too seldom where so many standard errors are missing: of a thousand shares that are right none is that low.
const STANDARD_ERRORS: f64 = 4.0;
/// What a 95 % interval should do.
const HOLDS: f64 = 0.95;

/// What a study comes to, in at most 23 lines of 80 columns.
#[derive(Clone, Copy, Debug)]
pub struct StudySummary<'a>(pub StudyReport<'a>);

impl fmt::Display for StudySummary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&plain(&summary(&self.0)))
    }
}

/// The series that one line tells.
struct Line<'s> {
    /// Where on the axes that are told apart.
    places: Vec<usize>,
    series: Vec<&'s Series>,
}

fn summary(report: &StudyReport<'_>) -> String {
    let texts = [
        wrapped("", "  ", &subject(report)),
        wrapped("  ", "  ", &intervals(report)),
        silent(report),
        failures(report),
        legend(report, 0),
    ];
    let [subject, intervals, silent, failures, longest_legend] =
        std::array::from_fn(|at| first_lines(&texts[at], TEXTS[at]));
    let others = [&subject, &intervals, &silent, &failures, &longest_legend];
    let taken: usize = others.iter().map(|text| text.lines().count()).sum();
    // The table's head, and a line before it.
    let (apart, lines) = fitting(report, MOST.saturating_sub(taken + 2).max(1));
    let table = first_lines(&table(report, apart, &lines), MOST - taken - 1);
    let legend = first_lines(&legend(report, apart), TEXTS[4]);
    format!("{subject}{intervals}\n{table}{silent}{failures}{legend}")
}

/// `Study of sequential, joint over noise: 300 trials at each of 5 points`.
fn subject(report: &StudyReport<'_>) -> String {
    let (points, trials) = (report.manifest.points.len(), report.manifest.trials);
    let each = if points == 1 { String::new() } else { format!(" at each of {points} points") };
    format!("{}: {trials} trials{each}", report.title())
}

/// Whether 95 % intervals hold the truth as often as they should.
fn intervals(report: &StudyReport<'_>) -> String {
    let quantities = report.series.iter().flat_map(|series| {
        let named = report.manifest.quantities.iter().zip(&series.quantities);
        named.map(move |((name, _), quantity)| (series, name, quantity))
    });
    let reported: Vec<_> = quantities.filter(|(.., quantity)| quantity.estimates > 0).collect();
    let worst = reported.iter().filter(|(.., quantity)| too_seldom(quantity));
    let count = worst.clone().count();
    let worst = worst.min_by(|a, b| a.2.coverage.value.total_cmp(&b.2.coverage.value));
    match (reported.len(), worst) {
        (0, _) => "No trial has an estimate.".to_owned(),
        (_, None) => "The 95 % intervals of every number hold the truth as often as they should.".to_owned(),
        (all, Some((series, name, quantity))) => {
            let at = report.manifest.reported(series.point);
            let at = if at.is_empty() { at } else { format!(" at {at}") };
            format!(
                "Of {count} of {all} numbers the 95 % intervals hold the truth too seldom. The worst: {name} by {}{at}, {} %.",
                report.name(series),
                significant(coverage(quantity), 3)
            )
        }
    }
}

fn too_seldom(quantity: &QuantityMeasures) -> bool {
    let error = (HOLDS * (1.0 - HOLDS) / quantity.estimates as f64).sqrt();
    quantity.coverage.value + STANDARD_ERRORS * error < HOLDS
}

/// Of how many axes, from the first on, the values are told apart so that there are no more lines than `most`; and these lines.
fn fitting<'s>(report: &'s StudyReport<'_>, most: usize) -> (usize, Vec<Line<'s>>) {
    let axes = report.manifest.axes.len();
    let grouped = (0..=axes).rev().map(|apart| (apart, lines(report, apart)));
    let mut fitting = grouped.skip_while(|(apart, lines)| *apart > 0 && lines.len() > most);
    fitting.next().unwrap_or_default()
}

fn lines<'s>(report: &'s StudyReport<'_>, apart: usize) -> Vec<Line<'s>> {
    let mut lines: BTreeMap<(Vec<usize>, usize, usize), Vec<&Series>> = BTreeMap::new();
    for series in report.series {
        let places = report.manifest.points[series.point][..apart].to_vec();
        lines.entry((places, series.estimator, series.solver)).or_default().push(series);
    }
    lines.into_iter().map(|((places, ..), series)| Line { places, series }).collect()
}

/// Columns of numbers, and between two columns two spaces.
fn table(report: &StudyReport<'_>, apart: usize, lines: &[Line<'_>]) -> String {
    let compares = compares(report);
    let mut rows = vec![head(report, apart, compares)];
    rows.extend(lines.iter().map(|line| row(report, apart, compares, line)));
    // Names give way: numbers do not.
    let names = usize::from(apart > 0) + usize::from(compares);
    let numbers: usize = (names..rows[0].len()).map(|column| 2 + widest(&rows, column)).sum();
    let mut left = WIDTH.saturating_sub(numbers);
    for column in (0..names).rev() {
        let most = if column == 0 { left } else { left * 2 / 3 };
        rows.iter_mut().for_each(|row| row[column] = cut(&row[column], most));
        left = left.saturating_sub(widest(&rows, column) + 2);
    }
    let sides = (0..rows[0].len()).map(|column| if column < names { Side::Left } else { Side::Right });
    let mut grid = Grid::new(sides.collect());
    rows.into_iter().for_each(|row| grid.row(row.into_iter().map(Cell::text).collect()));
    grid.lines("")
}

fn widest(rows: &[Vec<String>], column: usize) -> usize {
    rows.iter().map(|row| width(&row[column])).max().unwrap_or_default()
}

fn cut(text: &str, most: usize) -> String {
    match width(text) > most {
        true => text.chars().take(most.saturating_sub(1)).chain(['…']).collect(),
        false => text.to_owned(),
    }
}

/// Whether there are several estimators or solvers.
fn compares(report: &StudyReport<'_>) -> bool {
    report.reference(0).is_some()
}

fn head(report: &StudyReport<'_>, apart: usize, compares: bool) -> Vec<String> {
    let axis = report.manifest.axes[..apart].iter().map(|axis| match &axis.unit {
        Some(unit) => format!("{}, {unit}", axis.name),
        None => axis.name.clone(),
    });
    let mut head: Vec<String> = Vec::new();
    if apart > 0 {
        head.push(axis.collect::<Vec<_>>().join("; "));
    }
    if compares {
        head.push("estimator".to_owned());
    }
    head.extend(["answers", "error/bound", "in 95 %"].map(str::to_owned));
    if compares {
        head.push("error/last".to_owned());
    }
    head
}

fn row(report: &StudyReport<'_>, apart: usize, compares: bool, line: &Line<'_>) -> Vec<String> {
    let reported = |range: Option<Range>| range.map_or_else(|| "–".to_owned(), |range| range.reported());
    let series = || line.series.iter().copied();
    let mut row: Vec<String> = Vec::new();
    if apart > 0 {
        let labels = line.places.iter().zip(&report.manifest.axes).map(|(place, axis)| axis.labels[*place].as_str());
        row.push(labels.collect::<Vec<_>>().join("; "));
    }
    if compares {
        row.push(line.series.first().map(|series| report.name(series)).unwrap_or_default());
    }
    row.push(format!("{} %", shortest(100.0 * answered(series()))));
    row.push(reported(Range::over_quantities(series(), over_bound)));
    row.push(reported(Range::over_quantities(series(), coverage)));
    if compares {
        row.push(reported(Range::of(series().flat_map(|series| over_last(report, series)))));
    }
    row
}

/// Share of trials with an answer.
fn answered<'s>(series: impl Iterator<Item = &'s Series>) -> f64 {
    let (failed, trials) = series.fold((0, 0), |(failed, trials), series| {
        (failed + series.outcomes[Outcome::Failed as usize], trials + series.trials)
    });
    1.0 - failed as f64 / trials as f64
}

/// The rms error of each quantity over that of the last estimator at the same point; none of the last one itself.
fn over_last(report: &StudyReport<'_>, series: &Series) -> Vec<f64> {
    let Some(last) = report.reference(series.point).filter(|_| !report.is_reference(series)) else { return Vec::new() };
    let pairs = series.quantities.iter().zip(&last.quantities);
    pairs.map(|(own, last)| own.rms.value / last.rms.value).collect()
}

/// Which quantities an estimator never has, at no point.
fn silent(report: &StudyReport<'_>) -> String {
    let reported = lines(report, 0).into_iter().filter_map(|line| {
        let names = report.manifest.quantities.iter().enumerate();
        let never = names.filter(|(at, _)| line.series.iter().all(|series| series.quantities[*at].estimates == 0));
        let never: Vec<&str> = never.map(|(_, (name, _))| name.as_str()).collect();
        let name = report.name(line.series.first()?);
        match never.len() {
            0 => None,
            all if all == report.manifest.quantities.len() => Some(format!("{name} has no estimate")),
            _ => Some(format!("{name} has no estimate of {}", never.join(", "))),
        }
    });
    let reported: Vec<String> = reported.collect();
    if reported.is_empty() { String::new() } else { wrapped("", "  ", &format!("{}.", reported.join("; "))) }
}

/// Why trials failed, the most frequent reason first.
fn failures(report: &StudyReport<'_>) -> String {
    let mut reasons: BTreeMap<(String, &str), u64> = BTreeMap::new();
    for series in report.series {
        for (reason, count) in &series.reasons {
            *reasons.entry((report.name(series), reason)).or_default() += count;
        }
    }
    let mut reasons: Vec<_> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let reported = reasons
        .iter()
        .map(|((name, reason), count)| wrapped("", "  ", &format!("{name} failed {count} times: {reason}")));
    reported.collect()
}

fn legend(report: &StudyReport<'_>, apart: usize) -> String {
    let axes: Vec<&str> = report.manifest.axes[apart..].iter().map(|axis| axis.name.as_str()).collect();
    let all = if axes.is_empty() { String::new() } else { format!(" and values of {}", axes.join(", ")) };
    let last = match report.reference(0) {
        Some(last) => format!(" error/last: rms error over that of {}.", report.name(last)),
        None => String::new(),
    };
    wrapped(
        "",
        "  ",
        &format!(
            "Ranges over quantities{all}. error/bound: rms error over the Cramér-Rao bound. in 95 %: % of intervals \
             that hold the truth.{last} --full: each quantity."
        ),
    )
}

#[cfg(test)]
mod tests {
    use gravcal_study::batch::Manifest;

    use super::*;
    use crate::study::testing::{TRIALS, axis, manifest, quantity, series};

    fn reported(manifest: &Manifest, series: &[Series]) -> String {
        let text = StudySummary(StudyReport { manifest, series }).to_string();
        assert!(text.lines().count() <= MOST, "{text}");
        assert!(text.lines().all(|line| width(line) <= WIDTH), "{text}");
        text
    }

    #[test]
    fn every_point_has_a_line_where_there_is_room() {
        let manifest = manifest(&["sequential", "joint"], vec![axis("noise", &["0.2", "0.8", "3.2"])]);
        let text = reported(&manifest, &series(&manifest));
        let row = |label: &str, name: &str| {
            let mut rows = text.lines().filter(|line| line.starts_with(label) && line.contains(name));
            rows.next().unwrap_or_else(|| panic!("{text}")).split_whitespace().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(row("0.8", "sequential"), "0.8 sequential 100 % 3.00 95.0 3.00");
        assert_eq!(row("3.2", "joint"), "3.2 joint 100 % 1.00 95.0 –");
        assert!(text.starts_with("Study of sequential, joint over noise: 400 trials at each of 3 points\n"), "{text}");
        assert!(text.contains("as often as they should"), "{text}");
        assert!(!text.contains("values of"), "{text}");
    }

    #[test]
    fn intervals_that_hold_too_seldom_come_first() {
        let manifest = manifest(&["sequential", "joint"], vec![axis("noise", &["0.2", "0.8"])]);
        let mut series = series(&manifest);
        // 0.907 is 3.95 standard errors below, and may be chance; 0.905 is 4.1.
        series[0].quantities[0] = quantity(3.0, 0.907, TRIALS);
        assert!(reported(&manifest, &series).contains("as often as they should"));
        series[0].quantities[0] = quantity(3.0, 0.905, TRIALS);
        series[2].quantities[1] = quantity(3.0, 0.81, TRIALS);
        let text = reported(&manifest, &series).split_whitespace().collect::<Vec<_>>().join(" ");
        let worst = "joint1.torque_bias by sequential at noise = 0.8 count, 81.0 %.";
        assert!(
            text.contains(&format!(
                "Of 2 of 8 numbers the 95 % intervals hold the truth too seldom. The worst: {worst}"
            )),
            "{text}"
        );
    }

    #[test]
    fn what_is_too_much_stands_together() {
        let long = "a very long description of one of the values that are varied";
        let labels: Vec<String> = (0..7).map(|value| format!("{value} {long}")).collect();
        let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
        let axes = vec![axis("noise", &labels), axis("converter", &labels)];
        let manifest = manifest(&["sequential-true-steps-1-and-2", "joint"], axes);
        let mut series = series(&manifest);
        let last = series.len() - 2;
        series[last].quantities[0] = quantity(9.0, 0.95, TRIALS);
        series.iter_mut().for_each(|series| series.quantities[1] = quantity(1.0, 0.95, 0));
        for (at, series) in series.iter_mut().enumerate() {
            series.outcomes = [0, 0, TRIALS];
            series.reasons = vec![(format!("reason {at}: {long}, {long}"), TRIALS)];
        }
        let text = reported(&manifest, &series);
        let rows = text.lines().filter(|line| line.contains("sequential") && line.contains("0 %")).count();
        assert_eq!(rows, 1, "{text}");
        assert!(text.contains("3.00 to 9.00") && text.contains("values of"), "{text}");
        assert!(text.contains("has no estimate of joint1.torque_bias"), "{text}");
        assert!(text.contains("failed 400 times: reason"), "{text}");
        let last = text.lines().find(|line| line.starts_with("joint ") && line.contains('%'));
        assert!(last.is_some_and(|line| line.ends_with('–')), "{text}");
    }

    #[test]
    fn more_estimators_than_lines_are_said_to_be_more() {
        let names: Vec<String> = (0..40).map(|at| format!("estimator-{at}")).collect();
        let manifest = manifest(&names.iter().map(String::as_str).collect::<Vec<_>>(), Vec::new());
        assert!(reported(&manifest, &series(&manifest)).contains('…'));
    }
}
