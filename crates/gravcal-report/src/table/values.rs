//! Gravity and sensor parameters, the estimators side by side.

use gravcal_calibration::result::{EstimatorResult, GravityResult, ParameterResult, Verdict};

use crate::footnotes::Footnotes;
use crate::grid::{Cell, Grid, Side};
use crate::sensor_row::{shown_unit, split_name, tilt};
use crate::text::{WIDTH, wrapped};
use gravcal_robot_model::number::{measured, shortest, significant};

const GRAVITY_LEGEND: &str = "cone95: half-angle of the cone about gravity that holds its true direction with 95 % \
                              probability. tilt: angle between gravity and the base's -z axis.";

pub(super) fn report(results: &[EstimatorResult]) -> String {
    if results.is_empty() {
        return String::new();
    }
    let (shown, left_out) = worth_a_column(results);
    let mut footnotes = Footnotes::default();
    let mut text = String::from("Gravity and sensor parameters, value ± standard deviation\n");
    for block in side_by_side(&shown) {
        text += &grid(block, &mut footnotes).lines("");
        text.push('\n');
    }
    text += &footnotes.lines("");
    text += &uncertainties(&shown);
    for result in left_out {
        text += &wrapped("", "", &format!("{}: no value", result.name));
    }
    for convention in conventions(results) {
        text += &wrapped("", "", convention);
    }
    text + &wrapped("", "", GRAVITY_LEGEND)
}

/// Where the standard deviations come from: once, or for each where they differ.
fn uncertainties(results: &[&EstimatorResult]) -> String {
    let reported: Vec<(&str, String)> =
        results.iter().filter_map(|r| Some((r.name.as_str(), r.uncertainty.as_ref()?.to_string()))).collect();
    match reported.as_slice() {
        [] => String::new(),
        [(_, first), rest @ ..] if rest.iter().all(|(_, other)| other == first) => {
            wrapped("", "  ", &format!("Standard deviations: {first}"))
        }
        _ => reported
            .iter()
            .map(|(name, how)| wrapped("", "  ", &format!("Standard deviations of {name}: {how}")))
            .collect(),
    }
}

/// Estimators with a value, and those without any; if none has one, a column of words tells it best.
fn worth_a_column(results: &[EstimatorResult]) -> (Vec<&EstimatorResult>, Vec<&EstimatorResult>) {
    let (shown, left_out): (Vec<_>, Vec<_>) = results.iter().partition(|result| has_values(result));
    if shown.is_empty() { (left_out, shown) } else { (shown, left_out) }
}

fn has_values(result: &EstimatorResult) -> bool {
    result.gravity.is_some() || result.parameters.iter().any(|p| p.held.is_none() && p.value.is_some())
}

/// As many estimators side by side as fit the width; the others below them.
fn side_by_side<'a, 'r>(results: &'a [&'r EstimatorResult]) -> Vec<&'a [&'r EstimatorResult]> {
    let fits = |block: &[&EstimatorResult]| grid(block, &mut Footnotes::default()).width() <= WIDTH;
    let mut blocks = Vec::new();
    let mut rest = results;
    while !rest.is_empty() {
        let count = (1..=rest.len()).rev().find(|count| fits(&rest[..*count])).unwrap_or(1);
        let (block, others) = rest.split_at(count);
        blocks.push(block);
        rest = others;
    }
    blocks
}

fn grid(results: &[&EstimatorResult], footnotes: &mut Footnotes) -> Grid {
    let mut sides = vec![Side::Left, Side::Left, Side::Right];
    sides.extend(results.iter().map(|_| Side::Right));
    let mut grid = Grid::new(sides);
    let headings = ["", "unit", "nominal"].map(Cell::text).into_iter();
    grid.row(headings.chain(results.iter().map(|result| Cell::text(heading(result)))).collect());
    add_gravity(&mut grid, results);
    add_parameters(&mut grid, results, footnotes);
    grid
}

/// Numbers of an estimator that failed stand there for whoever looks for the reason, and must not pass for an answer.
fn heading(result: &EstimatorResult) -> String {
    match result.verdict {
        Verdict::Failed => format!("{} estimator (failed)", result.name),
        Verdict::Determined | Verdict::PartlyDetermined => format!("{} estimator", result.name),
    }
}

