//! Batches: a study gives the same table however it is run, says what failed, and refuses what it cannot do.

use std::fs;
use std::path::{Path, PathBuf};

use gravcal_study::batch::{Manifest, Outcome, StudyFolder};
use gravcal_study::measures::{QuantityMeasures, Series, measure};
use serde::Deserialize;
use tempfile::TempDir;

use crate::program::{BAD_INPUT, Run, gravcal};
use crate::tree;

/// A study of the Sarcos shoulder in a folder of its own.
pub struct Study {
    folder: TempDir,
}

impl Study {
    pub fn new(rest: &str) -> Study {
        let simulation = tree::experiment("sarcos-shoulder").join("simulation.toml");
        Study::of(&format!("simulation = '{}'\n{rest}", simulation.display()))
    }

    fn of(text: &str) -> Study {
        let study = Study { folder: tempfile::tempdir().unwrap() };
        fs::write(study.path(), text).unwrap();
        study
    }

    /// Two points, noise of two sizes.
    pub fn small(trials: u64) -> Study {
        Study::new(&format!(
            "trials = {trials}\nestimators = ['sequential', 'joint']\n\
             [[vary]]\nname = 'noise'\nunit = 'count'\nfield = 'torque.std'\nvalues = [0.4, 0.8]\n"
        ))
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("study.toml")
    }

    pub fn results(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn arguments(&self, results: &str, options: &[&str]) -> Vec<String> {
        let fixed = ["study", "run"].map(str::to_owned);
        let paths = [self.path().display().to_string(), "--output".into(), self.results(results).display().to_string()];
        fixed.into_iter().chain(paths).chain(options.iter().map(|option| (*option).to_owned())).collect()
    }

    pub fn run(&self, results: &str, options: &[&str]) -> Run {
        gravcal(self.arguments(results, options))
    }

    pub fn table(&self, results: &str) -> Vec<u8> {
        fs::read(self.results(results).join("trials.parquet")).unwrap()
    }

    fn measures(&self, results: &str) -> Vec<Series> {
        self.table_of_measures(results).series
    }

    pub fn table_of_measures(&self, results: &str) -> Table {
        let folder = StudyFolder::open(&self.results(results)).unwrap();
        Table { series: measure(&folder).unwrap(), manifest: folder.manifest }
    }
}

/// What a study of one point came to.
pub struct Table {
    manifest: Manifest,
    series: Vec<Series>,
}

impl Table {
    pub fn trials(&self) -> u64 {
        self.manifest.trials
    }

    pub fn quantities(&self) -> impl Iterator<Item = &str> {
        self.manifest.quantities.iter().map(|(name, _)| name.as_str())
    }

