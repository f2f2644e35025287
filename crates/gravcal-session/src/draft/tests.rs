use std::fs;
use std::path::PathBuf;

use gravcal_recording::{CsvWriting, inspect, inspect_as};
use gravcal_robot_model::session::Session;
use tempfile::TempDir;

use super::*;
use crate::read_session;
use crate::testing::TWO_JOINTS;

/// A folder with a robot and a recording.
fn folder(recording: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
    let path = folder.path().join("day.csv");
    fs::write(&path, recording).unwrap();
    (folder, path)
}

fn robot(folder: &TempDir) -> DraftRobot {
    DraftRobot::read(&folder.path().join("robot.toml"), None, &[], RecordedJoints::default()).unwrap()
}

/// The text that is drawn up, and what its session says when it is read.
fn drafted(recording: &str) -> (String, Vec<String>, Result<Session, String>) {
    let (folder, path) = folder(recording);
    let robot = robot(&folder);
    let inspection = inspect(&path, &|_| {}).unwrap();
    let draft = Draft::new(&path, &inspection, Some(&robot)).unwrap();
    let text = draft.text(&draft.search(&|_| {}).unwrap(), folder.path());
    let session = folder.path().join("session.toml");
    fs::write(&session, &text).unwrap();
    (text, draft.notes(), read_session(&session).map_err(|error| error.to_string()))
}

/// Two joints that stand in six poses of half a second, at 200 Hz, with a little noise; the header's columns.
fn standing(header: &str) -> String {
    let noise = |row: u32, of: u32| f64::from((row * 7919 + of * 104_729) % 1000) * 1e-6;
    let row = |row: u32| {
        let (pose, within) = (f64::from(row / 120), f64::from(row % 120) / 20.0);
        let at = 0.3 * (pose + within.min(1.0));
        let cells = [at + noise(row, 1), at - 0.5 + noise(row, 2), at.sin() + noise(row, 3), at.cos() + noise(row, 4)];
        format!("{},{}\n", f64::from(row) / 200.0, cells.map(|cell| cell.to_string()).join(","))
    };
    format!("{header}\n{}", (0..720).map(row).collect::<String>())
}

#[test]
fn a_recording_with_standstills_becomes_a_session_that_finds_them() {
    let (text, notes, session) = drafted(&standing("t_s,Shoulder_pos,elbow_pos,Shoulder_tau,elbow_tau"));
    let session = session.unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    assert!(text.contains("[readings.still]") && session.poses.len() >= 5, "{text}");
    assert!(text.contains(&format!("found in the recording: {}.", session.poses.len())), "{text}");
    assert_eq!(session.readings.positions[1].column, "elbow_pos");
}

/// The shoulder goes up and down at 0.1 rad/s, and stands for a second wherever it turns.
#[test]
fn standstills_where_sweeps_turn_are_fewer_poses_than_the_sweeps() {
    let noise = |row: u32, of: u32| f64::from((row * 7919 + of * 104_729) % 1000) * 1e-6;
    let row = |row: u32| {
        let within = row % 1100;
        let share = f64::from(within.min(500)) / 500.0 - f64::from(within.saturating_sub(550).min(500)) / 500.0;
        let at = share - 0.5;
        let cells = [at + noise(row, 1), noise(row, 2), at.sin() + noise(row, 3), at.cos() + noise(row, 4)];
        format!("{},{}\n", f64::from(row) / 50.0, cells.map(|cell| cell.to_string()).join(","))
    };
    let recording: String = (0..2200).map(row).collect();
    let (text, _, session) = drafted(&format!("t_s,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau\n{recording}"));
    let session = session.unwrap();
    assert!(text.contains("[readings.sweeps]") && session.poses.len() > 10, "{text}");

    let (folder, path) = folder(&format!("t_s,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau\n{recording}"));
    let (robot, inspection) = (robot(&folder), inspect(&path, &|_| {}).unwrap());
    let draft = Draft::new(&path, &inspection, Some(&robot)).unwrap();
    let poses = draft.search(&|_| {}).unwrap();
    let notes = poses.searched().unwrap().notes(&draft.mapping());
    assert!(notes.iter().any(|note| note.contains("the arm also stands 4 times")), "{notes:?}");
}

