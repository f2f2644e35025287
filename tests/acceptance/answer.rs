//! The part of `calibration.json` that the tests look at, with the names that other programs rely on.

use serde::Deserialize;

/// `calibration.json`.
#[derive(Debug, Deserialize)]
pub struct Answer {
    /// Which format, and which version of it.
    pub format: String,
    /// One entry an estimator.
    pub estimators: Vec<Estimator>,
    /// Where it comes from.
    pub provenance: Provenance,
}

/// Where an answer comes from.
#[derive(Debug, Deserialize)]
pub struct Provenance {
    /// What was chosen.
    pub options: Options,
}

/// What was chosen.
#[derive(Debug, Deserialize)]
pub struct Options {
    /// The solver.
    pub solver: String,
    /// Its options, as far as they were given.
    pub solver_options: toml::Table,
}

/// One iteration of a solve.
#[derive(Debug, Deserialize)]
pub struct Iteration {
    /// After it.
    pub cost: f64,
    /// Zero at a solution.
    pub largest_cosine: f64,
}

/// What one estimator answered.
#[derive(Debug, Deserialize)]
pub struct Estimator {
    /// `joint`, `sequential`.
    pub name: String,
    /// `determined`, `partly-determined` or `failed`.
    pub verdict: String,
    /// Why the solver stopped.
    pub termination: String,
    /// The way of the last solve.
    pub trace: Vec<Iteration>,
    /// Nothing where it is undetermined.
    pub gravity: Option<Gravity>,
    /// Every sensor parameter.
    pub parameters: Vec<Parameter>,
    /// What the data do not determine.
    pub undetermined: Vec<Undetermined>,
    /// Combinations of masses and moments that the data determine.
    pub moments: Vec<Moment>,
    /// What it leans on.
    pub active_constraints: Vec<ActiveConstraint>,
    /// How well it explains the readings.
    pub fit: Option<Fit>,
}

/// How well an estimate explains the readings.
#[derive(Debug, Deserialize)]
pub struct Fit {
    /// Of poses that it did not see.
    pub held_out: Option<HeldOut>,
}

/// Prediction of poses that were not seen.
#[derive(Debug, Deserialize)]
pub struct HeldOut {
    /// Joint by joint.
    pub joints: Vec<HeldOutJoint>,
}

/// The same of one joint.
#[derive(Debug, Deserialize)]
pub struct HeldOutJoint {
    /// Its name.
    pub joint: String,
    /// Root mean square of what is left, unit of the reading.
    pub rms: f64,
    /// Largest less smallest reading, in the same.
    pub range: f64,
}

/// A combination of masses and moments.
#[derive(Debug, Deserialize)]
pub struct Moment {
    /// Its value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// A constraint on which an estimate leans.
#[derive(Debug, Deserialize)]
pub struct ActiveConstraint {
    /// In words.
    pub constraint: String,
    /// The fall of ½ χ² for each unit by which it gives way.
    pub multiplier: f64,
    /// That unit.
    pub unit: String,
}

/// Gravity in base coordinates.
#[derive(Debug, Deserialize)]
pub struct Gravity {
    /// m/s².
    pub vector_m_per_s2: [f64; 3],
    /// m/s².
    pub std_m_per_s2: [f64; 3],
}

/// One sensor parameter.
#[derive(Debug, Deserialize)]
pub struct Parameter {
    /// `joint1.torque_gain`.
    pub name: String,
    /// Unit of value and std.
    pub unit: String,
    /// Nothing where it is undetermined.
    pub value: Option<f64>,
    /// Nothing where it is undetermined, zero where it is held.
    pub std: Option<f64>,
    /// Nothing where it is undetermined.
    pub ci95: Option<[f64; 2]>,
    /// Whether it has a value.
    pub determined: bool,
    /// Why it is held, where it is.
    pub held: Option<String>,
}

/// A combination that the data do not determine.
#[derive(Debug, Deserialize)]
pub struct Undetermined {
    /// Its name.
    pub combination: String,
    /// What would determine it.
    pub cure: String,
}

impl Estimator {
    /// The parameter of a name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// The parameters that were estimated and came out determined.
    pub fn estimated(&self) -> impl Iterator<Item = &Parameter> {
        self.parameters.iter().filter(|parameter| parameter.determined && parameter.held.is_none())
    }

    /// Names of the parameters without a value.
    pub fn without_value(&self) -> Vec<&str> {
        let open = self.parameters.iter().filter(|parameter| !parameter.determined);
        open.map(|parameter| parameter.name.as_str()).collect()
    }
}

/// Names of the undetermined combinations, in the program's order.
pub fn combinations(undetermined: &[Undetermined]) -> Vec<&str> {
    undetermined.iter().map(|undetermined| undetermined.combination.as_str()).collect()
}
