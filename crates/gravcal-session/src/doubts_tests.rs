use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use gravcal_recording::{Standstill, Standstills, StaticPose};
use gravcal_robot_model::session::{Pose, PoseTable, Searched, Session};

use crate::read_session;

/// Two joints with limits and masses.
const ROBOT: &str = r#"
name = "arm"
convention = "standard-dh"
[[joint]]
name = "shoulder"
a_m = 0.4
alpha_deg = 0
d_m = 0
limits_deg = [-170, 170]
mass_kg = 4
center_of_mass_m = [-0.2, 0, 0]
[[joint]]
name = "elbow"
a_m = 0.3
alpha_deg = 0
d_m = 0
mass_kg = 2
center_of_mass_m = [-0.1, 0, 0]
"#;

fn session(units: [&str; 2], readings: &str, rows: impl Iterator<Item = [f64; 4]>) -> Session {
    read(units, [readings, ""], rows)
}

/// A session of rows of two angles and two torques, in these units, with more in `[readings]` and at its end.
fn read(units: [&str; 2], more: [&str; 2], rows: impl Iterator<Item = [f64; 4]>) -> Session {
    read_with(["", ""], units, more, rows)
}

/// The same with one text in place of another, in the robot's file or in the session.
fn read_with(
    [text, other]: [&str; 2],
    units: [&str; 2],
    [readings, end]: [&str; 2],
    rows: impl Iterator<Item = [f64; 4]>,
) -> Session {
    let folder = tempfile::tempdir().unwrap();
    let table: String = rows.map(|[a, b, c, d]| format!("{a},{b},{c},{d}\n")).collect();
    let changed = |all: &str| if text.is_empty() { all.to_owned() } else { all.replace(text, other) };
    fs::write(folder.path().join("robot.toml"), changed(ROBOT)).unwrap();
    fs::write(folder.path().join("day.csv"), format!("q1,q2,y1,y2\n{table}")).unwrap();
    let [position, torque] = units;
    let written = format!(
        "robot = 'robot.toml'\n[gravity]\nmagnitude_m_per_s2 = 9.81\nhemisphere = [0, -1, 0]\n[readings]\n{readings}\n\
         position = {{ columns = ['q1', 'q2'], unit = '{position}' }}\ntorque = {{ columns = ['y1', 'y2'], unit = '{torque}' }}\n\
         [[poses]]\nfile = 'day.csv'\n{end}\n"
    );
    fs::write(folder.path().join("session.toml"), changed(&written)).unwrap();
    read_session(&folder.path().join("session.toml")).unwrap()
}

/// A number from -1 to 1 that looks random.
fn random(row: u32, of: u32) -> f64 {
    let mixed = (u64::from(row) * 7919 + u64::from(of) * 104_729) * 2_654_435 % 1009;
    mixed as f64 / 504.0 - 1.0
}

/// The torque of the shoulder alone matters here.
fn at(angles: [f64; 2], position: f64, torque: f64) -> [f64; 4] {
    let [a, b] = angles;
    let elbow = 2.0 * 9.81 * 0.2 * (a + b).cos();
    let shoulder = 9.81 * (4.0 * 0.2 + 2.0 * 0.4) * a.cos() + elbow;
    [position * a, position * b, torque * shoulder, torque * elbow]
}

fn poses(position: f64, torque: f64) -> impl Iterator<Item = [f64; 4]> {
    (0..60).map(move |row| at([2.5 * random(row, 1), 2.0 * random(row, 2)], position, torque))
}

/// Slower at the ends of their ways than between, and not together.
fn motion(rows: u32, per_second: f64) -> impl Iterator<Item = [f64; 4]> {
    (0..rows).map(move |row| {
        let t = f64::from(row) / per_second;
        at([2.0 * (0.6 * t).sin(), 1.5 * (0.37 * t + 1.0).cos()], 1.0, 1.0)
    })
}

