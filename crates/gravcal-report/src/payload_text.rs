//! Loads of unknown mass, in words.

use gravcal_calibration::check::CheckedPayload;
use gravcal_calibration::result::{PayloadNumber, PayloadResult};
use gravcal_robot_model::number::{measured, significant};

/// What was found of one, one sentence.
pub(crate) fn found(payload: &PayloadResult) -> String {
    let PayloadResult { load, link, mass_kg, center_of_mass_m, tensor_kg_m2, undetermined } = payload;
    let mut reported = vec![format!("load {load} on {link}")];
    reported.extend(mass_kg.map(|mass| format!("mass {} kg", number(&mass))));
    reported.extend(center_of_mass_m.as_ref().map(|place| format!("centre of mass {} m", numbers(place))));
    reported.extend(tensor_kg_m2.as_ref().map(|tensor| {
        let [xx, xy, yy, xz, yz, zz] = tensor;
        format!("tensor about it (xx, yy, zz, xy, xz, yz) {} kg·m²", numbers(&[*xx, *yy, *zz, *xy, *xz, *yz]))
    }));
    let open = undetermined.iter().map(|open| format!("undetermined: {open}"));
    reported.into_iter().chain(open).collect::<Vec<_>>().join(", ")
}

/// What can be known of one before it is solved.
pub(crate) fn expected(payload: &CheckedPayload) -> String {
    let CheckedPayload { load, predicted_mass_std_kg, undetermined } = payload;
    let std = predicted_mass_std_kg.map(|std| format!("mass ± {} kg", significant(std, 2)));
    let open = undetermined.as_ref().map(|open| format!("undetermined: {open}"));
    let reported: Vec<String> = std.into_iter().chain(open).collect();
    let reported = if reported.is_empty() { "can be determined".to_owned() } else { reported.join(", ") };
    format!("load {load}: {reported}")
}

fn number(number: &PayloadNumber) -> String {
    let (value, std) = measured(number.value, number.std);
    format!("{value} ± {std}")
}

fn numbers(all: &[PayloadNumber]) -> String {
    all.iter().map(number).collect::<Vec<_>>().join(", ")
}
