//! Static friction of joints that stand while another sweeps.
//!
//! ```text
//!     y_i = k τ_i + b + a_i c + u_s        a_i: 1 where the joint had come to its place from below, −1 from above, 0 where nobody knows
//! ```
//!
//! A joint that stands holds friction of any size up to that `f` of its own sweeps, and the same all through a sweep `s` of another, whose both ways
//! do not cancel it. On the average some of it is left to the side from which the joint came: `c`, one of each joint. The rest, `u`, is one
//! unknown of each joint and sweep. Leaving these readings out would lose what only they tell, as gravity where every joint sweeps once.

use std::collections::BTreeMap;
use std::sync::Arc;

use gravcal_estimation::{Block, ProblemBuilder, Residual, Values};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{Shift, Shifted};
use gravcal_robot_model::session::Session;

use crate::joint::variables::{OfJoints, State, VariableIndex};

/// Standard deviation of what is left on the average, as a share of friction: about that of simulated joints with pre-sliding, which leave 0.42.
const TO_SIDE: f64 = 0.5;

/// What static friction adds, unit of the torque reading.
#[derive(Clone, Debug)]
pub struct StaticFriction {
    /// To the side from which a joint came.
    pub to_side: OfJoints,
    /// By sweep in which joints with friction stand, its poses and what is left there beside that.
    pub sweeps: Vec<(Vec<usize>, OfJoints)>,
    /// By pose, the place of its sweep.
    of_pose: BTreeMap<usize, usize>,
}

/// Adds the unknowns of joints with friction, from where `start` has them; nothing where none has any.
pub(in crate::joint) fn add_unknown(
    session: &Session,
    start: &State,
    builder: &mut ProblemBuilder,
) -> Option<StaticFriction> {
    let friction = &session.static_friction;
    if friction.iter().all(|friction| *friction == 0.0) {
        return None;
    }
    let start = |place: usize| start.static_friction.get(place).map_or(&[][..], Vec::as_slice);
    let block = |name: String| {
        move |joints: &[usize]| {
            let chain = session.robot.chain.joints();
            let names: Vec<&str> = joints.iter().map(|joint| chain[*joint].name.as_str()).collect();
            let mut block = Block::vector(name, "", &names).linear();
            block.units = joints.iter().map(|joint| session.channel_unit(*joint)).collect();
            block
        }
    };
    let std: Vec<f64> = friction.iter().map(|friction| TO_SIDE * friction).collect();
    let to_side = OfJoints::add(block("static_friction".to_owned()), &std, start(0), builder)?;
    let mut sweeps = Vec::new();
    for (swept, poses) in recorded_sweeps(session) {
        // Anything up to friction, either way: uniform.
        let std = |(joint, friction): (usize, &f64)| if joint == swept { 0.0 } else { friction / f64::sqrt(3.0) };
        let std: Vec<f64> = friction.iter().enumerate().map(std).collect();
        let pose = &session.poses[poses[0]];
        let name = format!("static_friction[{}:{}]", session.tables[pose.table].path.display(), pose.line);
        let unknown = OfJoints::add(block(name), &std, start(1 + sweeps.len()), builder);
        sweeps.extend(unknown.map(|unknown| (poses, unknown)));
    }
    let of_sweep = |(place, (poses, _)): (usize, &(Vec<usize>, OfJoints))| {
        poses.iter().map(move |pose| (*pose, place)).collect::<Vec<_>>()
    };
    let of_pose = sweeps.iter().enumerate().flat_map(of_sweep).collect();
    Some(StaticFriction { to_side, sweeps, of_pose })
}

/// The joint that sweeps, and the poses, of each recorded sweep.
fn recorded_sweeps(session: &Session) -> Vec<(usize, Vec<usize>)> {
    let mut sweeps: Vec<(usize, Vec<usize>)> = Vec::new();
    for (index, pose) in session.poses.iter().enumerate() {
        let Some(swept) = session.swept_in_recording(pose) else { continue };
        let alike = |other: usize| {
            let other = &session.poses[other];
            other.table == pose.table && other.sweep_label == pose.sweep_label
        };
        match sweeps.last_mut().filter(|(_, poses)| alike(poses[0])) {
            Some((_, poses)) => poses.push(index),
            None => sweeps.push((swept, vec![index])),
        }
    }
    sweeps
}

impl StaticFriction {
    /// The values of one solution: by joint to the side, then of each sweep.
    pub(in crate::joint) fn values(&self, values: &Values, joints: usize) -> Vec<Vec<f64>> {
        let all = std::iter::once(&self.to_side).chain(self.sweeps.iter().map(|(_, unknown)| unknown));
        all.map(|unknown| unknown.by_joint(values, joints)).collect()
    }

    /// The residual of a pose with the unknowns around it; itself in a pose of no recorded sweep.
    pub(in crate::joint) fn around(
        &self,
        (session, variables, stored): (&Session, &VariableIndex, &Values),
        pose: usize,
        inner: Arc<dyn Residual>,
    ) -> Arc<dyn Residual> {
        let Some(place) = self.of_pose.get(&pose) else { return inner };
        let (_, of_sweep) = &self.sweeps[*place];
        let bias = |joint: usize| variables.sensors[joint][SensorParameter::TorqueBias as usize];
        let around = |inner, unknown: &OfJoints, scale: &dyn Fn(usize) -> f64| {
            let shifts: Vec<Shift> =
                unknown.joints.iter().map(|joint| Shift::of_scalar(bias(*joint), scale(*joint))).collect();
            Arc::new(Shifted::new(inner, |id| stored.get(id).len(), &shifts, unknown.block)) as Arc<dyn Residual>
        };
        let side = |joint: usize| match of_sweep.place(joint) {
            Some(_) => session.poses[pose]
                .conditions
                .direction
                .get(joint)
                .map_or(0.0, |side| if *side == 0.0 { 0.0 } else { side.signum() }),
            None => 0.0,
        };
        around(around(inner, of_sweep, &|_| 1.0), &self.to_side, &side)
    }
}
