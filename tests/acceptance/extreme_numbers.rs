//! Whatever number stands in a file, the program answers: with results, or with what is wrong.

use std::fs;
use std::ops::Range;
use std::path::Path;

use crate::program::Run;
use crate::small_session::{calibrate, small_session};
use crate::tree;

/// Put in the place of every number in turn.
const EXTREMES: [&str; 5] = ["0.0", "-1.0", "1e-300", "1e154", "1e300"];
/// Sessions without sense may creep for all the iterations they are given.
const FEW_ITERATIONS: &str = "solver = { name = \"levenberg-marquardt\", max_iterations = 100 }\n";
/// Rows of a table, its header among them, whose numbers are replaced.
const ROWS: usize = 3;

#[test]
fn any_number_in_a_session_is_answered() {
    assert_answered("session.toml", usize::MAX);
}

#[test]
fn any_number_in_a_robot_is_answered() {
    assert_answered("robot.toml", usize::MAX);
}

#[test]
fn any_number_in_a_table_is_answered() {
    assert_answered("plate-a.csv", ROWS);
}

fn assert_answered(file: &str, lines: usize) {
    let folder = small_session();
    let session = folder.path().join("session.toml");
    fs::write(&session, format!("{FEW_ITERATIONS}{}", fs::read_to_string(&session).unwrap())).unwrap();
    let text = fs::read_to_string(folder.path().join(file)).unwrap();
    let numbers = numbers(&text, lines);
    assert!(!numbers.is_empty());
    for number in numbers {
        for extreme in EXTREMES {
            let changed = [&text[..number.start], extreme, &text[number.end..]].concat();
            fs::write(folder.path().join(file), changed).unwrap();
            let run = calibrate_anew(folder.path());
            assert!(is_answer(&run), "{file}: byte {} replaced by {extreme}: {run:?}", number.start);
        }
    }
}

fn calibrate_anew(folder: &Path) -> Run {
    let results = folder.join(crate::small_session::RESULTS);
    if results.exists() {
        fs::remove_dir_all(&results).unwrap();
    }
    let run = calibrate(folder);
    let written = results.exists() && !tree::entries(&results).is_empty();
    assert_eq!(written, run.stderr.is_empty(), "{run:?}");
    run
}

/// Whether a run ends as `--help` says, and tells why where it gives no results.
fn is_answer(run: &Run) -> bool {
    let refused = run.stderr.starts_with("error: ") && !run.stderr.contains("panicked");
    match run.code {
        0 | 3 => run.stderr.is_empty(),
        2 => refused,
        4 => refused || run.stderr.is_empty(),
        _ => false,
    }
}

/// Where numbers with a point stand in the first lines of a text.
fn numbers(text: &str, lines: usize) -> Vec<Range<usize>> {
    let end: usize = text.split_inclusive('\n').take(lines).map(str::len).sum();
    let mut numbers = Vec::new();
    let mut from = 0;
    for word in text[..end].split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')) {
        if word.contains('.') && word.parse::<f64>().is_ok() {
            numbers.push(from..from + word.len());
        }
        // What parts two words is one character, of one or more bytes.
        from += word.len() + text[from + word.len()..].chars().next().map_or(0, char::len_utf8);
    }
    numbers
}
