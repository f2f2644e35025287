//! A run that is killed at any moment loses nothing: results appear as a whole, and the next run clears away what it left.
//!
//! Moments are spread over the time that a whole run takes; every third kill is SIGTERM, the others SIGKILL. `GRAVCAL_KILLS` says how many,
//! for more than the ordinary suite has time for:
//!
//! ```text
//! GRAVCAL_KILLS=100 cargo test --release -p gravcal-cli --test acceptance killed -- --nocapture
//! ```

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use gravcal_recording::{Heading, create, is_temporary};

use crate::program::gravcal_in;
use crate::small_session::{HEADER, small_session};
use crate::studies::Study;
use crate::tree;

/// Kills of each command in the ordinary suite.
const KILLS: u32 = 6;

/// What became of the runs that were to be killed.
#[derive(Debug, Default)]
struct Ends {
    killed: u32,
    /// They had ended before.
    whole: u32,
    /// They left temporary files, which the next run is to clear away.
    left_temporary: u32,
}

/// Kills runs of a command, each at another moment of the time that a whole run of it takes, and has what each left looked at.
fn kill_often(folder: &Path, whole: Duration, arguments: impl Fn(u32) -> Vec<String>, look: impl Fn(u32)) -> Ends {
    let kills = std::env::var("GRAVCAL_KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(KILLS);
    let (mut ends, mut kill) = (Ends::default(), 0);
    // A run that is faster than the measured one may end before it is killed.
    while ends.killed < kills && kill < 3 * kills {
        let mut run = Command::new(env!("CARGO_BIN_EXE_gravcal"));
        let run = run.args(arguments(kill)).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = run.spawn().unwrap();
        // Multiples of the golden ratio fill an interval evenly, however many there are.
        std::thread::sleep(whole.mul_f64((f64::from(kill) * 0.618_034).fract()));
        end(&mut child, kill);
        match child.wait().unwrap().code() {
            None => ends.killed += 1,
            Some(_) => ends.whole += 1,
        }
        ends.left_temporary += u32::from(!temporary(folder).is_empty());
        look(kill);
        kill += 1;
    }
    ends
}

/// Every third time as `kill` or a shutdown does, else by force.
fn end(child: &mut Child, kill: u32) {
    let reported = kill % 3 == 2
        && Command::new("kill").args(["-TERM", &child.id().to_string()]).status().is_ok_and(|status| status.success());
    if !reported {
        let _ = child.kill(); // an error where it has ended
    }
}

/// Temporary files and folders in a folder and below.
fn temporary(folder: &Path) -> Vec<PathBuf> {
    let is_ours = |entry: &PathBuf| is_temporary(entry.file_name().unwrap());
    let (ours, others): (Vec<_>, Vec<_>) = tree::entries(folder).into_iter().partition(is_ours);
    let below = others.iter().filter(|entry| entry.is_dir()).flat_map(|entry| temporary(entry));
    ours.into_iter().chain(below).collect()
}

/// Runs it whole, and tells how long that takes.
fn whole(folder: &Path, arguments: &[String]) -> Duration {
    let begun = Instant::now();
    let run = gravcal_in(folder, arguments);
    assert!([0, 3].contains(&run.code), "{run:?}");
    begun.elapsed()
}

fn words(line: &str) -> Vec<String> {
    line.split(' ').map(str::to_owned).collect()
}

/// Two sessions in turns into one folder: whatever is there is all of one of them.
#[test]
fn calibrate_leaves_no_new_file_beside_an_old_one() {
    let place = small_session();
    let folder = place.path();
    let session = fs::read_to_string(folder.join("session.toml")).unwrap();
    fs::write(folder.join("other.toml"), format!("{session}\n[loss]\nkind = \"huber\"\n")).unwrap();
    let sessions = ["session", "other"];
    let files = ["calibration.json", "table.txt", "report.html"];
    let arguments = |name: &str, results: &str| words(&format!("calibrate {name}.toml --output {results} --overwrite"));
    let times = sessions.map(|name| whole(folder, &arguments(name, name)));
    let read = |results: &str, file: &str| fs::read(folder.join(results).join(file)).ok();
    whole(folder, &arguments("session", "results"));
    let look = |kill: u32| {
        let there = files.map(|file| read("results", file));
        let is_of =
            |name: &str| there.iter().zip(files).all(|(there, file)| there.is_none() || *there == read(name, file));
        assert!(
            sessions.iter().any(|name| is_of(name)),
            "after kill {kill} files of two calibrations are side by side"
        );
    };
    let ends =
        kill_often(folder, times[0].max(times[1]), |kill| arguments(sessions[1 - kill as usize % 2], "results"), look);
    whole(folder, &arguments("other", "results"));
    assert!(files.iter().all(|file| read("results", file) == read("other", file)));
    assert_eq!(temporary(folder), Vec::<PathBuf>::new());
    println!("calibrate --overwrite: {ends:?}");
}

/// Over an output that is there: the old one or the new one is there, whole.
#[test]
fn apply_leaves_the_old_recording_or_the_new_one() {
    let place = small_session();
    let folder = place.path();
    name_columns_as_bags_do(folder);
    whole(folder, &words("calibrate session.toml --output results"));
    for recording in ["large.csv", "large.mcap"] {
        write_large(folder, recording);
        let output = format!("out-{recording}");
        let options = ["", " --residual --load plate-a"];
        let arguments =
            |option: &str| words(&format!("apply results/calibration.json {recording} {output} --overwrite{option}"));
        let input = fs::read(folder.join(recording)).unwrap();
        let ways = options.map(|option| {
            let took = whole(folder, &arguments(option));
            (took, fs::read(folder.join(&output)).unwrap())
        });
        let look = |kill: u32| {
            let there = fs::read(folder.join(&output)).unwrap();
            assert!(ways.iter().any(|(_, bytes)| *bytes == there), "after kill {kill} {output} is neither");
        };
        let ends = kill_often(folder, ways[0].0, |kill| arguments(options[kill as usize % 2]), look);
        whole(folder, &arguments(""));
        let is_whole = fs::read(folder.join(&output)).unwrap() == ways[0].1;
        assert!(is_whole && fs::read(folder.join(recording)).unwrap() == input);
        assert_eq!(temporary(folder), Vec::<PathBuf>::new());
        println!("apply to {recording} of {} bytes: {ends:?}", input.len());
    }
}

/// The session and its tables, with columns of the names that those of messages have.
fn name_columns_as_bags_do(folder: &Path) {
    let names = HEADER.trim_end().split(',').map(|old| {
        let (joint, rest) = old.split_once('_').unwrap();
        (old, format!("{joint}.{}", if rest.starts_with("position") { "position" } else { "effort" }))
    });
    let names: Vec<(&str, String)> = names.collect();
    for file in ["session.toml", "bare.csv", "plate-a.csv", "plate-b.csv"] {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        let renamed = names.iter().fold(text, |text, (old, new)| text.replace(old, new));
        fs::write(folder.join(file), renamed).unwrap();
    }
}

/// The rows of a table over and over again.
fn write_large(folder: &Path, recording: &str) {
    let table = fs::read_to_string(folder.join("plate-a.csv")).unwrap();
    let (names, rows) = table.split_once('\n').unwrap();
    let columns = ["time_s"].into_iter().chain(names.split(',')).map(str::to_owned).collect();
    let heading = Heading { columns, metadata: Default::default() };
    let mut writer = create(&folder.join(recording), &heading, false).unwrap();
    let cells: Vec<Vec<f64>> =
        rows.lines().map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    for row in 0..100_000 {
        writer.write(&[&[0.01 * f64::from(row)][..], &cells[row as usize % cells.len()]].concat()).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn a_study_goes_on_to_the_same_table() {
    let study = Study::small(40);
    let arguments = |results: &str| study.arguments(results, &["--threads", "1"]);
    let took = whole(study.folder(), &arguments("whole"));
    let results = study.results("killed");
    // A new start now and then, so that not all kills find a study that is all but done.
    let look = |kill: u32| {
        if kill % 4 == 3 && results.join("trials.parquet").exists() {
            assert!(study.table("whole") == study.table("killed"), "after kill {kill} the table differs");
            fs::remove_dir_all(&results).unwrap();
        }
    };
    let ends = kill_often(study.folder(), took.mul_f64(0.6), |_| arguments("killed"), look);
    whole(study.folder(), &arguments("killed"));
    assert!(study.table("whole") == study.table("killed"), "the table differs");
    assert!(!results.join("parts").exists(), "parts are left");
    for file in ["report.txt", "report.md", "measures.csv", "error-over-noise.svg"] {
        let [whole, killed] = ["whole", "killed"].map(|name| fs::read(study.results(name).join(file)).unwrap());
        assert!(whole == killed, "{file} differs");
    }
    assert_eq!(temporary(study.folder()), Vec::<PathBuf>::new());
    println!("study run: {ends:?}");
    let again = study.run("killed", &[]);
    assert!(again.code == 0 && again.stdout.ends_with("0 trials in 0.0 s\n"), "{again:?}");
}
