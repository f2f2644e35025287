//! From which side each joint came, as the order of poses tells it.
//!
//! Where no table says so, and poses are rows of tables that were read one after the other, the joint came from where it was in the row before. That may
//! be wrong, as rows may stand in another order than they were read in: then nothing goes with it.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

/// A joint whose coordinate moves by less, rad or m, may not have slid through: back, it may have its friction to either side.
const MOVED: f64 = 0.01;
/// It stands where it moves by less.
const STANDS: f64 = 1e-4;
/// Both in standard deviations of a position reading: five of the difference of two. The side to which noise moves a reading goes with its error.
const BEYOND_NOISE: f64 = 7.0;

/// By pose and joint: 1 where the coordinate rose, −1 where it fell, 0 where it is not known. Empty where the session says it itself, or where an arm was
/// followed while it moved.
pub fn moved_to(session: &Session) -> Vec<Vec<f64>> {
    let told = session.poses.iter().any(|pose| pose.conditions.direction.iter().any(|side| *side != 0.0));
    if told || !session.searched.is_empty() || session.has_windows() {
        return Vec::new();
    }
    let joints = session.joints.len();
    let gains: Vec<f64> = session.joints.iter().map(|joint| joint.of(SensorParameter::PositionGain).nominal).collect();
    let noise = |joint: usize| {
        session.deflection.reading_std.get(joint).map_or(0.0, |std| BEYOND_NOISE * std * gains[joint].abs())
    };
    let noise: Vec<f64> = (0..joints).map(noise).collect();
    let mut sides: Vec<Vec<f64>> = Vec::with_capacity(session.poses.len());
    for (place, pose) in session.poses.iter().enumerate() {
        let before = place.checked_sub(1).map(|before| (&session.poses[before], &sides[before]));
        let of_joint = |joint: usize| match before {
            Some((before, side)) if before.table == pose.table => {
                let moved = gains[joint] * (pose.position[joint] - before.position[joint]);
                side_after(moved, noise[joint], side[joint])
            }
            _ => 0.0,
        };
        let own = (0..joints).map(of_joint).collect();
        sides.push(own);
    }
    sides
}

/// The same without joints that always came from one side: of these the order tells nothing.
pub fn sides_by_order(session: &Session) -> Vec<Vec<f64>> {
    let sides = moved_to(session);
    let from = |joint: usize, side: f64| sides.iter().any(|pose| pose[joint] == side);
    let joints = 0..session.joints.len();
    let both: Vec<bool> = joints.map(|joint| from(joint, 1.0) && from(joint, -1.0)).collect();
    let told =
        |pose: Vec<f64>| pose.into_iter().zip(&both).map(|(side, both)| if *both { side } else { 0.0 }).collect();
    sides.into_iter().map(told).collect()
}

/// The same for what friction leaves at rest: of joints of which the order tells nothing it is the same in all poses, as from below.
pub fn sides_at_rest(session: &Session) -> Vec<Vec<f64>> {
    let mut sides = sides_by_order(session);
    for joint in 0..session.joints.len() {
        if sides.iter().all(|pose| pose[joint] == 0.0) {
            sides.iter_mut().for_each(|pose| pose[joint] = 1.0);
        }
    }
    sides
}

/// Whether a joint stands from one pose to another of the same table.
pub fn stands_still(session: &Session, joint: usize, [one, other]: [usize; 2]) -> bool {
    let [one, other] = [one, other].map(|pose| &session.poses[pose]);
    let gain = session.joints[joint].of(SensorParameter::PositionGain).nominal;
    let noise = session.deflection.reading_std.get(joint).map_or(0.0, |std| BEYOND_NOISE * std);
    let moved = (other.position[joint] - one.position[joint]).abs();
    one.table == other.table && moved * gain.abs() < STANDS.max(noise * gain.abs())
}

/// The side from which a joint came that moved so far, and before from `side`. `noise`: by which a position reading may make it move, rad or m.
fn side_after(moved: f64, noise: f64, side: f64) -> f64 {
    match moved.abs() {
        way if way > MOVED.max(noise) => moved.signum(),
        way if way < STANDS.max(noise) || moved.signum() == side => side,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_that_hardly_moved_back_may_have_its_friction_to_either_side() {
        let after = |moved: f64, side: f64| side_after(moved, 0.0, side);
        assert_eq!([0.02, -0.02].map(|moved| after(moved, 1.0)), [1.0, -1.0]);
        assert_eq!([0.005, -0.005, -5e-5].map(|moved| after(moved, 1.0)), [1.0, 0.0, 1.0]);
        assert_eq!([0.005, 0.02].map(|moved| after(moved, 0.0)), [0.0, 1.0]);
    }
}