#[test]
fn what_is_right_is_not_doubted() {
    let degrees = 180.0 / PI;
    assert_eq!(session(["rad", "N·m"], "", poses(1.0, 1.0)).doubts, [""; 0]);
    assert_eq!(session(["deg", "N·m"], "", poses(degrees, 1.0)).doubts, [""; 0]);
    assert_eq!(session(["deg", "mN·m"], "", poses(degrees, 1e3)).doubts, [""; 0]);
    // 6.4 rad, as a wrist that turns fully reads with an offset.
    assert_eq!(session(["rad", "N·m"], "", poses(6.4 / 2.5, 1.0)).doubts, [""; 0]);
}

#[test]
fn positions_in_another_unit_are_doubted() {
    let far = session(["rad", "N·m"], "", poses(180.0 / PI, 1.0)).doubts;
    assert_eq!(far.len(), 1, "{far:?}");
    let reported = "As declared, angles of shoulder, elbow reach 143.2 rad, farther than joints turn: the position readings look like deg, \
                and are declared as rad. If so, say unit = \"deg\" in [readings] position.";
    assert_eq!(far[0], reported);
    let near = session(["deg", "N·m"], "", poses(1.0, 1.0)).doubts;
    assert!(near[0].starts_with("As declared, no joint is farther than 2.5 deg from zero in any pose"), "{near:?}");
    assert!(near[0].contains("look like rad, and are declared as deg. If so, say unit = \"rad\""), "{near:?}");
}

/// One angle in degrees among radians is a wrong cell, and no unit.
#[test]
fn a_position_that_is_too_far_in_one_row_is_told_with_its_row() {
    let far = session(
        ["rad", "N·m"],
        "",
        poses(1.0, 1.0).enumerate().map(|(row, mut cells)| {
            cells[1] *= if row == 20 { 180.0 / PI } else { 1.0 };
            cells
        }),
    );
    let [doubt] = &far.doubts[..] else { panic!("{:?}", far.doubts) };
    assert!(doubt.starts_with("As declared, positions of elbow are farther than joints go in row 22 of "), "{doubt}");
}

/// What a recorder writes where it has no torque; a spike of a few times the range is for the residuals to tell.
#[test]
fn a_torque_that_is_nothing_like_the_others_is_told_with_its_row() {
    let doubts = |wrong: f64| {
        let rows = poses(1.0, 1.0).enumerate().map(move |(row, mut cells)| {
            cells[3] = if row == 20 { wrong } else { cells[3] };
            cells
        });
        session(["rad", "N·m"], "", rows).doubts
    };
    let told = doubts(-99999.0);
    assert!(told.len() == 1 && told[0].contains("elbow is -99999 N·m in row 22 of "), "{told:?}");
    assert_eq!(doubts(50.0), [""; 0]);
}

/// Whatever number the sensor counts from.
#[test]
fn a_sensor_that_counts_is_judged_by_how_far_it_goes() {
    let doubts = |gain: f64| {
        let gain = format!("position_gain = {{ nominal = {gain}, unit = 'rad/count' }}");
        let joints = format!("[[joint]]\nname = 'shoulder'\n{gain}\n[[joint]]\nname = 'elbow'\n{gain}");
        let row =
            |row| [30_000.0 + 2000.0 * random(row, 1), 2000.0 * random(row, 2), 20.0 * random(row, 3), random(row, 4)];
        read(["count", "N·m"], ["", &joints], (0..60).map(row)).doubts
    };
    assert_eq!(doubts(1e-3), [""; 0]);
    let far = doubts(1e-2);
    assert!(far.len() == 1 && far[0].contains("or their nominal gain, is another"), "{far:?}");
}

#[test]
fn torques_beyond_the_model_are_doubted() {
    let far = session(["rad", "N·m"], "", poses(1.0, 1e3)).doubts;
    assert!(far.len() == 1 && far[0].contains("torque readings of shoulder, elbow vary by"), "{far:?}");
    let small = session(["rad", "mN·m"], "", poses(1.0, 1.0)).doubts;
    assert!(small.len() == 1 && small[0].contains("make them vary by"), "{small:?}");
    // A single bad row is no other unit, but one to look at.
    let bad = poses(1.0, 1.0).enumerate().map(|(row, mut at)| {
        at[2] = if row == 7 { 1e6 } else { at[2] };
        at
    });
    let bad = session(["rad", "N·m"], "", bad).doubts;
    assert!(bad.len() == 1 && bad[0].contains("shoulder is 1000000 N·m in row 9 of "), "{bad:?}");
}