/// The same as pandas writes it, with dates as its index.
#[test]
fn dates_are_a_clock() {
    let date = |row: usize| format!("2024-05-01 12:00:{:02}.{:06}", row / 200, 5000 * (row % 200));
    let rows = standing("t")
        .lines()
        .skip(1)
        .enumerate()
        .map(|(row, line)| format!("{},{}\n", date(row), line.split_once(',').unwrap().1))
        .collect::<String>();
    let (text, _, session) = drafted(&format!(",q1_rad,q2_rad,tau1_Nm,tau2_Nm\n{rows}"));
    assert!(text.contains("[readings.time]\ncolumn = \"column1\"\nunit = \"ISO 8601\""), "{text}");
    let session = session.unwrap();
    assert!(text.contains("[readings.still]") && session.poses.len() >= 5, "{text}");
    let last = session.poses.last().unwrap().conditions.time.unwrap();
    assert!(session.poses[0].conditions.time == Some(0.0) && (2.0..4.0).contains(&last), "{last}");
}

#[test]
fn columns_of_a_recording_without_a_header_are_named_in_the_session() {
    let recording = standing("t");
    let (folder, path) = folder(recording.split_once('\n').unwrap().1);
    let names = ["t_s", "q1_rad", "q2_rad", "tau1_Nm", "tau2_Nm"].map(str::to_owned).to_vec();
    let csv = CsvWriting { columns: Some(names), ..CsvWriting::default() };
    let inspection = inspect_as(&path, &csv, &|_| {}).unwrap();
    let robot = robot(&folder);
    let draft = Draft::new(&path, &inspection, Some(&robot)).unwrap().written(csv);
    let text = draft.text(&draft.search(&|_| {}).unwrap(), folder.path());
    fs::write(folder.path().join("session.toml"), &text).unwrap();
    let session = read_session(&folder.path().join("session.toml")).unwrap();
    assert!(text.contains("columns = [\"t_s\", \"q1_rad\",") && session.poses.len() >= 5, "{text}");
}

#[test]
fn rows_of_an_arm_in_motion_without_a_clock_are_asked_about() {
    let row = |row: u32| {
        let t = f64::from(row) / 100.0;
        [t.sin(), (0.7 * t).cos(), t.sin(), (0.3 * t).cos()].map(|cell| cell.to_string()).join(",") + "\n"
    };
    let rows: String = (0..3000).map(row).collect();
    let (text, _, session) = drafted(&format!("q1,q2,tau1,tau2\n{rows}"));
    assert!(
        text.contains("[readings]\n# LOOK AT THIS: Each of the 3000 rows of day.csv is taken as a static pose, but"),
        "{text}"
    );
    assert!(text.contains("give it a clock") && text.lines().all(|line| line.chars().count() <= 130), "{text}");
    assert_eq!(session.unwrap().doubts.len(), 1);
}

#[test]
fn joints_of_other_names_are_taken_in_their_order_and_that_is_reported() {
    let (text, notes, session) = drafted(&standing("t_s,q1_rad,q2_rad,tau1_Nm,tau2_Nm"));
    assert_eq!(session.unwrap().readings.positions[0].column, "q1_rad");
    let reported = "joints were matched by the order of the numbers in the columns' names, as their names differ: shoulder is \
                `q1_rad`, elbow is `q2_rad`";
    assert_eq!(notes, [reported]);
    assert!(
        text.contains("taken in the order of the numbers in the columns' names.")
            && text.contains("shoulder is q1_rad, elbow is q2_rad.")
    );
}

#[test]
fn columns_are_paired_and_ordered_by_the_numbers_in_their_names() {
    let columns = |session: &Session| {
        let torque = |joint: usize| session.readings.torques[joint].as_ref().unwrap().0.column.clone();
        let position = |joint: usize| session.readings.positions[joint].column.clone();
        [0, 1].map(|joint| (position(joint), torque(joint)))
    };
    let numbered = [("J1 [rad]", "T1 (Nm)"), ("J2 [rad]", "T2 (Nm)")].map(|(a, b)| (a.to_owned(), b.to_owned()));
    let (text, _, session) = drafted(&standing("t_s,J2 [rad],J1 [rad],T1 (Nm),T2 (Nm)"));
    let session = session.unwrap();
    assert_eq!(columns(&session), numbered, "{text}");
    assert!(session.doubts.is_empty(), "{:?}", session.doubts);
    // Other numbers: in their order, which is told.
    let (text, ..) = drafted(&standing("t_s,J1 [rad],J2 [rad],T0 (Nm),T1 (Nm)"));
    assert!(text.contains("# LOOK AT THIS: Which torque is of which joint is not told"), "{text}");
}

