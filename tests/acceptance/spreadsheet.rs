//! Recordings as spreadsheets and pandas write them: dates with times, degrees, no header; and what is told where a unit is mistaken.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::program::{Run, gravcal_in};
use crate::small_session;

const ROBOT: &str = r#"
name = "my-arm"
convention = "standard-dh"
[[joint]]
name = "joint1"
a_m = 0.0
alpha_deg = 90.0
d_m = 0.36
mass_kg = 4.0
center_of_mass_m = [0.0, -0.1, 0.02]
[[joint]]
name = "joint2"
a_m = 0.4
alpha_deg = 0.0
d_m = 0.0
mass_kg = 3.0
center_of_mass_m = [-0.2, 0.0, 0.03]
"#;

const SIMULATION: &str = r#"robot = "robot.toml"
seed = 1
gravity = { direction = [0.3, 0.1, -1.0], magnitude_m_per_s2 = 9.80665 }
torque = { unit = "N·m", std = 0.02 }
position = { unit = "rad" }
recording = { rate_hz = 200, samples = 60, move_s = 0.5, settling_s = 0.2 }
random = [{ file = "bare.csv", poses = 12 }]
"#;

const NAMES: &str = "when,q1_deg,q2_deg,tau1_Nm,tau2_Nm";

/// A folder with `sheet.csv`: no header, and dates with times in place of seconds, without decimals where these are zero.
fn sheet() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    fs::write(file("robot.toml"), ROBOT).unwrap();
    fs::write(file("simulation.toml"), SIMULATION).unwrap();
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    fs::remove_file(file("session.toml")).unwrap(); // one is drawn up from the sheet alone
    let simulated = fs::read_to_string(file("bare.csv")).unwrap();
    let rows = simulated.lines().filter(|line| !line.starts_with('#')).skip(1);
    let dated = rows.map(|row| {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [seconds, q1, q2, tau1, tau2] = cells[..] else { panic!("{row}") };
        let cells = format!("{},{},{tau1},{tau2}", q1.to_degrees(), q2.to_degrees());
        let microseconds = (seconds * 1e6).round() as u64;
        let (whole, part) = (microseconds / 1_000_000, microseconds % 1_000_000);
        let part = if part == 0 { String::new() } else { format!(".{part:06}") };
        format!("2024-05-01 12:00:{whole:02}{part},{cells}\n")
    });
    fs::write(file("sheet.csv"), dated.collect::<String>()).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Run {
    gravcal_in(folder, arguments)
}

#[test]
fn a_sheet_without_a_header_goes_from_recording_to_verdict() {
    let folder = sheet();
    let run = |arguments: &[&str]| run(folder.path(), arguments);
    let drafted =
        run(&["inspect", "sheet.csv", "--columns", NAMES, "--robot", "robot.toml", "--session", "session.toml"]);
    assert_eq!(drafted.code, 0, "{drafted:?}");
    for reported in ["from 2024-05-01T12:00:00.000Z on, 200.0 Hz (`when` in ISO 8601)", "12 standstills found"] {
        assert!(drafted.stdout.contains(reported), "{reported}: {}", drafted.stdout);
    }
    let calibrated = run(&["calibrate", "--full", "session.toml"]);
    assert!(calibrated.code == 3 && calibrated.stdout.starts_with("Calibration of my-arm\n"), "{calibrated:?}");
    let applied = ["apply", "calibration/calibration.json", "sheet.csv", "true.csv", "--nominal", "--columns", NAMES];
    let applied = run(&applied);
    assert_eq!(applied.code, 0, "{applied:?}");
    assert!(fs::read_to_string(folder.path().join("true.csv")).unwrap().contains("\n2024-05-01 12:00:00.005000,"));

    let few = run(&["inspect", "sheet.csv", "--columns", "when,q1"]);
    assert_eq!(few.refusal(&["its rows have 5 cells, and 2 columns are named for files without a header"]), None);
    let twice = run(&["inspect", "sheet.csv", "--columns", "when,q1,q1,a,b"]);
    assert_eq!(twice.refusal(&["--columns: column 3 has the name of another one"]), None);
    let own = run(&["inspect", "bare.csv", "--columns", NAMES]);
    assert_eq!(own.refusal(&["this file names its columns itself: time_s, joint1.position"]), None);
}