/// Readings of a sensor that reads in steps agree anywhere.
#[test]
fn equal_readings_at_an_end_are_doubted_and_steps_are_not() {
    let told = |read: &dyn Fn(f64) -> f64| {
        let row = |row: u32| {
            let [q1, q2, y1, y2] = at([f64::from(17 * row % 60) / 20.0 - 1.5, 2.0 * random(row, 2)], 1.0, 1.0);
            [q1, q2, read(y1 + 0.1 * random(row, 3)), y2]
        };
        let session = session(["rad", "N·m"], "", (0..60).map(row));
        session
            .find_doubts()
            .into_iter()
            .filter(|doubt| doubt.contains("may be at the end of its range"))
            .collect::<Vec<String>>()
    };
    assert_eq!(told(&|torque| torque), [""; 0]);
    assert_eq!(told(&|torque| torque.round()), [""; 0]);
    let largest = told(&|torque| torque.min(12.0));
    assert!(largest.len() == 1 && largest[0].contains("largest torque reading of shoulder, 12,"), "{largest:?}");
    assert!(told(&|torque| torque.max(2.0))[0].contains("lowest in [readings] torque"));
    assert_eq!(told(&|torque| torque.clamp(2.0, 12.0)).len(), 2);
}

/// All of the time, or from some pose on; of a reading in coarse steps it may be chance, and each pose may be read several times.
#[test]
fn a_torque_sensor_that_is_stuck_is_doubted() {
    let stuck = |from: u32, to: u32| {
        let rows = poses(1.0, 1.0).zip(0..).map(move |(row, number)| {
            let [a, b, c, d] = row;
            [a, b, c, if (from..to).contains(&number) { 1.25 } else { d }]
        });
        session(["rad", "N·m"], "", rows).doubts
    };
    let reported = stuck(0, 60);
    let begin =
        "Torque readings of elbow are the same number (1.25) in all 60 poses, where gravity should change them by ±";
    assert!(reported.len() == 1 && reported[0].starts_with(begin), "{reported:?}");
    let reported = stuck(20, 45);
    let place = "in 25 poses one after another (line 22 of day.csv to line 46 of day.csv)";
    assert!(reported.len() == 1 && reported[0].contains(place), "{reported:?}");
    assert_eq!(stuck(20, 25), [""; 0]);
    let again = (0..60).map(|row| at([2.5 * random(row / 10, 1), 2.0 * random(row / 10, 2)], 1.0, 1.0));
    assert_eq!(session(["rad", "N·m"], "", again).doubts, [""; 0]);
    let coarse = poses(1.0, 1.0).map(|[a, b, c, d]| [a, b, c, (d / 3.0).round() * 3.0]);
    assert_eq!(session(["rad", "N·m"], "", coarse).doubts, [""; 0]);
}

/// Its torques are small beside those of the shoulder.
#[test]
fn the_sensor_of_a_light_wrist_is_doubted_too() {
    let of_wrist = |mass: &str, change: fn(f64) -> f64| {
        let light = move |[a, b, c, d]: [f64; 4]| [a, b, c, change(d)];
        read_with(["mass_kg = 2\n", mass], ["rad", "N·m"], ["", ""], poses(1.0, 1.0).map(light)).doubts
    };
    let stuck = of_wrist("mass_kg = 0.02\n", |_| 0.3);
    let begin = "Torque readings of elbow are the same number (0.3) in all 60 poses";
    assert!(stuck.len() == 1 && stuck[0].starts_with(begin), "{stuck:?}");
    let thousandths = of_wrist("mass_kg = 0.2\n", |d| 1000.0 * d);
    assert!(thousandths.len() == 1 && thousandths[0].contains("torque readings of elbow vary by"), "{thousandths:?}");
    assert_eq!(of_wrist("mass_kg = 0.2\n", |d| 0.1 * d), [""; 0]);
}