    /// One quantity by one estimator.
    pub fn of(&self, estimator: &str, quantity: &str) -> &QuantityMeasures {
        let place = self.quantities().position(|name| name == quantity).unwrap();
        let named = |series: &&Series| self.manifest.estimators[series.estimator] == estimator;
        &self.series.iter().find(named).unwrap().quantities[place]
    }
}

#[test]
fn threads_and_shares_give_the_same_table() {
    let study = Study::small(20);
    assert_eq!(study.run("one", &["--threads", "1"]).code, 0);
    assert_eq!(study.run("two", &["--threads", "2"]).code, 0);
    assert!(study.table("one") == study.table("two"), "the table depends on the number of threads");

    for share in ["1/4", "2/4", "3/4", "4/4"] {
        assert_eq!(study.run(&format!("share{}", &share[..1]), &["--shard", share]).code, 0);
    }
    let folders = ["share1", "share2", "share3", "share4"].map(|name| study.results(name).display().to_string());
    let incomplete = gravcal(["study", "merge", &folders[0], &folders[1]]);
    assert_eq!((incomplete.code, incomplete.refusal(&["parts are missing"])), (BAD_INPUT, None));
    let merged = gravcal(["study".to_owned(), "merge".to_owned()].into_iter().chain(folders));
    assert_eq!(merged.code, 0, "{merged:?}");
    assert!(study.table("one") == study.table("share1"), "the table depends on the shares");
    for file in ["report.txt", "report.md", "measures.csv", "error-over-noise.svg"] {
        let [whole, shared] = ["one", "share1"].map(|name| fs::read(study.results(name).join(file)).unwrap());
        assert!(whole == shared, "{file} depends on the shares");
    }
}

#[test]
fn a_trial_that_fails_is_a_row_with_its_reason() {
    // A fifth of the readings are far off, which the session does not know.
    let study = Study::new(
        "trials = 3\nestimators = ['joint']\n\
         [[change]]\nfield = 'torque.outliers'\nvalue = { share = 0.2, std = 200.0 }\n",
    );
    let run = study.run("results", &[]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(
        run.stdout.contains("No trial has an estimate.") && run.stdout.contains("contradicts the readings"),
        "{}",
        run.stdout
    );
    let folder = study.results("results").display().to_string();
    let all = gravcal(["study", "report", &folder, "--full"]);
    assert!(all.stdout.contains("joint: failed 100 %"), "{}", all.stdout);
    let series = study.measures("results");
    assert_eq!(series[0].outcomes[Outcome::Failed as usize], 3);
    assert!(series[0].reasons[0].0.contains("contradicts the readings"), "{:?}", series[0].reasons);
    assert!(series[0].quantities.iter().all(|quantity| quantity.estimates == 0));
}

#[test]
fn what_a_study_found_fits_on_a_screen() {
    let study = Study::small(20);
    let run = study.run("results", &[]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stdout.lines().count() <= 25, "{}", run.stdout);
    let mut lines = run.stdout.lines().filter(|line| !line.starts_with("Results in "));
    assert!(lines.all(|line| line.chars().count() <= 80), "{}", run.stdout);
    let rows = ["0.4", "0.8"].map(|noise| run.stdout.lines().filter(|line| line.starts_with(noise)).count());
    assert_eq!(rows, [2, 2], "{}", run.stdout);

    let folder = study.results("results").display().to_string();
    let all = gravcal(["study", "report", &folder, "--full"]).stdout;
    let report = fs::read_to_string(study.results("results").join("report.txt")).unwrap();
    assert!(all.starts_with(&report), "{all}");
    let quiet = gravcal(["study", "report", &folder, "--quiet"]).stdout;
    assert!(quiet.starts_with("Results in ") && quiet.lines().count() == 1, "{quiet}");
}

#[test]
fn an_axis_may_bear_the_name_of_a_column() {
    let vary = "[[vary]]\nname = 'estimator'\nfield = 'torque.std'\nvalues = [0.8]\n";
    let study = Study::new(&format!("trials = 1\nestimators = ['joint']\n{vary}"));
    let run = study.run("results", &["--quiet"]);
    assert_eq!(run.code, 0, "{run:?}");
    let measures = fs::read_to_string(study.results("results").join("measures.csv")).unwrap();
    assert!(measures.starts_with("varied estimator,estimator,solver,quantity,unit,"), "{measures}");
}

#[test]
fn every_robot_of_a_family_is_another() {
    let study = Study::of("random_arms = { know = 'nominal' }\ntrials = 4\nestimators = ['joint']\n");
    let run = study.run("results", &[]);
    assert_eq!(run.code, 0, "{run:?}");
    let counted: Vec<u64> = study.measures("results")[0].quantities.iter().map(|q| q.estimates).collect();
    assert!(counted.contains(&4) && counted.iter().any(|count| *count < 4), "{counted:?}");
}

#[test]
fn a_drawn_truth_is_measured_against_itself() {
    let study = Study::new(
        "trials = 12\nestimators = ['joint']\n[[change]]\nfield = 'torque.converter'\ndrop = true\n\
         [draw]\ntorque_gain_relative = 0.2\ntorque_bias = 50\nposition_gain_relative = 0.02\nposition_offset_deg = 10\n\
         gravity_deg = 10\n",
    );
    assert_eq!(study.run("results", &[]).code, 0);
    for quantity in &study.measures("results")[0].quantities {
        assert_eq!(quantity.estimates, 12);
        // Within five Monte-Carlo errors of χ² with 12 degrees of freedom.
        assert!((0.3..2.0).contains(&quantity.ratio.value), "{quantity:?}");
    }
}

#[test]
fn what_cannot_be_studied_is_refused_by_name() {
    let said = |rest: &str| format!("trials = 2\nestimators = ['joint']\n{rest}");
    let vary = |rest: &str| said(&format!("[[vary]]\nname = 'noise'\n{rest}"));
    let random = "[[change]]\nfield = 'sweep'\ndrop = true\n[[change]]\nfield = 'random'\nvalue = [{ file = 'a.csv', poses = 40 }]\n";
    let cases: [(&str, String, &[&str]); 14] = [
        (
            "unknown field",
            vary("field = 'torque.nose'\nvalues = [1]"),
            &["torque.nose", "unknown field `nose`", "noise = 1"],
        ),
        ("empty grid", vary("field = 'torque.std'\nvalues = []"), &["vary[0].values", "empty"]),
        ("neither field nor cases", vary(""), &["vary[0]", "`cases`"]),
        ("no element", vary("field = 'sweep.11.poses'\nvalues = [9]"), &["sweep", "11 elements"]),
        ("a value that does not fit", vary("field = 'torque.std'\nvalues = [-1]"), &["torque.std", "-1", "noise = -1"]),
        (
            "a session that does not fit",
            vary("field = 'session.loss.kind'\nvalues = ['l1']"),
            &["loss", "l1", "noise = l1"],
        ),
        (
            "twice the same axis",
            vary("field = 'torque.std'\nvalues = [1]\n[[vary]]\nname = 'noise'\ncases = [{ name = 1 }]"),
            &["noise"],
        ),
        ("no trials", "trials = 0\nestimators = ['joint']".into(), &["trials"]),
        ("no estimator", "trials = 1\nestimators = []".into(), &["estimators", "sequential"]),
        ("unknown estimator", "trials = 1\nestimators = ['kalman']".into(), &["estimators[0]", "kalman", "sequential"]),
        ("unknown solver", said("solvers = ['newton']"), &["solvers", "newton", "levenberg-marquardt"]),
        (
            "no sweeps for the steps",
            format!("trials = 1\nestimators = ['sequential']\n{random}"),
            &["sequential", "no sweeps"],
        ),
        ("both sources", said("random_arms = { know = 'nominal' }"), &["random_arms"]),
        (
            "constraints without their solver",
            said("[[change]]\nfield = 'session.constraints.masses'\nvalue = 'positive'"),
            &["constraints"],
        ),
    ];
    for (what, rest, reported) in cases {
        let study = Study::new(&rest);
        let run = study.run("results", &[]);
        assert_eq!(run.code, BAD_INPUT, "{what}: {run:?}");
        for part in reported {
            assert!(run.stderr.contains(part), "{what}: `{part}` is not told: {}", run.stderr);
        }
        assert!(!study.results("results").join("trials.parquet").exists(), "{what}: results were written");
    }
}

#[test]
fn results_of_another_study_stay() {
    let study = Study::small(2);
    assert_eq!(study.run("results", &[]).code, 0);
    let before = study.table("results");
    let text = fs::read_to_string(study.path()).unwrap();
    fs::write(study.path(), text.replace("trials = 2", "trials = 3")).unwrap();
    let refused = study.run("results", &[]);
    assert_eq!((refused.code, refused.refusal(&["another study", "--output"])), (BAD_INPUT, None));
    assert!(study.table("results") == before);
    let nothing = gravcal(["study", "report", &study.results("elsewhere").display().to_string()]);
    assert_eq!((nothing.code, nothing.refusal(&["there is no such folder", "study.json"])), (BAD_INPUT, None));

    let other = Study::small(4);
    assert_eq!(other.run("results", &[]).code, 0);
    let folders = [&study, &other].map(|study| study.results("results").display().to_string());
    let unlike = gravcal(["study", "merge", &folders[0], &folders[1]]);
    assert_eq!((unlike.code, unlike.refusal(&["another study"])), (BAD_INPUT, None));

    fs::write(study.results("results").join("study.json"), "nothing").unwrap();
    let unknown = study.run("results", &[]);
    assert_eq!((unknown.code, unknown.refusal(&["study.json", "another folder"])), (BAD_INPUT, None));
    assert!(study.table("results") == before);
}

#[test]
fn damaged_parts_and_a_lost_table_are_done_again() {
    let study = Study::small(16);
    assert_eq!(study.run("whole", &[]).code, 0);
    assert_eq!(study.run("mended", &["--shard", "1/2"]).code, 0);
    let parts = tree::entries(&study.results("mended").join("parts"));
    let part = parts.iter().find(|path| path.extension().is_some_and(|extension| extension == "parquet")).unwrap();
    let sound = fs::read(part).unwrap();
    fs::write(part, &sound[..50]).unwrap();
    assert_eq!(study.run("mended", &["--shard", "1/2"]).code, 0);
    assert!(fs::read(part).unwrap() == sound);
    // Some bits of a part are those of numbers, and are read without complaint.
    for place in (8..sound.len() - 8).step_by(sound.len() / 12) {
        let mut flipped = sound.clone();
        flipped[place] ^= 1;
        fs::write(part, flipped).unwrap();
        assert_eq!(study.run("mended", &["--shard", "1/2"]).code, 0);
        assert!(fs::read(part).unwrap() == sound, "byte {place}");
    }
    assert_eq!(study.run("mended", &[]).code, 0);
    assert!(study.table("whole") == study.table("mended"));

    fs::remove_file(study.results("mended").join("trials.parquet")).unwrap();
    assert_eq!(study.run("mended", &[]).code, 0);
    assert!(study.table("whole") == study.table("mended"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_made_is_reported() {
    let study = Study::small(2);
    let refused = gravcal(["study", "run", &study.path().display().to_string(), "--output", "/dev/full/results"]);
    assert_eq!((refused.code, refused.refusal(&["/dev/full"])), (BAD_INPUT, None));
}

/// `expected.toml` of a study: what a smaller version of it must come to.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    /// Trials at each point.
    trials: u64,
    measure: Vec<ExpectedMeasure>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExpectedMeasure {
    /// Such as `noise = 0.2 count, converter = none`; nothing where nothing is varied.
    #[serde(default)]
    at: String,
    estimator: String,
    /// A quantity, with `of`; or none, with `share` of an outcome.
    quantity: Option<String>,
    of: String,
    least: f64,
    most: f64,
}

#[test]
fn every_study_of_the_experiments_comes_to_what_it_says() {
    let folders = tree::folders(&tree::root().join("experiments"));
    let studies: Vec<PathBuf> = folders.into_iter().filter(|folder| folder.join("study.toml").exists()).collect();
    assert!(studies.len() >= 10, "{studies:?}");
    for study in studies {
        check_experiment(&study);
    }
}

fn check_experiment(folder: &Path) {
    let expected: Expected = tree::read_toml(&folder.join("expected.toml"));
    let text = fs::read_to_string(folder.join("study.toml")).unwrap();
    let trials = text.lines().find(|line| line.starts_with("trials = ")).unwrap();
    // Paths in a study are relative to it.
    let beside = tempfile::Builder::new().prefix("small-").suffix(".toml").tempfile_in(folder).unwrap();
    fs::write(beside.path(), text.replace(trials, &format!("trials = {}", expected.trials))).unwrap();
    let results = tempfile::tempdir().unwrap();
    let paths = [beside.path(), results.path()].map(|path| path.display().to_string());
    let run = gravcal(["study", "run", &paths[0], "--output", &paths[1]]);
    assert_eq!(run.code, 0, "{}: {run:?}", folder.display());
    let results = StudyFolder::open(results.path()).unwrap();
    let series = measure(&results).unwrap();
    for wanted in &expected.measure {
        let found = find(&results, &series, wanted);
        let reported = format!("{}: {wanted:?}", folder.display());
        let found = found.unwrap_or_else(|| panic!("{reported}: there is no such measure"));
        assert!((wanted.least..=wanted.most).contains(&found), "{reported}: {found}");
    }
}

fn find(results: &StudyFolder, series: &[Series], wanted: &ExpectedMeasure) -> Option<f64> {
    let manifest = &results.manifest;
    let series = series.iter().find(|series| {
        manifest.reported(series.point) == wanted.at && manifest.estimators[series.estimator] == wanted.estimator
    })?;
    let Some(quantity) = &wanted.quantity else {
        return Some(series.share(wanted.of.parse().ok()?));
    };
    let place = manifest.quantities.iter().position(|(name, _)| name == quantity)?;
    let measures = &series.quantities[place];
    Some(match wanted.of.as_str() {
        "rms" => measures.rms.value,
        "ratio" => measures.ratio.value,
        "nees" => measures.nees.value,
        "coverage" => measures.coverage.value,
        "estimates" => measures.estimates as f64,
        _ => return None,
    })
}
