//! A simulation's file that is being read.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::Registry;
use gravcal_robot_model::robot::Robot;

use super::tables::SimulationTable;
use crate::document::Document;

/// The file being read, and the robot whose names it uses.
pub(super) struct Reader<'a> {
    pub document: &'a Document,
    pub registry: &'a Registry,
    pub table: &'a SimulationTable,
    pub robot: &'a Robot,
}

impl Reader<'_> {
    pub fn names(&self) -> Vec<&str> {
        self.robot.chain.joints().iter().map(|joint| joint.name.as_str()).collect()
    }

    pub fn kind(&self, joint: usize) -> JointKind {
        self.robot.chain.joints()[joint].kind
    }
}
