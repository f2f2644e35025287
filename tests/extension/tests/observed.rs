//! The program with residuals of this crate: what was observed besides torques, computed from a simulation's truth, in columns of its
//! tables; unknowns of theirs and of the arm come out within their intervals.

use std::path::Path;
use std::process::{Command, Output};

use gravcal::calibration::simulation::Simulation;
use gravcal::calibration::{Session, State, read_session_with};
use gravcal_extension::registry;
use serde_json::Value;

const ROBOT: &str = "../../models/sarcos-dextrous-arm/robot.toml";

/// What is observed, and how well.
const RESIDUALS: &str = r#"
[[residual]]
kind = "dial-gauge"
name = "gauge"
link = "link3"
point_m = [0.1, 0.05, 0.4]
std_m = 2e-5
columns = { reading = "dial_m" }
parameters = { zero = { nominal = 0.3, std = 0.2, unit = "m" } }

[[residual]]
kind = "inclinometer"
link = "link2"
axis = [1, 0, 0]
std_rad = 2e-4
columns = { reading = "level_rad" }

[[residual]]
kind = "same-height"
link = "link3"
point_m = [-0.2, 0.1, 0.3]
std_m = 1e-5
columns = { block = "block_m" }

[[residual]]
kind = "force-gauge"
joint = "joint2"
std_n = 0.05
columns = { force = "rope_n" }
"#;

const GAUGE_ZERO: f64 = 0.35;
const LEVEL_ZERO: f64 = 0.02;
const TABLE: f64 = -0.4;
const FORCE: f64 = 23.0;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gravcal-extension")).current_dir(folder).args(arguments).output().unwrap()
}

/// Normal noise, near enough: twelve uniform numbers.
struct Noise(u64);

impl Noise {
    fn next(&mut self, std: f64) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        std * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)
    }
}

/// What is read besides, in each pose, as cells of a table; every fifth pose has no dial gauge, and every second touches the table.
fn observed(session: &Session, truth: &State) -> Vec<[String; 4]> {
    let chain = &session.robot.chain;
    let mut noise = Noise(5);
    let cells = |(index, position): (usize, &Vec<f64>)| {
        let coordinates: Vec<f64> = position.iter().zip(&truth.sensors).map(|(q, [_, _, s, o])| s * q + o).collect();
        let links = chain.forward(&coordinates);
        let [_, _, gauged] = links[2].transform_point([0.1, 0.05, 0.4]);
        let [_, _, touching] = links[2].transform_point([-0.2, 0.1, 0.3]);
        let [down, _, _] = links[1].inverse().rotate_vector(truth.gravity);
        let gravity = truth.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let dial = gauged + GAUGE_ZERO + noise.next(2e-5);
        let level = (-down / gravity).asin() + LEVEL_ZERO + noise.next(2e-4);
        let block = touching - TABLE + noise.next(1e-5 / 2_f64.sqrt());
        let force = FORCE * coordinates[1].cos() + noise.next(0.05);
        let unless = |left_out: bool, cell: f64| if left_out { String::new() } else { cell.to_string() };
        [unless(index % 5 == 0, dial), level.to_string(), unless(index % 2 == 0, block), force.to_string()]
    };
    let poses: Vec<Vec<f64>> = session.poses.iter().map(|pose| pose.position.clone()).collect();
    poses.iter().enumerate().map(cells).collect()
}

/// A folder with a simulated session, whose tables have what was observed behind their columns.
fn simulated(residuals: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(ROBOT), at("robot.toml")).unwrap();
    std::fs::write(at("simulation.toml"), include_str!("observed.toml")).unwrap();
    let out = run(folder.path(), &["simulate", "simulation.toml"]);
    assert!(out.status.success(), "{out:?}");
    let truth = Simulation::read_with(&at("simulation.toml"), &registry()).unwrap().truth;
    let session = read_session_with(&at("session.toml"), &registry()).unwrap();
    let observed = observed(&session, &truth);
    for (index, table) in session.tables.iter().enumerate() {
        let of_table = session.poses.iter().zip(&observed).filter(|(pose, _)| pose.table == index);
        let mut cells = of_table.map(|(_, cells)| cells.join(","));
        let mut header = true;
        let line = |line: &str| match line.starts_with('#') {
            true => format!("{line}\n"),
            false if std::mem::take(&mut header) => format!("{line},dial_m,level_rad,block_m,rope_n\n"),
            false => format!("{line},{}\n", cells.next().unwrap()),
        };
        let text: String = std::fs::read_to_string(&table.path).unwrap().lines().map(line).collect();
        std::fs::write(&table.path, text).unwrap();
    }
    let text = std::fs::read_to_string(at("session.toml")).unwrap();
    std::fs::write(at("session.toml"), format!("{text}\n{residuals}")).unwrap();
    folder
}