/// What a draft becomes where the columns of the recording are named after the robot's joints.
fn named_draft(recording: &str) -> Result<(String, Vec<String>, Vec<String>), DraftError> {
    let (folder, path) = folder(recording);
    let robot = robot(&folder);
    let names = DraftRobot::joint_names(&folder.path().join("robot.toml")).unwrap();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let inspection = inspect(&path, &|_| {}).unwrap().with_joint_names(&names);
    let draft = Draft::new(&path, &inspection, Some(&robot))?;
    let columns = draft.mapping().positions.into_iter().map(|position| position.column).collect();
    let text = draft.text(&draft.search(&|_| {}).unwrap(), folder.path());
    fs::write(folder.path().join("session.toml"), &text).unwrap();
    let doubts = read_session(&folder.path().join("session.toml")).unwrap().doubts;
    assert_eq!(doubts, [""; 0], "{text}");
    Ok((text, draft.notes(), columns))
}

/// Whatever order they stand in.
#[test]
fn columns_that_contain_the_names_of_joints_are_theirs() {
    let header = "t_s,/js/position/elbow,/js/position/shoulder,/js/effort/elbow,/js/effort/shoulder";
    let (text, notes, columns) = named_draft(&standing(header)).unwrap();
    assert_eq!(columns, ["/js/position/shoulder", "/js/position/elbow"]);
    assert!(text.contains("columns = [\"/js/effort/shoulder\", \"/js/effort/elbow\"]"), "{text}");
    let reported = "joints were matched by their names within those of the columns: shoulder is `/js/position/shoulder`, elbow is \
                    `/js/position/elbow`";
    assert_eq!(notes, [reported]);
}

#[test]
fn where_some_columns_name_joints_in_another_order_none_is_guessed() {
    let of = |positions: &str| named_draft(&standing(&format!("t_s,{positions},fore_tau,main_tau")));
    let reported = of("fore_pos,shoulder_pos").unwrap_err().to_string();
    for expected in ["but for elbow; the columns `fore_pos` name no joint", "the order does not tell it either"] {
        assert!(reported.contains(expected), "{reported}");
    }
    // In the order of the joints the others are told by it.
    let (_, notes, columns) = of("shoulder_pos,fore_pos").unwrap();
    assert_eq!(columns, ["shoulder_pos", "fore_pos"]);
    assert!(notes[0].starts_with("joints were matched by their order"), "{notes:?}");
}

#[test]
fn a_joint_without_torque_readings_has_no_torque_column() {
    let rows: String = standing("t_s,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau")
        .lines()
        .enumerate()
        .map(
            |(row, line)| {
                if row == 0 { format!("{line}\n") } else { format!("{},nan\n", line.rsplit_once(',').unwrap().0) }
            },
        )
        .collect();
    let (text, notes, _) = named_draft(&rows).unwrap();
    assert!(text.contains("columns = [\"shoulder_tau\", \"\"]"), "{text}");
    assert_eq!(notes, ["no torque is recorded of elbow: the column is \"\" there"]);
}

/// No row has both positions and torques: limits of motion make no pose of it.
#[test]
fn where_topics_have_rows_of_their_own_standstills_are_looked_for() {
    let header = "t_s,/a:shoulder.position,/a:elbow.position,/b:shoulder.effort,/b:elbow.effort";
    let rows: String = (0..400)
        .map(|row| {
            let t = f64::from(row) / 100.0;
            match row % 2 {
                0 => format!("{t},{},{},,\n", t.sin(), t.cos()),
                _ => format!("{t},,,{},{}\n", 1.0 + t, 2.0 - t),
            }
        })
        .collect();
    let (text, _, session) = drafted(&format!("{header}\n{rows}"));
    assert!(text.contains("[readings.still]") && text.contains("# LOOK AT THIS: none was found."), "{text}");
    let reported = session.unwrap_err();
    assert!(reported.contains("let the arm stand") && !reported.contains("delete the row"), "{reported}");
}

