//! A torque sensor that reads the other way in one table: as where files were written by two programs.

use std::sync::Arc;

use gravcal_recording::file_name;
use gravcal_robot_model::session::{Pose, Session};

use super::hypothesis::Hypothesis;

/// More tables are not looked at one by one.
const MOST_TABLES: usize = 12;

/// The sensor of a joint, and the table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ReversedInTable {
    joint: usize,
    table: usize,
}

/// Each joint that is read in each table, where it is read in several and there are not many.
pub(super) fn all(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
    if session.tables.len() > MOST_TABLES {
        return Vec::new();
    }
    let of_joint = |joint: usize| {
        let is_read =
            |table: &usize| session.poses.iter().any(|pose| pose.table == *table && pose.torque[joint].is_some());
        let mut tables: Vec<usize> = (0..session.tables.len()).filter(is_read).collect();
        // The gain's sign is free: of two tables the one is reversed where the other is, and of one none.
        if tables.len() <= 2 {
            tables = tables.into_iter().skip(1).collect();
        }
        tables.into_iter().map(move |table| ReversedInTable { joint, table })
    };
    let all = (0..session.joints.len()).flat_map(of_joint);
    all.map(|reversed| Arc::new(reversed) as Arc<dyn Hypothesis>).collect()
}

impl Hypothesis for ReversedInTable {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        let own = |pose: &&mut Pose| pose.table == self.table;
        let readings = made.poses.iter_mut().filter(own).filter_map(|pose| pose.torque[self.joint].as_mut());
        readings.for_each(|reading| reading.value = -reading.value);
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let joint = &session.robot.chain.joints()[self.joint].name;
        let file = file_name(&session.tables[self.table].path);
        (
            format!("torque readings of {joint} with another sign in {file} than elsewhere"),
            "Turn their sign round there, or in all other files, whichever is wrong.".to_owned(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::Verdict;
    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::estimate;

    #[test]
    fn a_sensor_that_is_reversed_in_one_file_is_named_with_it() {
        let mut session = sarcos_shoulder().session(0);
        let last = session.poses.last().unwrap().table;
        let file = file_name(&session.tables[last].path);
        let own = session.poses.iter_mut().filter(|pose| pose.table == last);
        own.filter_map(|pose| pose.torque[2].as_mut()).for_each(|reading| reading.value = -reading.value);
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
        let named = format!("torque readings of joint3 with another sign in {file} than elsewhere");
        assert!(result.termination.contains(&named), "{} {:?}", result.termination, result.notes);
    }
}
