//! What a calibration comes to, on one screen: verdict, what to do, one line a joint, gravity, what is undetermined.
//!
//! Of several estimators the one that decides is told. Numbers stand in the short notation of metrology: `1.0797(10)` is 1.0797 with
//! a standard deviation of 0.0010, the digits in brackets being the last ones of the value.

use std::fmt;

use gravcal_calibration::result::{EstimatorResult, ParameterResult, Undetermined, Verdict, deciding};
use gravcal_robot_model::number::{measured, significant};

use crate::advice::Advice;
use crate::further_parameters::further_parameters;
use crate::joint_table::{Entry, joint_table};
use crate::payload_text;
use crate::sensor_row::{shown_unit, tilt};
use crate::text::{WIDTH, plain, width, wrapped};

/// Lines at most, so that a screen of 25 has room for where the results are.
const MOST: usize = 24;
/// Of these, each part that may be cut has so many at least.
const LEAST: usize = 2;

const LEGEND: &str = "1.23(4): 1.23 ± 0.04. fixed: not estimated. open: undetermined. --full: all.";

/// What the deciding estimator answers, in at most 25 lines of 80 columns for seven joints.
///
/// ```
/// let summary = gravcal_report::CalibrationSummary { robot: "my-arm", results: &[], file: "calibration.json" };
/// assert_eq!(summary.to_string(), "Calibration of my-arm: no estimator ran\n");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CalibrationSummary<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// What the estimators answered.
    pub results: &'a [EstimatorResult],
    /// `calibration.json`, as the reader would name it in a command.
    pub file: &'a str,
}

impl fmt::Display for CalibrationSummary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(result) = deciding(self.results) else {
            return writeln!(f, "Calibration of {}: no estimator ran", plain(self.robot));
        };
        let reported = match result.verdict {
            Verdict::Failed => failed(self.robot, result, self.file),
            Verdict::Determined | Verdict::PartlyDetermined => found(self.robot, result, self.file),
        };
        f.write_str(&plain(&reported))
    }
}

/// The likely cause stands first; numbers that nobody may use are not shown.
fn failed(robot: &str, result: &EstimatorResult, file: &str) -> String {
    let Advice { headline, why, steps, .. } = Advice::of(result, file);
    let steps: String = steps.iter().map(|step| wrapped("  - ", "    ", step)).collect();
    wrapped("", "  ", &format!("Calibration of {robot}. {headline}"))
        + &wrapped("  ", "  ", &why)
        + "What to do\n"
        + &steps
        + "--full shows what the fit came to.\n"
}

fn found(robot: &str, result: &EstimatorResult, file: &str) -> String {
    let advice = Advice::of(result, file);
    let entries: Vec<Entry<'_>> = result
        .parameters
        .iter()
        .map(|parameter| Entry { name: &parameter.name, unit: &parameter.unit, cell: value(parameter) })
        .collect();
    let verdict = wrapped("", "  ", &format!("Calibration of {robot}. {}", advice.headline));
    let (table, gravity) = (joint_table(&entries), gravity(result));
    let rest = [&verdict, "What to do\n\n", &table, &gravity, LEGEND];
    let taken: usize = rest.iter().map(|text| text.lines().count()).sum();
    // In the order in which what is left of the screen goes to them.
    let [why, steps, further, open, payloads] = cut_to(
        [
            wrapped("  ", "  ", &advice.why),
            advice.steps.iter().map(|step| wrapped("  - ", "    ", step)).collect(),
            further_parameters(&entries),
            undetermined(result),
            payloads(result),
        ],
        MOST.saturating_sub(taken),
    );
    format!("{verdict}{why}What to do\n{steps}\n{table}{further}{gravity}{payloads}{open}{LEGEND}\n")
}

/// Texts cut to so many lines in all, where each has [`LEAST`] of its own; the first has what it needs before the others have more.
pub(crate) fn cut_to<const N: usize>(texts: [String; N], lines: usize) -> [String; N] {
    let needed = texts.each_ref().map(|text| text.lines().count());
    let mut left = lines.saturating_sub(needed.iter().map(|needed| LEAST.min(*needed)).sum());
    let mut place = 0;
    texts.map(|text| {
        let more = needed[place].saturating_sub(LEAST).min(left);
        (left, place) = (left - more, place + 1);
        first_lines(&text, LEAST + more)
    })
}

