//! What the sections of instruments come to.

use gravcal_recording::ReadingColumn;
use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::session::AuxiliarySensor;

use crate::file::unexplained;

/// What the instruments come to.
#[derive(Default)]
pub(crate) struct Instruments {
    pub instruments: Vec<AuxiliarySensor>,
    pub parameters: Vec<Parameter>,
    /// Column of each axis; `None` for axes that are not read.
    pub columns: Vec<Option<ReadingColumn>>,
    /// What is said of unexplained errors of each axis.
    pub unexplained: Vec<Option<unexplained::Said>>,
}

impl Instruments {
    /// The instruments with their parameters behind others.
    pub fn behind(self, further: &mut Vec<Parameter>) -> Vec<AuxiliarySensor> {
        let first = further.len();
        further.extend(self.parameters);
        let shifted = |i: AuxiliarySensor| AuxiliarySensor { first_parameter: first + i.first_parameter, ..i };
        self.instruments.into_iter().map(shifted).collect()
    }
}