fn add_gravity(grid: &mut Grid, results: &[&EstimatorResult]) {
    grid.heading("gravity in base coordinates");
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let cell = |g: &GravityResult| measured_cell(g.vector_m_per_s2[axis], g.std_m_per_s2[axis]);
        grid.row(gravity_row(name, "m/s²", "undetermined", results, cell));
    }
    if results.iter().any(|result| result.gravity.is_some()) {
        let cone = |g: &GravityResult| Cell::Value(significant(g.cone95_deg, 2));
        let tilt = |g: &GravityResult| Cell::Value(measured(tilt_deg(g.vector_m_per_s2), g.cone95_deg).0);
        grid.row(gravity_row("cone95", "deg", "", results, cone));
        grid.row(gravity_row("tilt", "deg", "", results, tilt));
    }
}

fn gravity_row(
    name: &str,
    unit: &str,
    absent: &str,
    results: &[&EstimatorResult],
    cell: impl Fn(&GravityResult) -> Cell,
) -> Vec<Cell> {
    let start = [format!("  {name}"), unit.to_owned(), String::new()].map(Cell::Text).into_iter();
    start.chain(results.iter().map(|r| r.gravity.as_ref().map_or_else(|| Cell::text(absent), &cell))).collect()
}

/// Angle between gravity and the base's −z axis, degrees: 0 for a base that stands upright.
fn tilt_deg(gravity: [f64; 3]) -> f64 {
    tilt(gravity).to_degrees()
}

fn add_parameters(grid: &mut Grid, results: &[&EstimatorResult], footnotes: &mut Footnotes) {
    let mut joint_before = None;
    for parameter in all_parameters(results) {
        let (joint, quantity) = split_name(&parameter.name);
        if joint_before != Some(joint) {
            grid.heading(joint);
            joint_before = Some(joint);
        }
        let (unit, factor) = shown_unit(&parameter.unit);
        let nominal = shortest(parameter.nominal * factor);
        let mut row = vec![Cell::text(format!("  {quantity}")), Cell::text(unit), Cell::Value(nominal)];
        row.extend(results.iter().map(|result| {
            find(result, &parameter.name)
                .map_or_else(Cell::empty, |reported| parameter_cell(reported, factor, footnotes))
        }));
        grid.row(row);
    }
}

/// One entry for each parameter that any of the estimators tells.
fn all_parameters<'r>(results: &[&'r EstimatorResult]) -> Vec<&'r ParameterResult> {
    let mut all: Vec<&ParameterResult> = Vec::new();
    for parameter in results.iter().flat_map(|result| &result.parameters) {
        if !all.iter().any(|known| known.name == parameter.name) {
            all.push(parameter);
        }
    }
    all
}

fn find<'a>(result: &'a EstimatorResult, name: &str) -> Option<&'a ParameterResult> {
    result.parameters.iter().find(|parameter| parameter.name == name)
}

fn parameter_cell(parameter: &ParameterResult, factor: f64, footnotes: &mut Footnotes) -> Cell {
    match (&parameter.held, parameter.value) {
        (Some(reason), _) => Cell::text(format!("fixed {}", footnotes.mark(&format!("fixed: {reason}")))),
        (None, Some(value)) => measured_cell(value * factor, parameter.std.unwrap_or(f64::NAN) * factor),
        (None, None) if parameter.asked => Cell::text("undetermined"),
        (None, None) => Cell::text(format!("undetermined {}", footnotes.mark("not asked for"))),
    }
}

fn measured_cell(value: f64, std: f64) -> Cell {
    let (value, std) = measured(value, std);
    Cell::Measured(value, std)
}

