//! Knowledge from an earlier calibration: half of the poses, then the other half with the first as a prior, say what all
//! poses say; and what cannot be knowledge is refused.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::program::{Calibration, gravcal_in};
use crate::small_session::{HEADER, small_session};

const TABLES: [&str; 3] = ["bare.csv", "plate-a.csv", "plate-b.csv"];

/// Knowledge from `first.json` of everything but the sensors, too.
const PRIOR: &str = "\n[prior]\ncalibration = \"first.json\"\nunchanged = [\"base\", \"links\", \"loads\"]\n";

/// The beginning of `[readings.torque]`, behind joints that give way.
const SOFT: &str = "[deflection]\ncompliance_std_rad_per_newton_metre = 1e-4\n\n[readings.torque]";

/// The small session with a tenth of its noise: what is true to first order only is seen to be true.
fn quiet_session() -> TempDir {
    let folder = small_session();
    let file = |name: &str| folder.path().join(name);
    let quieter = |name: &str| fs::read_to_string(file(name)).unwrap().replace("std = 0.8", "std = 0.08");
    let session = quieter("session.toml");
    fs::write(file("simulation.toml"), quieter("simulation.toml")).unwrap();
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--overwrite"]);
    assert_eq!(run.code, 0, "{run:?}");
    fs::write(file("session.toml"), session).unwrap();
    folder
}

/// The quiet session with some of its poses: those whose place in their table leaves this remainder by two.
fn half(remainder: usize) -> TempDir {
    let folder = quiet_session();
    for table in TABLES {
        let path = folder.path().join(table);
        let text = fs::read_to_string(&path).unwrap();
        let rows = text.lines().filter(|line| line.chars().next().is_some_and(|c| c == '-' || c.is_ascii_digit()));
        let kept: Vec<&str> = rows.skip(remainder).step_by(2).collect();
        assert_eq!(kept.len(), 6, "{table}");
        fs::write(path, format!("{HEADER}{}\n", kept.join("\n"))).unwrap();
    }
    folder
}

fn calibrate(folder: &Path) -> Calibration {
    Calibration::with(&folder.join("session.toml"), &["--estimator", "joint"])
}

/// The other half, with what the first one found.
fn second_with(prior: &str, found: &[u8]) -> TempDir {
    let folder = half(1);
    fs::write(folder.path().join("first.json"), found).unwrap();
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    fs::write(folder.path().join("session.toml"), session + prior).unwrap();
    folder
}

fn first() -> Vec<u8> {
    let calibration = calibrate(half(0).path());
    assert_eq!(calibration.run.code, 0, "{:?}", calibration.run);
    calibration.bytes("calibration.json")
}

/// Name, value and standard deviation.
type Number = (String, f64, f64);

/// Values and standard deviations of what is asked for, gravity first.
fn reported(calibration: &Calibration) -> Vec<Number> {
    let joint = calibration.estimator("joint");
    assert_eq!(joint.verdict, "determined", "{:?}", calibration.run);
    let gravity = joint.gravity.unwrap();
    let axes = (0..3).map(|i| (format!("gravity {i}"), gravity.vector_m_per_s2[i], gravity.std_m_per_s2[i]));
    let free = joint.parameters.into_iter().filter(|p| p.held.is_none());
    axes.chain(free.map(|p| (p.name, p.value.unwrap(), p.std.unwrap()))).collect()
}

#[test]
fn half_and_half_are_the_whole() {
    assert_chained(str::to_owned);
}

/// A mass and compliances that are known within a standard deviation would be exact without it: the file keeps it, and it counts once.
#[test]
fn what_is_unknown_only_by_its_std_is_known_from_the_earlier_calibration() {
    assert_chained(|session| session.replace("mass_kg = 1.724", "mass_kg = { nominal = 1.724, std = 0.002 }"));
    assert_chained(|session| session.replace("[readings.torque]", SOFT));
}

