//! Columns of two joints that are swapped: of torques, of positions, or of both.

use std::sync::Arc;

use gravcal_robot_model::session::{Pose, Session};

use super::hypothesis::Hypothesis;
use crate::joint::measurement_set::MeasurementSet;

/// Two joints whose columns are swapped.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SwappedColumns {
    joints: [usize; 2],
    torques: bool,
    positions: bool,
}

/// All that a session may have swapped: columns of one unit.
pub(super) fn all(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
    let joints = &session.joints;
    let pairs = || (0..joints.len()).flat_map(|second| (0..second).map(move |first| [first, second]));
    let torques_alike =
        |[a, b]: [usize; 2]| joints[a].torque_unit.is_some() && joints[a].torque_unit == joints[b].torque_unit;
    let positions_alike = |[a, b]: [usize; 2]| joints[a].position_unit == joints[b].position_unit;
    let swapped = |torques: bool, positions: bool| {
        let alike =
            move |pair: &[usize; 2]| (!torques || torques_alike(*pair)) && (!positions || positions_alike(*pair));
        pairs().filter(alike).map(move |joints| SwappedColumns { joints, torques, positions })
    };
    let swapped = swapped(true, false).chain(swapped(false, true)).chain(swapped(true, true));
    swapped.map(|swapped| Arc::new(swapped) as Arc<dyn Hypothesis>).collect()
}

impl Hypothesis for SwappedColumns {
    fn made(&self, session: &Session) -> Session {
        let ([a, b], mut made) = (self.joints, session.clone());
        let swap = |pose: &mut Pose| {
            if self.torques {
                pose.torque.swap(a, b);
            }
            if self.positions {
                pose.swap_positions(a, b);
            }
        };
        made.poses.iter_mut().for_each(swap);
        made
    }

    fn read(&self, readings: &MeasurementSet) -> MeasurementSet {
        let [a, b] = self.joints;
        if self.torques { readings.exchanged(a, b) } else { readings.clone() }
    }

    fn words(&self, session: &Session) -> (String, String) {
        let [a, b] = self.joints.map(|joint| session.robot.chain.joints()[joint].name.as_str());
        let (what, cure) = match (self.torques, self.positions) {
            (true, true) => (
                format!("torque and position columns of {a} and {b}, which are swapped"),
                "Exchange them in [readings], in the columns of position and of torque: columns stand in the order of the robot's joints.",
            ),
            (true, false) => {
                (format!("swapped torque columns: {a} and {b}"), "Exchange them in [readings] torque columns.")
            }
            (false, _) => {
                (format!("swapped position columns: {a} and {b}"), "Exchange them in [readings] position columns.")
            }
        };
        (what, cure.to_owned())
    }
}