fn value(parameter: &ParameterResult) -> String {
    match (&parameter.held, parameter.value, parameter.std) {
        (Some(_), ..) => Entry::FIXED.to_owned(),
        (None, Some(value), Some(std)) => {
            let factor = shown_unit(&parameter.unit).1;
            short(value * factor, std * factor)
        }
        _ => "open".to_owned(),
    }
}

/// `1.0797(10)`; beyond what reads well as a plain number `7.6699e-4 ± 1.2e-7`.
fn short(value: f64, std: f64) -> String {
    let (value, std) = measured(value, std);
    if std.contains('e') || value.contains('e') {
        return format!("{value} ± {std}");
    }
    let digits: String = std.chars().filter(char::is_ascii_digit).collect();
    format!("{value}({})", digits.trim_start_matches('0'))
}

fn gravity(result: &EstimatorResult) -> String {
    let Some(gravity) = &result.gravity else { return "gravity: undetermined\n".to_owned() };
    let [x, y, z] = [0, 1, 2].map(|axis| short(gravity.vector_m_per_s2[axis], gravity.std_m_per_s2[axis]));
    let tilt = measured(tilt(gravity.vector_m_per_s2).to_degrees(), gravity.cone95_deg).0;
    let cone = significant(gravity.cone95_deg, 2);
    wrapped("", "  ", &format!("gravity  {x} {y} {z} m/s², tilt {tilt} deg, direction ± {cone} deg (95 %)"))
}

fn payloads(result: &EstimatorResult) -> String {
    result.payloads.iter().map(|payload| wrapped("", "  ", &payload_text::found(payload))).collect()
}

/// What is not estimated stands as `fixed` in the table.
fn undetermined(result: &EstimatorResult) -> String {
    let fixed = |name: &String| result.parameters.iter().any(|other| other.name == *name && other.held.is_some());
    let of_fixed = |open: &&Undetermined| !open.parameters.is_empty() && open.parameters.iter().all(fixed);
    let open = result.undetermined.iter().filter(|open| !of_fixed(open));
    let reported: Vec<&str> = open.map(|open| open.combination.as_str()).collect();
    if reported.is_empty() {
        String::new()
    } else {
        wrapped("", "  ", &format!("undetermined: {}", reported.join("; ")))
    }
}