/// A load known within three per cent leaves the scale of all torques as uncertain, and moments with it. What is known better, a moment times a gain, is
/// no linear function of the two: as one it would tell the scale.
#[test]
fn moments_of_uncertain_scale_tell_no_scale() {
    let roughly = |session: &str| session.replace("mass_kg = 1.724", "mass_kg = { nominal = 1.724, std = 0.05 }");
    for Chained { name, shift, ratio, .. } in chained(roughly) {
        assert!(shift.abs() < 0.3 && (ratio - 1.0).abs() < 0.15, "{name}: {shift} std off, std {ratio} times");
    }
}

/// Of what is not determined the earlier calibration tells no number, by which all others came out.
#[test]
fn a_stated_std_that_earlier_readings_did_not_improve_is_refused() {
    let soft = |session: &Path| {
        let text = fs::read_to_string(session).unwrap();
        fs::write(session, text.replace("[readings.torque]", SOFT).replace("std = 0.08", "std = 0.8")).unwrap();
    };
    let first = half(0);
    soft(&first.path().join("session.toml"));
    let found = calibrate(first.path()).bytes("calibration.json");
    let second = second_with(PRIOR, &found);
    soft(&second.path().join("session.toml"));
    let reported = ["prior.calibration", "joint1.compliance is not determined there", "calibrate all tables together"];
    assert_eq!(calibrate(second.path()).run.refusal(&reported), None);
}

/// That half of the poses, then the other half with what the first found, say what all of them say, of a session that `write` changes.
fn assert_chained(write: impl Fn(&str) -> String) {
    for Chained { name, shift, ratio, gained } in chained(write) {
        // What is left is of second order: ten times the noise leaves ten times as much.
        assert!(shift.abs() < 0.04 && (ratio - 1.0).abs() < 0.006, "{name}: {shift} std off, std {ratio} times");
        assert!(gained < 1.0, "{name}: {gained}");
    }
}

/// One number of a chain of two calibrations.
struct Chained {
    name: String,
    /// How far it is from that of all poses together, in standard deviations.
    shift: f64,
    /// Its standard deviation as a share of that of all poses together, and of that of the second half alone.
    ratio: f64,
    gained: f64,
}

/// Of a session that `write` changes.
fn chained(write: impl Fn(&str) -> String) -> Vec<Chained> {
    let written = |folder: TempDir| {
        let path = folder.path().join("session.toml");
        let session = write(&fs::read_to_string(&path).unwrap());
        fs::write(path, session).unwrap();
        folder
    };
    let first = calibrate(written(half(0)).path()).bytes("calibration.json");
    let second = written(second_with(PRIOR, &first));
    let (half, chained) = (reported(&calibrate(written(self::half(1)).path())), reported(&calibrate(second.path())));
    let all = reported(&calibrate(written(quiet_session()).path()));
    let one =
        |((name, value, std), ((other, of_chain, chained_std), (_, _, half_std))): (&Number, (&Number, &Number))| {
            assert_eq!(name, other);
            Chained {
                name: name.clone(),
                shift: (of_chain - value) / std,
                ratio: chained_std / std,
                gained: chained_std / half_std,
            }
        };
    all.iter().zip(chained.iter().zip(&half)).map(one).collect()
}

#[test]
fn sensors_alone_are_known_when_all_else_has_changed() {
    let found = first();
    let sensors = PRIOR.replace("unchanged = [\"base\", \"links\", \"loads\"]\n", "");
    let [all, some] = [PRIOR, sensors.as_str()].map(|prior| reported(&calibrate(second_with(prior, &found).path())));
    // Gravity and moments are free to be others: that is less knowledge of everything.
    for ((name, _, with_all), (_, _, with_some)) in all.iter().zip(&some) {
        assert!(with_some >= with_all, "{name}: {with_some} {with_all}");
    }
    let gravity = |reported: &[Number]| reported[..3].iter().map(|(_, _, std)| std * std).sum::<f64>().sqrt();
    assert!(gravity(&some) > 1.2 * gravity(&all), "{} {}", gravity(&some), gravity(&all));
}