/// The equations in which the parameters stand.
fn conventions(results: &[EstimatorResult]) -> Vec<&str> {
    let mut conventions = Vec::new();
    for parameter in results.iter().flat_map(|result| &result.parameters) {
        if !conventions.contains(&&*parameter.convention) {
            conventions.push(&*parameter.convention);
        }
    }
    conventions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{determined, held, result, undetermined};
    use crate::text::width;
    use gravcal_calibration::result::UncertaintyResult;

    fn joint_of_seven() -> EstimatorResult {
        let mut joint = result("joint");
        joint.parameters = (1..=7)
            .flat_map(|i| {
                [
                    determined(&format!("lbr_iiwa_joint_{i}.torque_gain"), "count/(N·m)", 7.118_13, 0.0204),
                    determined(&format!("lbr_iiwa_joint_{i}.torque_bias"), "count", -2075.123, 0.0118),
                ]
            })
            .collect();
        joint
    }

    #[test]
    fn three_estimators_that_do_not_fit_are_stacked() {
        let results = ["sequential", "joint", "joint-paper-signals"].map(|name| {
            let mut named = joint_of_seven();
            named.name = name.into();
            named
        });
        let text = report(&results);
        assert!(text.lines().all(|line| width(line) <= WIDTH), "{text}");
        assert_eq!(text.matches("\nlbr_iiwa_joint_3\n").count(), 2);
        let results: Vec<&EstimatorResult> = results.iter().collect();
        assert_eq!(side_by_side(&results).iter().map(|block| block.len()).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn angles_are_reported_in_degrees() {
        let mut joint = result("joint");
        joint.parameters = vec![determined("joint2.position_offset", "rad", 134.2_f64.to_radians(), 4.2e-4)];
        let text = report(&[joint]);
        assert!(text.contains("  position_offset  deg         0  134.200 ± 0.024\n"), "{text}");
    }

    #[test]
    fn where_standard_deviations_come_from_is_reported_once_or_for_each() {
        let (sequential, mut joint) = (result("sequential"), result("joint"));
        let both = report(&[sequential.clone(), joint.clone()]);
        assert!(both.contains("\nStandard deviations: from the stated noise\n"), "{both}");
        joint.uncertainty = Some(UncertaintyResult::Sandwich { blocks: 31, block_poses: 10 });
        let each = report(&[sequential, joint]);
        assert!(each.contains("\nStandard deviations of sequential: from the stated noise\n"), "{each}");
        let sandwich =
            "\nStandard deviations of joint: robust to model error (sandwich over 31 blocks of\n  10 poses)\n";
        assert!(each.contains(sandwich), "{each}");
    }

    #[test]
    fn what_has_no_value_says_why() {
        let mut joint = result("joint");
        let mut free = undetermined("joint3.position_offset");
        free.asked = false;
        joint.parameters = vec![
            undetermined("joint1.torque_gain"),
            held("joint1.position_offset", "zero by definition of the base frame"),
            free,
        ];
        let text = report(&[joint]);
        assert!(text.contains("undetermined\n") && text.contains("fixed [1]\n") && text.contains("undetermined [2]\n"));
        assert!(text.contains("[1] fixed: zero by definition of the base frame\n[2] not asked for\n"));
    }

    #[test]
    fn without_gravity_there_is_neither_cone_nor_tilt() {
        let mut joint = result("joint");
        joint.gravity = None;
        let text = report(&[joint]);
        assert_eq!(text.matches("undetermined").count(), 3);
        assert_eq!(text.matches("tilt").count(), 1, "only in the legend");
    }

    #[test]
    fn an_estimator_without_any_value_takes_no_column() {
        let mut empty = result("sequential");
        empty.gravity = None;
        empty.parameters = vec![held("joint1.position_offset", "zero by definition of the base frame")];
        let text = report(&[empty.clone(), result("joint")]);
        assert!(text.contains("\nsequential: no value\n") && text.contains(" joint estimator\n"), "{text}");
        assert!(report(&[empty]).contains(" sequential estimator\n"));
    }

    #[test]
    fn an_upright_base_has_no_tilt_and_a_hanging_one_half_a_turn() {
        assert_eq!(tilt_deg([0.0, 0.0, -9.8]), 0.0);
        assert_eq!(tilt_deg([0.0, 0.0, 9.8]), 180.0);
        assert!((tilt_deg([3.0, 4.0, -5.0]) - 45.0).abs() < 1e-12);
    }

    #[test]
    fn numbers_of_a_failed_estimator_are_marked() {
        let mut joint = result("joint");
        joint.verdict = Verdict::Failed;
        assert!(report(&[joint]).contains("joint estimator (failed)"));
    }
}
