//! A calibration applied to arrays.

use std::path::Path;

use gravcal::calibration::Session;
use gravcal::calibration::application::{Application, Effort};
use gravcal::recording::read_earlier;
use gravcal_cli::Failure;
use numpy::ndarray::{Array2, ArrayView2};

/// Which calibration, and what of it.
pub struct Applied<'a> {
    /// A `calibration.json`.
    pub calibration: &'a Path,
    /// Whose answer.
    pub estimator: &'a str,
    /// What torques become.
    pub effort: Effort,
    /// Whether nominal values stand in for what is undetermined.
    pub nominal: bool,
}

impl Applied<'_> {
    /// Coordinates and torques behind readings, a row each sample: as `gravcal apply` gives them of a recording with these columns.
    pub fn to(
        &self,
        session: &Session,
        (position, torque): (ArrayView2<'_, f64>, ArrayView2<'_, f64>),
    ) -> Result<(Array2<f64>, Array2<f64>), Failure> {
        let calibration = read_earlier(self.calibration, self.estimator).map_err(|error| Failure::bad_input(&error))?;
        let application = Application::new(session, &calibration, &self.effort, self.nominal, None);
        let mut application = application.map_err(|error| Failure::bad_input(&error))?;
        let joints = session.joints.len();
        let mapping = &session.readings;
        let positions = mapping.positions.iter().map(|column| column.column.clone());
        let mut columns: Vec<String> = positions.collect();
        let read: Vec<usize> = (0..joints).filter(|joint| mapping.torques[*joint].is_some()).collect();
        columns.extend(mapping.torques.iter().flatten().map(|(column, _)| column.column.clone()));
        application.find(&columns).map_err(|error| Failure::bad_input(&error))?;

        let mut coordinates = Array2::from_elem(position.dim(), f64::NAN);
        let mut torques = Array2::from_elem(torque.dim(), f64::NAN);
        let mut cells = vec![f64::NAN; columns.len()];
        for row in 0..position.nrows() {
            (0..joints).for_each(|joint| cells[joint] = position[[row, joint]]);
            read.iter().enumerate().for_each(|(place, joint)| cells[joints + place] = torque[[row, *joint]]);
            application.apply(&columns, &mut cells);
            (0..joints).for_each(|joint| coordinates[[row, joint]] = cells[joint]);
            read.iter().enumerate().for_each(|(place, joint)| torques[[row, *joint]] = cells[joints + place]);
        }
        Ok((coordinates, torques))
    }
}