/// The same numbers declared as radians: told first, by `check` too, and kept in what is written.
#[test]
fn a_mistaken_unit_is_reported_before_all_else() {
    let folder = sheet();
    let run = |arguments: &[&str]| run(folder.path(), arguments);
    let drafted =
        run(&["inspect", "sheet.csv", "--columns", NAMES, "--robot", "robot.toml", "--session", "session.toml"]);
    assert_eq!(drafted.code, 0, "{drafted:?}");
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    let mistaken = session.replace("unit = \"deg\"", "unit = \"rad\"");
    assert_ne!(session, mistaken);
    fs::write(folder.path().join("mistaken.toml"), mistaken).unwrap();
    let reported = |text: &str| {
        let plain = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let first = "Look at this first - As declared, angles of joint1, joint2 reach ";
        plain.starts_with(first) && plain.contains("look like deg, and are declared as rad. If so, say unit = \"deg\"")
    };
    let checked = run(&["check", "--full", "mistaken.toml"]);
    assert!(reported(&checked.stdout), "{checked:?}");
    let calibrated = run(&["calibrate", "--full", "mistaken.toml"]);
    assert!(reported(&calibrated.stdout), "{calibrated:?}");
    let results = folder.path().join("mistaken-calibration");
    let table = fs::read_to_string(results.join("table.txt")).unwrap();
    assert!(reported(&table) && calibrated.stdout.starts_with(&table), "{table}");
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(results.join("calibration.json")).unwrap()).unwrap();
    assert_eq!(json["doubts"].as_array().unwrap().len(), 1);
    assert!(fs::read_to_string(results.join("report.html")).unwrap().contains("Look at this first"));
}

/// Masses in another unit than kg put all torque gains off alike, which the fit does not show: told first, and kept in what is written.
#[test]
fn a_load_ten_times_too_heavy_is_asked_about_before_all_else() {
    let folder = small_session::small_session();
    let file = folder.path().join("session.toml");
    let session = fs::read_to_string(&file).unwrap();
    fs::write(&file, session.replace("mass_kg = 1.724", "mass_kg = 17.24")).unwrap();
    let run = small_session::calibrate(folder.path());
    assert_eq!(run.code, 3, "{run:?}");
    let first = "Look at this first\n  - All torque gains are 0.099 times what is nominal: ";
    assert!(run.stdout.starts_with(first), "{run:?}");
    let results = folder.path().join(small_session::RESULTS);
    let written = |name: &str| fs::read_to_string(results.join(name)).unwrap();
    assert!(written("table.txt").starts_with(first));
    let json: serde_json::Value = serde_json::from_str(&written("calibration.json")).unwrap();
    let doubts = json["doubts"].as_array().unwrap();
    assert!(doubts.len() == 1 && doubts[0].as_str().unwrap().contains("plate-a 17.24 kg"), "{doubts:?}");
    let page = written("report.html");
    assert!(page.contains("Look at this first") && page.contains("Determined, with a warning"));
}

/// What the session makes doubtful is told before the solve, what came out after it: under one heading each.
#[test]
fn doubts_have_one_heading_before_the_solve_and_another_after_it() {
    let folder = small_session::small_session();
    let change = |name: &str, from: &str, to: &str| {
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(text.contains(from), "{text}");
        fs::write(folder.path().join(name), text.replace(from, to)).unwrap();
    };
    change("session.toml", "mass_kg = 1.724", "mass_kg = 17.24");
    change("robot.toml", "\nmass_kg = ", "\nmass_kg = 10000");
    let run = small_session::calibrate(folder.path());
    let headings = ["Look at this first\n", "Look at this, too\n"].map(|heading| run.stdout.matches(heading).count());
    assert_eq!(headings, [1, 1], "{run:?}");
    let table = fs::read_to_string(folder.path().join(small_session::RESULTS).join("table.txt")).unwrap();
    assert!(table.starts_with("Look at this first\n") && table.matches("Look at this").count() == 1, "{table}");
}

/// A recording in motion whose clock is lost is no table of static poses, and that is said.
#[test]
fn rows_in_motion_without_a_clock_are_asked_about() {
    let folder = sheet();
    let sheet = fs::read_to_string(folder.path().join("sheet.csv")).unwrap();
    let rows: String = sheet.lines().map(|row| format!("{}\n", row.split_once(',').unwrap().1)).collect();
    fs::write(folder.path().join("lost.csv"), format!("{}\n{rows}", NAMES.split_once(',').unwrap().1)).unwrap();
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for more in [&["--robot", "robot.toml", "--session", "lost.toml"][..], &[]] {
        let drafted = run(folder.path(), &[&["inspect", "lost.csv"], more].concat());
        let reported = "is taken as a static pose, but neighbours differ by little and in order";
        assert!(drafted.code == 0 && plain(&drafted.stdout).contains(reported), "{drafted:?}");
    }
    let checked = run(folder.path(), &["check", "--full", "lost.toml"]);
    assert!(plain(&checked.stdout).starts_with("Look at this first - Each of the "), "{checked:?}");
}
