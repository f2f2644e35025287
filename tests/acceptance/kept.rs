//! What a user has stays: no command writes onto what it reads, into folders of others, through links, or half of its results.

use std::fs;
use std::path::{Path, PathBuf};
#[cfg(target_os = "linux")]
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::experiments::say;
#[cfg(target_os = "linux")]
use crate::program::{BAD_INPUT, NOT_SHOWN, Run};
use crate::program::{gravcal, gravcal_in};
use crate::small_session::{RESULTS, calibrate, small_session};
use crate::studies::Study;
use crate::tree;

/// Every file below a folder with its contents.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    tree::files_below(folder).into_iter().map(|file| (file.clone(), fs::read(file).unwrap())).collect()
}

/// The small session with its results.
fn calibrated() -> TempDir {
    let folder = small_session();
    let run = calibrate(folder.path());
    assert!([0, 3].contains(&run.code), "{run:?}");
    folder
}

#[test]
fn no_command_writes_onto_what_it_reads() {
    let folder = calibrated();
    let path = |name: &str| folder.path().join(name);
    #[cfg(unix)]
    std::os::unix::fs::symlink("bare.csv", path("link.toml")).unwrap();
    fs::copy(path("simulation.toml"), path("truth.toml")).unwrap();
    // Another day's tables, with what was found before as a prior: it would be replaced by what is found with it.
    let prior = "[prior]\ncalibration = \"results/calibration.json\"\n[gravity]";
    let mut again = fs::read_to_string(path("session.toml")).unwrap().replacen("[gravity]", prior, 1);
    for table in ["bare.csv", "plate-a.csv", "plate-b.csv"] {
        let text = fs::read_to_string(path(table)).unwrap();
        fs::write(path(&format!("again-{table}")), format!("# another day\n{text}")).unwrap();
        again = again.replace(table, &format!("again-{table}"));
    }
    fs::write(path("again.toml"), again).unwrap();
    let before = contents(folder.path());
    let calibration = "results/calibration.json";
    let commands: [&[&str]; 8] = [
        &["inspect", "bare.csv", "--session", "bare.csv", "--overwrite"],
        &["inspect", "bare.csv", "--session", "link.toml", "--overwrite"],
        &["inspect", "bare.csv", "--robot", "robot.toml", "--session", "robot.toml", "--overwrite"],
        &["apply", calibration, "plate-a.csv", "bare.csv", "--overwrite"],
        &["apply", calibration, "plate-a.csv", "./plate-a.csv", "--overwrite"],
        &["export", calibration, "--to", "csv", "-o", calibration, "--overwrite"],
        &["simulate", "truth.toml", "--overwrite"],
        &["calibrate", "--full", "again.toml", "--output", RESULTS, "--overwrite"],
    ];
    for command in commands {
        let run = gravcal_in(folder.path(), command);
        assert_eq!(run.refusal(&["this file is read"]), None, "{command:?}");
        assert!(contents(folder.path()) == before, "{command:?} changed something");
    }
}

/// A folder that is no study's stays as it is, and so does what links in a study's folder point to.
#[test]
fn a_study_takes_no_folder_of_another() {
    let study = Study::small(2);
    let others: [&[&str]; 4] = [&["parts/mine"], &["lock"], &["report.md"], &["study.json", "trials.parquet"]];
    for (number, files) in others.iter().enumerate() {
        let name = format!("mine{number}");
        for file in *files {
            let file = study.results(&name).join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, "mine").unwrap();
        }
        let before = contents(&study.results(&name));
        let run = study.run(&name, &[]);
        assert_eq!(run.refusal(&["ame another folder"]), None, "{files:?}");
        assert!(contents(&study.results(&name)) == before, "{files:?}");
    }
    // Empty folders, and those that were begun, are taken.
    fs::create_dir(study.results("empty")).unwrap();
    assert_eq!(study.run("empty", &["--shard", "1/2", "-q"]).code, 0);
    fs::write(study.results("empty").join("parts/mine"), "mine").unwrap();
    assert_eq!(study.run("empty", &["-q"]).code, 0);
    assert_eq!(fs::read_to_string(study.results("empty").join("parts/mine")).unwrap(), "mine");
}

#[cfg(unix)]
#[test]
fn a_study_writes_through_no_link() {
    use std::os::unix::fs::symlink;
    let study = Study::small(2);
    let mine = study.results("mine");
    fs::create_dir(&mine).unwrap();
    fs::write(mine.join("file"), "mine").unwrap();
    for name in ["lock", "parts", "times.csv", "trials.parquet", "report.md", "study.html"] {
        let results = study.results(&format!("through-{name}"));
        assert_eq!(study.run(results.to_str().unwrap(), &["--shard", "1/2", "-q"]).code, 0);
        let path = results.join(name);
        let _ = fs::remove_dir_all(&path).or_else(|_| fs::remove_file(&path));
        symlink(if name == "parts" { mine.clone() } else { mine.join("file") }, &path).unwrap();
        let run = study.run(results.to_str().unwrap(), &["-q"]);
        assert_eq!(run.refusal(&[name]), None);
        assert_eq!(contents(&mine), [(mine.join("file"), b"mine".to_vec())], "{name}");
    }
}

