//! Angles of standstills whose sensor begins anew after a full turn.
//!
//! A position gain acts on the whole angle, so that 359° and −1° of one joint are two coordinates unless the gain is one. The poses of a session
//! show where the joint never is: in the largest arc between two neighbouring angles. The turn begins in the middle of that arc, so that the poses are
//! together, and nearest to zero. This needs no rows between the poses, and is the same for all recordings of a session.

use std::f64::consts::TAU;

use gravcal_recording::{PoseMapping, PositionUnit, within_turn};
use gravcal_robot_model::session::{Pose, Searched};

/// Width of the arc without poses, rad, at least: a joint whose poses leave less of the turn free may go round.
const LEAST_ARC: f64 = 0.5;
/// Readings that span more than a turn do not wrap, rad.
const MORE_THAN_A_TURN: f64 = 1.01 * TAU;

/// Takes the angles of joints that wrap in any of these recordings within the turn that the joint visits, and says so. By joint, where that turn begins; empty
/// where none wraps.
pub(super) fn within_one_turn(
    poses: &mut [Pose],
    mapping: &PoseMapping,
    searched: &mut [Searched],
) -> Vec<Option<f64>> {
    let mut turns = vec![None; mapping.positions.len()];
    for (joint, column) in mapping.positions.iter().enumerate() {
        let wraps = |searched: &Searched| searched.standstills.as_ref().map_or(0, |found| found.wraps[joint]);
        let is_angle = matches!(column.unit, PositionUnit::Radian | PositionUnit::Degree);
        let Some(first) = searched.iter_mut().find(|searched| wraps(searched) > 0).filter(|_| is_angle) else {
            continue;
        };
        let angles: Vec<f64> = poses.iter().map(|pose| pose.position[joint]).collect();
        turns[joint] = cut(&angles);
        first.remarks.push(match turns[joint] {
            Some(cut) => {
                poses.iter_mut().for_each(|pose| pose.position[joint] = within_turn(pose.position[joint], cut));
                format!("`{}` wraps: its poses are taken within the one turn about zero that the joint visits.", column.column)
            }
            None => format!(
                "`{}` wraps, and its poses are all over the turn or span more than one: those before and after may be a turn apart. Add the \
                 turns, or record an angle that goes on.",
                column.column
            ),
        });
    }
    if turns.iter().all(Option::is_none) { Vec::new() } else { turns }
}

/// Where a turn begins in which the joint visits one arc, nearest to zero; nothing where no arc is free.
fn cut(angles: &[f64]) -> Option<f64> {
    let [lowest, highest] = [angles.iter().copied().reduce(f64::min)?, angles.iter().copied().reduce(f64::max)?];
    let mut within: Vec<f64> = angles.iter().map(|angle| angle.rem_euclid(TAU)).collect();
    within.sort_by(f64::total_cmp);
    let next = within.iter().skip(1).copied().chain([within[0] + TAU]);
    let (arc, from) =
        within.iter().zip(next).map(|(from, to)| (to - from, *from)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let begin = from + 0.5 * arc;
    let middle = begin + 0.5 * TAU;
    (arc >= LEAST_ARC && highest - lowest <= MORE_THAN_A_TURN).then(|| begin - TAU * (middle / TAU).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mapped(degrees: &[f64]) -> Option<Vec<f64>> {
        let angles: Vec<f64> = degrees.iter().map(|angle| angle.to_radians()).collect();
        let cut = cut(&angles)?;
        Some(angles.iter().map(|angle| within_turn(*angle, cut).to_degrees().round()).collect())
    }

    #[test]
    fn poses_are_within_the_turn_that_the_joint_visits_about_zero() {
        assert_eq!(mapped(&[350.0, 10.0, 300.0, 90.0]).unwrap(), [-10.0, 10.0, -60.0, 90.0]);
        // One that works about 180° and is read from −180° to 180°.
        let about = mapped(&[170.0, -170.0, 100.0, -120.0]).unwrap();
        let expected = [[170.0, 190.0, 100.0, 240.0], [-190.0, -170.0, -260.0, -120.0]];
        assert!(expected.iter().any(|expected| about == expected), "{about:?}");
        assert_eq!(mapped(&[5.0]).unwrap(), [5.0]);
    }

    #[test]
    fn nothing_is_cut_where_no_arc_is_free_or_the_joint_turns_more_than_once() {
        let all_over: Vec<f64> = (0..36).map(|step| 10.0 * f64::from(step)).collect();
        assert_eq!(mapped(&all_over), None);
        assert_eq!(mapped(&[-350.0, 0.0, 350.0]), None);
        assert_eq!(mapped(&[]), None);
    }
}
