//! A comparison as text of 80 columns: the verdict, the tests, the values of what moved.

use gravcal_calibration::comparison::{Comparison, GRAVITY, SIGNIFICANCE, SensorComparison};

use super::{ComparisonReport, caveats};
use crate::grid::{Cell, Grid, Side};
use crate::sensor_row::{shown_unit, split_name};
use crate::text::wrapped;
use gravcal_robot_model::number::{measured, significant};

pub(super) fn text(report: &ComparisonReport<'_>) -> String {
    let files =
        report.files.iter().enumerate().map(|(index, file)| wrapped("  ", "     ", &format!("{}  {file}", index + 1)));
    let sections = [
        doubts(report.comparison) + &verdict(report.comparison) + &files.collect::<String>() + &warnings(report),
        tests(report),
        values(report),
        left_out(report),
    ];
    sections.into_iter().filter(|section| !section.is_empty()).collect::<Vec<_>>().join("\n")
}

/// What must be known before a sensor is blamed.
fn doubts(comparison: &Comparison) -> String {
    let doubtful = comparison.doubts.iter().enumerate().filter(|(_, doubts)| !doubts.is_empty());
    let reported: Vec<String> =
        doubtful.map(|(index, doubts)| format!("calibration {} ({})", index + 1, doubts.join("; "))).collect();
    if reported.is_empty() { String::new() } else { wrapped("", "  ", &format!("Doubtful: {}", reported.join(", "))) }
}

fn verdict(comparison: &Comparison) -> String {
    let blamed = match comparison.doubts.iter().any(|doubts| !doubts.is_empty()) {
        true => "Moved, or spoilt by an error of a model",
        false => "Moved",
    };
    let not_seen = comparison.not_seen().join(", ");
    let moved: Vec<String> = comparison.moved().map(|sensor| moved(comparison, sensor)).collect();
    match (moved.is_empty(), not_seen.is_empty()) {
        (true, true) => "Nothing moved, as far as these calibrations tell\n".to_owned(),
        (true, false) => wrapped("", "  ", &format!("Nothing that can be compared moved; not seen: {not_seen}")),
        (false, true) => wrapped("", "  ", &format!("{blamed}: {}", moved.join(", "))) + &base_frame(comparison),
        (false, false) => {
            wrapped("", "  ", &format!("{blamed}: {}", moved.join(", ")))
                + &base_frame(comparison)
                + &wrapped("", "  ", &format!("Not seen: {not_seen}"))
        }
    }
}

/// A sensor, with all that may have moved in its stead.
fn moved(comparison: &Comparison, sensor: &SensorComparison) -> String {
    let offsets = comparison.base_frame.iter().filter(|_| sensor.name == GRAVITY);
    let others = sensor.beside_others.iter().flat_map(|beside| &beside.or);
    std::iter::once(&sensor.name).chain(offsets).chain(others).cloned().collect::<Vec<_>>().join(" or ")
}

/// What a move of gravity means, if it moved.
fn base_frame(comparison: &Comparison) -> String {
    let offsets = comparison.base_frame.join(", ");
    if offsets.is_empty() || comparison.moved().all(|sensor| sensor.name != GRAVITY) {
        return String::new();
    }
    let reported = format!(
        "Gravity stands in the frame of the base, which {offsets} defines: either the base was tilted, or that offset moved. \
         A level on the base tells which."
    );
    wrapped("  ", "  ", &reported)
}

fn warnings(report: &ComparisonReport<'_>) -> String {
    let all = caveats::warnings(report.comparison, report.shared, report.robots);
    all.iter().map(|warning| wrapped("", "  ", &format!("Warning: {warning}"))).collect()
}

