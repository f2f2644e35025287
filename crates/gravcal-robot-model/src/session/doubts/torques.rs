//! Torque readings that the robot's masses cannot make.

use gravcal_dynamics::JointKind;

use super::names::named;
use crate::parameter::SensorParameter;
use crate::session::Session;
use crate::state::State;

/// Torques so many times larger than the model's, or smaller, are in another unit: mN·m make a factor of 1000.
const FAR: f64 = 20.0;
const FAR_BELOW: f64 = 50.0;
/// So many times larger than what the joint's own torque can be: files know wrists less well, and tools are not in them.
const FAR_OF_OWN: f64 = 200.0;
/// Share of the readings at either end that single bad rows may be.
const ENDS: f64 = 0.05;
/// Poses at which the model is computed at most, and readings of a joint that tell how much it varies at least.
const POSES: usize = 300;
const READINGS: usize = 5;
/// Torques of less than this, N·m, tell nothing.
const LEAST: f64 = 0.1;

/// How the torques of the joints that turn compare with those that the robot's masses make at nominal values; `angles_doubted`: whether these may be in
/// another unit, so that the masses make other torques than are computed.
pub(super) fn doubt(session: &Session, angles_doubted: bool) -> Option<String> {
    let joints = session.robot.chain.joints();
    let turning: Vec<usize> = (0..joints.len()).filter(|joint| joints[*joint].kind == JointKind::Revolute).collect();
    let model = model(session)?;
    let ranges: Vec<(usize, f64)> =
        turning.iter().filter_map(|joint| Some((*joint, half_range(read(session, *joint)?)?))).collect();
    let largest = turning.iter().flat_map(|joint| &model[*joint]).fold(0.0_f64, |most, torque| most.max(torque.abs()));
    let varies = turning.iter().filter_map(|joint| half_range(model[*joint].clone())).fold(0.0, f64::max);
    let most = ranges.iter().map(|(_, varies)| *varies).fold(0.0, f64::max);
    let own = most_in_any_direction(session);
    let is_beyond = |(joint, varies): &&(usize, f64)| {
        *varies > FAR * largest.max(LEAST) || own[*joint] > LEAST && *varies > FAR_OF_OWN * own[*joint]
    };
    let beyond: Vec<usize> = ranges.iter().filter(is_beyond).map(|(joint, _)| *joint).collect();
    if !beyond.is_empty() {
        return (!angles_doubted).then(|| format!(
            "As declared, torque readings of {} vary by ±{:.0} N·m, and the robot's masses make {:.1} N·m at most: they are in \
             another unit. {CURE}",
            named(session, &beyond),
            ranges.iter().filter(|(joint, _)| beyond.contains(joint)).map(|(_, varies)| *varies).fold(0.0, f64::max),
            beyond.iter().map(|joint| own[*joint]).fold(0.0, f64::max),
        ));
    }
    (varies > LEAST && !ranges.is_empty() && most < varies / FAR_BELOW).then(|| {
        let what = format!(
            "As declared, torque readings vary by ±{most:.1e} N·m at most, and the robot's masses make them vary by ±{varies:.1} N·m in \
             these poses"
        );
        let zero = turning.iter().filter_map(|joint| mean(read(session, *joint)?)).all(|mean| mean.abs() < varies / FAR_BELOW);
        match zero {
            true => format!("{what}. {EXTERNAL} Or they are in another unit. {CURE}"),
            false => format!("{what}: they are in another unit. {CURE}"),
        }
    })
}

/// What readings about zero may be.
const EXTERNAL: &str = "They may be external torques, from which the robot's controller has taken gravity, so that they are about zero while \
                        nothing touches the arm. Record what the sensors measure instead: tau_J of a Franka Panda (not tau_ext_hat_filtered), \
                        the measured torques of a KUKA iiwa (getMeasuredTorque, not getExternalTorque).";

const CURE: &str = "Look at the unit in [readings] torque (mN·m is one, and so are A and count, with a nominal torque_gain in [[joint]]), \
                    and at the masses of the robot's file.";

/// What gravity does to each joint in some of the poses, N·m or N; `None` where the robot's file says nothing of masses.
fn model(session: &Session) -> Option<Vec<Vec<f64>>> {
    if session.robot.chain.links().iter().all(|link| link.inertia.is_none()) {
        return None;
    }
    Some(gravity_torques(session, some_poses(session), session.gravity.assumed()))
}

fn some_poses(session: &Session) -> impl Iterator<Item = usize> {
    (0..session.poses.len()).step_by(session.poses.len().div_ceil(POSES).max(1))
}

/// The most that gravity of any direction does to each joint in these poses, N·m or N: a base may stand otherwise than assumed.
fn most_in_any_direction(session: &Session) -> Vec<f64> {
    let size = session.gravity.assumed().iter().map(|g| g * g).sum::<f64>().sqrt();
    let axes = [[size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
    let [x, y, z] = axes.map(|gravity| gravity_torques(session, some_poses(session), gravity));
    let most = |joint: usize| {
        let all = x[joint].iter().zip(&y[joint]).zip(&z[joint]);
        all.map(|((x, y), z)| (x * x + y * y + z * z).sqrt()).fold(0.0, f64::max)
    };
    (0..session.joints.len()).map(most).collect()
}

/// What this gravity, m/s², does to each joint in these poses, N·m or N, by the masses that are assumed, of the bare arm.
pub(super) fn gravity_torques(
    session: &Session,
    poses: impl Iterator<Item = usize>,
    gravity: [f64; 3],
) -> Vec<Vec<f64>> {
    let chain = &session.robot.chain;
    let State { sensors, inertia, .. } = State::nominal(session);
    let inertia: Vec<f64> = inertia.into_iter().flatten().collect();
    let [gain, offset] =
        [SensorParameter::PositionGain, SensorParameter::PositionOffset].map(|quantity| quantity as usize);
    let mut of_joints = vec![Vec::new(); session.joints.len()];
    let mut torque = vec![0.0; session.joints.len()];
    for pose in poses {
        let readings = session.poses[pose].position.iter().zip(&sensors);
        let coordinates: Vec<f64> = readings.map(|(reading, sensor)| sensor[gain] * reading + sensor[offset]).collect();
        chain.gravity_torque(&coordinates, gravity, &inertia, &mut torque);
        of_joints.iter_mut().zip(&torque).for_each(|(all, torque)| all.push(*torque));
    }
    of_joints
}

/// Torques as the nominal gain tells them, but for the bias.
fn read(session: &Session, joint: usize) -> Option<Vec<f64>> {
    session.joints[joint].torque_unit?;
    let gain = session.joints[joint].of(SensorParameter::TorqueGain).nominal;
    Some(session.poses.iter().filter_map(|pose| pose.torque[joint]).map(|reading| reading.value / gain).collect())
}

/// `None` where there is none.
fn mean(numbers: Vec<f64>) -> Option<f64> {
    (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
}

/// Half of the range of all but the ends.
fn half_range(mut numbers: Vec<f64>) -> Option<f64> {
    if numbers.len() < READINGS {
        return None;
    }
    numbers.sort_by(f64::total_cmp);
    let cut = (ENDS * numbers.len() as f64) as usize;
    Some(0.5 * (numbers[numbers.len() - 1 - cut] - numbers[cut]))
}
