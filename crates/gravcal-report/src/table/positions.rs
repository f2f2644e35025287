//! Where joints were found not to be where their position sensors say.

use gravcal_calibration::result::{DeflectionResult, EstimatorResult, PositionErrorResult};

use crate::grid::{Cell, Grid, Side};
use gravcal_robot_model::number::significant;

/// Sections of the estimators that have such unknowns.
pub(super) fn report(results: &[EstimatorResult]) -> String {
    let several = results.len() > 1;
    let sections = results.iter().flat_map(|result| {
        let whose = if several { format!(" ({})", result.name) } else { String::new() };
        [deflections(&result.deflections, &whose), position_errors(&result.position_errors, &whose)]
    });
    sections.flatten().collect::<Vec<_>>().join("\n")
}

fn deflections(deflections: &[DeflectionResult], whose: &str) -> Option<String> {
    if deflections.is_empty() {
        return None;
    }
    let mut grid = Grid::new(vec![Side::Left, Side::Left, Side::Left, Side::Right, Side::Right]);
    grid.row(["", "joint", "unit", "", "known before"].map(Cell::text).into());
    for deflection in deflections {
        let (unit, scale) = reported_unit(&deflection.unit);
        let number = |value: f64| significant(scale * value, 2);
        let [first, last] = deflection.lines;
        grid.row(vec![
            Cell::text(format!("{}:{first}-{last}", deflection.table)),
            Cell::text(deflection.joint.clone()),
            Cell::text(unit),
            match deflection.value {
                Some(value) => Cell::Measured(number(value), number(deflection.std)),
                None => Cell::text("not told by the readings"),
            },
            Cell::text(format!("± {}", number(deflection.prior_std))),
        ]);
    }
    Some(format!("Deflection of joints that stand{whose}\n{}", grid.lines("  ")))
}

fn position_errors(errors: &[PositionErrorResult], whose: &str) -> Option<String> {
    if errors.is_empty() {
        return None;
    }
    let mut grid =
        Grid::new(vec![Side::Left, Side::Left, Side::Right, Side::Right, Side::Right, Side::Right, Side::Left]);
    grid.row(["joint", "unit", "poses", "rms", "std", "known before", ""].map(Cell::text).into());
    for error in errors {
        let (unit, scale) = reported_unit(&error.unit);
        let numbers = [error.rms, error.std, error.prior_std].map(|number| Cell::text(significant(scale * number, 2)));
        let mut row = vec![Cell::text(error.joint.clone()), Cell::text(unit), Cell::text(error.poses.to_string())];
        row.extend(numbers);
        row.push(Cell::text(if error.observable { "" } else { "not told by the readings" }));
        grid.row(row);
    }
    Some(format!("Errors of single poses' positions{whose}\n{}", grid.lines("  ")))
}

/// Angles are told in degrees.
fn reported_unit(unit: &str) -> (&str, f64) {
    if unit == "rad" { ("deg", 1f64.to_degrees()) } else { (unit, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::result;

    #[test]
    fn what_the_readings_do_not_tell_has_no_number() {
        let deflection = |value| DeflectionResult {
            table: "sweep-3.csv".into(),
            lines: [2, 38],
            joint: "joint1".into(),
            unit: "rad".into(),
            value,
            std: 0.001,
            prior_std: 0.01,
        };
        let mut joint = result("joint");
        joint.deflections = vec![deflection(Some(0.005)), deflection(None)];
        joint.position_errors = vec![PositionErrorResult {
            joint: "joint2".into(),
            unit: "m".into(),
            poses: 37,
            rms: 0.001,
            std: 0.002,
            prior_std: 0.002,
            observable: false,
        }];
        assert_eq!(
            report(&[joint]),
            "Deflection of joints that stand\n\
             \x20                   joint   unit                            known before\n\
             \x20 sweep-3.csv:2-38  joint1  deg               0.29 ± 0.057        ± 0.57\n\
             \x20 sweep-3.csv:2-38  joint1  deg   not told by the readings        ± 0.57\n\
             \n\
             Errors of single poses' positions\n\
             \x20 joint   unit  poses     rms     std  known before\n\
             \x20 joint2  m        37  0.0010  0.0020        0.0020  not told by the readings\n"
        );
        assert_eq!(report(&[result("joint")]), "");
    }
}
