//! Joints whose position readings never change.

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
