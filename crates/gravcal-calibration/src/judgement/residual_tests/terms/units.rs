//! Units of sizes.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::session::Session;

/// The unit of a joint's reading for each unit of the torque (or force, of one that slides) of another, and of what comes with that.
pub fn per_torque(session: &Session, joint: usize, other: usize, and: &str) -> String {
    let unit = session.channel_unit(joint);
    match session.robot.chain.joints()[other].kind {
        JointKind::Prismatic if and.is_empty() => format!("{unit}/N"),
        JointKind::Prismatic => format!("{unit}/(N{and})"),
        _ => format!("{unit}/(N·m{and})"),
    }
}

/// The unit of a joint's reading for each unit of the speed or acceleration of another; `time`: by what its coordinate's is divided.
pub fn per_motion(session: &Session, (joint, other): (usize, usize), time: &str) -> String {
    format!("{}/({}/{time})", session.channel_unit(joint), of_coordinate(session, other))
}

/// The unit of a joint's coordinate.
pub fn of_coordinate(session: &Session, joint: usize) -> &'static str {
    if session.robot.chain.joints()[joint].kind == JointKind::Prismatic { "m" } else { "rad" }
}
