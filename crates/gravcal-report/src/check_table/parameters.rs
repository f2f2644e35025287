//! What can be known of each parameter, and what a tilt of the base would bring.

use gravcal_calibration::check::{CheckReport, CheckedParameter, TiltedGain};

use crate::footnotes::Footnotes;
use crate::grid::{Cell, Grid, Side};
use crate::sensor_row::{shown_unit, split_name};
use gravcal_robot_model::number::significant;

/// Why something determined has no predicted standard deviation.
const NO_NOISE: &str = "can be determined; how well depends on noise that no reading states";

pub(super) fn report(report: &CheckReport) -> String {
    let mut footnotes = Footnotes::default();
    let mut grid = Grid::new(vec![Side::Left, Side::Left, Side::Right]);
    grid.row(["", "unit", "predicted std"].map(Cell::text).into());
    let mut joint_before = "";
    for parameter in &report.parameters {
        let (joint, quantity) = split_name(&parameter.name);
        if joint_before != joint {
            grid.heading(joint);
            joint_before = joint;
        }
        let indent = if joint.is_empty() { "" } else { "  " };
        let (unit, factor) = shown_unit(&parameter.unit);
        let known = known(parameter, factor, &mut footnotes);
        grid.row(vec![Cell::text(format!("{indent}{quantity}")), Cell::text(unit), Cell::text(known)]);
    }
    format!("Predicted standard deviations, joint estimator\n{}{}", grid.lines("  "), footnotes.lines("  "))
}

fn known(parameter: &CheckedParameter, factor: f64, footnotes: &mut Footnotes) -> String {
    match (&parameter.held, parameter.predicted_std) {
        (Some(reason), _) => format!("fixed {}", footnotes.mark(&format!("fixed: {reason}"))),
        (None, _) if !parameter.determined && parameter.asked => "undetermined".to_owned(),
        (None, _) if !parameter.determined => format!("undetermined {}", footnotes.mark("not asked for")),
        (None, Some(std)) => significant(std * factor, 2),
        (None, None) => format!("determined {}", footnotes.mark(NO_NOISE)),
    }
}

pub(super) fn report_tilts(report: &CheckReport) -> String {
    if report.tilts.is_empty() {
        return String::new();
    }
    let mut footnotes = Footnotes::default();
    let mut percent = |gain: TiltedGain| {
        Cell::text(match gain.relative_std {
            _ if !gain.determined => "undetermined".to_owned(),
            Some(std) => significant(100.0 * std, 2),
            None => format!("determined {}", footnotes.mark(NO_NOISE)),
        })
    };
    let mut grid = Grid::new(vec![Side::Right; 3]);
    grid.row(["tilt, deg", "torque gain, %", "position gain, %"].map(Cell::text).into());
    for tilt in &report.tilts {
        let angle = Cell::text(significant(tilt.tilt_deg, 2));
        grid.row(vec![angle, percent(tilt.torque_gain), percent(tilt.position_gain)]);
    }
    let heading = "What a tilt of the base brings to the first joint: predicted std";
    format!("{heading}\n{}{}", grid.lines("  "), footnotes.lines("  "))
}