#[test]
fn rows_of_an_arm_in_motion_are_doubted() {
    for per_second in [20.0, 100.0, 1000.0] {
        let doubts = session(["rad", "N·m"], "", motion((20.0 * per_second) as u32, per_second)).doubts;
        let reported = format!(
            "Each of the {} rows of day.csv is taken as a static pose, but neighbours differ by little",
            20.0 * per_second
        );
        assert!(doubts.len() == 1 && doubts[0].starts_with(&reported), "{doubts:?}");
        assert!(doubts[0].contains("give it a clock") && doubts[0].contains("say still = {}"), "{doubts:?}");
    }
    let many = (0..4000).map(|row| at([2.0 * random(row, 1), random(row, 2)], 1.0, 1.0));
    let doubts = session(["rad", "N·m"], "", many).doubts;
    assert!(doubts.len() == 1 && doubts[0].contains("nobody lets an arm stand so often"), "{doubts:?}");
}

/// One joint sweeps in steps of a degree while the other stands, each pose is read ten times, limits of motion are said.
#[test]
fn static_poses_and_motion_that_is_known_are_not_doubted() {
    let sweep = (0..4 * 180).map(|row: u32| {
        let (sweep, step) = (row / 180, row % 180);
        let back = if sweep % 2 == 0 { step } else { 179 - step };
        at([f64::from(back).to_radians() - 1.5, 0.4 * f64::from(sweep)], 1.0, 1.0)
    });
    assert_eq!(session(["rad", "N·m"], "", sweep).doubts, [""; 0]);
    let again = (0..600).map(|row| {
        let noise = 1e-4 * random(row, 3);
        at([2.0 * random(row / 10, 1) + noise, random(row / 10, 2) - noise], 1.0, 1.0)
    });
    assert_eq!(session(["rad", "N·m"], "", again).doubts, [""; 0]);
    let known = "time = { column = 'y1', unit = 's' }\nvelocity = { columns = ['y1', 'y2'], unit = 'rad/s' }\n\
                 select = { arm = { speed_below = { value = 1e6, unit = 'rad/s' } } }";
    assert_eq!(session(["rad", "N·m"], known, motion(2000, 100.0)).doubts, [""; 0]);
}

/// Of those whose data are here. One is a trajectory that was published without its clock.
#[test]
fn of_the_experiments_a_trajectory_alone_is_doubted() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let sessions = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path().join("session.toml"));
    let read: Vec<Session> =
        sessions.filter(|path| path.is_file()).filter_map(|path| read_session(&path).ok()).collect();
    assert!(read.len() >= 3, "only {} sessions could be read", read.len());
    for session in read {
        let trajectory = session.input_paths().any(|input| input.ends_with("kuka_lbr_med7/measurements.csv"));
        assert_eq!(session.doubts.len(), usize::from(trajectory), "{:?}", session.doubts);
    }
}

#[test]
fn columns_whose_numbers_do_not_go_together_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("robot.toml"), ROBOT).unwrap();
    let rows: String =
        (0..6).map(|row| format!("{},{},2,3,4\n", 0.2 * f64::from(row), 1.0 + 0.1 * f64::from(row))).collect();
    fs::write(folder.path().join("day.csv"), format!("q1,q2,tau1,tau2,tau3\n{rows}")).unwrap();
    let doubts = |positions: &str, torques: &str| {
        let written = format!(
            "robot = 'robot.toml'\n[gravity]\nmagnitude_m_per_s2 = 9.81\n[readings]\nposition = {{ columns = {positions}, unit = 'rad' \
             }}\ntorque = {{ columns = {torques}, unit = 'N·m' }}\n[[poses]]\nfile = 'day.csv'\n"
        );
        fs::write(folder.path().join("session.toml"), written).unwrap();
        read_session(&folder.path().join("session.toml")).unwrap().doubts
    };
    let reported = doubts("['q1', 'q2']", "['tau2', 'tau1']");
    assert!(
        reported.len() == 1 && reported[0].contains("shoulder reads `q1` and `tau2`, elbow reads `q2` and `tau1`"),
        "{reported:?}"
    );
    for torques in ["['tau1', 'tau2']", "['tau2', 'tau3']", "['tau2', '']"] {
        assert_eq!(doubts("['q1', 'q2']", torques), [""; 0], "{torques}");
    }
    assert_eq!(doubts("['q2', 'q1']", "['tau2', 'tau1']"), [""; 0]);
}

