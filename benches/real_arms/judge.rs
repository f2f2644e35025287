//! One session: simulated, calibrated as `gravcal calibrate` does it, and held against its truth.

use std::fs;
use std::path::Path;

use gravcal_calibration::result::{EstimatorResult, Verdict};
use gravcal_calibration::{SolveEnvironment, check_choice};
use gravcal_robot_model::EstimatorName;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

use crate::arms::arms;
use crate::line::{Line, Setting, Source};
use crate::spoilt::{misjudge_masses, tabulate};

/// An estimated number beside the truth.
pub struct Reported {
    /// `joint2.torque_gain`.
    pub name: String,
    /// In standard deviations.
    pub error: f64,
    /// Whether its 95 % interval holds the truth.
    pub held: bool,
    pub std: f64,
}

/// What a session comes to.
pub struct Judged {
    /// Its name.
    pub arm: &'static str,
    pub exit: u8,
    pub reported: Vec<Reported>,
    /// Whether the report has the word that was looked for.
    pub named: bool,
}

/// Simulates, calibrates and judges one session. `named`: a word of its report.
///
/// # Errors
/// Where files cannot be written, or the simulation is refused.
pub fn judge(setting: &Setting, seed: u64, number: u64, folder: &Path, named: Option<&str>) -> Result<Judged, String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let all = arms(setting.from.moves());
    let arm = usize::try_from(number % all.len().max(1) as u64).ok().and_then(|place| all.get(place));
    let arm = arm.ok_or("no arm is there: name the folder of URDFs in GRAVCAL_SHARED_DATA")?;
    fs::create_dir_all(folder).map_err(|error| said(&error))?;
    let path = folder.join("simulation.toml");
    fs::write(&path, setting.simulation(arm, seed, number)).map_err(|error| said(&error))?;
    let simulation = Simulation::read(&path).map_err(|error| said(&error))?;
    let files = write_session(&simulation, 0, folder, true).map_err(|error| said(&error))?;
    let text = fs::read_to_string(&files[0]).map_err(|error| said(&error))?;
    fs::write(&files[0], setting.spoil(text, arm)?).map_err(|error| said(&error))?;
    match (setting.from, &arm.urdf) {
        (Source::Sweeps, Some(urdf)) => misjudge_masses(&files[0], urdf, seed ^ number.rotate_left(32))?,
        (Source::Table, _) => tabulate(&files[0])?,
        _ => {}
    }
    Ok(match calibrated(&files[0]) {
        Ok(result) => Judged {
            arm: arm.name,
            exit: match result.verdict {
                Verdict::Determined => 0,
                Verdict::PartlyDetermined => 3,
                Verdict::Failed => 4,
            },
            reported: reported(setting, &simulation, &result),
            named: named.is_some_and(|word| has(&result, word)),
        },
        Err(refused) => {
            let named = named.is_some_and(|word| refused.contains(word));
            Judged { arm: arm.name, exit: 2, reported: Vec::new(), named }
        }
    })
}

fn calibrated(path: &Path) -> Result<EstimatorResult, String> {
    let session = read_session(path).map_err(|error| error.to_string())?;
    let (solver, estimators) = (LevenbergMarquardt::default(), [EstimatorName::Joint]);
    check_choice(&session, &estimators, &solver).map_err(|error| error.to_string())?;
    let results = gravcal_calibration::calibrate(&session, &estimators, &SolveEnvironment::new(&solver, &|_| {}));
    results.into_iter().next().ok_or_else(|| "no estimator answered".to_owned())
}

/// Whatever was estimated and has a truth; the friction of a session that estimates it stands for bristles, and has none.
fn reported(setting: &Setting, simulation: &Simulation, result: &EstimatorResult) -> Vec<Reported> {
    let session = &simulation.template;
    let of = |id| {
        let name = session.parameter_name(id);
        let found = result.parameter(&name)?;
        let ((value, std), ci95) = (found.value.zip(found.std)?, found.ci95?);
        let has_truth = std > 0.0 && !(setting.line == Line::Coulomb && name.ends_with("coulomb_friction"));
        let truth = simulation.truth.value(id);
        let held = (ci95[0]..=ci95[1]).contains(&truth);
        has_truth.then(|| Reported { error: (value - truth) / std, held, std, name })
    };
    session.parameters().into_iter().filter_map(of).collect()
}

fn has(result: &EstimatorResult, word: &str) -> bool {
    let undetermined = result.undetermined.iter().flat_map(|one| [&one.why, &one.cure]);
    result.notes.iter().chain([&result.termination]).chain(undetermined).any(|text| text.contains(word))
}