fn joint(folder: &Path) -> Value {
    estimated(folder, "joint")
}

fn estimated(folder: &Path, estimator: &str) -> Value {
    let results = std::fs::read(folder.join("results/calibration.json")).unwrap();
    let results: Value = serde_json::from_slice(&results).unwrap();
    results["estimators"].as_array().unwrap().iter().find(|one| one["name"] == estimator).unwrap().clone()
}

/// Value, standard deviation and interval of a parameter.
fn found(joint: &Value, name: &str) -> (f64, f64) {
    let reported: Vec<&Value> =
        joint["parameters"].as_array().unwrap().iter().filter(|reported| reported["name"] == name).collect();
    assert_eq!(reported.len(), 1, "{name} is told once");
    let [value, std] =
        ["value", "std"].map(|key| reported[0][key].as_f64().unwrap_or_else(|| panic!("{}", reported[0])));
    (value, std)
}

/// True values, in the units of results.
const TRUTH: [(&str, f64); 8] = [
    ("gauge.zero", GAUGE_ZERO),
    ("inclinometer.zero", LEVEL_ZERO),
    ("compensator.force", FORCE),
    ("joint1.torque_gain", 7.12),
    ("joint2.position_gain", 0.995),
    ("joint2.position_offset", 134.2 * std::f64::consts::PI / 180.0),
    ("joint3.position_gain", 1.01),
    ("joint3.position_offset", 0.2),
];

