//! Sensor models and residuals whose functions are written in Python, for all poses at once.
//!
//! A term is asked pose by pose. One that depends on nothing but what each pose says (position readings, time, temperature, ...) is
//! therefore evaluated for all poses of the session together, whenever its parameters are others than last time ([`Batch`]); one that reads
//! a torque or a true coordinate, which change with all unknowns, costs a call into Python each pose.

mod batch;
mod residual;
mod said;
mod term;

use std::sync::Arc;

use gravcal::calibration::{Registry, Session};
use pyo3::prelude::*;

use crate::estimation::Raised;
use crate::failure::bad_input_reported;
use residual::{PythonResidual, SaidResidual};
use said::{PythonModel, SaidModel};

/// What Python says of one model.
#[derive(Debug, FromPyObject)]
pub enum Said {
    Sensor(SaidModel),
    Residual(SaidResidual),
}

/// The models of one session.
#[derive(Debug, Default)]
pub struct Models {
    models: Vec<PythonModel>,
    residuals: Vec<PythonResidual>,
    raised: Arc<Raised>,
}

impl Models {
    pub fn new(py: Python<'_>, said: Vec<Said>) -> PyResult<Models> {
        let raised = Arc::new(Raised::default());
        let (mut sensors, mut residuals) = (Vec::new(), Vec::new());
        for model in said {
            match model {
                Said::Sensor(model) => sensors.push(model),
                Said::Residual(model) => residuals.push(model),
            }
        }
        for (place, model) in residuals.iter().enumerate() {
            if residuals[..place].iter().any(|other| other.name == model.name) {
                let reported = format!("there is a residual `{}` already: give yours another name", model.name);
                return Err(bad_input_reported(py, &reported));
            }
        }
        let said = sensors;
        let standard = Registry::standard();
        for (place, model) in said.iter().enumerate() {
            let twice = said[..place].iter().any(|other| other.name == model.name);
            if twice || standard.sensor_model(&model.name).is_ok() {
                let reported = format!("there is a sensor model `{}` already: give yours another name", model.name);
                return Err(bad_input_reported(py, &reported));
            }
        }
        let models = said.into_iter().map(|model| PythonModel::new(model, &raised)).collect();
        let residuals = residuals.into_iter().map(|model| PythonResidual::new(model, &raised)).collect();
        Ok(Models { models, residuals, raised })
    }

    /// gravcal's own, and these.
    pub fn registry(&self) -> Registry {
        let sensors = self.models.iter().cloned().fold(Registry::standard(), Registry::with_sensor_model);
        self.residuals.iter().cloned().fold(sensors, Registry::with_residual_model)
    }

    /// From here on terms are evaluated for all poses of the session at once.
    pub fn know_poses(&self, session: &Session) {
        self.models.iter().flat_map(PythonModel::batches).for_each(|batch| batch.know(session));
    }

    /// What functions of the user have raised; nothing where there are none.
    pub fn raised(&self) -> Option<&Arc<Raised>> {
        (!self.models.is_empty() || !self.residuals.is_empty()).then_some(&self.raised)
    }
}
