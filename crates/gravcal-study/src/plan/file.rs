//! What `study.toml` may hold.

use gravcal_session::document::OneOrMany;
use serde::Deserialize;
use toml::Value;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct StudyTable {
    /// The simulation that is varied. Give this or `random_arms`.
    ///
    /// Example: `simulation = "../sarcos-shoulder/simulation.toml"`
    pub simulation: Option<String>,
    /// A family of random arms, one a trial.
    ///
    /// Example: `random_arms = { know = "nominal" }`
    pub random_arms: Option<RandomArmsTable>,
    /// Trials at each point.
    ///
    /// Unit: trials.
    /// Example: `trials = 1000`
    pub trials: u64,
    /// Seed.
    ///
    /// Unit: none.
    /// Default: that of the simulation; 0 for random arms.
    /// Example: `seed = 1`
    pub seed: Option<u64>,
    /// Which estimators are compared. Besides those of a session: `sequential-true-step-1` and
    /// `sequential-true-steps-1-and-2`, which are given true results.
    ///
    /// Example: `estimators = ["sequential", "joint"]`
    pub estimators: Vec<String>,
    /// Which solvers each runs with.
    ///
    /// Default: the default.
    /// Example: `solvers = ["levenberg-marquardt"]`
    #[serde(default)]
    pub solvers: Vec<String>,
    /// What is other than in the simulation's file, at every point.
    ///
    /// Default: nothing.
    /// Example: `change = [{ field = "torque.converter", drop = true }]`
    #[serde(default)]
    pub change: Vec<ChangeTable>,
    /// What is varied. The points are the grid of all of these.
    ///
    /// Default: one point.
    /// Example: `vary = [{ name = "noise", unit = "count", field = "torque.std", values = [0.2, 0.8] }]`
    #[serde(default)]
    pub vary: Vec<VaryTable>,
    /// Each trial has its own truth, within ± of the simulation's.
    ///
    /// Example: `draw = { torque_gain_relative = 0.3 }`
    pub draw: Option<DrawTable>,
}

/// A family of robots instead of one: see [`crate::random_arms`].
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RandomArmsTable {
    /// What the sessions know of the sensors: `"nominal"` or `"nothing"`.
    ///
    /// Example: `know = "nominal"`
    pub know: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangeTable {
    /// The field, or a list of fields that all get the value: keys with dots between; 0, 1, … or `*` for elements of a
    /// list. Fields of `session` are those of session.toml.
    ///
    /// Example: `field = "sweep.*.range_deg"`
    pub field: OneOrMany<String>,
    /// Its value.
    ///
    /// Unit: that of the field.
    /// Example: `value = [-90, 90]`
    pub value: Option<Value>,
    /// Leave the field away.
    ///
    /// Default: `false`.
    /// Example: `drop = true`
    #[serde(default)]
    pub drop: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VaryTable {
    /// What it is called in tables and figures.
    ///
    /// Example: `name = "noise"`
    pub name: String,
    /// Unit of the values.
    ///
    /// Unit: none.
    /// Default: none.
    /// Example: `unit = "count"`
    pub unit: Option<String>,
    /// The field that is varied, or a list.
    ///
    /// Example: `field = "torque.std"`
    pub field: Option<OneOrMany<String>>,
    /// Its values.
    ///
    /// Unit: as `unit` says.
    /// Example: `values = [0.1, 0.3, 1.0]`
    pub values: Option<Vec<Value>>,
    /// In place of field and values: several changes at once, with a name.
    ///
    /// Example: `cases = [{ name = 180, change = [{ field = "sweep.*.range_deg", value = [-90, 90] }] }]`
    pub cases: Option<Vec<CaseTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseTable {
    /// A text or a number.
    ///
    /// Example: `name = 180`
    pub name: Value,
    /// What is changed.
    ///
    /// Default: nothing.
    /// Example: `change = [{ field = "torque.std", value = 1 }]`
    #[serde(default)]
    pub change: Vec<ChangeTable>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DrawTable {
    /// Of torque gains, relative to them.
    ///
    /// Unit: 1.
    /// Default: 0.
    /// Example: `torque_gain_relative = 0.3`
    #[serde(default)]
    pub torque_gain_relative: f64,
    /// Of torque biases.
    ///
    /// Unit: the reading's.
    /// Default: 0.
    /// Example: `torque_bias = 100`
    #[serde(default)]
    pub torque_bias: f64,
    /// Of position gains, relative to them.
    ///
    /// Unit: 1.
    /// Default: 0.
    /// Example: `position_gain_relative = 0.03`
    #[serde(default)]
    pub position_gain_relative: f64,
    /// Of position offsets that are no choices of frames.
    ///
    /// Default: 0.
    /// Example: `position_offset_deg = 20`
    #[serde(default)]
    pub position_offset_deg: f64,
    /// Angle by which gravity's direction is off.
    ///
    /// Default: 0.
    /// Example: `gravity_deg = 10`
    #[serde(default)]
    pub gravity_deg: f64,
}
