//! Wrist sensors on a body that somebody turned, from the session's file to the estimate.

use std::fs;

use gravcal_identification::SolveEnvironment;
use gravcal_recording::OrientationForm;
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;
use gravcal_session::read_session;
use gravcal_solvers::LevenbergMarquardt;
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, SensorModelTest, TestKind, UncertaintyResult, Verdict};

const SESSION: &str = r#"
[gravity]
magnitude_m_per_s2 = 9.81
hemisphere = [0, 0, -1]
[readings]
orientation = { columns = ["w", "x", "y", "z"], order = "wxyz", rotation = "base-from-body" }
[[force_torque_sensor]]
name = "wrist"
readings = { columns = ["fx", "fy", "fz", "nx", "ny", "nz"], unit = ["N", "N", "N", "N·m", "N·m", "N·m"], std = [0.1, 0.1, 0.1, 0.01, 0.01, 0.01] }
force_gain = { fixed = 1, unit = "N/N" }
moment_gain = { fixed = 1, unit = "N·m/(N·m)" }
[[poses]]
file = "poses.csv"
"#;

/// True values: gravity leans, as the base is not quite level.
const GRAVITY: [f64; 3] = [0.3, -0.2, -9.803_373];
const MASS: f64 = 1.4;
const MOMENT: [f64; 3] = [0.01, -0.02, 0.07];
const BIAS: [f64; 6] = [3.0, -2.0, 5.0, 0.1, -0.2, 0.3];

/// Something like noise of unit size, the same every time.
fn noise(index: usize) -> f64 {
    (0..3).map(|k| (12.9898 * (index as f64 + 0.37) * (k + 1) as f64).sin()).sum::<f64>() * (2.0_f64 / 3.0).sqrt()
}

/// Rotation of the body in one pose, and what an ideal sensor reads there: `f = −m v`, `n = v × h`, `v = Rᵀ g`.
fn pose(index: usize) -> (UnitQuaternion<f64>, [f64; 6]) {
    let angles = [1.1, 2.3, 3.7].map(|step| step * (index as f64 + 1.0));
    let turned = UnitQuaternion::from_euler_angles(angles[0], angles[1].sin(), angles[2]);
    let seen = turned.inverse() * Vector3::from(GRAVITY);
    let (force, moment) = (-MASS * seen, seen.cross(&Vector3::from(MOMENT)));
    (turned, [force.x, force.y, force.z, moment.x, moment.y, moment.z])
}

/// A table of 40 poses: the cells that `orientation` makes of the rotation, and the readings, turned by `sign`.
fn table(head: &str, sign: f64, orientation: impl Fn(&UnitQuaternion<f64>) -> Vec<f64>) -> String {
    let mut text = format!("{head},fx,fy,fz,nx,ny,nz\n");
    for index in 0..40 {
        let (turned, sensed) = pose(index);
        let read = |axis: usize| {
            let std = if axis < 3 { 0.1 } else { 0.01 };
            sign * sensed[axis] + BIAS[axis] + std * noise(6 * index + axis)
        };
        let cells: Vec<String> =
            orientation(&turned).into_iter().chain((0..6).map(read)).map(|cell| format!("{cell:.6}")).collect();
        text += &format!("{}\n", cells.join(","));
    }
    text
}

fn wxyz(turned: &UnitQuaternion<f64>) -> Vec<f64> {
    let Quaternion { coords } = turned.into_inner();
    vec![coords.w, coords.x, coords.y, coords.z]
}

fn read(session: &str, table: &str) -> Result<Session, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("session.toml"), session).unwrap();
    fs::write(folder.path().join("poses.csv"), table).unwrap();
    let shown = format!("{}/", folder.path().display());
    read_session(&folder.path().join("session.toml")).map_err(|error| error.to_string().replace(&shown, ""))
}

