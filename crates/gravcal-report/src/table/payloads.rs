//! Loads of unknown mass.

use gravcal_calibration::result::EstimatorResult;

use crate::payload_text::found;
use crate::text::wrapped;

const HEADING: &str = "Loads of unknown mass, in the frame of the link that carries them";

pub(super) fn report(results: &[EstimatorResult]) -> String {
    let all = results.iter().flat_map(|result| result.payloads.iter().map(move |payload| (result, payload)));
    let reported: String =
        all.map(|(result, payload)| wrapped("  ", "    ", &format!("{}: {}", result.name, found(payload)))).collect();
    if reported.is_empty() { reported } else { format!("{HEADING}\n{reported}") }
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::result::{PayloadNumber, PayloadResult};

    use super::*;
    use crate::testing::result;

    #[test]
    fn what_is_open_is_said_and_no_number_given() {
        let number = |value: f64| PayloadNumber { value, std: 0.01, ci95: [value - 0.02, value + 0.02] };
        let mut joint = result("joint");
        joint.payloads = vec![
            PayloadResult {
                load: "tool".into(),
                link: "link7".into(),
                mass_kg: Some(number(1.5)),
                center_of_mass_m: Some([0.1, 0.0, 0.2].map(number)),
                tensor_kg_m2: None,
                undetermined: Some("the inertia tensor: move".into()),
            },
            PayloadResult {
                load: "other".into(),
                link: "link7".into(),
                mass_kg: None,
                center_of_mass_m: None,
                tensor_kg_m2: None,
                undetermined: Some("no pose carries it".into()),
            },
        ];
        let reported = report(&[joint]);
        assert!(reported.contains("load tool on link7, mass 1.500 ± 0.010 kg"), "{reported}");
        assert!(reported.contains("load other on link7, undetermined: no pose carries it\n"), "{reported}");
        assert_eq!(report(&[result("joint")]), "");
    }
}
