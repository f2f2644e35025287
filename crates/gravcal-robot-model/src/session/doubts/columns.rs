//! Columns of positions and torques of different joints that are read as one's.

use gravcal_recording::{are_same_numbers, column_numbers};

use crate::session::Session;

/// Where each name of a column of positions carries a number of its own, and those of the torques carry the same ones, both columns of
/// a joint carry one.
pub(super) fn doubt(session: &Session) -> Option<String> {
    let joints = session.robot.chain.joints().iter().zip(&session.readings.positions).zip(&session.readings.torques);
    let read: Vec<(&str, &str, &str)> = joints
        .filter_map(|((joint, position), torque)| {
            let (torque, _) = torque.as_ref()?;
            Some((joint.name.as_str(), position.column.as_str(), torque.column.as_str()))
        })
        .collect();
    let positions = column_numbers(read.iter().map(|(_, position, _)| *position))?;
    let torques = column_numbers(read.iter().map(|(.., torque)| *torque))?;
    if positions == torques || !are_same_numbers(&positions, &torques) {
        return None;
    }
    let odd = read.iter().zip(positions.iter().zip(&torques)).filter(|(_, (position, torque))| position != torque);
    let odd: Vec<String> =
        odd.map(|((joint, position, torque), _)| format!("{joint} reads `{position}` and `{torque}`")).collect();
    Some(format!(
        "Positions and torques of other numbers are taken as one joint's: {}. If numbers count joints, bring the columns of [readings] \
         position and torque into one order: that of the robot's joints.",
        odd.join(", ")
    ))
}
