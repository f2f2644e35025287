//! What a session states that can hardly be meant: gravity that no place on Earth has, loads that nothing carries, hardly any pose.

use crate::session::Session;

/// Gravity on Earth, m/s², from the highest mountain at the equator to the poles.
const ON_EARTH: [f64; 2] = [9.76, 9.84];
/// Fewer poses than this determine hardly anything.
const FEWEST: usize = 5;

/// A sentence for each.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    gravity(session).into_iter().chain(unused_loads(session)).chain(few_poses(session)).collect()
}

fn gravity(session: &Session) -> Option<String> {
    let (magnitude, [least, most]) = (session.gravity.magnitude, ON_EARTH);
    // Where it is known to some error only, that error may reach.
    let error = 3.0 * session.gravity.magnitude_std.unwrap_or(0.0);
    (magnitude < least - error || magnitude > most + error).then(|| {
        format!(
            "[gravity] magnitude_m_per_s2 is {magnitude}: on Earth it is from {least} to {most} m/s². All torque gains and masses are \
             measured against it."
        )
    })
}

fn unused_loads(session: &Session) -> impl Iterator<Item = String> {
    let carried = |load: usize| session.poses.iter().any(|pose| pose.load == Some(load));
    let unused = session.loads.iter().enumerate().filter(move |(index, _)| !carried(*index));
    unused.map(|(_, load)| format!("No pose carries load `{}`: is a `load =` missing from a [[poses]]?", load.name))
}

fn few_poses(session: &Session) -> Option<String> {
    let poses = session.poses.len();
    let s = if poses == 1 { "" } else { "s" };
    (poses < FEWEST).then(|| {
        format!("There {} only {poses} static pose{s}. Record more: some 30 poses of all joints, without and with a load, are a good start.", if poses == 1 { "is" } else { "are" })
    })
}
