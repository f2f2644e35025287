//! The pages of `docs/reference` that are written by the program's own sources, so that they cannot drift: the keys of its files,
//! and its help.
//!
//! `GRAVCAL_UPDATE_REFERENCE=1 cargo test --release -p gravcal-cli --test acceptance reference` writes them anew.

use std::fmt::Write as _;
use std::fs;

use crate::keys::{Key, Sources, Table};
use crate::program::gravcal;
use crate::tree;

const UPDATE: &str = "GRAVCAL_UPDATE_REFERENCE";

const CALIBRATION: &str = "crates/gravcal-calibration/src";
const MODEL: &str = "crates/gravcal-robot-model/src";
const SESSION: &str = "crates/gravcal-session/src";

/// Compares a page with what it should be, or writes it.
fn keep(page: &str, text: &str) {
    let path = tree::root().join("docs/reference").join(page);
    if std::env::var_os(UPDATE).is_some() {
        fs::write(&path, text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    let stale = written.lines().zip(text.lines()).find(|(written, right)| written != right);
    assert!(written == text, "{page} is stale: run this test with {UPDATE}=1. First difference: {stale:#?}");
}

/// A page of tables of keys.
fn page(title: &str, introduction: &str, tables: &[Table], examples: bool) -> String {
    let mut text = format!("# {title}\n\n{introduction}\n");
    for table in tables {
        let header = if table.header.is_empty() { "Top".to_owned() } else { format!("`{}`", table.header) };
        write!(text, "\n## {header}\n\n").unwrap();
        let repeated = table.header.is_empty() || table.documentation.trim_end_matches('.') == header;
        if !repeated && !table.documentation.is_empty() {
            write!(text, "{}\n\n", table.documentation).unwrap();
        }
        text += if examples {
            "| key | type | unit | default | meaning | example |\n|---|---|---|---|---|---|\n"
        } else {
            "| field | type | unit | meaning |\n|---|---|---|---|\n"
        };
        table.keys.iter().for_each(|key| text += &row(key, examples));
    }
    text
}

fn row(key: &Key, examples: bool) -> String {
    let Key { name, kind, unit, default, meaning, example } = key;
    let cells = match examples {
        true => {
            vec![format!("`{name}`"), kind.clone(), unit.clone(), default.clone(), meaning.clone(), example.clone()]
        }
        false => vec![format!("`{name}`"), kind.clone(), unit.clone(), meaning.clone()],
    };
    let cells: Vec<String> = cells.into_iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// Every key says what it means, and shows it by an example that is TOML with that key.
fn check(tables: &[Table]) {
    for (table, key) in tables.iter().flat_map(|table| table.keys.iter().map(move |key| (table, key))) {
        let at = format!("{} {}", table.header, key.name);
        assert!(!key.meaning.is_empty(), "{at} has no meaning");
        let example = key.example.strip_prefix('`').and_then(|example| example.strip_suffix('`'));
        let example = example.unwrap_or_else(|| panic!("{at} has no example"));
        let parsed: toml::Table = toml::from_str(example).unwrap_or_else(|error| panic!("{at}: {error}"));
        assert!(parsed.len() == 1 && parsed.contains_key(&key.name), "{at} is not shown by its example: {example}");
        let is_number = |value: &toml::Value| value.is_float() || value.is_integer();
        let number = key.kind.contains("number") && is_number(&parsed[&key.name]);
        assert!(!number || !key.unit.is_empty(), "{at} has no unit: end its name with one, or say it by `Unit: …`");
    }
}

fn keep_keys(file: &str, introduction: &str, sources: &Sources, roots: &[(&str, &str)]) {
    let mut tables: Vec<Table> = roots.iter().flat_map(|(file, root)| sources.tables(file, root)).collect();
    // What several structs read from the top of one file stands together.
    let others: Vec<usize> = (1..tables.len()).filter(|at| tables[*at].header.is_empty()).collect();
    for at in others.into_iter().rev() {
        let keys = tables.remove(at).keys;
        tables[0].keys.extend(keys);
    }
    check(&tables);
    keep(&format!("{}.md", file.trim_end_matches(".toml")), &page(file, introduction, &tables, true));
}

#[test]
fn keys_of_sessions_are_in_the_book() {
    let sources = Sources::of(&[SESSION, MODEL]);
    keep_keys(
        "session.toml",
        "All that is known beforehand. A key without a default is optional where it says –. Where a value may differ by joint it is one for \
         all or a list with one for each. Some sections exclude each other; gravcal says which.",
        &sources,
        &[("crates/gravcal-session/src/file.rs", "SessionTable")],
    );
}

#[test]
fn keys_of_robots_are_in_the_book() {
    let sources = Sources::of(&[SESSION, MODEL, "crates/gravcal-dynamics/src"]);
    keep_keys(
        "robot.toml",
        "A robot by its Denavit-Hartenberg rows. In place of this file a session may name a URDF.",
        &sources,
        &[("crates/gravcal-session/src/robot_file/file.rs", "RobotTable")],
    );
}

#[test]
fn keys_of_simulations_are_in_the_book() {
    let sources = Sources::of(&[SESSION, MODEL]);
    keep_keys(
        "simulation.toml",
        "What `gravcal simulate` makes: a session, its tables, and `truth.toml` with the values that a calibration should find.",
        &sources,
        &[
            ("crates/gravcal-session/src/simulation/file/tables.rs", "SimulationTable"),
            ("crates/gravcal-session/src/simulation/file/instruments.rs", "InstrumentTables"),
        ],
    );
}

#[test]
fn keys_of_studies_are_in_the_book() {
    let sources = Sources::of(&["crates/gravcal-study/src/plan"]);
    keep_keys(
        "study.toml",
        "What `gravcal study run` simulates, varies and compares. Paths are relative to the study, and in `session` too.",
        &sources,
        &[("crates/gravcal-study/src/plan/file.rs", "StudyTable")],
    );
}

#[test]
fn fields_of_calibrations_are_in_the_book() {
    let sources = Sources::of(&["crates/gravcal-report/src", CALIBRATION, MODEL, "crates/gravcal-estimation/src"]);
    let tables = sources.tables("crates/gravcal-report/src/calibration_file.rs", "Document");
    let unexplained = tables.iter().flat_map(|table| &table.keys).filter(|key| key.meaning.is_empty());
    assert_eq!(unexplained.map(|key| key.name.as_str()).collect::<Vec<_>>(), [""; 0]);
    let introduction = "The result of `gravcal calibrate`. Values are in SI, angles in rad; torque readings in the unit of their sensor. What is \
                        undetermined has the value `null`, never a number. The same input gives the same bytes.";
    keep("calibration.md", &page("calibration.json", introduction, &tables, false));
}

#[test]
fn help_of_every_command_is_in_the_book() {
    let commands: [&[&str]; 17] = [
        &[],
        &["calibrate"],
        &["check"],
        &["simulate"],
        &["inspect"],
        &["apply"],
        &["export"],
        &["compare"],
        &["study"],
        &["study", "run"],
        &["study", "merge"],
        &["study", "report"],
        &["study", "submit"],
        &["study", "status"],
        &["study", "cancel"],
        &["completions"],
        &["manual"],
    ];
    let mut text = "# Commands\n\nWhat each command prints with `--help`.\n".to_owned();
    for command in commands {
        let run = gravcal(command.iter().copied().chain(["--help"]));
        assert_eq!(run.code, 0, "{command:?}: {run:?}");
        let name = ["gravcal"].into_iter().chain(command.iter().copied()).collect::<Vec<_>>().join(" ");
        let help: Vec<&str> = run.stdout.lines().map(str::trim_end).collect();
        write!(text, "\n## `{name}`\n\n```text\n{}\n```\n", help.join("\n").trim_end()).unwrap();
    }
    keep("commands.md", &text);
}
