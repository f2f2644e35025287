//! What the sections of instruments come to.

use gravcal_recording::ReadingColumn;
use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::session::Instrument;

use crate::file::unexplained;

/// What the instruments come to.
#[derive(Default)]
pub(crate) struct Instruments {
    pub instruments: Vec<Instrument>,
    pub parameters: Vec<Parameter>,
    /// Column of each axis; `None` for axes that are not read.
    pub columns: Vec<Option<ReadingColumn>>,
    /// What is said of unexplained errors of each axis.
    pub unexplained: Vec<Option<unexplained::Said>>,
}

impl Instruments {
    /// The instruments with their parameters behind others.
    pub fn behind(self, further: &mut Vec<Parameter>) -> Vec<Instrument> {
        let first = further.len();
        further.extend(self.parameters);
        let shifted = |i: Instrument| Instrument { first_parameter: first + i.first_parameter, ..i };
        self.instruments.into_iter().map(shifted).collect()
    }
}
