//! The entry of a parameter before anything is estimated.

use super::ParameterResult;
use crate::parameter::{ParameterId, UNREAD};
use crate::session::{LAST_FRAME_CHOICE, NO_TORQUE_SENSOR, Session};

impl Session {
    /// A parameter's entry in a result, without a value; `determined` only says that its value is not a choice.
    pub(crate) fn blank_parameter(&self, id: ParameterId) -> ParameterResult {
        let parameter = self.parameter(id);
        let name = parameter.name();
        let meaningless = [LAST_FRAME_CHOICE, NO_TORQUE_SENSOR, UNREAD].map(Some).contains(&parameter.held);
        ParameterResult {
            asked: self.asks(&name),
            unit: parameter.unit,
            convention: parameter.convention,
            value: None,
            std: None,
            ci95: None,
            determined: !meaningless,
            held: parameter.held.map(str::to_owned),
            nominal: parameter.knowledge.nominal,
            name,
        }
    }
}
