//! What the torque readings say of where joints are, beyond what was known of it.

use gravcal_robot_model::session::Session;

use crate::joint::{PositionUnknown, Solved};
use crate::result::{DeflectionResult, PositionErrorResult};

/// The readings tell an error where they leave at most this share of the standard deviation that it had before: where they
/// alone know it √3 times better than the prior.
const OBSERVABLE: f64 = 0.5;

/// The deflections of each sweep, or of each pose that belongs to none, where the session asks for them.
pub(crate) fn deflections(session: &Session, solved: &Solved) -> Vec<DeflectionResult> {
    let asked = session.deflection.hold_std.is_some();
    let holds = solved.built.variables.position_unknowns.iter().filter(|unknown| unknown.is_hold && asked);
    holds.flat_map(|hold| (0..hold.joints.len()).map(move |index| deflection(session, solved, hold, index))).collect()
}

fn deflection(session: &Session, solved: &Solved, hold: &PositionUnknown, index: usize) -> DeflectionResult {
    let [(table, first), (_, last)] =
        [hold.poses[0], hold.poses[hold.poses.len() - 1]].map(|pose| session.row_of(pose));
    let (value, std) = found(solved, hold, index);
    DeflectionResult {
        table,
        lines: [first, last],
        joint: session.robot.chain.joints()[hold.joints[index]].name.clone(),
        unit: solved.built.problem.block(hold.block).units[index].clone(),
        value: (std <= OBSERVABLE * hold.std[index]).then_some(value),
        std,
        prior_std: hold.std[index],
    }
}

/// Value and standard deviation of one number of an unknown.
fn found(solved: &Solved, unknown: &PositionUnknown, index: usize) -> (f64, f64) {
    let column = solved.built.problem.columns_of(unknown.block).nth(index);
    let std = column.map_or(0.0, |column| solved.covariance().std(column));
    (solved.estimate.values.get(unknown.block)[index], std)
}

/// The errors of single poses, by joint.
pub(crate) fn position_errors(session: &Session, solved: &Solved) -> Vec<PositionErrorResult> {
    let joints = session.robot.chain.joints().iter().enumerate();
    joints.filter_map(|(joint, described)| of_joint(solved, joint, &described.name)).collect()
}

fn of_joint(solved: &Solved, joint: usize, name: &str) -> Option<PositionErrorResult> {
    let single = solved.built.variables.position_unknowns.iter().filter(|unknown| !unknown.is_hold);
    let own: Vec<(&PositionUnknown, usize)> =
        single.filter_map(|unknown| Some((unknown, unknown.joints.iter().position(|j| *j == joint)?))).collect();
    let (first, index) = own.first()?;
    let rms = |square: &dyn Fn(&PositionUnknown, usize) -> f64| {
        (own.iter().map(|(unknown, index)| square(unknown, *index)).sum::<f64>() / own.len() as f64).sqrt()
    };
    let std = rms(&|unknown, index| found(solved, unknown, index).1.powi(2));
    let prior_std = rms(&|unknown, index| unknown.std[index].powi(2));
    Some(PositionErrorResult {
        joint: name.to_owned(),
        unit: solved.built.problem.block(first.block).units[*index].clone(),
        poses: own.len(),
        rms: rms(&|unknown, index| found(solved, unknown, index).0.powi(2)),
        std,
        prior_std,
        observable: std <= OBSERVABLE * prior_std,
    })
}
