//! Constraints on which an estimate leans.

use gravcal_calibration::result::{ActiveConstraint, EstimatorResult};

use super::shared::{Shared, by_content};
use crate::text::wrapped;
use gravcal_robot_model::number::significant;

const HEADING: &str = "Active constraints, and by how much ½ χ² would fall if they gave way";

pub(super) fn report(results: &[EstimatorResult]) -> String {
    let active = by_content(results, |result| &result.active_constraints);
    let reported: String = active.iter().map(|shared| report_one(shared, results.len() > 1)).collect();
    if reported.is_empty() { reported } else { format!("{HEADING}\n{reported}") }
}

fn report_one(shared: &Shared<'_, ActiveConstraint>, several: bool) -> String {
    let ActiveConstraint { constraint, multiplier, unit } = shared.item;
    let whose = if several { format!(" ({})", shared.names) } else { String::new() };
    let unit = if unit.contains(['/', '·']) { format!("({unit})") } else { unit.clone() };
    wrapped("  ", "    ", &format!("{constraint}{whose}: {} per {unit}", significant(*multiplier, 3)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::result;

    fn active(constraint: &str, multiplier: f64, unit: &str) -> ActiveConstraint {
        ActiveConstraint { constraint: constraint.into(), multiplier, unit: unit.into() }
    }

    #[test]
    fn each_is_reported_with_its_multiplier() {
        let mut joint = result("joint");
        joint.active_constraints =
            vec![active("link2.mass is at least 0", 12.345, "kg"), active("a moment", 0.5, "kg·m")];
        assert_eq!(
            report(&[joint.clone()]),
            "Active constraints, and by how much ½ χ² would fall if they gave way\n  \
             link2.mass is at least 0: 12.3 per kg\n  a moment: 0.500 per (kg·m)\n"
        );
        assert!(report(&[result("sequential"), joint]).contains("link2.mass is at least 0 (joint): 12.3 per kg\n"));
        assert_eq!(report(&[result("joint")]), "");
    }
}