#[test]
fn columns_that_bear_the_names_of_other_joints_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let doubts = |joints: [&str; 2], columns: [&str; 4]| {
        let robot = ROBOT
            .replace("\"shoulder\"", &format!("'{}'", joints[0]))
            .replace("\"elbow\"", &format!("'{}'", joints[1]));
        fs::write(folder.path().join("robot.toml"), robot).unwrap();
        let rows: String = poses(1.0, 1.0).map(|row| row.map(|cell| cell.to_string()).join(",") + "\n").collect();
        fs::write(folder.path().join("day.csv"), format!("{}\n{rows}", columns.join(","))).unwrap();
        let written = format!(
            "robot = 'robot.toml'\n[gravity]\nmagnitude_m_per_s2 = 9.81\nhemisphere = [0, -1, 0]\n[readings]\nposition = {{ columns = \
             ['{}', '{}'], unit = 'rad' }}\ntorque = {{ columns = ['{}', '{}'], unit = 'N·m' }}\n[[poses]]\nfile = 'day.csv'\n",
            columns[0], columns[1], columns[2], columns[3]
        );
        fs::write(folder.path().join("session.toml"), written).unwrap();
        read_session(&folder.path().join("session.toml")).unwrap().doubts
    };
    let arm = ["shoulder", "elbow"];
    let reported = doubts(arm, ["elbow.position", "q", "y", "arm_shoulder_tau"]);
    let expected = "Columns bear the names of other joints than they are taken for: `elbow.position` bears the name of elbow and is taken as \
                    shoulder's; `arm_shoulder_tau` bears the name of shoulder and is taken as elbow's. Bring the columns";
    assert!(reported.len() == 1 && reported[0].starts_with(expected), "{reported:?}");
    let reported = doubts(arm, ["elbow_q", "shoulder_q", "elbow_y", "shoulder_y"]);
    assert!(
        reported[0].contains("`elbow_q` and `elbow_y` bear the name of elbow and are taken as shoulder's;"),
        "{reported:?}"
    );
    assert_eq!(doubts(arm, ["shoulder.position", "elbow.position", "y1", "y2"]), [""; 0]);
    assert_eq!(doubts(arm, ["elbow_shoulder", "q", "y1", "y2"]), [""; 0], "which of the two is not told");
    // Columns that are counted from 0.
    assert_eq!(doubts(["joint_1", "joint_2"], ["joint_0_q", "joint_1_q", "joint_0_y", "joint_1_y"]), [""; 0]);
}

#[test]
fn a_load_that_hangs_many_arm_lengths_away_is_reported() {
    let load = |at: &str| {
        let load = format!("load = 'plate'\n[[load]]\nname = 'plate'\nmass_kg = 1\nlink = 'link2'\nposition_m = {at}");
        read(["rad", "N·m"], ["", &load], poses(1.0, 1.0)).doubts
    };
    let reported = load("[50, 0, 100]");
    let expected = "Load `plate` is stated 112 m away from link2, which carries it: is position_m in mm?";
    assert!(reported.len() == 1 && reported[0].starts_with(expected), "{reported:?}");
    assert_eq!(load("[0.05, 0, 0.1]"), [""; 0]);
}

/// The controller has taken gravity from them.
#[test]
fn torques_about_zero_beside_heavy_masses_may_be_external_ones() {
    let noise = poses(1.0, 1.0).zip(0..).map(|([a, b, ..], row)| [a, b, 0.02 * random(row, 3), 0.02 * random(row, 4)]);
    let reported = session(["rad", "N·m"], "", noise).doubts;
    assert!(reported.len() == 1 && reported[0].contains("They may be external torques"), "{reported:?}");
    // Small torques about another number are in another unit.
    let small = poses(1.0, 1e-3).map(|[a, b, c, d]| [a, b, c + 5.0, d + 5.0]);
    let reported = session(["rad", "N·m"], "", small).doubts;
    assert!(reported.len() == 1 && !reported[0].contains("external"), "{reported:?}");
}

