//! What sessions and simulations may name: a value that is handed to their readers, to which any crate adds its own.
//!
//! ```
//! use gravcal_robot_model::Registry;
//!
//! let registry = Registry::standard();
//! assert!(registry.sensor_model("coulomb-friction").is_ok());
//! let error = registry.sensor_model("coulomb-frction").unwrap_err();
//! assert!(error.to_string().contains("did you mean `coulomb-friction`?"));
//! ```

use std::sync::Arc;

use gravcal_recording::nearest_name;
use thiserror::Error;

use crate::residual_models::ResidualModel;
use crate::sensors::{SensorModel, standard_sensor_models};
use crate::solver_factory::SolverFactory;

/// Everything that has a name in files and may be added to.
#[derive(Clone, Debug)]
pub struct Registry {
    sensor_models: Vec<Arc<dyn SensorModel>>,
    residual_models: Vec<Arc<dyn ResidualModel>>,
    solvers: Vec<Arc<dyn SolverFactory>>,
}

impl Registry {
    /// What gravcal itself has.
    pub fn standard() -> Registry {
        Registry { sensor_models: standard_sensor_models(), residual_models: Vec::new(), solvers: Vec::new() }
    }

    /// The same with one more model of sensors. Of two of one name the later one counts.
    #[must_use]
    pub fn with_sensor_model(mut self, model: impl SensorModel + 'static) -> Registry {
        self.sensor_models.retain(|known| known.name() != model.name());
        self.sensor_models.push(Arc::new(model));
        self
    }

    /// All models of sensors.
    pub fn sensor_models(&self) -> impl Iterator<Item = &dyn SensorModel> {
        self.sensor_models.iter().map(AsRef::as_ref)
    }

    /// The model of sensors that has this name.
    ///
    /// # Errors
    /// There is none; the message has the known names.
    pub fn sensor_model(&self, name: &str) -> Result<&dyn SensorModel, UnknownName> {
        self.sensor_models().find(|known| known.name() == name).ok_or_else(|| {
            let known: Vec<&str> = self.sensor_models().map(SensorModel::name).collect();
            UnknownName::new("sensor model", name, &known)
        })
    }

    /// The same with one more model of residuals. Of two of one name the later one counts.
    #[must_use]
    pub fn with_residual_model(mut self, model: impl ResidualModel + 'static) -> Registry {
        self.residual_models.retain(|known| known.name() != model.name());
        self.residual_models.push(Arc::new(model));
        self
    }

    /// All models of residuals: those that were added.
    pub fn residual_models(&self) -> impl Iterator<Item = &dyn ResidualModel> {
        self.residual_models.iter().map(AsRef::as_ref)
    }

    /// The model of residuals that has this name.
    ///
    /// # Errors
    /// There is none; the message has the known names.
    pub fn residual_model(&self, name: &str) -> Result<&dyn ResidualModel, UnknownName> {
        self.residual_models().find(|known| known.name() == name).ok_or_else(|| {
            let known: Vec<&str> = self.residual_models().map(ResidualModel::name).collect();
            UnknownName::new("residual", name, &known)
        })
    }

    /// The same with one more method that minimises. Of two of one name the later one counts.
    #[must_use]
    pub fn with_solver(mut self, solver: impl SolverFactory + 'static) -> Registry {
        self.solvers.retain(|known| known.name() != solver.name());
        self.solvers.push(Arc::new(solver));
        self
    }

    /// All methods that were added.
    pub fn solvers(&self) -> impl Iterator<Item = &dyn SolverFactory> {
        self.solvers.iter().map(AsRef::as_ref)
    }
}

impl Default for Registry {
    fn default() -> Self {
        Registry::standard()
    }
}

/// Nothing has this name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("there is no {what} `{name}`{near}; known: {}", if .known.is_empty() { "none" } else { .known })]
pub struct UnknownName {
    what: &'static str,
    name: String,
    near: String,
    known: String,
}

impl UnknownName {
    fn new(what: &'static str, name: &str, known: &[&str]) -> UnknownName {
        let near = nearest_name(name, known).map_or_else(String::new, |near| format!(" (did you mean `{near}`?)"));
        UnknownName { what, name: name.to_owned(), near, known: known.join(", ") }
    }
}
