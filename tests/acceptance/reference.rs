//! The pages of `docs/reference` that are written by the program's own sources, so that they cannot drift: the keys of its files,
//! and its help; and schemas, by which editors know these keys.
//!
//! `GRAVCAL_UPDATE_REFERENCE=1 cargo test --release -p gravcal-cli --test acceptance reference` writes them anew.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::keys::{Key, Sources, Table};
use crate::program::gravcal;
use crate::schema::Schema;
use crate::tree;

const UPDATE: &str = "GRAVCAL_UPDATE_REFERENCE";

const CALIBRATION: &str = "crates/gravcal-calibration/src";
const MODEL: &str = "crates/gravcal-robot-model/src";
const RECORDING: &str = "crates/gravcal-recording/src";
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
    let Key { name, kind, unit, default, meaning, example, .. } = key;
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

/// A page on a file, and its schema.
struct Reference {
    file: &'static str,
    introduction: &'static str,
    tables: Vec<Table>,
}

impl Reference {
    /// Of what some structs read or write, all of them at the top of the file.
    fn new(file: &'static str, introduction: &'static str, folders: &[&str], roots: &[(&str, &str)]) -> Reference {
        let sources = Sources::of(folders);
        let mut tables: Vec<Table> = roots.iter().flat_map(|(file, root)| sources.tables(file, root)).collect();
        let others: Vec<usize> = (1..tables.len()).filter(|at| tables[*at].header.is_empty()).collect();
        for at in others.into_iter().rev() {
            let keys = tables.remove(at).keys;
            tables[0].keys.extend(keys);
        }
        Reference { file, introduction, tables }
    }

    fn session() -> Reference {
        Reference::new(
            "session.toml",
            "All that is known beforehand. A key without a default is optional where it says –. Where a value may differ by joint it is one for \
             all or a list with one for each. Some sections exclude each other; gravcal says which.",
            &[SESSION, MODEL],
            &[("crates/gravcal-session/src/file/session_table.rs", "SessionTable")],
        )
    }

    fn robot() -> Reference {
        Reference::new(
            "robot.toml",
            "A robot by its Denavit-Hartenberg rows. In place of this file a session may name a URDF.",
            &[SESSION, MODEL, "crates/gravcal-dynamics/src"],
            &[("crates/gravcal-session/src/robot_file/file.rs", "RobotTable")],
        )
    }

    fn simulation() -> Reference {
        Reference::new(
            "simulation.toml",
            "What `gravcal simulate` makes: a session, its tables, and `truth.toml` with the values that a calibration should find.",
            &[SESSION, MODEL],
            &[
                ("crates/gravcal-session/src/simulation/file/tables.rs", "SimulationTable"),
                ("crates/gravcal-session/src/simulation/file/instruments.rs", "InstrumentTables"),
            ],
        )
    }

    fn study() -> Reference {
        Reference::new(
            "study.toml",
            "What `gravcal study run` simulates, varies and compares. Paths are relative to the study, and in `session` too.",
            &["crates/gravcal-study/src/plan"],
            &[("crates/gravcal-study/src/plan/file.rs", "StudyTable")],
        )
    }

    fn calibration() -> Reference {
        Reference::new(
            "calibration.json",
            "The result of `gravcal calibrate`. Values are in SI, angles in rad; torque readings in the unit of their sensor. What is \
             undetermined has the value `null`, never a number. The same input gives the same bytes.",
            &["crates/gravcal-report/src", CALIBRATION, MODEL, RECORDING, "crates/gravcal-estimation/src"],
            &[("crates/gravcal-report/src/calibration_file.rs", "Document")],
        )
    }

    fn schema(&self) -> Schema {
        Schema::of(self.file, self.introduction, &self.tables)
    }

    /// The page, and the schema beside it.
    fn keep(&self, examples: bool) {
        let name = self.file.split('.').next().unwrap();
        keep(&format!("{name}.md"), &page(self.file, self.introduction, &self.tables, examples));
        keep(&format!("schema/{name}.json"), &self.schema().text());
    }
}

