//! How well the model explains the readings.

use gravcal_calibration::result::{EstimatorResult, Fit, HeldOut, JointFit, SmallerModelKind, UnexplainedResult};

use crate::grid::{Cell, Grid, Side};
use crate::text::wrapped;
use gravcal_robot_model::number::significant;

/// Below this probability the stated noise and the model do not go together.
const IMPROBABLE: f64 = 1e-3;

pub(super) fn report(results: &[EstimatorResult]) -> String {
    let fits = results.iter().filter_map(|result| Some((result.name.as_str(), result.fit.as_ref()?)));
    let reported: String = fits.map(|(name, fit)| report_one(name, fit)).collect();
    if reported.is_empty() {
        reported
    } else {
        format!("Fit: residuals of the torque readings, in their unit\n{reported}")
    }
}

fn report_one(name: &str, fit: &Fit) -> String {
    let mut text = wrapped("  ", "    ", &format!("{name}: {}", chi_squared(fit)));
    if let Some(held_out) = &fit.held_out {
        text += &wrapped("    ", "    ", &prediction(held_out));
    }
    text += &grid(fit).lines("    ");
    if fit.joints.iter().any(|joint| joint.noise_estimated) {
        text += &wrapped("    ", "    ", "~ estimated from the residuals");
    }
    let smaller = smaller_models(fit);
    if let Some(headings) = smaller.first() {
        text += &wrapped("    ", "    ", SMALLER_MODELS);
        let mut grid = Grid::new([vec![Side::Left; 2], vec![Side::Right; headings.len() - 2]].concat());
        smaller.into_iter().for_each(|row| grid.row(row.into_iter().map(Cell::text).collect()));
        text += &grid.lines("    ");
    }
    for (joint, unexplained) in fit.joints.iter().filter_map(|joint| Some((joint, joint.unexplained?))) {
        text += &wrapped("    ", "      ", &unexplained_error(joint, &unexplained));
    }
    text
}

/// What the table of smaller models shows.
pub(crate) const SMALLER_MODELS: &str =
    "rms of what was held out, by smaller models that were fitted to the same readings and by this one:";

/// How well smaller models predict what was held out, and this one: headings, then a joint a row. Empty where there are none.
pub(crate) fn smaller_models(fit: &Fit) -> Vec<Vec<String>> {
    let Some(held_out) = fit.held_out.as_ref().filter(|_| !fit.smaller_models.is_empty()) else { return Vec::new() };
    let mut models: Vec<(&str, &HeldOut)> =
        fit.smaller_models.iter().map(|model| (name(model.kind), &model.held_out)).collect();
    models.push(("this model", held_out));
    let headings = ["", "unit"].into_iter().chain(models.iter().map(|(name, _)| *name)).map(str::to_owned).collect();
    let row = |joint: &JointFit| {
        let rms = |(_, model): &(&str, &HeldOut)| {
            let own = model.joints.iter().find(|other| other.joint == joint.joint);
            own.map_or("-".to_owned(), |own| significant(own.rms, 3))
        };
        [joint.joint.clone(), joint.unit.clone()].into_iter().chain(models.iter().map(rms)).collect()
    };
    std::iter::once(headings).chain(held_out.joints.iter().map(row)).collect()
}

fn name(kind: SmallerModelKind) -> &'static str {
    match kind {
        SmallerModelKind::Gravity => "gravity",
        SmallerModelKind::GravityAndFriction => "with friction",
    }
}

/// How large errors are that the noise does not explain.
pub(crate) fn unexplained_error(joint: &JointFit, unexplained: &UnexplainedResult) -> String {
    let UnexplainedResult { std, estimated, times_noise, gravity_std, share_of_gravity } = unexplained;
    let JointFit { joint, unit, .. } = joint;
    if *std == 0.0 {
        return format!("{joint}: nothing unexplained, the noise explains the residuals");
    }
    let stated = if *estimated { "" } else { " as stated" };
    let mut reported = format!("{joint}: unexplained {} {unit}{stated}", significant(*std, 2));
    reported += &format!(", {} times the noise", significant(*times_noise, 2));
    // A joint that carries little is held against another.
    let own = share_of_gravity.filter(|share| share * gravity_std > 0.99 * std);
    reported += &match (own, share_of_gravity) {
        (Some(share), _) => format!(", {} % of gravity's part in its readings", significant(100.0 * share, 2)),
        (None, Some(share)) => format!(
            ", {} % of a tenth of gravity's part where that is largest (it carries less itself)",
            significant(100.0 * share, 2)
        ),
        (None, None) => String::new(),
    };
    reported
}