/// The same tables again are no further knowledge, one of them neither, and under another name neither.
#[test]
fn what_an_earlier_calibration_was_made_from_does_not_count_twice() {
    let refused = |session: &Path| {
        let calibration = calibrate(session);
        let reported = "the calibration of [prior], first.json, was made from this table, too";
        assert_eq!(calibration.run.refusal(&["poses[1].file", reported]), None);
    };
    let again = half(0);
    let file = |name: &str| again.path().join(name);
    fs::write(file("first.json"), first()).unwrap();
    let session = fs::read_to_string(file("session.toml")).unwrap();
    let others = half(1);
    fs::copy(others.path().join("bare.csv"), file("bare.csv")).unwrap();
    fs::write(file("session.toml"), session.clone() + PRIOR).unwrap();
    refused(again.path());
    fs::rename(file("plate-a.csv"), file("renamed.csv")).unwrap();
    fs::write(file("session.toml"), session.replace("plate-a.csv", "renamed.csv") + PRIOR).unwrap();
    refused(again.path());
}

#[test]
fn what_cannot_be_knowledge_is_refused() {
    let found = first();
    let text = String::from_utf8(found.clone()).unwrap();
    let changed = |old: &str, new: &str| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new).into_bytes()
    };
    let elsewhere = PRIOR.replace("first.json", "no-such.json");
    let sequential = PRIOR.replace("unchanged", "estimator = \"sequential\"\nunchanged");
    let twice = format!(
        "{PRIOR}\n[[joint]]\nname = \"joint1\"\ntorque_bias = {{ nominal = 2048, std = 5, unit = \"count\" }}\n"
    );
    let lengths = format!("{PRIOR}\n[inertia]\nlength_std_m = 0.001\n");
    let sandwich = changed("\"kind\": \"noise\"", "\"kind\": \"sandwich\", \"blocks\": 12");
    let cases: [(&str, &[u8], &[&str]); 9] = [
        (
            &lengths,
            &found,
            &["inertia.length_std_m states an error that both calibrations have in common", "without [prior]"],
        ),
        (PRIOR, &sandwich, &["its covariance is a sandwich of 12 blocks of poses, too few for", "jackknife"]),
        (&elsewhere, &found, &["prior.calibration", "no-such.json: cannot be read"]),
        (&sequential, &found, &["prior.estimator", "no covariance between steps"]),
        (&twice, &found, &["joint1.torque_bias is known from there and by a std of its own here"]),
        (PRIOR, b"{}", &["prior.calibration", "not a calibration.json that gravcal wrote"]),
        (PRIOR, &changed("\"verdict\": \"determined\"", "\"verdict\": \"failed\""), &["estimator `joint` failed"]),
        (
            PRIOR,
            &changed("\"unit\": \"count\"", "\"unit\": \"V\""),
            &["joint1.torque_bias is in V there, but in count"],
        ),
        (PRIOR, &changed("\"order\": [", "\"order\": [], \"was\": ["), &["it has no covariance"]),
    ];
    for (prior, found, expected) in cases {
        let calibration = calibrate(second_with(prior, found).path());
        assert_eq!(calibration.run.refusal(expected), None);
    }
}

/// A sensor that has changed since is no fault of the readings: what was known of it is the reason.
#[test]
fn a_sensor_that_has_changed_contradicts_what_was_known_of_it() {
    let second = second_with(PRIOR, &first());
    for table in TABLES {
        let path = second.path().join(table);
        let text = fs::read_to_string(&path).unwrap();
        let changed = text.lines().skip(1).map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            cells[4] = (1.03 * cells[4].parse::<f64>().unwrap()).to_string();
            cells.join(",") + "\n"
        });
        fs::write(&path, HEADER.to_owned() + &changed.collect::<String>()).unwrap();
    }
    let calibration = calibrate(second.path());
    assert_eq!(calibration.run.code, 4, "{:?}", calibration.run);
    let joint = calibration.estimator("joint");
    assert!(joint.termination.starts_with("the readings contradict the earlier calibration"), "{}", joint.termination);
    let farthest = "off are joint2.torque_bias by ";
    assert!(joint.termination.contains(farthest), "{}", joint.termination);
    assert!(joint.termination.matches("standard deviations").count() <= 3, "{}", joint.termination);
    let file: serde_json::Value = serde_json::from_slice(&calibration.bytes("calibration.json")).unwrap();
    let first = file["estimators"][0]["notes"][0].as_str().unwrap();
    assert!(first.starts_with("What [prior] knows is not what was read here"), "{first}");
}
