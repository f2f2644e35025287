//! Columns that are read as another joint's than their names say, and columns of two joints that are read as one's.

use gravcal_recording::{are_same_numbers, column_numbers, named_joint};

use crate::session::Session;

/// One sentence or two for each mistake.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    other_names(session).into_iter().chain(other_numbers(session)).collect()
}

/// The joints with the columns that are read as theirs: the position's, then the torque's, where there is one.
fn columns(session: &Session) -> impl Iterator<Item = (&str, [Option<&str>; 2])> {
    let joints = session.robot.chain.joints().iter().zip(&session.readings.positions).zip(&session.readings.torques);
    joints.map(|((joint, position), torque)| {
        let torque = torque.as_ref().map(|(torque, _)| torque.column.as_str());
        (joint.name.as_str(), [Some(position.column.as_str()), torque])
    })
}

/// Columns that bear the name of another joint of the robot.
fn other_names(session: &Session) -> Option<String> {
    let names: Vec<&str> = session.robot.chain.joints().iter().map(|joint| joint.name.as_str()).collect();
    let odd: Vec<String> = columns(session)
        .enumerate()
        .flat_map(|(place, (joint, columns))| {
            let named = columns.into_iter().flatten().filter_map(|column| Some((column, named_joint(column, &names)?)));
            let odd = named.filter(|(_, named)| *named != place).collect::<Vec<_>>();
            let report = |(column, named): &(&str, usize)| {
                format!("`{column}` bears the name of {} and is taken as {joint}'s", names[*named])
            };
            match odd[..] {
                [(position, named), (torque, of_torque)] if named == of_torque => vec![format!(
                    "`{position}` and `{torque}` bear the name of {} and are taken as {joint}'s",
                    names[named]
                )],
                _ => odd.iter().map(report).collect(),
            }
        })
        .collect();
    (!odd.is_empty() && !count_from_elsewhere(session, &names)).then(|| {
        format!(
            "Columns bear the names of other joints than they are taken for: {}. Bring the columns of [readings] position and torque into \
             the order of the robot's joints: {}.",
            odd.join("; "),
            names.join(", ")
        )
    })
}

/// Whether the numbers in the columns' names are those of the joints' names but for where they begin: from 0 and from 1.
fn count_from_elsewhere(session: &Session, names: &[&str]) -> bool {
    let shifted = |of_joints: &[u64]| {
        let numbers = column_numbers(columns(session).filter_map(|(_, [position, _])| position))?;
        let mut by = of_joints.iter().zip(&numbers).map(|(joint, number)| i128::from(*joint) - i128::from(*number));
        let first = by.next()?;
        Some(first != 0 && by.all(|by| by == first))
    };
    column_numbers(names.iter().copied()).and_then(|numbers| shifted(&numbers)).unwrap_or(false)
}

/// Where each name of a column of positions carries a number of its own, and those of the torques carry the same ones, both columns of
/// a joint carry one.
fn other_numbers(session: &Session) -> Option<String> {
    let read: Vec<(&str, &str, &str)> =
        columns(session).filter_map(|(joint, [position, torque])| Some((joint, position?, torque?))).collect();
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