/// Of a wrist sensor that somebody turned: moments in N·mm make what it carries hang metres away.
#[test]
fn moments_in_newton_millimetres_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let doubts = |scale: f64| {
        let row = |row: u32| {
            let angle = 2.5 * random(row, 1);
            let (force, half) = ([0.0, 15.0 * angle.sin(), -15.0 * angle.cos()], 0.5 * angle);
            let moment = [0.1 * scale * force[1], 0.05 * scale * force[2], 0.0];
            let cells = force.into_iter().chain(moment).chain([half.sin(), 0.0, 0.0, half.cos()]);
            cells.map(|cell| cell.to_string()).collect::<Vec<_>>().join(",") + "\n"
        };
        let rows: String = (0..40).map(row).collect();
        fs::write(folder.path().join("day.csv"), format!("fx,fy,fz,tx,ty,tz,qx,qy,qz,qw\n{rows}")).unwrap();
        let written = "[gravity]\nmagnitude_m_per_s2 = 9.81\n[readings]\norientation = { columns = ['qx', 'qy', 'qz', 'qw'], order = 'xyzw', \
                       rotation = 'base-from-body' }\n[[force_torque_sensor]]\nname = 'wrist'\nreadings = { columns = ['fx', 'fy', 'fz', 'tx', \
                       'ty', 'tz'], unit = 'N' }\n[[poses]]\nfile = 'day.csv'\n";
        fs::write(folder.path().join("session.toml"), written).unwrap();
        read_session(&folder.path().join("session.toml")).unwrap().doubts
    };
    let reported = doubts(1000.0);
    assert!(reported.len() == 1 && reported[0].contains("are the moments in N·mm?"), "{reported:?}");
    assert_eq!(doubts(1.0), [""; 0]);
}

/// The first doubt of right poses of which one text is another.
fn of_change(text: &str, other: &str) -> String {
    read_with([text, other], ["rad", "N·m"], ["", ""], poses(1.0, 1.0)).doubts.swap_remove(0)
}

#[test]
fn lengths_in_millimetres_and_angles_in_radians_are_reported() {
    assert!(of_change("a_m = 0.4", "a_m = 400").contains("places links 400 m apart"));
    let turned = of_change("a_m = 0.4\nalpha_deg = 0", "a_m = 0.4\nalpha_deg = 1.5708");
    assert!(turned.starts_with("The axis of elbow is π/2 or π degrees off the one before it"), "{turned}");
}

#[test]
fn gravity_of_no_place_on_earth_is_reported() {
    assert!(of_change("= 9.81\n", "= 981\n").starts_with("[gravity] magnitude_m_per_s2 is 981: on Earth"));
    let roughly = read_with(
        ["m_per_s2 = 9.81\n", "m_per_s2 = 9.7\nmagnitude_std_m_per_s2 = 0.1\n"],
        ["rad", "N·m"],
        ["", ""],
        poses(1.0, 1.0),
    );
    assert!(roughly.doubts.is_empty(), "{:?}", roughly.doubts);
}

#[test]
fn a_load_that_nothing_carries_is_reported() {
    let load = "[[load]]\nname = 'plate'\nmass_kg = 1\nlink = 'link2'";
    let session = read(["rad", "N·m"], ["", load], poses(1.0, 1.0));
    assert_eq!(session.doubts, ["No pose carries load `plate`: is a `load =` missing from a [[poses]]?"]);
}

#[test]
fn hardly_any_pose_is_reported() {
    let session = session(["rad", "N·m"], "", poses(1.0, 1.0).take(2));
    assert!(
        session.doubts.iter().any(|doubt| doubt.starts_with("There are only 2 static poses")),
        "{:?}",
        session.doubts
    );
}

/// What is said of a clock in right poses that were read at these times.
fn of_clock(time: &dyn Fn(u32) -> f64) -> (Session, Vec<String>) {
    let known = "time = { column = 'y2', unit = 's' }";
    let rows = poses(1.0, 1.0).zip(0..).map(|([a, b, c, _], row)| [a, b, c, time(row)]);
    let session = read_with(["'y1', 'y2'], unit", "'y1', ''], unit"], ["rad", "N·m"], [known, ""], rows);
    let doubts = session.doubts.clone();
    (session, doubts)
}