pub(crate) fn chi_squared(fit: &Fit) -> String {
    let chi_squared = significant(fit.chi_squared, 5);
    let chi_squared = format!("χ² {chi_squared} for {} degrees of freedom", fit.degrees_of_freedom);
    let in_part = fit.p_value.is_some() && fit.joints.iter().any(|joint| joint.noise_estimated);
    if let Some(times) = fit.times_noise.filter(|_| in_part) {
        return format!(
            "{chi_squared}; residuals of the channels that state their noise are {} times that, {}",
            significant(times, 3),
            probability(fit)
        );
    }
    match fit.median_ratio {
        None => format!("{chi_squared}, {}", probability(fit)),
        Some(ratio) => format!(
            "median residual {} times that of the stated noise, {}; {chi_squared}, outliers included",
            significant(ratio, 3),
            probability(fit)
        ),
    }
}

fn probability(fit: &Fit) -> String {
    match fit.p_value {
        Some(p) if p < IMPROBABLE => "p < 0.001: model and stated noise do not explain the readings".to_owned(),
        Some(p) if p > 1.0 - IMPROBABLE => "p > 0.999: the residuals are smaller than the stated noise".to_owned(),
        Some(p) => format!("p = {}", significant(p, 2)),
        None if fit.joints.iter().any(|joint| joint.noise_estimated) => {
            "noise estimated from the residuals, no p-value".to_owned()
        }
        None if fit.joints.iter().any(|joint| joint.unexplained.is_some_and(|u| u.estimated && u.std > 0.0)) => {
            "unexplained errors estimated from the residuals, no p-value".to_owned()
        }
        None => "no p-value".to_owned(),
    }
}

pub(crate) fn prediction(held_out: &HeldOut) -> String {
    let HeldOut { poses, stretches, files, chi_squared, readings, joints: _ } = held_out;
    let unseen = match files.as_slice() {
        [] if *stretches == 1 => format!("{poses} consecutive poses that a second fit did not see"),
        [] => format!("{poses} poses in {stretches} stretches that a second fit did not see"),
        files => format!("{poses} poses of {} that are in no fit", files.join(", ")),
    };
    format!("held out: {unseen}, χ² {} for {readings} readings", significant(*chi_squared, 5))
}

fn grid(fit: &Fit) -> Grid {
    let columns = if fit.held_out.is_some() { 9 } else { 6 };
    let mut sides = vec![Side::Left, Side::Left];
    sides.resize(columns, Side::Right);
    let mut grid = Grid::new(sides);
    let over = ["", "", "", "", "fitted", "", "held out", "", ""];
    let headings = ["", "unit", "readings", "noise", "rms", "largest", "rms", "largest", "of range"];
    grid.row(over[..columns].iter().copied().map(Cell::text).collect());
    grid.row(headings[..columns].iter().copied().map(Cell::text).collect());
    for joint in &fit.joints {
        grid.row(joint_row(joint, fit.held_out.as_ref()).into_iter().map(Cell::text).collect());
    }
    grid
}

/// A joint's name, its unit, how many readings, their noise, rms and largest residual; rms, largest residual and share of the range of what was held out.
pub(crate) fn joint_row(joint: &JointFit, held_out: Option<&HeldOut>) -> Vec<String> {
    let estimated = if joint.noise_estimated { "~" } else { "" };
    let noise = format!("{estimated}{}", significant(joint.noise_std, 2));
    let mut row = vec![
        joint.joint.clone(),
        joint.unit.clone(),
        joint.readings.to_string(),
        noise,
        significant(joint.rms, 3),
        significant(joint.largest, 3),
    ];
    if let Some(other) = held_out.and_then(|all| all.joints.iter().find(|other| other.joint == joint.joint)) {
        row.extend([significant(other.rms, 3), significant(other.largest, 3), share_of_range(other)]);
    }
    row
}

