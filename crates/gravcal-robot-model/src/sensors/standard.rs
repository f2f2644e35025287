//! The models that gravcal itself has.

use std::sync::Arc;

use super::crosstalk::Crosstalk;
use super::drift::{DriftInTime, DriftWithTemperature};
use super::formula::Formula;
use super::friction::{Coulomb, Presliding, Viscous};
use super::harmonics::Harmonics;
use super::model::{SensorModel, Side};
use super::polynomial::Polynomial;

/// In the order in which messages list them.
pub(crate) fn standard_sensor_models() -> Vec<Arc<dyn SensorModel>> {
    vec![
        Arc::new(DriftInTime),
        Arc::new(DriftWithTemperature),
        Arc::new(Polynomial),
        Arc::new(Coulomb),
        Arc::new(Viscous),
        Arc::new(Presliding),
        Arc::new(Crosstalk),
        Arc::new(Harmonics),
        Arc::new(Formula(Side::Torque)),
        Arc::new(Formula(Side::Position)),
    ]
}
