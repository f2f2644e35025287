//! Joints that are not where their position sensors say, as further unknowns.
//!
//! ```text
//!     θ_j = s_j q_j + o_j + δ_j,     δ_j = 0 ± σ
//! ```
//!
//! - **By hold**: joints that stand while another sweeps have one δ each in all poses of the sweep (a pose of no sweep is a
//!   hold of its own, of all joints): deflection that the sensor does not see. So has in a recorded sweep what a coarse sensor's rounding
//!   leaves, without being asked for: uniform within the step `q`, of standard deviation `q/√12`.
//! - **By pose**: every pose has its own δ, of the joints that stand, or, where the position readings are noisy, of all
//!   joints (errors in variables).
//!
//! Each has its prior, without which most of them are no use (section 4 of the estimation model). Those of single poses are
//! eliminated.

use std::collections::BTreeMap;
use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_estimation::{Block, Factor, Noise, NoiseError, ProblemBuilder, Residual, Values};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{Prior, Shift, Shifted};
use gravcal_robot_model::session::{Deflection, Session};
use gravcal_robot_model::sweeps::{Sweep, find_sweeps, sweeping};

use crate::joint::measurement_set::MeasurementSet;
use crate::joint::variables::{PositionUnknown, State, VariableIndex};

/// Adds the unknowns that the session has: those of sweeps first, from where `start` has them, and all others from zero.
pub(in crate::joint) fn add_unknowns(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> Vec<PositionUnknown> {
    let deflection = &session.deflection;
    let Deflection { hold_std, pose_std, reading_std, .. } = deflection;
    if !deflection.holds() && pose_std.is_none() && reading_std.iter().all(|std| *std == 0.0) {
        return Vec::new();
    }
    let mut adding = Adding { session, builder, unknowns: Vec::new() };
    let sweeps = if deflection.holds() { find_sweeps(session) } else { Vec::new() };
    for sweep in &sweeps {
        // A sweep in which no joint can be elsewhere has no unknown, and no start.
        adding.hold(sweep.poses.clone(), Some(sweep), start.deflections.get(adding.unknowns.len()));
    }
    let sweeping = sweeping(session);
    let used = (0..session.poses.len()).filter(|pose| !readings.used[*pose].is_empty());
    for pose in used {
        if hold_std.is_some() && sweeping[pose].is_none() {
            adding.hold(vec![pose], None, None);
        }
        adding.single_pose(pose, sweeping[pose]);
    }
    adding.unknowns
}

struct Adding<'a> {
    session: &'a Session,
    builder: &'a mut ProblemBuilder,
    unknowns: Vec<PositionUnknown>,
}

impl Adding<'_> {
    fn hold(&mut self, poses: Vec<usize>, sweep: Option<&Sweep>, start: Option<&Vec<f64>>) {
        let deflection = &self.session.deflection;
        let std = |joint: usize| match sweep {
            Some(sweep) if sweep.swept == joint => 0.0,
            Some(_) => deflection.sweep_std(joint),
            None => deflection.hold_std.unwrap_or(0.0),
        };
        let joints = self.joints(|joint| if self.turns(joint) { std(joint) } else { 0.0 });
        self.add("deflection", poses, joints, start, sweep.is_some());
    }

    fn single_pose(&mut self, pose: usize, sweeping: Option<usize>) {
        let deflection = &self.session.deflection;
        let joints = self.joints(|joint| {
            let stands = sweeping != Some(joint) && self.turns(joint);
            let gain = self.session.joints[joint].of(SensorParameter::PositionGain).nominal;
            let standing = deflection.pose_std.filter(|_| stands).unwrap_or(0.0);
            standing.hypot(gain * deflection.reading_std.get(joint).copied().unwrap_or(0.0))
        });
        self.add("position_error", vec![pose], joints, None, false);
    }

    fn turns(&self, joint: usize) -> bool {
        self.session.robot.chain.joints()[joint].kind == JointKind::Revolute
    }

    /// Joints whose standard deviation is not zero, with it.
    fn joints(&self, std: impl Fn(usize) -> f64) -> Vec<(usize, f64)> {
        (0..self.session.joints.len()).map(|joint| (joint, std(joint))).filter(|(_, std)| *std > 0.0).collect()
    }

    fn add(
        &mut self,
        what: &str,
        poses: Vec<usize>,
        joints: Vec<(usize, f64)>,
        start: Option<&Vec<f64>>,
        shared: bool,
    ) {
        if joints.is_empty() {
            return;
        }
        let chain = self.session.robot.chain.joints();
        let (joints, std): (Vec<usize>, Vec<f64>) = joints.into_iter().unzip();
        let names: Vec<&str> = joints.iter().map(|joint| chain[*joint].name.as_str()).collect();
        let mut block = Block::vector(format!("{what}[{}]", self.place(&poses)), "rad", &names);
        for (unit, joint) in block.units.iter_mut().zip(&joints) {
            if chain[*joint].kind == JointKind::Prismatic {
                *unit = "m".into();
            }
        }
        let block = if shared { block } else { block.eliminated() };
        let block = self.builder.add_block(block, start.unwrap_or(&vec![0.0; joints.len()]));
        self.unknowns.push(PositionUnknown { block, joints, std, poses, is_hold: what == "deflection" });
    }

    /// Table and lines of some poses: `sweep-3.csv:2-38`.
    fn place(&self, poses: &[usize]) -> String {
        let [first, last] = [poses[0], poses[poses.len() - 1]].map(|pose| &self.session.poses[pose]);
        let lines = if poses.len() == 1 { first.line.to_string() } else { format!("{}-{}", first.line, last.line) };
        format!("{}:{lines}", self.session.tables[first.table].path.display())
    }
}

/// Puts the unknowns of each pose around its residual.
pub(in crate::joint) struct Around<'a> {
    variables: &'a VariableIndex,
    /// By pose, the places of its unknowns.
    of_pose: BTreeMap<usize, Vec<usize>>,
    /// For the lengths of blocks.
    stored: Values,
}

impl<'a> Around<'a> {
    /// `stored`: any values of all blocks.
    pub fn new(variables: &'a VariableIndex, stored: Values) -> Self {
        let mut of_pose: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, unknown) in variables.position_unknowns.iter().enumerate() {
            unknown.poses.iter().for_each(|pose| of_pose.entry(*pose).or_default().push(index));
        }
        Around { variables, of_pose, stored }
    }

    pub fn residual(&self, pose: usize, inner: Arc<dyn Residual>) -> Arc<dyn Residual> {
        let unknowns = self.of_pose.get(&pose).into_iter().flatten();
        unknowns.fold(inner, |inner, index| {
            let PositionUnknown { block, joints, .. } = &self.variables.position_unknowns[*index];
            let offset = |joint: &usize| {
                Shift::of_scalar(self.variables.sensors[*joint][SensorParameter::PositionOffset as usize], 1.0)
            };
            let offsets: Vec<Shift> = joints.iter().map(offset).collect();
            Arc::new(Shifted::new(inner, |id| self.stored.get(id).len(), &offsets, *block))
        })
    }
}

/// Adds what is known of the unknowns beforehand.
pub(in crate::joint) fn add_priors(variables: &VariableIndex, builder: &mut ProblemBuilder) -> Result<(), NoiseError> {
    for PositionUnknown { block, std, .. } in &variables.position_unknowns {
        let prior = Prior::new(*block, vec![0.0; std.len()]);
        builder.add_factor(Factor::new(prior, Noise::independent(std)?));
    }
    Ok(())
}
