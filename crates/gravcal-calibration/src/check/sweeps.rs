//! Which sweeps a session has, and what the sequential procedure will do with them.

use gravcal_recording::file_name;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use gravcal_robot_model::sweeps::{HOLD_TOLERANCE, SWEEP_POSES, SWEEP_RANGE};

use super::report::{StepReport, SweepReport};
use crate::plan::{LoadPair, Plan};

pub(super) fn sweep_rule() -> String {
    format!(
        "consecutive poses of one table in which one joint moves by {:.0}° or more and no other by more than {:.0}°, \
         {} poses at least",
        SWEEP_RANGE.to_degrees(),
        HOLD_TOLERANCE.to_degrees(),
        SWEEP_POSES
    )
}

pub(super) fn report_sweep(session: &Session, plan: &Plan, index: usize) -> SweepReport {
    let sweep = &plan.sweeps[index];
    let (first, last) = (sweep.poses[0], sweep.poses[sweep.poses.len() - 1]);
    let gain = session.joints[sweep.swept].of(SensorParameter::PositionGain).nominal;
    let coordinate = |pose: usize| (gain * session.poses[pose].position[sweep.swept]).to_degrees();
    let mut steps = Vec::new();
    if plan.bias.get(sweep.swept).is_some_and(|bias| bias.contains(&index)) {
        steps.push(1);
    }
    if plan.gravity.contains(&index) {
        steps.push(2);
    }
    if plan.gain.iter().flatten().any(|pair| pair.sweeps.contains(&index)) {
        steps.push(3);
    }
    SweepReport {
        table: file_name(&session.tables[sweep.table].path),
        lines: [session.poses[first].line, session.poses[last].line],
        joint: session.robot.chain.joints()[sweep.swept].name.clone(),
        poses: sweep.poses.len(),
        range_deg: [coordinate(first), coordinate(last)],
        load: sweep.load.map(|load| session.loads[load].name.clone()),
        steps,
    }
}

/// What each step reads; nothing of a robot that is no serial chain.
pub(super) fn report_steps(session: &Session, plan: &Plan) -> Vec<StepReport> {
    if !session.robot.chain.is_serial() {
        return Vec::new();
    }
    let names: Vec<&str> = session.robot.chain.joints().iter().map(|j| j.name.as_str()).collect();
    let mut steps = Vec::new();
    for (joint, sweeps) in plan.bias.iter().enumerate() {
        steps.push(StepReport {
            step: 1,
            finds: format!("{0}.torque_bias, {0}.position_gain", names[joint]),
            sweeps: sweeps.len(),
            problem: sweeps.is_empty().then(|| format!("no sweep of {}", names[joint])),
        });
    }
    if let [first, second, ..] = names[..] {
        let few = format!("needs sweeps of {second} at two positions of {first} at least");
        let problem = (plan.gravity.len() < 2).then_some(few);
        steps.push(StepReport { step: 2, finds: "gravity".into(), sweeps: plan.gravity.len(), problem });
    }
    for (joint, pairs) in plan.gain.iter().enumerate() {
        let name = names[joint];
        let needed = if joint == 0 { 1 } else { 2 };
        let alike = |of: &LoadPair| {
            pairs.iter().filter(|pair| (pair.distance, pair.posture) == (of.distance, of.posture)).count()
        };
        let most = pairs.iter().map(alike).max().unwrap_or(0);
        let problem = match names.get(joint + 1) {
            None => Some(format!("{name} is the last joint, which no step reaches")),
            Some(next) if most < needed => Some(format!(
                "needs sweeps of {next} with the load at two placements, at {needed} position(s) of {name} with the joints beyond \
                 {next} standing alike"
            )),
            Some(_) => None,
        };
        steps.push(StepReport {
            step: 3,
            finds: if joint == 0 {
                format!("{name}.torque_gain")
            } else {
                format!("{name}.torque_gain, {name}.position_offset")
            },
            sweeps: 2 * pairs.len(),
            problem,
        });
    }
    steps
}