#[test]
fn parts_and_tables_are_those_of_the_study() {
    let study = Study::small(64);
    assert_eq!(study.run("a", &["--shard", "1/2"]).code, 0);
    assert_eq!(study.run("b", &["--shard", "2/2"]).code, 0);
    let [a, b] = ["a", "b"].map(|name| study.results(name));
    let whole = study.results("whole");
    assert_eq!(study.run("whole", &[]).code, 0);
    for ending in ["parquet", "times.csv"] {
        let [from, to] = ["00000002", "00000000"].map(|part| a.join(format!("parts/{part}.{ending}")));
        fs::copy(from, to).unwrap();
    }
    let merged = gravcal(["study".as_ref(), "merge".as_ref(), a.as_os_str(), b.as_os_str()]);
    assert_eq!(
        merged.refusal(&["00000000.parquet", "its rows are not those of the study", "expected trial 0 of point 0"]),
        None
    );
    assert!(!a.join("trials.parquet").exists());

    // The table of one part is none of the whole study.
    fs::copy(b.join("parts/00000001.parquet"), whole.join("trials.parquet")).unwrap();
    let report = gravcal(["study".as_ref(), "report".as_ref(), whole.as_os_str()]);
    assert_eq!(report.refusal(&["trials.parquet", "its rows are not those of the study"]), None);
}

#[test]
fn a_study_that_contradicts_itself_is_refused() {
    let damaged = tree::root().join("../shared/data/damaged/study/points-beyond-axes.json");
    if !damaged.exists() {
        return say("the shared data are absent: no damaged study is tried");
    }
    let study = Study::small(2);
    assert_eq!(study.run("results", &["-q"]).code, 0);
    fs::copy(damaged, study.results("results").join("study.json")).unwrap();
    for command in ["report", "merge"] {
        let run = gravcal(["study".as_ref(), command.as_ref(), study.results("results").as_os_str()]);
        assert_eq!(run.refusal(&["study.json", "its points are not the grid of what is varied"]), None);
    }
}

/// Results that no longer fit on a disk are not there at all; a limit to the size of files stands for a full disk.
#[cfg(target_os = "linux")]
#[test]
fn half_of_the_results_is_none() {
    let folder = calibrated();
    let path = |name: &str| folder.path().join(name);
    let within = |blocks: u32, arguments: &str| {
        let line = format!("trap '' XFSZ; ulimit -f {blocks}; exec '{}' {arguments}", env!("CARGO_BIN_EXE_gravcal"));
        let output = Command::new("bash").args(["-c", &line]).current_dir(folder.path()).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Run { code: output.status.code().unwrap_or(-1), stdout: text(output.stdout), stderr: text(output.stderr) }
    };
    let before = contents(folder.path());
    // More than a kilobyte, less than the page.
    assert!(fs::metadata(path(RESULTS).join("table.txt")).unwrap().len() > 1024);
    let largest = |name: &str| fs::metadata(path(RESULTS).join(name)).unwrap().len() / 1024;
    let enough_for_some = u32::try_from(largest("table.txt") + 1).unwrap();
    assert!(u64::from(enough_for_some) < largest("report.html"));
    for arguments in [
        "calibrate session.toml --output new/deep",
        "calibrate session.toml --estimator joint --output results --overwrite",
    ] {
        let run = within(enough_for_some, arguments);
        assert_eq!((run.code, run.stderr.contains("cannot be written")), (BAD_INPUT, true), "{arguments}: {run:?}");
        assert!(contents(folder.path()) == before && !path("new").exists(), "{arguments}");
    }
    for arguments in ["simulate simulation.toml --output new", "simulate simulation.toml --trial 1 --overwrite"] {
        let run = within(1, arguments);
        assert_eq!((run.code, run.stderr.contains("cannot be written")), (BAD_INPUT, true), "{arguments}: {run:?}");
        assert!(contents(folder.path()) == before && !path("new").exists(), "{arguments}");
    }
}

