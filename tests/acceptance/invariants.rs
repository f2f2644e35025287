//! What ARCHITECTURE.md calls invariants, as far as the files of the project can hold them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::imports::Imports;
use crate::tree;

/// The crates that the program and its libraries are made of.
fn crates() -> Vec<PathBuf> {
    tree::folders(&tree::root().join("crates"))
}

/// Names under `[dependencies]` of a crate.
fn dependencies(name: &str) -> Vec<String> {
    let manifest: toml::Table = tree::read_toml(&tree::root().join("crates").join(name).join("Cargo.toml"));
    manifest["dependencies"].as_table().unwrap().keys().cloned().collect()
}

/// Those that are crates of this project.
fn own_dependencies(name: &str) -> Vec<String> {
    dependencies(name).into_iter().filter(|dependency| dependency.starts_with("gravcal")).collect()
}

#[test]
fn what_robots_recordings_and_estimation_are_made_of_is_independent() {
    for name in ["gravcal-estimation", "gravcal-dynamics", "gravcal-recording"] {
        assert_eq!(own_dependencies(name), [""; 0], "{name}");
    }
}

#[test]
fn solvers_know_estimation_only() {
    assert_eq!(own_dependencies("gravcal-solvers"), ["gravcal-estimation"]);
}

#[test]
fn identification_knows_estimation_only_and_names_no_robot() {
    assert_eq!(own_dependencies("gravcal-identification"), ["gravcal-estimation"]);
    let sources = tree::files_below(&tree::root().join("crates/gravcal-identification/src"));
    assert!(!sources.is_empty());
    for source in sources {
        let text = fs::read_to_string(&source).unwrap().to_lowercase();
        let mut code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let of_robots = ["robot", "joint", "torque", "gravity", "session"];
        let named = code.find(|line| of_robots.iter().any(|word| line.contains(word)));
        assert_eq!(named, None, "{}", source.display());
    }
}

#[test]
fn calibration_knows_neither_solvers_nor_reports() {
    let known = own_dependencies("gravcal-calibration");
    for stranger in ["gravcal-solvers", "gravcal-report"] {
        assert!(!known.iter().any(|name| name == stranger), "{stranger}");
    }
}

#[test]
fn a_robot_model_knows_neither_files_nor_estimators_and_a_session_no_estimator() {
    let model = ["gravcal-dynamics", "gravcal-estimation", "gravcal-recording"];
    assert_eq!(own_dependencies("gravcal-robot-model"), model);
    assert_eq!(own_dependencies("gravcal-session"), [&model[..], &["gravcal-robot-model"]].concat());
    let calibration = [
        "gravcal-dynamics",
        "gravcal-estimation",
        "gravcal-identification",
        "gravcal-recording",
        "gravcal-robot-model",
    ];
    assert_eq!(own_dependencies("gravcal-calibration"), calibration);
}

/// Files that may import each other in a circle.
const CIRCLE: usize = 3;

#[test]
fn few_files_import_each_other_in_a_circle() {
    for path in crates() {
        let mut roots = ["lib.rs", "main.rs"].iter().map(|file| path.join("src").join(file));
        let imports = Imports::of(&roots.find(|root| root.exists()).unwrap());
        let circles = imports.circles();
        let largest = circles.first().map_or(0, Vec::len);
        let reported = || circles.first().map(|circle| imports.within(circle)).unwrap_or_default();
        assert!(largest <= CIRCLE, "{largest} files import each other:\n{}", reported());
    }
}

#[test]
fn files_of_a_calibration_import_nothing_that_their_facade_defines() {
    for name in ["gravcal-calibration", "gravcal-identification", "gravcal-robot-model", "gravcal-session"] {
        let imports = Imports::of(&tree::root().join("crates").join(name).join("src/lib.rs"));
        let reported = imports.taken_from_own_facade();
        assert!(reported.is_empty(), "{reported}");
    }
}

#[test]
fn threads_enter_in_two_libraries_and_are_counted_by_the_program() {
    let names = crates().into_iter().map(|path| tree::name(&path));
    let threaded: Vec<String> = names.filter(|name| dependencies(name).contains(&"rayon".to_owned())).collect();
    assert_eq!(threaded, ["gravcal-cli", "gravcal-estimation", "gravcal-study"]);
}

#[test]
fn only_the_program_prints_or_reads_the_clock() {
    let libraries: Vec<PathBuf> = crates().into_iter().filter(|path| tree::name(path) != "gravcal-cli").collect();
    let sources: Vec<PathBuf> = libraries.iter().flat_map(|path| tree::files_below(&path.join("src"))).collect();
    assert!(sources.len() > libraries.len());
    let found: Vec<String> = sources.iter().flat_map(|source| forbidden(source)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Lines of a source, comments and tests aside, that print or read the clock.
fn forbidden(source: &Path) -> Vec<String> {
    let text = fs::read_to_string(source).unwrap();
    let program = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code = program.lines().filter(|line| !line.trim_start().starts_with("//"));
    let forbidden =
        code.filter(|line| ["Instant", "SystemTime", "print!(", "println!("].iter().any(|word| line.contains(word)));
    forbidden.map(|line| format!("{}: {}", source.display(), line.trim())).collect()
}

#[test]
fn every_model_is_a_robot_whose_numbers_have_a_source() {
    let models = tree::folders(&tree::root().join("models"));
    assert!(!models.is_empty(), "there is no model");
    for model in models {
        let has = |file: &str| model.join(file).is_file();
        assert!(has("robot.toml") || has("robot.urdf"), "{} has no robot", model.display());
        assert!(has("README.md"), "{} has no README.md", model.display());
    }
}