#[test]
fn unknowns_of_residuals_and_shared_ones_are_found_with_the_arms() {
    let folder = simulated(RESIDUALS);
    let out = run(folder.path(), &["check", "session.toml"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(
        out.status.success() && reported.contains("gauge") && reported.contains("compensator"),
        "{reported} {out:?}"
    );

    let out = run(folder.path(), &["calibrate", "session.toml", "--estimator", "joint", "-o", "results", "--full"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert_eq!(out.status.code(), Some(0), "{reported} {out:?}");
    let with = joint(folder.path());
    for (name, truth) in TRUTH {
        let (value, std) = found(&with, name);
        assert!(std > 0.0 && (value - truth).abs() < 3.5 * std, "{name}: {value} ± {std}, truly {truth}");
    }
    let tests: Vec<&Value> = with["sensor_models"].as_array().unwrap().iter().collect();
    assert_eq!(tests.len(), 2, "each joint with a rope: {tests:?}");
    for test in tests {
        assert_eq!(
            (&test["parameters"][0], test["test"].is_object()),
            (&Value::from("compensator.force"), true),
            "{test}"
        );
    }
    assert!(reported.contains("Residual gauge (dial-gauge): 144 rows"), "{reported}");
    assert!(reported.contains("reading = height of the point + zero"), "{reported}");

    // What they say of the arm itself: without them its joints are known far worse.
    let without = simulated("");
    let out = run(without.path(), &["calibrate", "session.toml", "--estimator", "joint", "-o", "results", "--quiet"]);
    assert!([Some(0), Some(3)].contains(&out.status.code()), "{out:?}");
    for name in ["joint2.position_gain", "joint2.position_offset"] {
        let [(_, with), (_, without)] = [found(&with, name), found(&joint(without.path()), name)];
        assert!(with < 0.3 * without, "{name}: {with} with, {without} without");
    }
}

/// Readings that enter pose by pose, errors of positions as unknowns of each pose (two of which a contact ties together), and standard
/// deviations from blocks of poses go with residuals.
#[test]
fn other_ways_to_estimate_find_the_same() {
    let folder = simulated(RESIDUALS);
    let file = folder.path().join("session.toml");
    let session = std::fs::read_to_string(&file).unwrap();
    let position = "unit = [\"rad\", \"rad\", \"rad\"]";
    let trembling = format!("{position}\nstd = 1e-6");
    let jackknife = "[uncertainty]\nkind = \"jackknife\"\n\n[[residual]]";
    for (from, to, estimator) in [
        ("", "", "recursive"),
        (position, trembling.as_str(), "joint"),
        ("[[residual]]", jackknife, "joint"),
        ("[[poses]]\nfile = \"bare.csv\"", "[[validation]]\nfile = \"bare.csv\"", "joint"),
    ] {
        assert!(session.contains(from), "{from} in {session}");
        std::fs::write(&file, session.replacen(from, to, 1)).unwrap();
        let arguments =
            ["calibrate", "session.toml", "--estimator", estimator, "-o", "results", "--overwrite", "--quiet"];
        let out = run(folder.path(), &arguments);
        assert_eq!(out.status.code(), Some(0), "{to} {estimator} {out:?}");
        let reported = estimated(folder.path(), estimator);
        for (name, truth) in TRUTH {
            let (value, std) = found(&reported, name);
            assert!(
                std > 0.0 && (value - truth).abs() < 4.0 * std,
                "{to} {estimator} {name}: {value} ± {std}, truly {truth}"
            );
        }
    }
}

/// What was said of torques can be corrected without the columns of residuals.
#[test]
fn a_calibration_is_applied_to_recordings_without_these_columns() {
    let folder = simulated(RESIDUALS);
    let out = run(folder.path(), &["calibrate", "session.toml", "--estimator", "joint", "-o", "results", "--quiet"]);
    assert_eq!(out.status.code(), Some(0), "{out:?}");
    let plain = simulated("");
    std::fs::copy(plain.path().join("bare.csv"), folder.path().join("other.csv")).unwrap();
    let text = std::fs::read_to_string(folder.path().join("other.csv")).unwrap();
    let cut = |line: &str| line.rsplitn(5, ',').last().unwrap_or_default().to_owned() + "\n";
    let text: String =
        text.lines().map(|line| if line.starts_with('#') { format!("{line}\n") } else { cut(line) }).collect();
    std::fs::write(folder.path().join("other.csv"), text).unwrap();
    let out = run(folder.path(), &["apply", "results/calibration.json", "other.csv", "applied.csv"]);
    assert!(out.status.success(), "{out:?}");
}

/// Every refusal names the field and what to do.
#[test]
fn what_is_wrong_with_a_residual_is_said() {
    let folder = simulated(RESIDUALS);
    let file = folder.path().join("session.toml");
    let session = std::fs::read_to_string(&file).unwrap();
    let refused = |from: &str, to: &str| {
        assert!(session.contains(from), "{from}");
        std::fs::write(&file, session.replacen(from, to, 1)).unwrap();
        let out = run(folder.path(), &["check", "session.toml"]);
        assert_eq!(out.status.code(), Some(2), "{out:?}");
        String::from_utf8_lossy(&out.stderr).into_owned()
    };
    let gauge = "kind = \"dial-gauge\"";
    for (from, to, expected) in [
        (
            gauge,
            "kind = \"dial-gage\"",
            "residual[0].kind: there is no residual `dial-gage` (did you mean `dial-gauge`?); known: dial-gauge",
        ),
        ("std_m = 2e-5", "std_mm = 2e-2", "residual[0].std_mm: dial-gauge has no such option: did you mean `std_m`?"),
        ("std_m = 2e-5\n", "", "residual[0].std_m: how well is the gauge read?: add std_m, a number above zero"),
        (
            "link = \"link3\"\npoint_m = [0.1",
            "link = \"link4\"\npoint_m = [0.1",
            "residual[0].link: there is no link `link4`",
        ),
        (
            "{ reading = \"dial_m\" }",
            "{}",
            "residual[0].columns.reading: dial-gauge reads a column `reading`: add columns",
        ),
        ("\"dial_m\"", "\"dail_m\"", "dail_m"),
        ("{ zero =", "{ nought =", "residual[0].parameters.nought: "),
        ("name = \"gauge\"", "name = \"link2\"", "residual[0].name: `link2` is a joint, a link"),
        ("kind = \"inclinometer\"", "kind = \"inclinometer\"\nname = \"gauge\"", "residual[1].name: "),
        (
            "unit = \"m\" } }",
            "unit = \"kg\" } }",
            "residual[0].parameters.zero.unit: the unit `kg` does not fit: expected `m` or `mm`",
        ),
    ] {
        let reported = refused(from, to);
        assert!(reported.contains(expected), "{to}: {reported}");
    }
    let out = {
        std::fs::write(&file, &session).unwrap();
        run(folder.path(), &["calibrate", "session.toml", "--estimator", "sequential", "-o", "results"])
    };
    let reported = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(
        out.status.code() == Some(2) && reported.contains("only the joint estimators heed residuals"),
        "{reported}"
    );
}

#[test]
fn the_help_lists_the_residuals_of_this_crate() {
    let out = run(Path::new("."), &["--help"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(reported.contains("dial-gauge") && reported.contains("[[residual]]"), "{reported}");
}

/// A study draws torques and positions only: it does not leave out what a session observes besides without a word.
#[test]
fn a_study_whose_session_has_a_residual_is_refused() {
    const STUDY: &str = r#"
simulation = "simulation.toml"
trials = 2
estimators = ["joint"]

[[change]]
field = "session.residual"
value = [{ kind = "inclinometer", link = "link2", axis = [1, 0, 0], std_rad = 2e-4, columns = { reading = "joint1_torque_count" } }]
"#;
    let folder = simulated("");
    std::fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    let out = run(folder.path(), &["study", "run", "study.toml"]);
    let reported = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(2), "{out:?}");
    assert!(reported.contains("simulations do not draw what the residual inclinometer observes"), "{reported}");
}
