//! One session: simulated, calibrated as `gravcal calibrate` does it, and held against its truth.

use std::fs;
use std::path::{Path, PathBuf};

use gravcal_calibration::result::{EstimatorResult, Verdict};
use gravcal_calibration::{SolveEnvironment, check_choice};
use gravcal_robot_model::EstimatorName;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

use crate::arms::{Arm, arms};
use crate::line::{Line, Recording, Setting, Source};
use crate::spoilt::{misjudge_masses, tabulate, write_degrees};

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
    let arm = arm_of(setting, number)?;
    let (simulation, session) = recorded(setting, &arm, Recording { seed, number, take: 0, moved: None }, folder)?;
    Ok(match calibrated(&session) {
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

/// The arm of a session: they take turns.
pub fn arm_of(setting: &Setting, number: u64) -> Result<Arm, String> {
    let mut all = arms(setting.from.moves());
    let place = usize::try_from(number % all.len().max(1) as u64).unwrap_or(0);
    match place < all.len() {
        true => Ok(all.swap_remove(place)),
        false => Err("no arm is there: name the folder of URDFs in GRAVCAL_SHARED_DATA".into()),
    }
}

/// Simulates one recording, and its session as a user of that line writes it.
pub fn recorded(
    setting: &Setting,
    arm: &Arm,
    recording: Recording,
    folder: &Path,
) -> Result<(Simulation, PathBuf), String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    fs::create_dir_all(folder).map_err(|error| said(&error))?;
    let path = folder.join("simulation.toml");
    fs::write(&path, setting.simulation(arm, recording)).map_err(|error| said(&error))?;
    let simulation = Simulation::read(&path).map_err(|error| said(&error))?;
    let mut files = write_session(&simulation, 0, folder, true).map_err(|error| said(&error))?;
    let session = files.swap_remove(0);
    let text = fs::read_to_string(&session).map_err(|error| said(&error))?;
    fs::write(&session, setting.spoil(text, arm)?).map_err(|error| said(&error))?;
    if setting.line == Line::Radians {
        write_degrees(folder)?;
    }
    match (setting.from, &arm.urdf) {
        (Source::Sweeps, Some(urdf)) => {
            misjudge_masses(&session, urdf, recording.seed ^ recording.number.rotate_left(32))?
        }
        (Source::Table, _) => tabulate(&session)?,
        _ => {}
    }
    Ok((simulation, session))
}

/// The joint estimate, as `gravcal calibrate` makes it.
pub fn calibrated(path: &Path) -> Result<EstimatorResult, String> {
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