/// Probabilities, and what they mean.
fn tests(report: &ComparisonReport<'_>) -> String {
    let mut grid = Grid::new(vec![Side::Left, Side::Right, Side::Right, Side::Right, Side::Right, Side::Left]);
    grid.row(["", "χ²", "dof", "p", "corrected", ""].map(Cell::text).into());
    for sensor in &report.comparison.sensors {
        let mut row = vec![Cell::text(&sensor.name)];
        match &sensor.test {
            None => row.extend(["", "", "", "", "not compared"].map(Cell::text)),
            Some(test) => {
                row.push(Cell::text(significant(test.chi_squared, 3)));
                row.push(Cell::text(test.degrees_of_freedom.to_string()));
                row.extend([test.p_value, test.corrected_p_value].map(|p| Cell::text(probability(p))));
                row.push(Cell::text(step(report, sensor)));
            }
        }
        grid.row(row);
    }
    let tests = report.comparison.tests();
    let explained = format!(
        "p: probability of such differences if the sensor has not moved. corrected: for {tests} {} (Holm); below {SIGNIFICANCE} it \
         has moved.",
        if tests == 1 { "test" } else { "tests" },
    );
    let beside = report.comparison.sensors.iter().find_map(|sensor| sensor.beside_others.as_ref());
    let beside = beside.map_or_else(String::new, |beside| {
        let explained = format!(
            "beside the others: its own test tells no move, as its uncertainty is common to all sensors (that of a load's mass, say). Tested together, \
             such differences have p {}.",
            probability(beside.p_value)
        );
        wrapped("  ", "  ", &explained)
    });
    format!("{}{}{beside}", grid.lines("  "), wrapped("  ", "  ", &explained))
}

/// That it moved, and in what if only a part of it is compared; of more than two calibrations, when.
fn step(report: &ComparisonReport<'_>, sensor: &SensorComparison) -> String {
    let part = part(sensor);
    let Some(test) = sensor.test.as_ref().filter(|test| test.moved) else {
        return part.map_or_else(String::new, |part| format!("{part} only"));
    };
    let moved = part.map_or_else(|| "moved".to_owned(), |part| format!("{part} moved"));
    let moved = if sensor.beside_others.is_some() { format!("{moved} beside the others") } else { moved };
    match report.files.len() {
        2 => moved,
        _ => format!("{moved}, most from {} to {}", test.largest_step.0 + 1, test.largest_step.0 + 2),
    }
}

/// What of a sensor is compared, where that is not all of it: `gain`.
fn part(sensor: &SensorComparison) -> Option<String> {
    let short = |name: &str| {
        let quantity = split_name(name).1;
        ["position_", "torque_"].iter().find_map(|sensor| quantity.strip_prefix(sensor)).unwrap_or(quantity).to_owned()
    };
    let compared: Vec<String> = sensor.parameters.iter().map(|parameter| short(&parameter.name)).collect();
    sensor.left_out.iter().any(|left_out| left_out.can_move).then(|| compared.join(", "))
}

fn probability(p: f64) -> String {
    if p < 1e-3 { "< 0.001".to_owned() } else { significant(p, 2) }
}

/// Values of what moved, calibration by calibration.
fn values(report: &ComparisonReport<'_>) -> String {
    let reported = |sensor: &&SensorComparison| report.verbose || sensor.test.as_ref().is_some_and(|test| test.moved);
    let sensors: Vec<&SensorComparison> = report.comparison.sensors.iter().filter(reported).collect();
    if sensors.is_empty() {
        return String::new();
    }
    let mut grid = Grid::new(vec![Side::Left, Side::Left, Side::Left, Side::Right]);
    for parameter in sensors.iter().flat_map(|sensor| &sensor.parameters) {
        let (unit, factor) = shown_unit(&parameter.unit);
        for (index, (value, std)) in parameter.values.iter().zip(&parameter.stds).enumerate() {
            let (name, unit) = if index == 0 { (parameter.name.as_str(), unit) } else { ("", "") };
            let (value, std) = measured(factor * value, factor * std);
            grid.row(vec![
                Cell::text(name),
                Cell::text(unit),
                Cell::text((index + 1).to_string()),
                Cell::Measured(value, std),
            ]);
        }
    }
    format!("Values ± standard deviation\n{}", grid.lines("  "))
}

fn left_out(report: &ComparisonReport<'_>) -> String {
    let all = report.comparison.sensors.iter().flat_map(|sensor| &sensor.left_out);
    let reported: String = all.map(|what| wrapped("  ", "    ", &what.to_string())).collect();
    if reported.is_empty() { reported } else { format!("Not compared\n{reported}") }
}