#[test]
fn keys_of_files_that_are_read_are_in_the_book() {
    for reference in [Reference::session(), Reference::robot(), Reference::simulation(), Reference::study()] {
        check(&reference.tables);
        reference.keep(true);
    }
}

#[test]
fn fields_of_calibrations_are_in_the_book() {
    let reference = Reference::calibration();
    let unexplained = reference.tables.iter().flat_map(|table| &table.keys).filter(|key| key.meaning.is_empty());
    assert_eq!(unexplained.map(|key| key.name.as_str()).collect::<Vec<_>>(), [""; 0]);
    reference.keep(false);
}

/// What an example shows is what its schema allows.
#[test]
fn examples_of_keys_obey_their_schemas() {
    for reference in [Reference::session(), Reference::robot(), Reference::simulation(), Reference::study()] {
        let schema = reference.schema();
        for (table, key) in reference.tables.iter().flat_map(|table| table.keys.iter().map(move |key| (table, key))) {
            let example: Value = toml::from_str(key.example.trim_matches('`')).unwrap();
            let faults = schema.faults(&key.schema, &example[&key.name]);
            assert!(faults.is_empty(), "{} {}: {example} {faults:?}", table.header, key.name);
        }
    }
}

/// The project's own files of a kind, by what their names hold.
fn own_files(reference: &Reference) -> Vec<PathBuf> {
    let name = reference.file.trim_end_matches(".toml");
    let is_meant = |file: &Path| match tree::name(file) {
        // Robots with wrong lengths.
        other if other.ends_with("-off.toml") => name == "robot",
        other => other == reference.file,
    };
    let folders = ["experiments", "models", "benches", "tests/extension/tests"].map(|folder| tree::root().join(folder));
    folders.iter().flat_map(|folder| tree::files_below(folder)).filter(|file| is_meant(file)).collect()
}

#[test]
fn the_projects_own_files_obey_their_schemas() {
    for (reference, least) in
        [(Reference::session(), 7), (Reference::robot(), 6), (Reference::simulation(), 5), (Reference::study(), 12)]
    {
        let (schema, files) = (reference.schema(), own_files(&reference));
        assert!(files.len() >= least, "{}: {files:?}", reference.file);
        for file in files {
            let value: Value = tree::read_toml(&file);
            assert_eq!(schema.faults_of_file(&value), [""; 0], "{}", file.display());
            assert_slips_are_seen(&schema, &value);
        }
    }
}

/// A key that is misspelled, and a text where a table should stand, at the top and one level below.
fn assert_slips_are_seen(schema: &Schema, value: &Value) {
    let mut misspelled = value.clone();
    misspelled["robt"] = "robot.toml".into();
    assert_eq!(schema.faults_of_file(&misspelled), ["/robt: no such key"]);
    for (key, inside) in value.as_object().unwrap().iter().filter(|(_, inside)| inside.is_object()) {
        let mut slip = value.clone();
        slip[key] = "text".into();
        // A session in a study or simulation is checked when it is read.
        let open = key == "session" || (key == "robot" && inside["urdf"].is_string());
        assert!(open || !schema.faults_of_file(&slip).is_empty(), "{key}");
    }
}

#[test]
fn a_calibration_obeys_its_schema() {
    let schema = Reference::calibration().schema();
    for experiment in ["sarcos-shoulder", "seven-joints-upright"] {
        let results = tempfile::tempdir().unwrap();
        let session = tree::experiment(experiment).join("session.toml");
        gravcal(["calibrate".as_ref(), session.as_os_str(), "--output".as_ref(), results.path().as_os_str()]);
        let text = fs::read_to_string(results.path().join("calibration.json")).unwrap();
        let mut value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(schema.faults_of_file(&value), [""; 0], "{experiment}");
        value["estimators"][0]["parameters"][0]["value"] = "7".into();
        assert_eq!(schema.faults_of_file(&value).len(), 1);
    }
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