/// The first lines of a text, with a mark where there are more; cut between words.
pub(crate) fn first_lines(text: &str, most: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    if lines.len() <= most {
        return text.to_owned();
    }
    let mut last = lines[most - 1].trim_end();
    while width(last) > WIDTH - 2 {
        last = last.trim_end().rsplit_once(char::is_whitespace).map_or("", |(words, _)| words.trim_end());
    }
    let shown: String = lines[..most - 1].iter().map(|line| format!("{line}\n")).collect();
    format!("{shown}{last} …\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{determined, fit, held, result, undetermined as open};

    fn reported(results: &[EstimatorResult]) -> String {
        CalibrationSummary { robot: "arm", results, file: "calibration.json" }.to_string()
    }

    fn seven_joints() -> EstimatorResult {
        let mut joint = result("joint");
        joint.fit = Some(fit());
        joint.parameters = (1..=7)
            .flat_map(|i| {
                let name = |quantity: &str| format!("lbr_iiwa_joint_{i}.{quantity}");
                [
                    determined(&name("torque_gain"), "count/(N·m)", 7.118_13, 0.0204),
                    determined(&name("torque_bias"), "count", -2075.123, 0.0118),
                    determined(&name("position_gain"), "rad/rad", 0.988_02, 0.000_47),
                    determined(&name("position_offset"), "rad", -2.35, 0.000_42),
                ]
            })
            .collect();
        for gain in joint.parameters.iter_mut().filter(|parameter| parameter.name.ends_with("position_gain")) {
            gain.nominal = 1.0;
        }
        joint
    }

    #[test]
    fn seven_joints_fit_on_a_screen_whatever_is_wrong_with_them() {
        let mut partly = seven_joints();
        partly.verdict = Verdict::PartlyDetermined;
        partly.parameters[0] = open("lbr_iiwa_joint_1.torque_gain");
        let undetermined = Undetermined {
            combination: "lbr_iiwa_joint_1.torque_gain, lbr_iiwa_joint_1.position_gain, and a long list of others"
                .into(),
            parameters: vec!["lbr_iiwa_joint_1.torque_gain".into()],
            why: "w".into(),
            cure: "tilt the base, and record what was recorded before it was tilted, once more, ".repeat(4),
        };
        partly.undetermined = vec![undetermined.clone(), undetermined];
        partly.parameters.extend((0..9).map(|i| determined(&format!("wrist.fx_{i}"), "N", 0.1, 0.01)));
        for result in [seven_joints(), partly] {
            let text = reported(&[result]);
            assert!(text.lines().count() <= 24, "with the place of the results 25: {text}");
            assert!(text.lines().all(|line| width(line) <= WIDTH), "{text}");
            assert!(text.contains("lbr_iiwa_joint_7"), "{text}");
        }
    }

    #[test]
    fn numbers_stand_with_the_last_digits_of_their_standard_deviation() {
        assert_eq!(short(1.079_71, 0.001_02), "1.0797(10)");
        assert_eq!(short(2009.0, 1.0), "2009.0(10)");
        assert_eq!(short(3412.0, 17.0), "3412(17)");
        assert_eq!(short(-0.001_1, 0.002_7), "-0.0011(27)");
        assert!(short(7.669_9e-7, 1.2e-10).contains(" ± "));
    }

    #[test]
    fn only_the_estimator_that_decides_is_reported() {
        let mut sequential = result("sequential");
        sequential.parameters = vec![open("joint1.torque_gain")];
        let mut joint = seven_joints();
        joint.parameters[3] = held("lbr_iiwa_joint_1.position_offset", "it defines the base frame");
        let text = reported(&[sequential, joint]);
        assert!(!text.contains("sequential"), "{text}");
        assert!(!text.contains("joint1 ") && text.lines().any(|line| line.ends_with("fixed")), "{text}");
        assert!(text.contains("7.118(20)") && text.contains("-134.645(24)"), "{text}");
    }

    #[test]
    fn what_is_undetermined_is_reported_unless_it_is_fixed() {
        let mut joint = seven_joints();
        joint.parameters[3] = held("lbr_iiwa_joint_1.position_offset", "it defines the base frame");
        let open = |combination: &str, parameters: &[&str]| Undetermined {
            combination: combination.into(),
            parameters: parameters.iter().map(ToString::to_string).collect(),
            why: "w".into(),
            cure: "c".into(),
        };
        let offset = "lbr_iiwa_joint_1.position_offset";
        joint.undetermined = vec![
            open(offset, &[offset]),
            open("the size of the noise", &[]),
            open("a scale", &[offset, "lbr_iiwa_joint_1.torque_gain"]),
        ];
        assert!(reported(&[joint]).contains("\nundetermined: the size of the noise; a scale\n"));
    }

    #[test]
    fn a_failure_begins_with_its_cause_and_shows_no_number() {
        let mut failed = seven_joints();
        failed.verdict = Verdict::Failed;
        failed.termination = "swapped torque columns: joint2 and joint3".into();
        failed.reasons = 1;
        failed.notes = vec!["The likely cause is swapped torque columns. Exchange them.".into()];
        assert_eq!(
            reported(&[failed]),
            "Calibration of arm. Failed: there is no answer to rely on\n\
             \x20 Swapped torque columns: joint2 and joint3.\n\
             What to do\n\
             \x20 - The likely cause is swapped torque columns. Exchange them.\n\
             \x20 - Look at the residuals (report.html): which joint is far off, and in which\n\
             \x20   poses, tells what is wrong.\n\
             \x20 - Use no number of this result. Mend the session and calibrate again.\n\
             --full shows what the fit came to.\n"
        );
    }
}
