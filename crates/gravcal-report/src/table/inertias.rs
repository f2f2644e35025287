//! Inertias that rigid bodies can have, for simulations and controllers.

use gravcal_calibration::result::{ConsistentModel, EstimatorResult, HeldOut};

use crate::grid::{Cell, Grid, Side};
use crate::text::wrapped;
use gravcal_robot_model::number::significant;

const HEADING: &str =
    "Consistent inertias: rigid bodies nearest to the readings and to the robot's file, without loads";

pub(super) fn report(results: &[EstimatorResult]) -> String {
    let models = results.iter().filter_map(|result| Some((result, result.consistent_model.as_ref()?)));
    let reported: String = models.map(|(result, model)| report_one(result, model)).collect();
    if reported.is_empty() { reported } else { format!("{HEADING}\n{reported}") }
}

fn report_one(result: &EstimatorResult, model: &ConsistentModel) -> String {
    let mut text = grid(model).lines("  ");
    if !model.tensors_from_readings {
        text += &wrapped("  ", "    ", "Tensors are the file's: the arm stood.");
    }
    let growth = significant(model.chi_squared_growth, 2);
    text += &wrapped(
        "  ",
        "    ",
        &format!("The bodies explain the readings worse than the estimate does: χ² grows by {growth}."),
    );
    let held_out = result.fit.as_ref().and_then(|fit| fit.held_out.as_ref());
    if let Some((consistent, without)) = model.held_out.as_ref().zip(held_out) {
        text += &wrapped("  ", "    ", &predictions(consistent, without));
    }
    text
}

/// How well tables that no fit saw are predicted, with and without.
pub(crate) fn predictions(consistent: &HeldOut, without: &HeldOut) -> String {
    let by_joint: Vec<String> = consistent
        .joints
        .iter()
        .zip(&without.joints)
        .map(|(a, b)| format!("{} {} ({}) {}", a.joint, significant(a.rms, 3), significant(b.rms, 3), a.unit))
        .collect();
    let files = consistent.files.join(", ");
    format!("held out: the bodies predict {files} with rms (in brackets: the estimate's) {}", by_joint.join(", "))
}

fn grid(model: &ConsistentModel) -> Grid {
    let mut sides = vec![Side::Left];
    sides.resize(8, Side::Right);
    let mut grid = Grid::new(sides);
    let headings = ["", "mass", "centre x", "y", "z", "I_xx", "I_yy", "I_zz"];
    let units = ["", "kg", "m", "m", "m", "kg·m²", "kg·m²", "kg·m²"];
    grid.row(headings.map(Cell::text).to_vec());
    grid.row(units.map(Cell::text).to_vec());
    for link in &model.links {
        let [x, y, z] = link.center_of_mass_m;
        let [xx, _, yy, _, _, zz] = link.tensor_kg_m2;
        let meters = [x, y, z].map(|place| format!("{place:.4}"));
        let tensor = [xx, yy, zz].map(|entry| significant(entry, 3));
        let numbers = [significant(link.mass_kg, 4)].into_iter().chain(meters).chain(tensor);
        grid.row([link.link.clone()].into_iter().chain(numbers).map(Cell::text).collect());
    }
    grid
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::result::LinkInertiaResult;

    use super::*;
    use crate::testing::{fit, result};

    #[test]
    fn bodies_stand_below_each_other_and_predictions_side_by_side() {
        let mut joint = result("joint");
        let held_out = fit().held_out.unwrap();
        let held_out = HeldOut { files: vec!["other.csv".into()], ..held_out };
        joint.fit = Some(fit());
        joint.consistent_model = Some(ConsistentModel {
            links: vec![LinkInertiaResult {
                link: "arm".into(),
                mass_kg: 2.5,
                center_of_mass_m: [0.1, -0.05, 0.0],
                tensor_kg_m2: [0.02, 0.001, 0.03, 0.0, 0.0, 0.015],
            }],
            relative_std: vec![0.3],
            tensors_from_readings: true,
            variance_inflation: 4.0,
            chi_squared_growth: 1.25,
            held_out: Some(held_out),
        });
        assert_eq!(
            report(&[joint]),
            "\
Consistent inertias: rigid bodies nearest to the readings and to the robot's file, without loads
        mass  centre x        y       z    I_xx    I_yy    I_zz
          kg         m        m       m   kg·m²   kg·m²   kg·m²
  arm  2.500    0.1000  -0.0500  0.0000  0.0200  0.0300  0.0150
  The bodies explain the readings worse than the estimate does: χ² grows by 1.2.
  held out: the bodies predict other.csv with rms (in brackets: the estimate's)
    joint1 0.912 (0.912) count
"
        );
        assert_eq!(report(&[result("joint")]), "");
    }
}
