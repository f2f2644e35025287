//! What `study.toml` may hold.

use gravcal_calibration::document::OneOrMany;
use serde::Deserialize;
use toml::Value;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct StudyTable {
    pub simulation: Option<String>,
    pub random_arms: Option<RandomArmsTable>,
    pub trials: u64,
    pub seed: Option<u64>,
    pub estimators: Vec<String>,
    #[serde(default)]
    pub solvers: Vec<String>,
    #[serde(default)]
    pub change: Vec<ChangeTable>,
    #[serde(default)]
    pub vary: Vec<VaryTable>,
    pub draw: Option<DrawTable>,
}

/// A family of robots instead of one: see [`crate::random_arms`].
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RandomArmsTable {
    pub know: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangeTable {
    pub field: OneOrMany<String>,
    pub value: Option<Value>,
    #[serde(default)]
    pub drop: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VaryTable {
    pub name: String,
    pub unit: Option<String>,
    pub field: Option<OneOrMany<String>>,
    pub values: Option<Vec<Value>>,
    pub cases: Option<Vec<CaseTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseTable {
    pub name: Value,
    #[serde(default)]
    pub change: Vec<ChangeTable>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DrawTable {
    #[serde(default)]
    pub torque_gain_relative: f64,
    #[serde(default)]
    pub torque_bias: f64,
    #[serde(default)]
    pub position_gain_relative: f64,
    #[serde(default)]
    pub position_offset_deg: f64,
    #[serde(default)]
    pub gravity_deg: f64,
}
