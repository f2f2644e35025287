//! A comparison as text of 80 columns: the verdict, the tests, the values of what moved.

use gravcal_calibration::comparison::{SIGNIFICANCE, SensorComparison};

use super::ComparisonReport;
use crate::grid::{Cell, Grid, Side};
use crate::number::{measured, significant};
use crate::sensor_row::shown_unit;
use crate::text::wrapped;

pub(super) fn text(report: &ComparisonReport<'_>) -> String {
    let moved: Vec<&str> = report.comparison.moved().map(|sensor| sensor.name.as_str()).collect();
    let verdict = match moved.as_slice() {
        [] => "Nothing moved, as far as these calibrations tell\n".to_owned(),
        some => wrapped("", "  ", &format!("Moved: {}", some.join(", "))),
    };
    let files =
        report.files.iter().enumerate().map(|(index, file)| wrapped("  ", "     ", &format!("{}  {file}", index + 1)));
    let sections = [
        verdict + &files.collect::<String>() + &warning(report.shared),
        tests(report),
        values(report),
        left_out(report),
    ];
    sections.into_iter().filter(|section| !section.is_empty()).collect::<Vec<_>>().join("\n")
}

fn warning(shared: &[String]) -> String {
    match shared {
        [] => String::new(),
        some => wrapped(
            "",
            "  ",
            &format!(
                "Warning: some of these were made from the same {}. The test takes them to be independent: what they share \
                 counts as agreement, and a sensor that moved may go unnoticed.",
                some.join(", ")
            ),
        ),
    }
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
    let explained = format!(
        "p: probability of such differences if the sensor has not moved. corrected: for {} tests (Holm); below {} it has moved.",
        report.comparison.tests(),
        SIGNIFICANCE
    );
    format!("{}{}", grid.lines("  "), wrapped("  ", "  ", &explained))
}

/// That it moved; of more than two calibrations, when.
fn step(report: &ComparisonReport<'_>, sensor: &SensorComparison) -> String {
    match sensor.test.as_ref().filter(|test| test.moved) {
        None => String::new(),
        Some(_) if report.files.len() == 2 => "moved".to_owned(),
        Some(test) => format!("moved, most from {} to {}", test.largest_step.0 + 1, test.largest_step.0 + 2),
    }
}

fn probability(p: f64) -> String {
    if p < 1e-3 { "< 0.001".to_owned() } else { significant(p, 2) }
}

/// Values of what moved, calibration by calibration.
fn values(report: &ComparisonReport<'_>) -> String {
    let told = |sensor: &&SensorComparison| report.verbose || sensor.test.as_ref().is_some_and(|test| test.moved);
    let sensors: Vec<&SensorComparison> = report.comparison.sensors.iter().filter(told).collect();
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
    let told: String = all.map(|what| wrapped("  ", "    ", what)).collect();
    if told.is_empty() { told } else { format!("Not compared\n{told}") }
}
