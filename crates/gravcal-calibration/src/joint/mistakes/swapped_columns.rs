//! Columns of two joints that are swapped: of torques, of positions, or of both; in all files, or in one of them.

use std::sync::Arc;

use gravcal_recording::file_name;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{Pose, Session};

use super::hypothesis::Hypothesis;
use crate::joint::measurement_set::MeasurementSet;

/// Two joints whose columns are swapped.
#[derive(Clone, Debug, PartialEq)]
struct SwappedColumns {
    joints: [usize; 2],
    torques: bool,
    positions: bool,
    /// Where they are, if not everywhere.
    within: Option<OneTable>,
}

/// A table and its poses.
#[derive(Clone, Debug, PartialEq)]
struct OneTable {
    table: usize,
    poses: Arc<[usize]>,
}

/// More tables are not looked at one by one.
const MOST_TABLES: usize = 8;

/// All that a session may have swapped everywhere: columns of one unit.
pub(super) fn all(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
    shared(everywhere(session))
}

/// The same in one table each, where there are several and not many.
pub(super) fn in_one_table(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
    let poses_of = |table: usize| {
        let own = session.poses.iter().enumerate().filter(|(_, pose)| pose.table == table);
        OneTable { table, poses: own.map(|(pose, _)| pose).collect() }
    };
    let tables: Vec<OneTable> = (0..session.tables.len()).map(poses_of).filter(|own| !own.poses.is_empty()).collect();
    if !(2..=MOST_TABLES).contains(&tables.len()) {
        return Vec::new();
    }
    let within = |own: &OneTable| {
        let own = own.clone();
        everywhere(session).into_iter().map(move |swapped| SwappedColumns { within: Some(own.clone()), ..swapped })
    };
    shared(tables.iter().flat_map(within))
}

fn everywhere(session: &Session) -> Vec<SwappedColumns> {
    let joints = &session.joints;
    let pairs = || (0..joints.len()).flat_map(|second| (0..second).map(move |first| [first, second]));
    let torques_alike =
        |[a, b]: [usize; 2]| joints[a].torque_unit.is_some() && joints[a].torque_unit == joints[b].torque_unit;
    let positions_alike = |[a, b]: [usize; 2]| joints[a].position_unit == joints[b].position_unit;
    let swapped = |torques: bool, positions: bool| {
        let alike =
            move |pair: &[usize; 2]| (!torques || torques_alike(*pair)) && (!positions || positions_alike(*pair));
        pairs().filter(alike).map(move |joints| SwappedColumns { joints, torques, positions, within: None })
    };
    swapped(true, false).chain(swapped(false, true)).chain(swapped(true, true)).collect()
}

fn shared(swapped: impl IntoIterator<Item = SwappedColumns>) -> Vec<Arc<dyn Hypothesis>> {
    swapped.into_iter().map(|swapped| Arc::new(swapped) as Arc<dyn Hypothesis>).collect()
}

impl SwappedColumns {
    fn is_in(&self, pose: usize) -> bool {
        self.within.as_ref().is_none_or(|within| within.poses.binary_search(&pose).is_ok())
    }
}

impl Hypothesis for SwappedColumns {
    fn made(&self, session: &Session) -> Session {
        let ([a, b], mut made) = (self.joints, session.clone());
        let gains = self.joints.map(|joint| session.joints[joint].of(SensorParameter::PositionGain).nominal);
        let swap = |pose: &mut Pose| {
            if self.torques {
                pose.torque.swap(a, b);
            }
            if self.positions {
                pose.swap_positions(self.joints, gains);
            }
        };
        made.poses.iter_mut().enumerate().filter(|(pose, _)| self.is_in(*pose)).for_each(|(_, pose)| swap(pose));
        made
    }

    fn read(&self, readings: &MeasurementSet) -> MeasurementSet {
        if self.torques { readings.exchanged(self.joints, |pose| self.is_in(pose)) } else { readings.clone() }
    }

    fn words(&self, session: &Session) -> (String, String) {
        let [a, b] = self.joints.map(|joint| session.robot.chain.joints()[joint].name.as_str());
        let of_which = match (self.torques, self.positions) {
            (true, true) => "torque and position",
            (true, false) => "torque",
            (false, _) => "position",
        };
        if let Some(OneTable { table, .. }) = self.within {
            let file = file_name(&session.tables[table].path);
            let what = format!("swapped {of_which} columns in {file}: {a} and {b}");
            return (
                what,
                "Exchange the names of its columns, or record it again: other files have them right.".to_owned(),
            );
        }
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
