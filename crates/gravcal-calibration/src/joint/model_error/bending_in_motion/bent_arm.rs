//! An arm that moved, beyond joints that bend: what would be read of its links.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::session::Session;

use crate::joint::building::displacements::predictions;
use crate::joint::measurement_set::{Effect, MeasurementSet};
use crate::joint::model_error::bending_in_motion::carried::Carried;
use crate::joint::model_error::bending_in_motion::moments::Moments;
use crate::joint::variables::State;

/// How far joints bend as the state has it, rad/(N·m).
pub(super) fn compliances(state: &State, joints: usize) -> Vec<f64> {
    (0..joints).map(|joint| state.bending.get(joint).copied().unwrap_or(0.0)).collect()
}

/// One effect less another, times a factor.
pub(super) fn difference(one: &Effect, other: &Effect, times: f64) -> Effect {
    let of_pose = |(one, other): (&Vec<f64>, &Vec<f64>)| {
        one.iter().zip(other).map(|(one, other)| times * (one - other)).collect()
    };
    one.iter().zip(other).map(of_pose).collect()
}

/// An arm that moved, with what its joints carry and what its readings would be if they bent.
pub(super) struct BentArm<'a> {
    /// Without what recordings were searched for: that is large, and no prediction reads it.
    pub session: Session,
    readings: &'a MeasurementSet,
    state: &'a State,
    /// The same without rotor inertias: rotors move as their sensors read, whatever bends behind them.
    of_links: State,
    pub moments: Moments,
}

impl<'a> BentArm<'a> {
    /// Nothing where there are no windows.
    pub fn of(session: &Session, readings: &'a MeasurementSet, state: &'a State) -> Option<Self> {
        session.poses.iter().any(|pose| pose.course.is_some()).then(|| {
            let mut of_links = state.clone();
            session.rotors.iter().flatten().for_each(|place| of_links.further[*place] = 0.0);
            let session = Session { searched: Vec::new(), validation: Vec::new(), ..session.clone() };
            BentArm { moments: Moments::of(&session), session, readings, state, of_links }
        })
    }

    /// Readings of links whose joints bend by these compliances under what they carry.
    pub fn predictions(&self, compliances: &[f64], carried: &Carried) -> Result<Effect, EvaluateError> {
        let beyond = self.moments.session_read_beyond(&self.session, self.state, compliances, carried);
        predictions(&beyond, self.readings, &self.of_links, &self.session.robot.chain)
    }
}