/// A robot's joints may stand in another order than that of the numbers in their names.
#[test]
fn numbers_of_the_robots_joints_count_where_they_are_those_of_the_columns() {
    let (folder, path) = folder(&standing("t_s,J1 [°],J2 [°],T1 (Nm),T2 (Nm)"));
    let robot = TWO_JOINTS.replace("\"shoulder\"", "\"axis2\"").replace("\"elbow\"", "\"axis1\"");
    fs::write(folder.path().join("robot.toml"), robot).unwrap();
    let robot = self::robot(&folder);
    let inspection = inspect(&path, &|_| {}).unwrap();
    let draft = Draft::new(&path, &inspection, Some(&robot)).unwrap();
    let columns: Vec<String> = draft.mapping().positions.into_iter().map(|position| position.column).collect();
    assert_eq!(columns, ["J2 [°]", "J1 [°]"]);
}

#[test]
fn other_numbers_of_joints_are_refused() {
    let (folder, path) = folder("t_s,q1,tau1\n0,1,2\n1,2,3\n");
    let inspection = inspect(&path, &|_| {}).unwrap();
    let robot = robot(&folder);
    let reported = Draft::new(&path, &inspection, Some(&robot)).unwrap_err().to_string();
    let expected = "of the robot's 2 joints these are not in the recording: shoulder, elbow; the joints whose positions are recorded are 1,";
    assert!(reported.contains(expected), "{reported}");
}

#[test]
fn a_recording_may_have_more_joints_than_the_robot() {
    let finger = |text: &str| -> String {
        let mut lines = text.lines();
        let header = format!("{},finger_pos,finger_tau\n", lines.next().unwrap_or_default());
        header + &lines.map(|line| format!("{line},0.02,0\n")).collect::<String>()
    };
    let (text, notes, session) = drafted(&finger(&standing("t_s,shoulder_pos,elbow_pos,shoulder_tau,elbow_tau")));
    assert_eq!(session.unwrap().readings.positions.len(), 2, "{text}");
    assert_eq!(notes, ["left out, as no joints of the chain: finger"]);
    // Of other names: those that read a torque are as many as the robot has.
    let (_, notes, session) = drafted(&finger(&standing("t_s,q1_rad,q2_rad,tau1_Nm,tau2_Nm")));
    assert_eq!(session.unwrap().readings.positions[1].column, "q2_rad");
    assert!(
        notes[0].starts_with("joints were matched by the order of the numbers") && notes[1].contains("finger"),
        "{notes:?}"
    );
}

#[test]
fn a_urdf_is_followed_to_the_recorded_joints_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("arm.urdf");
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 1 0\"/></joint>"
        )
    };
    let links: String = ["base", "upper", "fore"].map(|link| format!("<link name=\"{link}\"/>")).concat();
    let joints = joint("shoulder", "base", "upper") + &joint("elbow", "upper", "fore");
    fs::write(&urdf, format!("<robot name=\"arm\">{links}{joints}</robot>")).unwrap();
    let ends = |tips: &[String], recorded: &[&str]| {
        let recorded = RecordedJoints { all: recorded, moving: recorded };
        let robot = DraftRobot::read(&urdf, None, tips, recorded).map_err(|error| error.to_string())?;
        Ok::<_, String>(robot.ends.map(|ends| (ends.base, ends.tips.concat())).unwrap())
    };
    let whole = Ok(("base".to_owned(), "fore".to_owned()));
    // Which joints slide is known of those beyond the chain, too.
    let text = fs::read_to_string(&urdf).unwrap();
    let finger = "<link name=\"finger\"/><joint name=\"grip_1\" type=\"prismatic\"><parent link=\"fore\"/><child link=\"finger\"/></joint>";
    let gripping = folder.path().join("gripping.urdf");
    fs::write(&gripping, text.replace("</robot>", &format!("{finger}</robot>"))).unwrap();
    let recorded = RecordedJoints { all: &["shoulder", "elbow"], moving: &["shoulder", "elbow"] };
    let robot = DraftRobot::read(&gripping, None, &[], recorded).unwrap();
    assert_eq!(robot.robot.chain.joints().len(), 2);
    assert!(robot.slides("grip_1") && robot.slides("grip1") && !robot.slides("elbow"));
    assert_eq!(ends(&[], &["shoulder", "elbow", "finger"]), whole);
    // A joint that stands all the time is part of what the last one carries that moves.
    let standing = RecordedJoints { all: &["shoulder", "elbow"], moving: &["shoulder"] };
    let robot = DraftRobot::read(&urdf, None, &[], standing).unwrap();
    assert_eq!(robot.ends.unwrap().tips, ["upper"]);
    assert_eq!(ends(&["fore".to_owned()], &["a", "b", "c"]), whole);
    let reported = ends(&[], &["a", "b", "c"]).unwrap_err();
    assert!(
        reported.contains("none of its joints has the name of one that is recorded with a torque (a, b, c)"),
        "{reported}"
    );
    assert!(ends(&["hand".to_owned()], &["a"]).unwrap_err().contains("no link of such a name: hand"));
}

