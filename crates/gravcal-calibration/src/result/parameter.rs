//! What is told of one parameter.

use std::borrow::Cow;

use gravcal_robot_model::parameter::{ParameterId, UNREAD};
use gravcal_robot_model::session::{LAST_FRAME_CHOICE, NO_TORQUE_SENSOR, Session};
use serde::Serialize;

/// One sensor parameter.
#[derive(Clone, Debug, Serialize)]
pub struct ParameterResult {
    /// `joint1.torque_gain`.
    pub name: String,
    /// Unit of value, std and interval.
    pub unit: String,
    /// The equation in which it stands.
    pub convention: Cow<'static, str>,
    /// `null` where it is undetermined; then so are `std` and `ci95`.
    pub value: Option<f64>,
    /// Standard deviation; 0 where the value is fixed. Where few residuals tell the noise it is told larger, for caution, and `ci95` is not.
    pub std: Option<f64>,
    /// 95 % interval: `value` ± q · `std`. q is the 0.975 quantile of Student's t with the degrees of freedom with which `std` was found: readings
    /// less parameters where the residuals show the noise, and one less than the blocks that tell this parameter where leaving out blocks does.
    /// With stated noise alone, and of the sequential estimator, it is 1.96. Of the bootstrap the interval is percentiles.
    pub ci95: Option<[f64; 2]>,
    /// Whether the data (or exact knowledge) give it a value.
    pub determined: bool,
    /// Why it was fixed and not estimated, where it was.
    pub held: Option<String>,
    /// Whether it was asked for.
    pub asked: bool,
    /// The value from which the estimation started.
    pub nominal: f64,
}

impl ParameterResult {
    /// Value and standard deviation in [`unit`](ParameterResult::unit), where there are any; a value that is fixed has a standard deviation of 0.
    pub fn estimate(&self) -> Option<(f64, f64)> {
        self.value.zip(self.std)
    }

    /// A parameter's entry in a result, without a value; `determined` only says that its value is not a choice.
    pub(crate) fn blank(session: &Session, id: ParameterId) -> ParameterResult {
        let parameter = session.parameter(id);
        let name = parameter.name();
        let meaningless = [LAST_FRAME_CHOICE, NO_TORQUE_SENSOR, UNREAD].map(Some).contains(&parameter.fixed);
        ParameterResult {
            asked: session.asks(&name),
            unit: parameter.unit,
            convention: parameter.convention,
            value: None,
            std: None,
            ci95: None,
            determined: !meaningless,
            held: parameter.fixed.map(str::to_owned),
            nominal: parameter.prior.nominal,
            name,
        }
    }
}