fn estimated(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

/// Value and standard deviation of a parameter.
fn found(result: &EstimatorResult, name: &str) -> (f64, f64) {
    let parameter = result.parameters.iter().find(|parameter| parameter.name == name).unwrap();
    (parameter.value.unwrap(), parameter.std.unwrap())
}

/// Every value lies where the truth is, within its own standard deviations.
fn assert_true(result: &EstimatorResult) {
    assert_eq!(result.verdict, Verdict::Determined, "{:?} {:?}", result.undetermined, result.notes);
    let truth = [("tool_mass", MASS), ("tool_moment_x", MOMENT[0]), ("tool_moment_y", MOMENT[1])];
    let biases = ["bias_fx", "bias_fy", "bias_fz", "bias_nx", "bias_ny", "bias_nz"].into_iter().zip(BIAS);
    for (name, truth) in truth.into_iter().chain([("tool_moment_z", MOMENT[2])]).chain(biases) {
        let (value, std) = found(result, &format!("wrist.{name}"));
        assert!((value - truth).abs() < 4.0 * std && std < 0.05, "{name}: {value} ± {std}, not {truth}");
    }
    let gravity = result.gravity.as_ref().unwrap();
    for ((value, std), truth) in gravity.vector_m_per_s2.iter().zip(gravity.std_m_per_s2).zip(GRAVITY) {
        assert!((value - truth).abs() < 4.0 * std.max(1e-4) && std < 0.05, "{value} ± {std}, not {truth}");
    }
}

/// A body that stood a degree from where its orientations say: what is read in one pose errs together, and intervals from noise of one size are too narrow.
#[test]
fn orientations_that_err_from_pose_to_pose_widen_what_is_told() {
    let place = std::cell::Cell::new(0);
    let off = |turned: &UnitQuaternion<f64>| {
        let first = place.replace(place.get() + 3);
        let turn = Vector3::from_fn(|axis, _| 0.02 * noise(1000 + first + axis));
        wxyz(&(UnitQuaternion::from_scaled_axis(turn) * turned))
    };
    let text = SESSION.replace(", std = [0.1, 0.1, 0.1, 0.01, 0.01, 0.01]", "");
    let result = estimated(&read(&text, &table("w,x,y,z", 1.0, off)).unwrap());
    let told = |note: &String| note.contains("as if the body were turned by");
    assert!(result.notes.iter().any(told), "{:?}", result.notes);
    assert!(matches!(result.uncertainty, Some(UncertaintyResult::LargerOfNoiseAndJackknife { .. })));
    let sound = estimated(&read(&text, &table("w,x,y,z", 1.0, wxyz)).unwrap());
    assert!(!sound.notes.iter().any(told), "{:?}", sound.notes);
}

#[test]
fn a_wrist_sensor_is_calibrated_by_how_it_stood() {
    let session = read(SESSION, &table("w,x,y,z", 1.0, wxyz)).unwrap();
    assert!(session.joints.is_empty() && session.inputs.len() == 2);
    assert_eq!(session.readings.orientation.as_ref().unwrap().form, OrientationForm::QuaternionWxyz);
    assert_true(&estimated(&session));
}

/// Of each axis few readings are left to tell its noise: by itself the quietest would draw the fit, and seem quieter still.
#[test]
fn a_wrist_sensor_without_std_that_is_read_in_few_poses_is_not_told_too_well() {
    let text = SESSION.replace(", std = [0.1, 0.1, 0.1, 0.01, 0.01, 0.01]", "");
    let all = table("w,x,y,z", 1.0, wxyz);
    let (head, rows) = all.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let moment = ["tool_moment_x", "tool_moment_y", "tool_moment_z"].into_iter().zip(MOMENT);
    let truth: Vec<(&str, f64)> = [("tool_mass", MASS)].into_iter().chain(moment).collect();
    let mut told = 0;
    for few in (3..=6).flat_map(|poses| rows.chunks_exact(poses)) {
        let result = estimated(&read(&text, &format!("{head}\n{}\n", few.join("\n"))).unwrap());
        for (name, truth) in &truth {
            let parameter = result.parameters.iter().find(|own| own.name == format!("wrist.{name}")).unwrap();
            let (Some(value), Some(std)) = (parameter.value, parameter.std) else { continue };
            assert!((value - truth).abs() < 4.0 * std, "{} poses, {name}: {value} ± {std}, not {truth}", few.len());
            told += 1;
        }
    }
    assert!(told > 100, "{told}");
}

#[test]
fn newtons_of_a_wrist_sensor_go_with_newton_metres() {
    let poses = table("w,x,y,z", 1.0, wxyz);
    let units = "[\"N\", \"N\", \"N\", \"N·m\", \"N·m\", \"N·m\"]";
    assert_eq!(SESSION.matches(units).count(), 1);
    assert_eq!(read(&SESSION.replace(units, "\"N\""), &poses).unwrap().further, read(SESSION, &poses).unwrap().further);
    let message = read(&SESSION.replace(units, "\"kg\""), &poses).unwrap_err();
    assert!(message.contains(&format!("or one for each axis, such as {units}")), "{message}");
    let message = read(&SESSION.replace("fixed = 1, unit = \"N/N\"", "nominal = 4, unit = \"N/count\""), &poses);
    assert!(message.unwrap_err().contains("the unit `N/count` does not fit: expected N/N"));
}

#[test]
fn the_same_orientations_may_be_written_otherwise() {
    let written = "columns = [\"w\", \"x\", \"y\", \"z\"], order = \"wxyz\", rotation = \"base-from-body\"";
    let columns = "columns = [\"x\", \"y\", \"z\", \"w\"], order = \"xyzw\", rotation = \"body-from-base\"";
    let inverse = table("w,x,y,z", 1.0, |turned| wxyz(&turned.inverse()));
    assert_true(&estimated(&read(&SESSION.replace(written, columns), &inverse).unwrap()));
    let columns =
        "columns = [\"a\", \"b\", \"c\", \"d\", \"e\", \"f\", \"g\", \"h\", \"i\"], rotation = \"base-from-body\"";
    let matrix = table("a,b,c,d,e,f,g,h,i", 1.0, |turned| {
        let rotation: Rotation3<f64> = turned.to_rotation_matrix();
        rotation.matrix().transpose().iter().copied().collect()
    });
    assert_true(&estimated(&read(&SESSION.replace(written, columns), &matrix).unwrap()));
}

#[test]
fn what_is_not_said_of_an_orientation_is_asked_for() {
    let poses = table("w,x,y,z", 1.0, wxyz);
    let refused = |old: &str, new: &str| {
        assert_eq!(SESSION.matches(old).count(), 1, "{old}");
        read(&SESSION.replace(old, new), &poses).unwrap_err()
    };
    let message = refused(", order = \"wxyz\"", "");
    assert!(message.contains("readings.orientation.order: does the real part"), "{message}");
    let message = refused(", rotation = \"base-from-body\"", "");
    assert!(message.contains("readings.orientation.rotation: which way does it turn?"), "{message}");
    let message = refused("\"y\", \"z\"]", "\"y\"]");
    assert!(message.contains("found 3"), "{message}");
    let message = refused("[readings]\n", "[readings]\nposition = { columns = [\"x\"], unit = \"rad\" }\n");
    assert!(message.contains("readings.position: there are no joints"), "{message}");
    let message = refused("orientation = {", "# {");
    assert!(message.contains("robot: which robot?"), "{message}");
    let swapped = refused("[\"w\", \"x\", \"y\", \"z\"]", "[\"fx\", \"x\", \"y\", \"z\"]");
    assert!(swapped.contains("column `fx` is mapped to two readings"), "{swapped}");
}

#[test]
fn cells_that_are_no_rotation_are_refused_with_their_line() {
    let poses = table("w,x,y,z", 1.0, |turned| wxyz(turned).iter().map(|part| 1.02 * part).collect());
    let message = read(SESSION, &poses).unwrap_err();
    assert!(message.starts_with("poses.csv:2: column `w`: expected the orientation"), "{message}");
    assert!(message.contains("a quaternion of length 1.0200"), "{message}");
    let empty = "w,x,y,z,fx,fy,fz,nx,ny,nz\n1,0,0,0,1,2,3,4,5,6\n1,0,,0,1,2,3,4,5,6\n";
    let message = read(SESSION, empty).unwrap_err();
    assert!(message.starts_with("poses.csv:3: column `y`: the cell is empty"), "{message}");
}

#[test]
fn equal_rows_are_merged_only_where_the_body_stood_alike() {
    let session = SESSION.replace("[readings]", "[readings]\nmerge_repeated_rows = true");
    let text = "w,x,y,z,fx,fy,fz,nx,ny,nz\n1,0,0,0,1,2,3,4,5,6\n1,0,0,0,3,2,3,4,5,6\n0,1,0,0,1,2,3,4,5,6\n";
    let session = read(&session, text).unwrap();
    let forces: Vec<f64> = session.poses.iter().map(|pose| pose.instruments[0].unwrap().value).collect();
    assert_eq!(forces, [2.0, 1.0]);
}

#[test]
fn a_sensor_that_reads_the_other_way_is_found_or_declared() {
    let poses = table("w,x,y,z", -1.0, wxyz);
    let result = estimated(&read(SESSION, &poses).unwrap());
    assert_eq!(result.verdict, Verdict::Failed);
    let reported = result.notes.iter().any(|note| note.contains("sign = \"reversed\" in its [[force_torque_sensor]]"));
    assert!(reported, "{:?}", result.notes);
    let declared = SESSION.replace("name = \"wrist\"", "name = \"wrist\"\nsign = \"reversed\"");
    let session = read(&declared, &poses).unwrap();
    assert_eq!(session.nominal(ParameterId::Further(0)), -1.0);
    assert_true(&estimated(&session));
    let at_its_word = SESSION.replace("name = \"wrist\"", "name = \"wrist\"\nsign = \"normal\"");
    let result = estimated(&read(&at_its_word, &poses).unwrap());
    assert!(found(&result, "wrist.tool_mass").0 < 0.0, "taken at its word");
}

/// Nothing stated but the tool's mass, to this; neither gravity's hemisphere nor any noise.
fn weighed(std: &str) -> String {
    let mass = format!("tool_mass = {{ nominal = 1.4, std = {std}, unit = \"kg\" }}\nmoment_gain");
    let bare =
        SESSION.replace("hemisphere = [0, 0, -1]\n", "").replace("force_gain = { fixed = 1, unit = \"N/N\" }\n", "");
    bare.replace(", std = [0.1, 0.1, 0.1, 0.01, 0.01, 0.01]", "").replace("moment_gain", &mass)
}

#[test]
fn the_better_the_mass_of_the_tool_is_known_the_better_are_the_gains() {
    let poses = table("w,x,y,z", 1.0, wxyz);
    let mut before = f64::INFINITY;
    for std in ["0.01", "0.003", "0.002", "0.001", "0.0001"] {
        let result = estimated(&read(&weighed(std), &poses).unwrap());
        assert_eq!(result.verdict, Verdict::Determined, "{std}: {:?} {:?}", result.undetermined, result.notes);
        let (value, of_gain) = found(&result, "wrist.gain_fx");
        assert!((value - 1.0).abs() < 4.0 * of_gain && of_gain < before, "{std}: {value} ± {of_gain}");
        before = of_gain;
    }
    assert!(before < 0.003, "{before}");
}

/// Gravity the other way up and a tool of negative mass read the same.
#[test]
fn no_assumed_mass_tells_which_way_gravity_points() {
    let session = SESSION.replace("hemisphere = [0, 0, -1]\n", "");
    let result = estimated(&read(&session, &table("w,x,y,z", 1.0, wxyz)).unwrap());
    assert!(result.verdict == Verdict::PartlyDetermined && result.gravity.is_none(), "{:?}", result.gravity);
    let reported: Vec<&str> = result.parameters.iter().filter(|p| p.value.is_some()).map(|p| p.name.as_str()).collect();
    assert!(
        reported.iter().all(|name| !name.starts_with("wrist.tool_")) && reported.contains(&"wrist.bias_fx"),
        "{reported:?}"
    );
    assert!(result.notes.iter().all(|note| !note.contains("centre of mass")), "{:?}", result.notes);
}

#[test]
fn the_cure_of_a_common_scale_states_what_is_not_stated_yet() {
    let poses = table("w,x,y,z", 1.0, wxyz);
    let cure = |session: &str, parameter: &str| {
        let result = estimated(&read(session, &poses).unwrap());
        let open = result.undetermined.iter().find(|open| open.parameters.iter().any(|name| name == parameter));
        open.map(|open| open.cure.clone()).unwrap_or_else(|| panic!("{:?}", result.undetermined))
    };
    let forces = SESSION.replace("force_gain = { fixed = 1, unit = \"N/N\" }\n", "");
    let reported = cure(&forces, "wrist.gain_fx");
    assert!(
        reported.contains("force_gain = { fixed = 1, unit = \"N/N\" }; or state tool_mass; or record"),
        "{reported}"
    );
    let stated = weighed("0.001").replace("moment_gain = { fixed = 1, unit = \"N·m/(N·m)\" }\n", "");
    let reported = cure(&stated, "wrist.gain_nx");
    assert!(
        reported.contains("moment_gain = { fixed = 1, unit = \"N·m/(N·m)\" }; or state tool_moment_x"),
        "{reported}"
    );
    assert!(!reported.contains("tool_mass"), "{reported}");
    let rough = forces.replace("moment_gain", "tool_mass = { nominal = 1.4, std = 1, unit = \"kg\" }\nmoment_gain");
    let reported = cure(&rough, "wrist.gain_fx");
    assert!(reported.contains("force_gain = ") && !reported.contains("tool_mass"), "{reported}");
}

#[test]
fn of_a_reversed_sensor_whose_scale_is_open_no_mass_is_reported() {
    let poses = table("w,x,y,z", -1.0, wxyz);
    let note = |session: &str| {
        let result = estimated(&read(session, &poses).unwrap());
        let note = result.notes.into_iter().find(|note| note.contains("sign = \"reversed\" in its"));
        note.unwrap()
    };
    assert!(note(SESSION).starts_with("The mass of what hangs beyond wrist would be negative, -1.4"));
    let open = note(&SESSION.replace("force_gain = { fixed = 1, unit = \"N/N\" }\n", ""));
    assert!(open.starts_with("The mass of what hangs beyond wrist would be negative: it reads"), "{open}");
}

/// The same poses in two tables, between which the sensor was zeroed.
fn zeroed_between() -> (String, [String; 2]) {
    let text = table("w,x,y,z", 1.0, wxyz);
    let (head, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let zeroed = |row: &&str| {
        let cells = row.split(',').enumerate();
        let moved = cells.map(|(place, cell)| match place.checked_sub(4) {
            Some(axis) => (cell.parse::<f64>().unwrap() - BIAS[axis] + ZEROED[axis]).to_string(),
            None => cell.to_owned(),
        });
        moved.collect::<Vec<_>>().join(",")
    };
    let later: Vec<String> = rows[20..].iter().map(zeroed).collect();
    let tables = [rows[..20].join("\n"), later.join("\n")].map(|rows| format!("{head}\n{rows}\n"));
    (format!("{SESSION}[[poses]]\nfile = \"later.csv\"\n"), tables)
}

/// The biases after it was zeroed.
const ZEROED: [f64; 6] = [-1.0, 0.5, 2.0, -0.02, 0.01, 0.05];

#[test]
fn a_sensor_zeroed_between_tables_has_a_bias_in_each() {
    let (text, [first, later]) = zeroed_between();
    let read = |session: &str| {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("session.toml", session), ("poses.csv", &first), ("later.csv", &later)] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        read_session(&folder.path().join("session.toml")).unwrap()
    };
    assert_ne!(estimated(&read(&text)).verdict, Verdict::Determined, "one bias for both explains nothing");
    let session = read(&text.replace("name = \"wrist\"", "name = \"wrist\"\nbiases = \"table\""));
    let result = estimated(&session);
    assert_eq!(result.verdict, Verdict::Determined, "{:?} {:?}", result.undetermined, result.notes);
    for (axis, name) in ["fx", "fy", "fz", "nx", "ny", "nz"].into_iter().enumerate() {
        for (number, truth) in [(1, BIAS[axis]), (2, ZEROED[axis])] {
            let (value, std) = found(&result, &format!("wrist.bias_{name}_{number}"));
            assert!((value - truth).abs() < 4.0 * std && std < 0.1, "{name}: {value} ± {std}, not {truth}");
        }
    }
    let [test] = <[SensorModelTest; 1]>::try_from(result.sensor_models.clone()).unwrap();
    assert_eq!((test.joint.as_str(), test.model.as_str(), test.parameters.len()), ("wrist", "biases-of-tables", 12));
    let reported = test.test.unwrap();
    assert!(
        reported.kind == TestKind::LikelihoodRatio
            && reported.degrees_of_freedom == [Some(6), None]
            && reported.p_value < 1e-9,
        "{reported:?}"
    );
    let (mass, std) = found(&result, "wrist.tool_mass");
    assert!((mass - MASS).abs() < 4.0 * std && std < 0.01, "{mass} ± {std}");
    let report = crate::check::check(&session).unwrap();
    assert!(report.complete && report.tilts.is_empty());
    // A sensor that was not zeroed needs but one.
    let all = table("w,x,y,z", 1.0, wxyz);
    let (head, rows) = all.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let halves = [&rows[..20], &rows[20..]].map(|rows| format!("{head}\n{}\n", rows.join("\n")));
    let folder = tempfile::tempdir().unwrap();
    let by_table = text.replace("name = \"wrist\"", "name = \"wrist\"\nbiases = \"table\"");
    for (name, text) in [("session.toml", &by_table), ("poses.csv", &halves[0]), ("later.csv", &halves[1])] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let same = estimated(&read_session(&folder.path().join("session.toml")).unwrap());
    assert!(same.sensor_models[0].test.as_ref().unwrap().p_value > 1e-3, "{:?}", same.sensor_models);
    // Of a second bias no reading tells where the second table has none of its axis.
    let forces = |row: &str| row.split(',').take(7).chain([""; 3]).collect::<Vec<_>>().join(",");
    let (head, rows) = later.split_once('\n').unwrap();
    let forces: String = rows.lines().map(|row| forces(row) + "\n").collect();
    let forces = format!("{head}\n{forces}");
    let folder = tempfile::tempdir().unwrap();
    let text = text.replace("name = \"wrist\"", "name = \"wrist\"\nbiases = \"table\"");
    for (name, text) in [("session.toml", &text), ("poses.csv", &first), ("later.csv", &forces)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let result = estimated(&read_session(&folder.path().join("session.toml")).unwrap());
    let open = result.parameters.iter().filter(|parameter| !parameter.determined).map(|p| p.name.as_str());
    assert_eq!(open.collect::<Vec<_>>(), ["nx", "ny", "nz"].map(|axis| format!("wrist.bias_{axis}_2")));
}

#[test]
fn wrenches_in_the_base_frame_are_turned_back() {
    let text = table("w,x,y,z", 1.0, wxyz);
    let sensor = read(SESSION, &text).unwrap();
    let mut turned = text.lines().next().unwrap().to_owned() + "\n";
    for (index, row) in text.lines().skip(1).enumerate() {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let in_base = |first: usize| pose(index).0 * Vector3::from_column_slice(&cells[first..first + 3]);
        let cells = cells[..4].iter().chain(&in_base(4)).chain(&in_base(7)).map(f64::to_string).collect::<Vec<_>>();
        turned += &format!("{}\n", cells.join(","));
    }
    let base = SESSION.replace("name = \"wrist\"", "name = \"wrist\"\nframe = \"base\"");
    let session = read(&base, &turned).unwrap();
    for (own, turned) in sensor.poses.iter().zip(&session.poses) {
        for (own, turned) in own.instruments.iter().flatten().zip(turned.instruments.iter().flatten()) {
            assert!((own.value - turned.value).abs() < 1e-4, "{own:?} {turned:?}");
            assert!((own.std.unwrap() / turned.std.unwrap() - 1.0).abs() < 1e-12, "{own:?} {turned:?}");
        }
    }
    assert_true(&estimated(&session));
    assert!(session.further[0].convention.contains("turned from the base's frame"));
    // A missing component leaves nothing to turn.
    let missing = turned.replacen(turned.lines().nth(1).unwrap().split(',').nth(5).unwrap(), "", 1);
    let session = read(&base, &missing).unwrap();
    assert_eq!(session.poses[0].instruments.iter().filter(|reading| reading.is_some()).count(), 3);
    let message = read(&base.replace("\"fy\", ", "\"\", "), &turned).unwrap_err();
    assert!(message.contains("force_torque_sensor[0].frame: only three axes of one unit"), "{message}");
}

/// The table of poses with a time and a temperature, with which the biases of all axes drift by so many standard deviations an
/// hour or a kelvin.
fn drifting(in_time: f64, with_temperature: f64) -> String {
    let text = table("w,x,y,z", 1.0, wxyz);
    let mut drifting = format!("t,T,{}\n", text.lines().next().unwrap());
    for (index, row) in text.lines().skip(1).enumerate() {
        let (time, temperature) = (360.0 * index as f64, 25.0 + 4.0 * (0.9 * index as f64).sin());
        let drift = in_time * time / 3600.0 + with_temperature * (temperature - 25.0);
        let cells = row.split(',').map(|cell| cell.parse::<f64>().unwrap()).enumerate();
        let moved = cells.map(|(place, cell)| match place {
            0..4 => cell,
            4..7 => cell + 0.1 * drift,
            _ => cell + 0.01 * drift,
        });
        let cells: Vec<String> = moved.map(|cell| format!("{cell:.7}")).collect();
        drifting += &format!("{time},{temperature},{}\n", cells.join(","));
    }
    drifting
}

#[test]
fn drifts_of_a_wrist_sensor_are_found() {
    let poses = drifting(5.0, 2.0);
    let conditions = "time = { column = \"t\", unit = \"s\" }\ntemperature = { columns = \"T\", unit = \"degC\" }\n";
    let models =
        "sensor_models = [{ kind = \"bias-in-time\" }, { kind = \"bias-with-temperature\", reference_degC = 25 }]\n";
    let constant = SESSION.replace("[readings]\n", &format!("[readings]\n{conditions}"));
    assert_ne!(estimated(&read(&constant, &poses).unwrap()).verdict, Verdict::Determined);
    let declared = constant.replace("name = \"wrist\"\n", &format!("name = \"wrist\"\n{models}"));
    let result = estimated(&read(&declared, &poses).unwrap());
    assert_true(&result);
    for (axis, noise) in [("fx", 0.1), ("fz", 0.1), ("ny", 0.01)] {
        for (name, truth) in [("drift", noise * 5.0 / 3600.0), ("temperature_drift", noise * 2.0)] {
            let (value, std) = found(&result, &format!("wrist.bias_{axis}_{name}"));
            assert!(
                (value - truth).abs() < 4.0 * std && std < 0.2 * truth,
                "{axis} {name}: {value} ± {std}, not {truth}"
            );
        }
    }
    let needed = |result: &EstimatorResult| {
        let reported = |test: &SensorModelTest| {
            let p = test.test.as_ref().unwrap().p_value;
            assert_eq!((test.joint.as_str(), test.parameters.len()), ("wrist", 6));
            (test.model.clone(), p)
        };
        result.sensor_models.iter().map(reported).collect::<Vec<_>>()
    };
    let [(time, of_time), (temperature, of_temperature)] = needed(&result).try_into().unwrap();
    assert_eq!((time.as_str(), temperature.as_str()), ("bias-in-time", "bias-with-temperature"));
    assert!(of_time < 1e-6 && of_temperature < 1e-6, "{of_time} {of_temperature}");
    let still = estimated(&read(&declared, &drifting(0.0, 0.0)).unwrap());
    assert!(needed(&still).iter().all(|(_, p)| *p > 1e-3), "{:?}", still.sensor_models);
    let refused = |text: String| read(&text, &poses).unwrap_err();
    let message = refused(declared.replace("time = { column = \"t\", unit = \"s\" }\n", ""));
    assert!(message.contains("readings.time: a bias that drifts with time"), "{message}");
    let message = refused(declared.replace("temperature = { columns = \"T\", unit = \"degC\" }\n", ""));
    assert!(message.contains("readings.temperature: a bias that drifts with temperature"), "{message}");
    let message = refused(declared.replace(", reference_degC = 25", ""));
    assert!(message.contains("sensor_models[1].reference_degC: at which temperature"), "{message}");
}

#[test]
fn orientations_that_turn_the_other_way_are_named() {
    let inverse = table("w,x,y,z", 1.0, |turned| wxyz(&turned.inverse()));
    let result = estimated(&read(SESSION, &inverse).unwrap());
    assert_eq!(result.verdict, Verdict::Failed);
    let reported =
        result.notes.iter().any(|note| note.contains("rotation = \"body-from-base\" in readings.orientation"));
    assert!(reported, "{:?}", result.notes);
}

/// In the order of the columns, or by how the sensor is mounted.
#[test]
fn exchanged_axes_of_a_wrist_sensor_are_named() {
    let poses = table("w,x,y,z", 1.0, wxyz);
    for (old, new, reported) in [
        (
            "\"fx\", \"fy\", \"fz\", \"nx\", \"ny\", \"nz\"",
            "\"fy\", \"fx\", \"fz\", \"ny\", \"nx\", \"nz\"",
            "x, y, z are in the columns of y, x, z",
        ),
        (
            "\"fx\", \"fy\", \"fz\", \"nx\", \"ny\", \"nz\"",
            "\"fy\", \"fz\", \"fx\", \"ny\", \"nz\", \"nx\"",
            "x, y, z are in the columns of z, x, y",
        ),
        (
            "\"fx\", \"fy\", \"fz\", \"nx\", \"ny\", \"nz\"",
            "\"fx\", \"fy\", \"fz\", \"ny\", \"nx\", \"nz\"",
            "swapped columns: wrist.nx and wrist.ny",
        ),
        (
            "\"fx\", \"fy\", \"fz\", \"nx\", \"ny\", \"nz\"",
            "\"fz\", \"fy\", \"fx\", \"nx\", \"ny\", \"nz\"",
            "swapped columns: wrist.fx and wrist.fz",
        ),
        (
            "name = \"wrist\"",
            "name = \"wrist\"\nmounting = { rpy_deg = [0, 0, 90] }",
            "its mounting is turned by rpy_deg = [0, 0, -90] besides",
        ),
        (
            "name = \"wrist\"",
            "name = \"wrist\"\nmounting = { rpy_deg = [180, 0, 0] }",
            "x, y, z are in the columns of x, -y, -z",
        ),
    ] {
        assert_eq!(SESSION.matches(old).count(), 1, "{old}");
        let result = estimated(&read(&SESSION.replace(old, new), &poses).unwrap());
        assert_eq!(result.verdict, Verdict::Failed, "{reported}");
        assert!(result.notes[0].contains(reported), "{reported}: {} {:?}", result.termination, result.notes);
    }
}

#[test]
fn robust_standard_deviations_go_by_its_poses() {
    let session = format!("{SESSION}[uncertainty]\nkind = \"sandwich\"\nblock_poses = 1\n");
    let result = estimated(&read(&session, &table("w,x,y,z", 1.0, wxyz)).unwrap());
    assert_true(&result);
    assert_eq!(result.uncertainty, Some(UncertaintyResult::Sandwich { blocks: 40, block_poses: 1 }));
}