/// Nothing is bad about the input where only the answer cannot be told.
#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_printed_has_a_code_of_its_own_and_is_written() {
    let folder = small_session();
    let full = |arguments: &[&str]| {
        let to = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_gravcal"));
        let command = command.args(arguments).current_dir(folder.path()).stdout(to).stderr(Stdio::piped());
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let commands: [(&[&str], &str); 5] = [
        (&["calibrate", "--full", "session.toml", "-o", RESULTS], "results/calibration.json"),
        (&["check", "--full", "session.toml"], "session.toml"),
        (&["simulate", "simulation.toml", "-o", "made"], "made/session.toml"),
        (&["export", "results/calibration.json", "--to", "csv", "-o", "out.csv"], "out.csv"),
        (&["apply", "results/calibration.json", "bare.csv", "applied.csv"], "applied.csv"),
    ];
    for (arguments, written) in commands {
        let (code, reported) = full(arguments);
        assert_eq!(code, Some(NOT_SHOWN), "{arguments:?}: {reported}");
        assert!(reported.contains("cannot be printed"), "{reported}");
        assert!(folder.path().join(written).is_file(), "{arguments:?}");
    }
}

#[test]
fn a_calibration_is_applied_in_its_own_units_only() {
    let folder = calibrated();
    let path = |name: &str| folder.path().join(name);
    // The same columns, said to be N·m, of a robot without nominal sensors.
    let robot = fs::read_to_string(path("robot.toml")).unwrap();
    let bare = robot.lines().filter(|line| !line.starts_with("torque_sensor"));
    fs::write(path("bare-robot.toml"), bare.map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    let session = fs::read_to_string(path("session.toml")).unwrap();
    let other = session.replacen("robot.toml", "bare-robot.toml", 1).replacen("unit = \"count\"", "unit = \"N·m\"", 1);
    fs::write(path("other.toml"), other).unwrap();
    let given = ["apply", "results/calibration.json", "bare.csv", "out.csv", "--session"];
    let run = gravcal_in(folder.path(), [&given[..], &["other.toml"]].concat());
    assert_eq!(
        run.refusal(&["joint1.torque_gain is in count/(N·m) in the calibration, but in N·m/(N·m) in the session"]),
        None
    );
    assert!(!path("out.csv").exists());
    assert_eq!(gravcal_in(folder.path(), [&given[..], &["session.toml"]].concat()).code, 0);
}

/// What the session says of a recording that says nothing of itself is heeded; what nobody says is told.
#[test]
fn the_load_of_a_residual_is_known_or_reported() {
    let folder = calibrated();
    let path = |name: &str| folder.path().join(name);
    fs::copy(path("plate-a.csv"), path("copy.csv")).unwrap();
    let apply = |input: &str, more: &[&str]| {
        let given = ["apply", "results/calibration.json", input, "out.csv", "--overwrite", "--residual"];
        let run = gravcal_in(folder.path(), [&given[..], more].concat());
        assert_eq!(run.code, 0, "{run:?}");
        (run.stdout, fs::read_to_string(path("out.csv")).unwrap())
    };
    let numbers =
        |text: &str| text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>();
    let (_, named) = apply("copy.csv", &["--load", "plate-a"]);
    let (reported, known) = apply("plate-a.csv", &[]);
    assert_eq!(numbers(&known), numbers(&named));
    assert!(known.contains("; load plate-a, as the session says") && !reported.contains("note:"), "{reported}");
    let (reported, bare) = apply("bare.csv", &[]);
    assert!(bare.contains("; no load, as the session says") && !reported.contains("note:"), "{reported}");
    let (reported, assumed) = apply("copy.csv", &[]);
    assert!(reported.contains("note: no load is assumed") && assumed.contains("; no load is assumed"), "{reported}");
    assert_ne!(numbers(&assumed), numbers(&named));
}

#[test]
fn names_are_shown_and_never_act() {
    let folder = small_session();
    let session = folder.path().join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    fs::write(&session, text.replace("plate-a\"", "\\u001b]0;owned\\u0007\\u009b2Jplate-a\"")).unwrap();
    let robot = folder.path().join("robot.toml");
    let text = fs::read_to_string(&robot).unwrap();
    fs::write(&robot, text.replacen("name = \"", "name = \"\\u001b[2J\\u0007", 1)).unwrap();
    let run = calibrate(folder.path());
    assert!([0, 3].contains(&run.code), "{run:?}");
    let table = fs::read_to_string(folder.path().join(RESULTS).join("table.txt")).unwrap();
    for reported in [&run.stdout, &table] {
        assert!(!reported.contains(|c: char| c.is_control() && c != '\n'), "{reported:?}");
    }
    assert!(table.starts_with("Calibration of �[2J�"), "{table}");
}

#[test]
fn an_error_is_no_longer_than_anyone_reads() {
    let folder = small_session();
    let session = folder.path().join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    fs::write(&session, text.replacen("unit = \"rad\"", &format!("unit = \"{}\"", "rad".repeat(1 << 20)), 1)).unwrap();
    let run = calibrate(folder.path());
    assert_eq!(run.refusal(&["session.toml:", "readings.position.unit", "characters left out"]), None);
    assert!(run.stderr.len() < 10_000, "{}", run.stderr.len());
}
