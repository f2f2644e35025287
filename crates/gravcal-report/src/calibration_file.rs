//! `calibration.json`: the answers and where they come from.
//!
//! The same input gives the same bytes: no times, no paths of one machine.

use gravcal_calibration::result::EstimatorResult;
use serde::Serialize;

use crate::finite::check_finite;
use crate::json::{JsonError, json};
use crate::provenance::Provenance;

/// What the file calls its own format.
pub const FORMAT: &str = "gravcal-calibration/1";

/// The contents of `calibration.json`.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationFile<'a> {
    /// What the session says that can hardly be so.
    pub doubts: &'a [String],
    /// What the estimators answered.
    pub estimators: &'a [EstimatorResult],
    /// Where it comes from.
    pub provenance: &'a Provenance,
}

/// The file as it is written.
#[derive(Serialize)]
struct Document<'a> {
    /// `gravcal-calibration/1`.
    format: &'static str,
    /// What the session says that can hardly be so; absent where there is nothing.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    doubts: &'a [String],
    /// What each estimator answered.
    estimators: &'a [EstimatorResult],
    /// Where it comes from.
    provenance: &'a Provenance,
}

impl CalibrationFile<'_> {
    /// The contents as JSON. What is undetermined has the value `null`, never a number.
    ///
    /// # Errors
    /// Where a number is infinite or none at all, which JSON cannot hold.
    pub fn to_json(&self) -> Result<String, JsonError> {
        check_finite(self.estimators)?;
        let CalibrationFile { doubts, estimators, provenance } = *self;
        json(&Document { format: FORMAT, doubts, estimators, provenance })
    }
}

#[cfg(test)]
mod tests {
    use gravcal_calibration::result::Iteration;

    use gravcal_recording::InputRole;

    use super::*;
    use crate::provenance::{Input, Options};
    use crate::testing::{determined, fit, held, result, undetermined};

    fn provenance() -> Provenance {
        let input = Input { path: "session.toml".into(), sha256: "ab".repeat(32), bytes: 12, role: InputRole::Session };
        let mut solver_options = toml::Table::new();
        solver_options.insert("cosine_tolerance".into(), 1e-8.into());
        let solver = "levenberg-marquardt".into();
        Provenance::new(vec![input], Options { estimators: vec!["joint".into()], solver, solver_options })
    }

    fn parsed(estimators: &[EstimatorResult]) -> serde_json::Value {
        let provenance = provenance();
        let text = CalibrationFile { doubts: &[], estimators, provenance: &provenance }.to_json().unwrap();
        assert!(text.ends_with("}\n"));
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn fields_are_those_of_the_contract() {
        let mut joint = result("joint");
        joint.parameters = vec![
            determined("joint1.torque_gain", "count/(N·m)", 7.118, 0.02),
            undetermined("joint2.torque_gain"),
            held("joint1.position_offset", "zero by definition of the base frame"),
        ];
        joint.fit = Some(fit());
        let start = Iteration { cost: 900.5, largest_cosine: 0.7, step: 0.0, damping: 0.0 };
        joint.trace = vec![start, Iteration { cost: 50.6, largest_cosine: 2e-11, step: 0.1, damping: 1e-3 }];
        let file = parsed(&[joint]);
        assert_eq!(file["format"], "gravcal-calibration/1");
        let estimator = &file["estimators"][0];
        assert_eq!(estimator["name"], "joint");
        assert_eq!(estimator["verdict"], "determined");
        for field in ["vector_m_per_s2", "std_m_per_s2", "ci95_m_per_s2", "cone95_deg"] {
            assert!(!estimator["gravity"][field].is_null(), "{field}");
        }
        let parameter = &estimator["parameters"][0];
        for field in ["name", "unit", "convention", "value", "std", "ci95", "determined"] {
            assert!(!parameter[field].is_null(), "{field}");
        }
        assert!(estimator["parameters"][1]["value"].is_null());
        assert_eq!(estimator["parameters"][2]["value"], 0.0);
        assert!(estimator["covariance"]["order"].is_array() && estimator["covariance"]["matrix"].is_array());
        assert!(estimator["moments"].is_array() && estimator["undetermined"].is_array());
        assert!(estimator["active_constraints"].is_array());
        assert_eq!(estimator["fit"]["held_out"]["poses"], 4);
        assert_eq!(estimator["trace"][1]["largest_cosine"], 2e-11);
    }

    #[test]
    fn provenance_names_program_inputs_and_options() {
        let provenance = &parsed(&[])["provenance"];
        assert_eq!(provenance["program"], "gravcal");
        assert_eq!(provenance["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(provenance["inputs"][0]["path"], "session.toml");
        assert_eq!(provenance["inputs"][0]["bytes"], 12);
        assert_eq!(provenance["inputs"][0]["sha256"].as_str().unwrap().len(), 64);
        assert_eq!(provenance["options"]["estimators"][0], "joint");
        assert_eq!(provenance["options"]["solver"], "levenberg-marquardt");
        assert_eq!(provenance["options"]["solver_options"]["cosine_tolerance"], 1e-8);
    }

    #[test]
    fn numbers_survive_to_the_last_bit() {
        let mut joint = result("joint");
        let value = 0.1 + 0.2;
        joint.parameters = vec![determined("joint1.torque_gain", "1", value, 1e-300)];
        let parameter = &parsed(&[joint])["estimators"][0]["parameters"][0];
        assert_eq!(parameter["value"].as_f64().unwrap().to_bits(), value.to_bits());
        assert_eq!(parameter["std"], 1e-300);
    }

    #[test]
    fn no_number_is_refused() {
        let mut joint = result("joint");
        joint.parameters = vec![determined("joint1.torque_gain", "1", f64::NAN, 0.1)];
        let provenance = provenance();
        let refused =
            CalibrationFile { doubts: &[], estimators: &[joint], provenance: &provenance }.to_json().unwrap_err();
        assert!(refused.to_string().contains("joint1.torque_gain is NaN"));
    }
}
