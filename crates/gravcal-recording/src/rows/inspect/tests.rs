use std::fs;

use super::*;
use crate::rows::{Heading, create};

fn inspected(text: &str) -> Inspection {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, text).unwrap();
    inspect(&path, &|_| {}).unwrap()
}

#[test]
fn a_table_with_spaces_between_cells_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, "0.5 1.25\n0.75 2.5\n").unwrap();
    let error = inspect(&path, &|_| {}).unwrap_err().to_string();
    assert!(
        error.contains("(commas between cells); cells are separated by commas, semicolons or tabs, not by"),
        "{error}"
    );
}

/// A thousand rows at 1 kHz with a reading that is given by its row.
fn thousand(name: &str, reading: impl Fn(u32) -> f64) -> Inspection {
    let rows = (0..1000).map(|row| format!("{},{}\n", f64::from(row) * 1e-3, reading(row)));
    inspected(&format!("time_s,{name}\n{}", rows.collect::<String>()))
}

#[test]
fn rate_duration_gaps_and_jumps_are_reported() {
    let found = inspected("t_ms,q\n0,1\n10,2\n20,3\n20,3\n30,4\n1030,5\n1020,6\n1030,7\n,8\n");
    let time = found.time.as_ref().unwrap();
    assert_eq!((time.unit, time.from_s, time.to_s, time.interval_s), ("ms", 0.0, 1.03, 0.01));
    assert_eq!((time.gaps, time.first_gaps[0]), (1, Gap { at_s: 0.03, lasts_s: 1.0 }));
    assert_eq!((time.backwards, time.first_backwards, time.missing, found.repeated), (1, Some(8), 1, 1));
    let text = found.to_string();
    for line in [
        "CSV file (commas between cells), 9 rows",
        "1.030 s from 0.000 s on, 100.0 Hz (`t_ms` in ms)",
        "1 gap of more than five intervals: 1.000 s at 0.030 s.",
        "Time goes backwards 1 time, first at row 8.",
        "1 row repeats the row before it.",
    ] {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn stuck_and_saturated_sensors_are_reported() {
    let noisy = |row: u32| f64::from(row * 7919 % 1000);
    let found = |reading: &dyn Fn(u32) -> f64| thousand("tau1", reading).columns.remove(0);
    let good = found(&noisy);
    assert_eq!((good.stuck, good.clipped.len(), good.whole), (None, 0, true));
    let stuck = found(&|row| if (300..500).contains(&row) { 5.0 } else { noisy(row) }).stuck.unwrap();
    assert_eq!((stuck.at, stuck.from_s, stuck.readings), (5.0, 0.3, 200));
    assert_eq!(found(&|_| 7.0).stuck.unwrap().readings, 1000);
    let clipped = found(&|row| noisy(row).min(950.0)).clipped;
    assert_eq!(clipped, [Clipped { at: 950.0, readings: 50 }]);
    // A sensor with coarse steps rests often, and says nothing by it.
    assert_eq!(found(&|row| f64::from(row / 250)).stuck, None);
}

/// Encoders without noise, of an arm that stands for long at the ends of its way: neither stuck nor at an end of their range.
#[test]
fn an_arm_that_rests_is_no_sensor_that_is_stuck() {
    let rows = |stuck: bool| {
        let row = |row: u32| {
            let at = f64::from((row % 500).min(250)) * 1e-3;
            let second = if stuck && row > 600 { 7.0 } else { 2.0 - at };
            format!("{},{at},{second},{}\n", f64::from(row) * 1e-2, f64::from(row * 7919 % 1000))
        };
        inspected(&format!("time_s,q1,q2,tau1\n{}", (0..1000).map(row).collect::<String>()))
    };
    let resting = rows(false).columns;
    assert!(resting.iter().all(|column| column.stuck.is_none() && column.clipped.is_empty()), "{resting:?}");
    assert!(resting[0].readings == 1000 && (resting[0].interval_s - 0.01).abs() < 1e-9, "{resting:?}");
    let stuck = rows(true).columns.remove(1).stuck.unwrap();
    assert_eq!((stuck.at, stuck.readings), (7.0, 150), "while the other moves");
}

#[test]
fn meanings_are_guessed_from_names_and_ranges() {
    let guess = |name: &str, range: [f64; 2], whole| {
        let Guess { meaning, joint, unit, .. } = names::guess(name, range[0], range[1], whole);
        (meaning, joint.unwrap_or_default(), unit.unwrap_or("-"))
    };
    let near = [-1.0, 2.0];
    let named = |meaning, joint: &str, unit| (Some(meaning), joint.to_owned(), unit);
    for (name, range, whole, expected) in [
        ("shoulder.position", near, false, named(Meaning::Position, "shoulder", "rad")),
        ("shoulder.position", [-90.0, 90.0], false, named(Meaning::Position, "shoulder", "deg")),
        ("/a:b.effort", near, false, named(Meaning::Torque, "b", "N·m")),
        ("q1_deg", near, false, named(Meaning::Position, "1", "deg")),
        ("joint1_position_rad", near, false, named(Meaning::Position, "joint1", "rad")),
        ("joint2_torque_count", near, false, named(Meaning::Torque, "joint2", "count")),
        ("qd3_rad_per_s", near, false, named(Meaning::Velocity, "3", "rad/s")),
        ("tau1_Nm", near, false, named(Meaning::Torque, "1", "N·m")),
        ("tau1", [0.0, 4095.0], true, named(Meaning::Torque, "1", "count")),
        ("tau1 [mN·m]", near, false, named(Meaning::Torque, "1", "mN·m")),
        ("tau1_N·m", near, false, named(Meaning::Torque, "1", "N·m")),
        ("q1 (°)", near, false, named(Meaning::Position, "1", "deg")),
        ("joint1 <degrees>", near, false, named(Meaning::Position, "joint1", "deg")),
        ("joint1 {Nm}", near, false, named(Meaning::Torque, "joint1", "N·m")),
        ("elbow_current_mA", near, false, named(Meaning::Current, "elbow", "mA")),
        ("actual_current_3 [A]", near, false, named(Meaning::Current, "3", "A")),
        ("load_torque2 [%]", near, false, named(Meaning::Torque, "load2", "%")),
        ("qd1 [°/s]", near, false, named(Meaning::Velocity, "1", "deg/s")),
        ("tau_a", near, false, named(Meaning::Torque, "a", "N·m")),
        ("ft_sensor_fz", near, false, named(Meaning::ForceTorque, "", "N")),
        ("ft_sensor_tz", near, false, named(Meaning::ForceTorque, "", "N·m")),
        ("fx", [0.0, 4095.0], true, named(Meaning::ForceTorque, "", "count")),
        ("wrist_orientation_x", near, false, named(Meaning::Orientation, "", "-")),
        ("wrench.torque.x [Nm]", near, false, named(Meaning::ForceTorque, "", "N·m")),
        ("temperature2", [20.0, 30.0], false, named(Meaning::Temperature, "2", "degC")),
    ] {
        assert_eq!(guess(name, range, whole), expected, "{name}");
    }
    assert_eq!(guess("voltage", near, false).0, None);
}

#[test]
fn axes_of_wrenches_and_parts_of_orientations_are_reported_by_their_names() {
    let axis = |name: &str| names::guess(name, -1.0, 1.0, false).axis.unwrap_or("-");
    for (name, expected) in [
        ("fx", "fx"),
        ("tz [Nm]", "nz"),
        ("mx", "nx"),
        ("wrench.force.y", "fy"),
        ("wrench.torque.y", "ny"),
        ("ft_x", "-"),
        ("qx", "x"),
        ("tool_qw", "w"),
        ("pose.orientation.z", "z"),
        ("q1", "-"),
        ("orientation", "-"),
        ("r11", "r11"),
        ("R_23", "r23"),
        ("tool.rot33", "r33"),
        ("r14", "-"),
        ("motor11", "-"),
    ] {
        assert_eq!(axis(name), expected, "{name}");
    }
}

#[test]
fn a_joint_that_stands_is_distinguished_from_one_that_moves() {
    let found = inspected("t_s,q1,q2,q3,tau1,tau2,tau3\n0,0,1,0.02,1,2,3\n1,2,1.1,0.0201,4,5,6\n");
    let joints = found.joints();
    let moving: Vec<_> = found.moving(&joints).map(|joint| found.columns[joint.position].name.as_str()).collect();
    assert_eq!(moving, ["q1", "q2"]);
}

#[test]
fn what_sensors_read_is_taken_before_what_was_asked_and_torques_before_currents() {
    let columns = "t_s,q1_desired,q1_measured,tau1_desired,current1_A,tau1_measured,q2,tau2_cmd,current2_A,fx";
    let found = inspected(&format!("{columns}\n0,1,2,3,4,5,6,7,8,1e305\n1,2,3,4,5,6,7,8,9,1\n"));
    let name = |place: usize| found.columns[place].name.clone();
    let joints: Vec<_> = found.joints().iter().map(|joint| (name(joint.position), joint.torque.map(name))).collect();
    let expected = [("q1_measured", "tau1_measured"), ("q2", "current2_A")];
    assert_eq!(joints, expected.map(|(position, torque)| (position.to_owned(), Some(torque.to_owned()))));
    let text = found.to_string();
    for line in
        ["asked of the joint", "a [[force_torque_sensor]] of", "no sensor reads such numbers", "no recording tells"]
    {
        assert!(text.contains(line), "{text}");
    }
}

/// Columns of bags begin with their topic where two have the same joint.
#[test]
fn a_topic_of_commands_is_passed_over_and_two_of_readings_are_told() {
    let of = |first: &str, second: &str| {
        let columns = [first, second].map(|topic| format!("{topic}:a.position,{topic}:a.effort")).join(",");
        let found = inspected(&format!("time_s,{columns}\n0,1,2,3,4\n1,2,3,4,5\n"));
        let joints = found.joints();
        assert_eq!(joints.len(), 1);
        let taken = [joints[0].position, joints[0].torque.unwrap()].map(|place| found.columns[place].name.clone());
        (taken, found.topics_doubt(), found.to_string())
    };
    let (taken, doubt, _) = of("/joint_commands", "/joint_states");
    assert_eq!((taken, doubt), (["/joint_states:a.position", "/joint_states:a.effort"].map(str::to_owned), None));
    let (taken, doubt, text) = of("/left", "/right");
    assert_eq!(taken, ["/left:a.position", "/left:a.effort"]);
    assert!(doubt.unwrap().starts_with("The topics `/left` and `/right` both tell the positions of the same joints."));
    assert!(text.contains("The topics `/left` and `/right`"), "{text}");
}

#[test]
fn units_of_joints_that_slide_are_lengths_and_forces() {
    let columns = "t_s,arm_pos,finger_pos,finger_vel,finger_effort,rail_pos,rail_pos_deg";
    let found = inspected(&format!("{columns}\n0,1,0.02,0.1,3,0,0\n1,2,0.04,0.1,4,800,90\n"));
    let units = |found: &Inspection| found.columns.iter().map(|column| column.guess.unit.unwrap()).collect::<Vec<_>>();
    assert_eq!(units(&found), ["rad", "rad", "rad/s", "N·m", "count", "deg"]);
    let known = found.with_sliding(|joint| joint == "finger" || joint == "rail");
    assert_eq!(units(&known), ["rad", "m", "m/s", "N", "count", "deg"]);
}

/// Of each joint, in their order, the columns of its position and its torque.
fn pairs(header: &str) -> (Vec<String>, Inspection) {
    let cells = |from: usize| (0..header.split(',').count()).map(|cell| (from + cell).to_string()).collect::<Vec<_>>();
    let found = inspected(&format!("{header}\n{}\n{}\n", cells(1).join(","), cells(2).join(",")));
    let name = |place: usize| found.columns[place].name.as_str();
    let pair = |joint: &JointFound| format!("{} {}", name(joint.position), joint.torque.map_or("", name));
    (found.joints().iter().map(pair).collect(), found)
}

#[test]
fn numbers_in_names_tell_which_torque_is_whose() {
    let (reported, found) = pairs("J1 [°],J3 [°],J2 [°],T3 (Nm),T1 (Nm),T2 (Nm)");
    assert_eq!(reported, ["J1 [°] T1 (Nm)", "J2 [°] T2 (Nm)", "J3 [°] T3 (Nm)"]);
    assert_eq!(found.pairing_doubt(), None);
    // Of names that tell the joint, numbers are only the order.
    assert_eq!(pairs("tau1,q2,tau2,q1").0, ["q1 tau1", "q2 tau2"]);
    // A joint without a number leaves the others where they stand.
    assert_eq!(pairs("q2,q1,q_elbow").0, ["q2 ", "q1 ", "q_elbow "]);
}

#[test]
fn numbers_that_do_not_go_together_are_reported() {
    for (header, expected) in [
        ("J1 [°],J2 [°],T0 (Nm),T1 (Nm)", "those of positions carry the numbers 1, 2, those of torques 0, 1"),
        ("J1 [°],J2 [°],left (Nm),right (Nm)", "only those of positions carry numbers (1, 2)"),
        ("left [°],right [°],T1 (Nm),T2 (Nm)", "only those of torques carry numbers (1, 2)"),
    ] {
        let (reported, found) = pairs(header);
        let (positions, torques): (Vec<_>, Vec<_>) = header.split(',').enumerate().partition(|(place, _)| *place < 2);
        let in_order: Vec<String> = positions.iter().zip(&torques).map(|(a, b)| format!("{} {}", a.1, b.1)).collect();
        assert_eq!(reported, in_order);
        let doubt = found.pairing_doubt().unwrap();
        assert!(doubt.contains(expected) && doubt.contains("paired by their order: `"), "{doubt}");
        assert!(found.to_string().contains("Which torque is of which joint is not told"), "{found}");
    }
    assert_eq!(pairs("left [°],right [°],upper (Nm),lower (Nm)").1.pairing_doubt(), None);
}

#[test]
fn the_clock_is_found_by_its_name() {
    let clock = |names: [&str; 2]| names::clock(&names.map(str::to_owned));
    assert_eq!((clock(["q", "time_s"]), clock(["timestamp", "q"]), clock(["a", "tau"])), (Some(1), Some(0), None));
    assert_eq!((clock(["J1 [°]", "T1 (Nm)"]), clock(["q", "T (ms)"])), (None, Some(1)));
    assert_eq!((clock(["t1", "t2"]), clock(["t0", "q1"])), (None, Some(0)));
    for temperature in ["T_winding", "t_motor", "T1"] {
        assert_eq!(clock([temperature, "q1"]), None, "{temperature}");
    }
    for time in ["t_ros", "t_sys", "t_rel_s"] {
        assert_eq!(clock(["q1", time]), Some(1), "{time}");
    }
    let clock = |names: [&str; 3]| names::clock(&names.map(str::to_owned));
    assert_eq!((clock(["t_1", "t_2", "t"]), clock(["t_s", "T1 (Nm)", "T2 (Nm)"])), (Some(2), Some(0)));
    for (name, step, unit) in [
        ("time_s", 0.001, "s"),
        ("t", 0.001, "s"),
        ("t", 1.0, "ms"),
        ("stamp", 1e6, "ns"),
        ("t_us", 1e3, "µs"),
        ("time_min", 1e-4, "min"),
        ("t (hours)", 1e-6, "h"),
        ("t", 1e9, "s"),
    ] {
        assert_eq!(names::time_unit(name, step).name, unit, "{name} {step}");
    }
    let text = inspected("q\n1\n2\n").to_string();
    assert!(text.contains("No column is a clock"), "{text}");
}

/// As pandas writes them, whole seconds without decimals; with its index, which has no name; and without a header.
#[test]
fn dates_with_times_are_a_clock() {
    let row = |row: u32| {
        let part = row % 100;
        let decimals = if part == 0 { String::new() } else { format!(".{:06}", 10_000 * part) };
        format!("2024-05-01 12:00:0{}{decimals}", row / 100)
    };
    let rows: String = (0..300).map(|at| format!("{},{}.5,1e-3\n", row(at), at)).collect();
    for (header, column) in [("time,q1,tau1\n", "time"), (",q1,tau1\n", "column1"), ("", "column1")] {
        let found = inspected(&format!("{header}{rows}"));
        let time = found.time.as_ref().unwrap();
        assert_eq!((time.column.as_str(), time.unit, time.from_s), (column, "ISO 8601", 1_714_564_800.0));
        assert!((time.interval_s - 0.01).abs() < 1e-6 && (time.to_s - time.from_s - 2.99).abs() < 1e-6, "{time:?}");
        assert!(found.remarks.is_empty() && found.columns.len() == 2, "{found:?}");
        let reported = format!("2.990 s from 2024-05-01T12:00:00.000Z on, 100.0 Hz (`{column}` in ISO 8601)");
        assert!(found.to_string().contains(&reported), "{found}");
    }
    let commas = inspected("time;q1\n2024-05-01 12:00:00,010;1,5\n2024-05-01 12:00:00,020;2,5\n");
    assert!(
        (commas.time.as_ref().unwrap().interval_s - 0.01).abs() < 1e-6 && commas.columns[0].highest == 2.5,
        "{commas:?}"
    );
    let other = inspected("time,q1\n2024-05-01 12:00:00,1\n12,2\n01.05.2024 12:00,3\n");
    let reported =
        "cells that are no dates with times (ISO 8601) count as missing: 2 of `time`; the first is on line 3";
    assert_eq!(other.remarks, [reported]);
    let none = inspected("time,q1\n01.05.2024 12:00,1\n01.05.2024 12:01,2\n");
    assert!(none.time.is_none() && none.remarks[0].contains("nor dates with times such as"), "{none:?}");
}

#[test]
fn the_text_has_eighty_columns_and_tells_topics_and_losses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let long = format!("{}.position", "a_joint_with_a_very_long_name_".repeat(2));
    let heading = Heading {
        columns: ["time_s", "a.position", "/hand:b.effort", &long].map(str::to_owned).to_vec(),
        metadata: BTreeMap::from([("load".to_owned(), "plate-a, ".repeat(20))]),
    };
    let mut writer = create(&path, &heading, false).unwrap();
    (0..50).for_each(|row| writer.write(&[f64::from(row), 1e-9, 1e9, 0.5]).unwrap());
    writer.finish().unwrap();
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
    let found = inspect(&path, &|_| {}).unwrap();
    let text = found.to_string();
    let wide: Vec<&str> = text.lines().filter(|line| line.chars().count() > 80).collect();
    assert_eq!(wide, [""; 0], "{text}");
    assert!(text.contains("/hand: 50 messages, sensor_msgs/msg/JointState in cdr"), "{text}");
    assert_eq!(found.columns.iter().map(|column| column.readings).collect::<Vec<_>>(), [50, 50, 50]);
}

/// Of each of the joints with these names, the columns that are taken as its position and its torque.
fn named(header: &str, joints: &[&str]) -> Vec<(String, String)> {
    let (_, found) = pairs(header);
    let found = found.with_joint_names(joints);
    let name = |place: usize| found.columns[place].name.clone();
    let columns = |joint: &&str| {
        let of_joint = found.joints().into_iter().find(|one| one.name == **joint);
        let pair = of_joint.map(|one| (name(one.position), one.torque.map_or_else(String::new, name)));
        pair.unwrap_or_default()
    };
    joints.iter().map(columns).collect()
}

#[test]
fn columns_are_those_of_the_joint_whose_name_they_contain() {
    let arm = ["shoulder_joint", "elbow_joint"];
    for [elbow, shoulder, elbows_torque, shoulders_torque] in [
        [
            "/js/position/elbow_joint",
            "/js/position/shoulder_joint",
            "/js/effort/elbow_joint",
            "/js/effort/shoulder_joint",
        ],
        [
            "left_elbow_joint.position",
            "left_shoulder_joint.position",
            "left_elbow_joint.effort",
            "left_shoulder_joint.effort",
        ],
        [
            "elbow_joint Winkel [°]",
            "shoulder_joint Winkel [°]",
            "elbow_joint Moment [Nm]",
            "shoulder_joint Moment [Nm]",
        ],
        ["elbow_joint_deg", "shoulder_joint_deg", "elbow_joint_Nm", "shoulder_joint_Nm"],
        ["robot1/elbow_joint", "robot1/shoulder_joint", "robot1_tau/elbow_joint", "robot1_tau/shoulder_joint"],
    ] {
        let header = format!("t_s,{elbow},{shoulder},{elbows_torque},{shoulders_torque}");
        let pair = |position: &str, torque: &str| (position.to_owned(), torque.to_owned());
        assert_eq!(named(&header, &arm), [pair(shoulder, shoulders_torque), pair(elbow, elbows_torque)]);
    }
    // Of two arms, neither is the robot's for sure; one with just its names is.
    let none = [(String::new(), String::new())];
    assert_eq!(named("left_a_joint.position,right_a_joint.position", &["a_joint"]), none);
    let own = [("a_joint.position".to_owned(), String::new())];
    assert_eq!(named("left_a_joint.position,a_joint.position", &["a_joint"]), own);
    // What its names do not tell the recording says itself.
    assert_eq!(named("q1,tau1", &["q1"]), [("q1".to_owned(), "tau1".to_owned())]);
}

#[test]
fn a_joint_that_moves_without_any_torque_reading_is_one_of_the_arm() {
    let header = "a.position,b.position,finger.position,a.effort,b.effort,finger.effort";
    let found = inspected(&format!("{header}\n0,0,0,1,nan,nan\n1,2,0.04,2,nan,nan\n"));
    let silent: Vec<String> = found.joints_with_silent_torque().into_iter().map(|joint| joint.name).collect();
    assert_eq!(silent, ["b"]);
}

/// A sensor that is stuck, beside a gripper whose torque nothing measures.
#[test]
fn a_joint_that_moves_with_a_torque_that_stands_is_one_of_the_arm() {
    let header = "a.position,b.position,finger.position,a.effort,b.effort,finger.effort";
    let found = inspected(&format!("{header}\n0,0,0,1,0,0\n1.5,2,0.8,2,0,0\n"));
    let names = |joints: Vec<JointFound>| joints.into_iter().map(|joint| joint.name).collect::<Vec<_>>();
    assert_eq!(
        (names(found.joints_with_torque()), names(found.joints_with_silent_torque())),
        (vec!["a".into()], vec!["b".into()])
    );
}

/// As controllers of Universal Robots name what they record.
#[test]
fn a_current_that_was_read_goes_before_a_torque_that_was_asked_for() {
    let all = "actual_q_0,target_moment_0,target_current_0,actual_current_0";
    assert_eq!(pairs(all).0, ["actual_q_0 actual_current_0"]);
    assert_eq!(pairs(&all.replace(",actual_current_0", "")).0, ["actual_q_0 target_moment_0"]);
    assert_eq!(pairs(&format!("{all},actual_torque_0")).0, ["actual_q_0 actual_torque_0"]);
}

#[test]
fn what_may_be_a_clock_is_told() {
    let rows: String = (0..30).map(|row| format!("{},{}\n", 10 * row, row % 7)).collect();
    let text = inspected(&format!("tick,q1\n{rows}")).to_string();
    assert!(text.contains("`tick` rises in every row: if it is one, call it `time_ms`"), "{text}");
    let text = inspected(&format!("q2,q1\n{rows}")).to_string();
    assert!(!text.contains("rises in every row"), "{text}");
}

#[test]
fn a_clock_with_too_few_digits_is_reported() {
    let rows: String = (0..30).map(|row| format!("1.764144e+09,{row}\n")).collect();
    let found = inspected(&format!("t_s,q1\n{rows}"));
    assert!(found.time.as_ref().is_some_and(TimeFound::stands));
    let text = found.to_string();
    assert!(text.contains("The clock stands: 29 of 30 rows have the time of the row before."), "{text}");
    assert!(!thousand("q1", f64::from).to_string().contains("The clock stands"));
}

#[test]
fn an_angle_that_wraps_is_reported_where_rows_are_near_in_time() {
    let angle = |row: u32| (f64::from(row) + 180.0).rem_euclid(360.0) - 180.0;
    let found = thousand("q1_deg", angle);
    assert_eq!(found.columns[0].wraps, 3);
    assert!(found.to_string().contains("jumps by about a full turn 3 times"), "{found}");
    assert_eq!(thousand("tau1", angle).columns[0].wraps, 0);
    let poses: String = (0..9).map(|row| format!("{},{}\n", 10 * row, angle(179 * row))).collect();
    assert!(!inspected(&format!("t_s,q1_deg\n{poses}")).to_string().contains("full turn"));
}
