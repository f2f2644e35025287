//! Mountings of instruments, which the session states: what one that is turned otherwise would read.

use gravcal_dynamics::Transform;
use gravcal_estimation::EvaluateError;
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::{AuxiliarySensorKind, Session};

use crate::joint::building::displacements::{STEP, predictions};
use crate::joint::solved::Solved;
use crate::joint::variables::State;

impl Solved {
    /// What a radian about each axis of each instrument's frame does to the whitened residuals of the problem that is judged. None of an accelerometer whose mounting
    /// is known to within a standard deviation.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated at the solution.
    pub(crate) fn turned_instruments(&self, session: &Session) -> Result<Vec<Vec<f64>>, EvaluateError> {
        let exact = |place: &usize| {
            let instrument = &session.instruments[*place];
            let mut own = instrument.own_parameters().map(ParameterId::Further);
            instrument.kind == AuxiliarySensorKind::ForceTorque || own.all(|id| session.fixed(id).is_some())
        };
        let places: Vec<usize> = (0..session.instruments.len()).filter(exact).collect();
        if places.is_empty() {
            return Ok(Vec::new());
        }
        let state = self.state(&State::nominal(session));
        let read = |session: &Session| predictions(session, self.readings(), &state, &session.robot.chain);
        let described = read(session)?;
        let turned = |(place, axis): (usize, usize)| {
            let mut other = session.clone();
            let mounting = &mut other.instruments[place].mounting;
            let turn =
                Transform::from_xyz_rpy([0.0; 3], std::array::from_fn(|own| if own == axis { STEP } else { 0.0 }));
            *mounting = mounting.compose(&turn);
            let there = read(&other)?;
            let column =
                self.whitened(session, |id| (there[id.pose][id.channel] - described[id.pose][id.channel]) / STEP);
            Ok(column)
        };
        places.into_iter().flat_map(|place| (0..3).map(move |axis| (place, axis))).map(turned).collect()
    }
}
