//! Positions that are in another unit than declared: angles in radians for degrees, or the other way round.

use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{MistakenUnit, Session};

use super::hypothesis::Hypothesis;

/// Of all joints that turn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OtherUnit {
    /// Of the position gains.
    factor: f64,
    mistaken: MistakenUnit,
}

/// The one that there may be, where all joints that turn are declared in one unit.
pub(super) fn all(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
    let turning = turning(session);
    let declared = |unit: &str| turning.iter().all(|joint| session.joints[*joint].position_unit.name() == unit);
    let mistaken = MistakenUnit::of_angles()
        .into_iter()
        .filter(|(_, mistaken)| !turning.is_empty() && declared(mistaken.declared));
    mistaken.map(|(factor, mistaken)| Arc::new(OtherUnit { factor, mistaken }) as Arc<dyn Hypothesis>).collect()
}

fn turning(session: &Session) -> Vec<usize> {
    let joints = session.robot.chain.joints().iter().enumerate();
    joints.filter(|(_, joint)| joint.kind == JointKind::Revolute).map(|(place, _)| place).collect()
}

impl Hypothesis for OtherUnit {
    /// A gain of so much makes of the readings what their own unit does.
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        for joint in turning(session) {
            made.joints[joint].parameters[SensorParameter::PositionGain as usize].nominal *= self.factor;
        }
        made
    }

    fn words(&self, _session: &Session) -> (String, String) {
        let MistakenUnit { declared, likely } = self.mistaken;
        let cure = self.mistaken.cure();
        (format!("position readings in {likely} that are declared as {declared}"), format!("If so, {cure}."))
    }
}