#[test]
fn an_arm_in_motion_gets_windows_and_friction() {
    let row = |row: u32| {
        let t = f64::from(row) / 100.0;
        let cells = [t.sin(), (0.7 * t).cos(), t.cos(), -0.7 * (0.7 * t).sin(), t.sin(), (0.3 * t).cos()];
        format!("{t},{}\n", cells.map(|cell| cell.to_string()).join(","))
    };
    let rows: String = (0..3000).map(row).collect();
    let (text, _, session) = drafted(&format!("t_s,q1,q2,qd1,qd2,tau1,tau2\n{rows}"));
    let session = session.unwrap();
    assert!(text.contains("[readings.motion]\n") && text.lines().all(|line| line.chars().count() <= 130), "{text}");
    assert!(session.poses.len() > 100 && session.has_windows() && !session.terms.is_empty(), "{text}");
}

#[test]
fn without_a_clock_every_row_is_a_pose() {
    let (text, _, session) = drafted("q1_deg,q2_deg,tau1,tau2\n0,0,1,2\n10,20,3,4\n20,50,3,4\n");
    assert!(text.contains("Every row of the file is taken as one static pose"), "{text}");
    assert_eq!(session.unwrap().poses.len(), 3);
}

#[test]
fn what_only_the_user_knows_is_asked_for() {
    let (text, notes, session) =
        drafted("# load = plate\nq1_deg,q2_deg,tau1,tau2\n0,0,1000,2000\n10,20,3000,1\n20,50,30,4\n");
    assert!(text.contains("# torque_gain = { nominal = …, unit = \"count/(N·m)\" }"), "{text}");
    assert!(text.contains("# torque_bias = { nominal = 1515, unit = \"count\" }"), "{text}");
    let (currents, ..) = drafted("q1_deg,q2_deg,current1_A,current2_A\n0,0,1,2\n10,20,3.3,1\n20,50,-0.3,4\n");
    assert!(currents.contains("# torque_bias = { nominal = 0, unit = \"A\" }"), "{currents}");
    assert!(
        notes[1].starts_with("sensors read in units of their own: fill in")
            && notes[1].ends_with("for shoulder, elbow"),
        "{notes:?}"
    );
    assert!(notes[2].contains("the mass of the load"), "{notes:?}");
    assert!(session.is_err(), "a load without a mass, and counts without a gain");
}

#[test]
fn without_a_robot_the_session_asks_for_one() {
    let (folder, path) = folder("q1,tau1\n0,1\n1,2\n");
    let inspection = inspect(&path, &|_| {}).unwrap();
    let draft = Draft::new(&path, &inspection, None).unwrap();
    assert!(draft.text(&DraftPoses::Rows { doubt: None }, folder.path()).contains("# FILL IN the robot"));
}

#[test]
fn columns_that_say_nothing_are_refused() {
    for (text, reported) in
        [("a,b\n1,2\n2,3\n", "which columns are the joints' positions"), ("q1,b\n1,2\n", "no column is a torque")]
    {
        let (_folder, path) = folder(text);
        let inspection = inspect(&path, &|_| {}).unwrap();
        assert!(Draft::new(&path, &inspection, None).unwrap_err().to_string().contains(reported));
    }
}
