//! Reading the torque of a joint that is not read.

use gravcal_recording::{Reading, TorqueUnit};

use super::addition::Addition;
use crate::check::hypothetical::Hypothetical;

/// In all poses. Its noise is supposed to be that of the joint before it, or of the next that is read.
pub fn of_unread_joint(now: &Hypothetical) -> Vec<Addition> {
    let joints = now.session.joints.len();
    let read_like = |joint: usize| {
        let noise = (0..joint).rev().chain(joint..joints).find_map(|other| now.noise[other])?;
        let name = &now.session.robot.chain.joints()[joint].name;
        let words = format!("record the torque of {name}, too, in all poses");
        Some(Addition::new(words, move |hypothetical| {
            hypothetical.session.joints[joint].torque_unit.get_or_insert(TorqueUnit::NewtonMeter);
            hypothetical.noise[joint] = Some(noise);
            for pose in &mut hypothetical.session.poses {
                pose.torque[joint] = Some(Reading { value: 0.0, std: Some(noise) });
            }
        }))
    };
    (0..joints).filter(|joint| now.noise[*joint].is_none()).filter_map(read_like).collect()
}
