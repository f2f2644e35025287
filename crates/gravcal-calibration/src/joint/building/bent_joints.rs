//! Joints that may bend, as an unknown of the problem: `model_error/bending.rs` says when, and by how much.

use std::sync::Arc;

use gravcal_estimation::{Block, ProblemBuilder, Residual, Values};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{Displaced, Shift, Shifted};
use gravcal_robot_model::session::Session;

use crate::joint::measurement_set::{Bending, Effect, MeasurementSet};
use crate::joint::variables::{OfJoints, State, VariableIndex};

/// Adds the unknown of the joints that may bend, from where `start` has it.
pub(in crate::joint) fn add_unknown(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> Option<OfJoints> {
    let block = |joints: &[usize]| {
        let chain = session.robot.chain.joints();
        let names: Vec<&str> = joints.iter().map(|joint| chain[*joint].name.as_str()).collect();
        Block::vector("bending", "rad/(N·m)", &names)
    };
    OfJoints::add(block, &readings.bending.as_ref()?.std, &start.bending, builder)
}

impl Bending {
    /// The residual of these readings of a pose with the unknown around it.
    pub(in crate::joint) fn around(
        &self,
        (session, variables, stored): (&Session, &VariableIndex, &Values),
        unknown: &OfJoints,
        (pose, used): (usize, &[usize]),
        inner: Arc<dyn Residual>,
    ) -> Arc<dyn Residual> {
        if session.poses[pose].course.is_some() {
            let column = |joint: &Effect| used.iter().map(|channel| joint[pose][*channel]).collect();
            let columns: Vec<Vec<f64>> = self.in_motion.iter().map(column).collect();
            return Arc::new(Displaced::new(inner, &columns, |id| stored.get(id).len(), &[unknown.block]));
        }
        let offset = |joint: usize| variables.sensors[joint][SensorParameter::PositionOffset as usize];
        let shifted: Vec<Shift> =
            unknown.joints.iter().map(|joint| Shift::of_scalar(offset(*joint), self.torques[pose][*joint])).collect();
        Arc::new(Shifted::new(inner, |id| stored.get(id).len(), &shifted, unknown.block))
    }
}
