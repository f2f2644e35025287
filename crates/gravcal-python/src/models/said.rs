//! What Python says of a model: objects with these attributes.

use std::sync::{Arc, Mutex, PoisonError};

use gravcal::calibration::parameter::Limit;
use gravcal::calibration::sensors::{
    Declared, Need, Options, ParameterSpec, Reads, RefusedOption, SensorModel, Side, Site,
};
use pyo3::prelude::*;

use super::batch::Batch;
use super::term::{Function, PythonTerm};
use crate::estimation::Raised;

/// A model.
#[derive(Debug, FromPyObject)]
pub struct SaidModel {
    pub name: String,
    help: String,
    of_position: bool,
    parameters: Vec<SaidParameter>,
    reads_torque: bool,
    reads_coordinate: bool,
    /// Names of conditions.
    needs: Vec<String>,
    linear: bool,
    affine_in_torque: bool,
    evaluate: Py<PyAny>,
}

/// A parameter of a model: one that each joint with it has, or a residual.
#[derive(Clone, Debug, FromPyObject)]
pub struct SaidParameter {
    name: String,
    unit: String,
    limit: f64,
    nominal: f64,
    equation: String,
    cure: String,
}

/// A model, and what the terms that it declared keep of the poses.
#[derive(Clone, Debug)]
pub struct PythonModel {
    said: Arc<SaidModel>,
    batches: Arc<Mutex<Vec<Arc<Batch>>>>,
    raised: Arc<Raised>,
}

impl PythonModel {
    pub fn new(said: SaidModel, raised: &Arc<Raised>) -> PythonModel {
        PythonModel { said: Arc::new(said), batches: Arc::default(), raised: Arc::clone(raised) }
    }

    pub fn batches(&self) -> Vec<Arc<Batch>> {
        self.batches.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn reads(&self, joint: usize) -> Reads {
        let said = &self.said;
        let need = |name: &String| match name.as_str() {
            "time" => Some(Need::Time),
            "temperature" => Some(Need::Temperature),
            "velocity" => Some(Need::Velocity),
            "direction" => Some(Need::Direction),
            _ => None,
        };
        let reads = said.needs.iter().filter_map(need).fold(Reads::positions(), Reads::condition);
        let reads = if said.reads_torque { reads.torque(joint) } else { reads };
        let reads = if said.reads_coordinate { reads.coordinate(joint) } else { reads };
        let reads = if said.affine_in_torque { reads.affine_in_torques() } else { reads };
        if said.linear { reads.linear_in_parameters() } else { reads }
    }
}

impl SensorModel for PythonModel {
    fn name(&self) -> &str {
        &self.said.name
    }

    fn help(&self) -> &str {
        &self.said.help
    }

    fn side(&self) -> Side {
        if self.said.of_position { Side::Position } else { Side::Torque }
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let parameters: Vec<ParameterSpec> = self.said.parameters.iter().map(SaidParameter::spec).collect();
        let evaluate = Python::attach(|py| self.said.evaluate.clone_ref(py));
        let alone = !self.said.reads_torque && !self.said.reads_coordinate;
        let function = Function { evaluate, joint: site.joint(), raised: Arc::clone(&self.raised) };
        let batch = alone.then(|| Arc::new(Batch::new(function.joint)));
        self.batches.lock().unwrap_or_else(PoisonError::into_inner).extend(batch.clone());
        Ok(vec![Declared::new(
            parameters,
            PythonTerm { function, reads: self.reads(site.joint()), joints: site.joint_names().len(), batch },
        )])
    }
}

impl SaidParameter {
    pub fn spec(&self) -> ParameterSpec {
        ParameterSpec::new(&self.name, &self.unit, Limit::Absolute(self.limit))
            .starting_at(self.nominal)
            .in_equation(self.equation.clone())
            .cured_by(self.cure.clone())
    }
}