/// Rows that stand in any order are no clock that begins anew, and neither are parts that have a table each.
#[test]
fn a_clock_that_begins_anew_in_a_table_is_doubted() {
    let every = |rows: u32| move |row: u32| 10.0 * f64::from(row % rows);
    assert_eq!(of_clock(&every(60)).1, [""; 0]);
    let (mut session, once) = of_clock(&every(40));
    let begin = "day.csv: times go back in line 42, as where a clock begins anew.";
    assert!(once.len() == 1 && once[0].starts_with(begin), "{once:?}");
    let often = of_clock(&every(10)).1;
    assert!(often.len() == 1 && often[0].contains("in line 12 and 4 more, as where"), "{often:?}");
    assert_eq!(of_clock(&every(5)).1, [""; 0]);
    assert_eq!(of_clock(&|row| 10.0 * random(row, 3)).1, [""; 0]);
    session.tables.push(session.tables[0].clone());
    session.poses[40..].iter_mut().for_each(|pose| pose.table = 1);
    assert_eq!(session.find_doubts(), [""; 0], "each part has a table of its own");
}

/// Twenty times at least, and more than four times as often as it stands.
#[test]
fn a_recording_in_which_the_arm_creeps_is_doubted() {
    let mut session = session(["rad", "N·m"], "", poses(1.0, 1.0));
    let mut doubts = |moved_on: [u64; 2], stands: usize| {
        let stood = Standstill {
            interval: [0.0, 1.0],
            pose: StaticPose::default(),
            position: Vec::new(),
            torque: Vec::new(),
            instruments: Vec::new(),
        };
        let standstills =
            Standstills { found: vec![stood; stands], moved_on: moved_on.into(), ..Standstills::default() };
        let (remarks, lost) = (Vec::new(), Vec::new());
        let path = "day.mcap".into();
        session.searched =
            vec![Searched { path, standstills: Some(standstills), remarks, lost, ..Searched::default() }];
        session.find_doubts()
    };
    let elbow = doubts([3, 50], 12);
    let begin = "day.mcap: 50 times the arm hardly moved, and elbow moved on before it stood long enough: beside 12 standstills.";
    assert!(elbow.len() == 1 && elbow[0].starts_with(begin), "{elbow:?}");
    assert!(doubts([26, 50], 0)[0].contains("and shoulder, elbow moved on"));
    assert_eq!([doubts([3, 48], 12), doubts([19, 19], 0), doubts([0, 0], 0)], [[""; 0]; 3]);
    assert_eq!(doubts([0, 20], 0).len(), 1);
}

/// Two tables of the same rows: one of another load is a copy, one of the same load only repeats.
#[test]
fn a_copy_that_is_said_to_carry_another_load_is_doubted() {
    let load = "[[load]]\nname = 'plate'\nmass_kg = 1\nlink = 'link2'";
    let session = read(["rad", "N·m"], ["", load], poses(1.0, 1.0));
    let told = |load: Option<usize>| {
        let mut session = session.clone();
        session.tables.push(PoseTable { path: "copy.csv".into(), load, swept: None, step: None });
        let again: Vec<Pose> = session.poses.iter().map(|pose| Pose { table: 1, load, ..pose.clone() }).collect();
        session.poses.extend(again);
        let doubts = session.find_doubts().into_iter();
        doubts.filter(|doubt| doubt.contains("is a copy of the other")).collect::<Vec<_>>()
    };
    assert_eq!(told(None), [""; 0]);
    let copied = told(Some(0));
    let expected =
        "60 rows of copy.csv, which is said to be of load plate, are those of day.csv, of no load, in every number";
    assert!(copied.len() == 1 && copied[0].starts_with(expected), "{copied:?}");
}

#[test]
fn ends_of_a_range_beyond_which_much_is_are_doubted() {
    let told = |lowest: &str| {
        let ends = format!("unit = 'N·m', lowest = {lowest}, highest = 4095 }}");
        let session = read_with(["unit = 'N·m' }", &ends], ["rad", "N·m"], ["", ""], poses(1.0, 1.0));
        let doubts = session.doubts.into_iter();
        doubts.filter(|doubt| doubt.contains("beyond the stated ends")).collect::<Vec<_>>()
    };
    assert_eq!(told("-4096"), [""; 0]);
    let left_out = told("0");
    assert!(left_out.len() == 1 && left_out[0].contains("of 60 of shoulder"), "{left_out:?}");
}
