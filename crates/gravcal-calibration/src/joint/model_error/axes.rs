//! Directions of the joints' axes, which the robot's description states: what a joint that is tilted does to the readings.
//!
//! A joint that is tilted about an axis perpendicular to its own takes along all that hangs on it, and no parameter of a sensor says so. About its own axis it
//! is an offset of its position sensor. At rest, joints that sit aside, bend or are deflected, and sensors whose reading is no line over the torque, are left out of
//! what it does: these are small beside it. In motion the whole problem is posed again (`changed_chain.rs`).

use gravcal_dynamics::Chain;
use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{ReadingId, Session};
use nalgebra::Vector3;

use crate::joint::model_error::bending::carried_by_joints;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// Step of a tilt, rad: torques are nearly linear in it.
const STEP: f64 = 1e-5;

/// A joint of a chain.
#[derive(Clone, Debug)]
pub(crate) struct JointTilt {
    /// The link that it moves.
    pub link: usize,
    /// What a radian does to the whitened residuals of the problem that is judged, about two axes perpendicular to the joint's own.
    pub columns: Vec<Vec<f64>>,
}

impl Solved {
    /// Those of all joints. None where moments are described by sweep, and where instruments turn with joints.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated beside the solution.
    pub(crate) fn joint_tilts(&self, session: &Session) -> Result<Vec<JointTilt>, EvaluateError> {
        if self.built.variables.inertia.is_empty() || !session.instruments.is_empty() {
            return Ok(Vec::new());
        }
        if session.has_windows() {
            return self.joint_tilts_in_motion(session);
        }
        let (chain, state) = (&session.robot.chain, self.state(&State::nominal(session)));
        let torques = |chain: &Chain| {
            let carried = |pose: usize| carried_by_joints(session, chain, &state, pose);
            (0..session.poses.len()).map(carried).collect::<Vec<Vec<f64>>>()
        };
        let straight = torques(chain);
        let about = |link: usize, axis: Vector3<f64>| {
            let tilted = torques(&chain.with_joint_turned(link, (STEP * axis).into()));
            self.readings_changed(session, &straight, &tilted)
        };
        let of = |link: usize| JointTilt { link, columns: across(chain, link).map(|axis| about(link, axis)).into() };
        Ok(in_parallel(0..chain.link_count(), of))
    }

    fn joint_tilts_in_motion(&self, session: &Session) -> Result<Vec<JointTilt>, EvaluateError> {
        let chain = &session.robot.chain;
        let of = |link: usize| {
            let [first, second] = across(chain, link);
            let about = |axis: Vector3<f64>| move |turn: f64| chain.with_joint_turned(link, (turn * axis).into());
            let columns = self.by_changes_of_chain(session, [&about(first), &about(second)])?;
            Ok(JointTilt { link, columns })
        };
        in_parallel(0..chain.link_count(), of).into_iter().collect()
    }

    /// What another torque of a step does to the whitened residuals, by radian.
    fn readings_changed(&self, session: &Session, straight: &[Vec<f64>], tilted: &[Vec<f64>]) -> Vec<f64> {
        let mut column = vec![0.0; self.judged_problem().rows()];
        for (id, entry) in self.built.rows.iter().zip(&mut column) {
            let ReadingId { pose, channel } = *id;
            let gain = self.built.variables.sensors[channel][SensorParameter::TorqueGain as usize];
            let gain = self.estimate.values.scalar(gain);
            *entry =
                gain * (tilted[pose][channel] - straight[pose][channel]) / STEP / self.readings().std(session, *id);
        }
        column
    }
}

/// Two axes perpendicular to that of the joint which moves a link, in its frame.
fn across(chain: &Chain, link: usize) -> [Vector3<f64>; 2] {
    let own = Vector3::from(chain.movers()[link].axis);
    let across = own.cross(&Vector3::ith(own.iamin(), 1.0)).normalize();
    [across, own.cross(&across)]
}
