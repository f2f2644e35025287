//! What the session's tables hold: poses, torque readings, sweeps.

use gravcal_calibration::check::{CheckReport, SweepReport};

use crate::grid::{Cell, Grid, Side};
use crate::text::wrapped;

pub(super) fn report(report: &CheckReport) -> String {
    let poses = listed("Poses by load", &report.poses);
    let standstills = report.standstills.iter().map(|reported| wrapped("", "  ", reported)).collect::<String>();
    let notes =
        report.selection.iter().chain(&report.unmoved).map(|reported| wrapped("", "  ", reported)).collect::<String>();
    poses + &listed("Torque readings by joint", &report.torque_readings) + &standstills + &notes
}

fn listed(heading: &str, counts: &[(String, usize)]) -> String {
    let reported: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
    wrapped(&format!("{heading}: "), "  ", &reported.join(", "))
}

pub(super) fn report_sweeps(report: &CheckReport) -> String {
    let mut text = format!("Sweeps\n{}", wrapped("  ", "  ", &report.sweep_rule));
    if report.sweeps.is_empty() {
        return text + "  none found\n";
    }
    let mut grid =
        Grid::new(vec![Side::Left, Side::Right, Side::Right, Side::Right, Side::Left, Side::Left, Side::Left]);
    grid.row(["swept", "poses", "from, deg", "to, deg", "load", "steps", "table:lines"].map(Cell::text).into());
    report.sweeps.iter().for_each(|sweep| grid.row(row(sweep)));
    text += &grid.lines("  ");
    text
}

fn row(sweep: &SweepReport) -> Vec<Cell> {
    let steps: Vec<String> = sweep.steps.iter().map(u8::to_string).collect();
    let [first, last] = sweep.lines;
    vec![
        Cell::text(&sweep.joint),
        Cell::text(sweep.poses.to_string()),
        Cell::text(format!("{:.1}", sweep.range_deg[0])),
        Cell::text(format!("{:.1}", sweep.range_deg[1])),
        Cell::text(sweep.load.as_deref().unwrap_or("none")),
        Cell::text(if steps.is_empty() { "none".to_owned() } else { steps.join(", ") }),
        Cell::text(format!("{}:{first}-{last}", sweep.table)),
    ]
}
