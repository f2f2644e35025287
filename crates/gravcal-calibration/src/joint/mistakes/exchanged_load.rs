//! Tables with and without the one load there is, exchanged.
//!
//! The same readings are those of gravity the other way up, with the zero of a joint half a turn away: residuals may say nothing of it. Then the robot's assumed
//! masses tell, whose torques those of the estimated ones oppose.

use std::sync::Arc;

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use super::assumed_masses::{OPPOSED, agreement};
use super::hypothesis::{Hypothesis, Mistake};
use super::reversed::{AS_GOOD, solve_with};
use crate::joint::ends::symmetries::not_as_declared;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// Poses that are said to be bare carry the load, and the other way round.
#[derive(Clone, Copy, Debug)]
struct ExchangedLoad;

/// The one there is, where some poses carry the only load, and some none.
pub(super) fn all(session: &Session) -> Option<Arc<dyn Hypothesis>> {
    let loaded = session.poses.iter().filter(|pose| pose.load.is_some()).count();
    let exchangeable = session.loads.len() == 1 && (1..session.poses.len()).contains(&loaded);
    exchangeable.then(|| Arc::new(ExchangedLoad) as Arc<dyn Hypothesis>)
}

impl Hypothesis for ExchangedLoad {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        made.poses.iter_mut().for_each(|pose| pose.load = if pose.load.is_some() { None } else { Some(0) });
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let what = format!("tables with and without load {} exchanged", session.loads[0].name);
        (what, "Exchange load = … among the [[poses]].".to_owned())
    }
}

/// Looks for tables that are exchanged where residuals say nothing of it: exchanged they explain the readings as well, all gains and zeros are as declared, and the
/// estimated masses go with the assumed ones, which they do not as it stands.
pub(super) fn hidden_exchange(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    let Some(exchanged) = all(session) else { return Ok(None) };
    // Noise that few wrong readings make excuses whatever else is wrong.
    if solved.heavy_tails(session)?.is_some() {
        return Ok(None);
    }
    let here = solved.state(&State::nominal(session));
    let opposes = |session: &Session, state: &State| agreement(session, solved, state).map(|with| with < OPPOSED);
    if not_as_declared(session, &here) == 0 && opposes(session, &here) != Some(true) {
        return Ok(None);
    }
    let made = exchanged.made(session);
    let upside_down = Session { gravity: made.gravity.other_hemisphere(), ..made.clone() };
    for (made, turned) in [(made, false), (upside_down, true)] {
        let (cost, state) = solve_with(&made, solved.readings(), solved, environment)?;
        let as_good = cost <= AS_GOOD * solved.least_cost() && not_as_declared(&made, &state) == 0;
        if as_good && opposes(&made, &state) == Some(false) {
            let (what, cure) = exchanged.words(session);
            let also = if turned {
                " Then gravity lies in the other hemisphere: turn [gravity] hemisphere round, too."
            } else {
                ""
            };
            let advice = format!(
                "The readings are explained as well with the {what}, with all gains and zeros as declared; and only then gravity torques go with those of \
                 the masses in the robot's file. {cure}{also}"
            );
            return Ok(Some(Mistake { what, advice }));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use gravcal_session::simulation::Simulation;

    use super::*;
    use crate::result::Verdict;
    use crate::testing::sensor_models::estimate;

    const ROBOT: &str = r#"
name = "arm"
convention = "standard-dh"
joint = [
    { name = "joint1", a_m = 0.0, alpha_deg = 90.0, d_m = 0.36, mass_kg = 4.0, center_of_mass_m = [0.0, -0.1, 0.02] },
    { name = "joint2", a_m = 0.4, alpha_deg = 0.0, d_m = 0.0, mass_kg = 3.0, center_of_mass_m = [-0.2, 0.0, 0.03] },
    { name = "joint3", a_m = 0.3, alpha_deg = 0.0, d_m = 0.0, mass_kg = 2.0, center_of_mass_m = [-0.1, 0.02, 0.0] },
]"#;
    const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 3
[gravity]
direction = [0.3, 0.1, -1.0]
magnitude_m_per_s2 = 9.80665
hemisphere = [0.3, 0.1, -1.0]
[torque]
unit = "N·m"
std = 0.02
[position]
unit = "rad"
[[load]]
name = "plate"
mass_kg = 2.0
link = "link3"
position_m = [0.05, 0.02, 0.1]
[[random]]
file = "bare.csv"
poses = 30
[[random]]
file = "loaded.csv"
poses = 30
load = "plate"
"#;

    /// An arm on a tilted base, bare and with a plate.
    fn bare_and_loaded() -> Session {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), ROBOT).unwrap();
        fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
        Simulation::read(&folder.path().join("simulation.toml")).unwrap().session(0)
    }

    fn named(session: &Session) -> Option<String> {
        let result = estimate(session);
        let named = result.notes.into_iter().find(|note| note.contains("with and without load plate exchanged"));
        assert_eq!(result.verdict == Verdict::Failed, named.is_some());
        named
    }

    /// Noise that is found about it makes all residuals as good.
    #[test]
    fn one_wrong_cell_accuses_no_tables() {
        let mut session = bare_and_loaded();
        session
            .poses
            .iter_mut()
            .flat_map(|pose| pose.torque.iter_mut().flatten())
            .for_each(|reading| reading.std = None);
        session.poses[5].torque[1].as_mut().unwrap().value = 1e9;
        let result = estimate(&session);
        assert!(!result.notes.concat().contains("exchanged"), "{:?}", result.notes);
    }

    #[test]
    fn what_residuals_do_not_show_the_assumed_masses_do() {
        let right = bare_and_loaded();
        assert_eq!(named(&right), None);
        let exchanged = ExchangedLoad.made(&right);
        let told = named(&exchanged).unwrap();
        assert!(told.contains("Exchange load = …") && !told.contains("turn [gravity]"), "{told}");
        let upside_down = Session { gravity: exchanged.gravity.other_hemisphere(), ..exchanged.clone() };
        let told = named(&upside_down).unwrap();
        assert!(told.contains("turn [gravity] hemisphere round, too"), "{told}");
        let only_upside_down = Session { gravity: right.gravity.other_hemisphere(), ..right.clone() };
        assert_eq!(named(&only_upside_down), None, "the masses go with the tables as they are");
    }
}