/// How large the rms is beside the range of the joint's readings.
fn share_of_range(fit: &JointFit) -> String {
    let share = 100.0 * fit.rms / fit.range;
    if share.is_finite() { format!("{} %", significant(share, 2)) } else { "-".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravcal_calibration::result::SmallerModel;

    use crate::testing::{fit, joint_fit, result};

    #[test]
    fn residuals_stand_beside_the_noise() {
        let mut joint = result("joint");
        joint.fit = Some(fit());
        assert_eq!(
            report(&[joint]),
            "\
Fit: residuals of the torque readings, in their unit
  joint: χ² 101.30 for 95 degrees of freedom, p = 0.31
    held out: 4 poses in 2 stretches that a second fit did not see, χ² 9.1000
    for 8 readings
                                    fitted           held out
            unit   readings  noise     rms  largest       rms  largest  of range
    joint1  count        37   0.80   0.791     2.12     0.912     1.43    0.20 %
"
        );
    }

    #[test]
    fn smaller_models_stand_before_this_one() {
        let mut reported = fit();
        assert!(smaller_models(&reported).is_empty());
        let mut held_out = reported.held_out.clone().unwrap();
        held_out.joints[0].rms = 3.25;
        reported.smaller_models.push(SmallerModel { kind: SmallerModelKind::GravityAndFriction, held_out });
        let rows = smaller_models(&reported);
        assert_eq!(rows, [["", "unit", "with friction", "this model"], ["joint1", "count", "3.25", "0.912"]]);
        assert!(report_one("joint", &reported).contains("    joint1  count           3.25       0.912\n"));
    }

    #[test]
    fn probabilities_in_words() {
        let reported = |p_value| probability(&Fit { p_value, ..fit() });
        assert_eq!(reported(Some(0.054)), "p = 0.054");
        assert_eq!(reported(Some(0.0)), "p < 0.001: model and stated noise do not explain the readings");
        assert_eq!(reported(Some(0.99995)), "p > 0.999: the residuals are smaller than the stated noise");
        assert_eq!(reported(None), "no p-value");
    }

    #[test]
    fn under_a_loss_the_median_is_judged() {
        let reported = chi_squared(&Fit { median_ratio: Some(1.023), ..fit() });
        assert_eq!(
            reported,
            "median residual 1.02 times that of the stated noise, p = 0.31; χ² 101.30 for 95 degrees of freedom, outliers \
             included"
        );
    }

    #[test]
    fn estimated_noise_has_no_p_value() {
        let mut estimated = joint_fit("joint1");
        estimated.noise_estimated = true;
        let reported = report_one("joint", &Fit { p_value: None, joints: vec![estimated], held_out: None, ..fit() });
        assert!(reported.contains("noise estimated from the\n    residuals, no p-value\n"), "{reported}");
        assert!(!reported.contains("held out"), "{reported}");
        assert!(reported.contains("~0.80") && reported.ends_with("    ~ estimated from the residuals\n"), "{reported}");
    }

    #[test]
    fn unexplained_errors_stand_beside_noise_and_gravity() {
        let reported = |std: f64, gravity_std: f64, share_of_gravity| {
            let unexplained =
                UnexplainedResult { std, estimated: true, times_noise: std / 0.00245, gravity_std, share_of_gravity };
            let joint = JointFit { unit: "N·m".to_owned(), unexplained: Some(unexplained), ..joint_fit("joint2") };
            unexplained_error(&joint, &unexplained)
        };
        assert_eq!(
            reported(0.049, 49.0, Some(0.001)),
            "joint2: unexplained 0.049 N·m, 20 times the noise, 0.10 % of gravity's part in its readings"
        );
        assert_eq!(
            reported(0.049, 0.0, Some(0.01)),
            "joint2: unexplained 0.049 N·m, 20 times the noise, 1.0 % of a tenth of gravity's part where that is largest (it \
             carries less itself)"
        );
        assert_eq!(reported(0.0, 49.0, Some(0.0)), "joint2: nothing unexplained, the noise explains the residuals");
        let joint = JointFit {
            unexplained: Some(UnexplainedResult {
                std: 0.049,
                estimated: true,
                times_noise: 20.0,
                gravity_std: 49.0,
                share_of_gravity: Some(0.001),
            }),
            ..joint_fit("joint2")
        };
        let reported = report_one("joint", &Fit { p_value: None, joints: vec![joint], held_out: None, ..fit() });
        assert!(
            reported.contains("unexplained errors estimated") && reported.contains("    joint2: unexplained"),
            "{reported}"
        );
    }
}
