//! Sensors whose readings never change, or are not there.

use gravcal_robot_model::session::Session;

use crate::testing::sarcos_shoulder;

/// Joints that stand while another sweeps are no sensors that are stuck.
#[test]
fn positions_that_stay_are_reported_where_others_move() {
    let session = sarcos_shoulder().session(0);
    assert_eq!((session.unmoved_note(), session.stuck_positions_remark()), (None, None));
    let mut unmoved = session.clone();
    unmoved.poses.iter_mut().for_each(|pose| pose.position[2] = 0.25);
    let reported = unmoved.unmoved_note().unwrap();
    assert!(
        reported.starts_with("Position readings that are the same in all 407 poses: joint3 (0.250000 rad)."),
        "{reported}"
    );
    assert!(unmoved.stuck_positions_remark().unwrap().contains("other joints move: joint3 (0.250000 rad). Where"));
}

/// A file of which no torque is read, as its columns hold no numbers, is named; one in which single joints are read is not.
#[test]
fn files_without_a_torque_are_named() {
    let mut session = sarcos_shoulder().session(0);
    let doubts = |session: &Session| session.find_doubts().into_iter().find(|doubt| doubt.contains("No torque"));
    assert_eq!(doubts(&session), None);
    let table = session.poses[0].table;
    let of_table = session.poses.iter().filter(|pose| pose.table == table).count();
    session.poses.iter_mut().filter(|pose| pose.table == table).for_each(|pose| pose.torque[1] = None);
    assert_eq!(doubts(&session), None);
    session.poses.iter_mut().filter(|pose| pose.table == table).for_each(|pose| pose.torque.fill(None));
    let told = doubts(&session).unwrap();
    let file = gravcal_recording::file_name(&session.tables[table].path);
    assert!(told.contains(&format!("counts of {file} ({of_table} poses):")), "{told}");
}
