//! The problem: seven joints on a tilted base, bare and with a load at two placements a known distance apart.

use std::path::Path;

use gravcal_calibration::joint::{JointProblem, Signals, State, build_problem, select};
use gravcal_robot_model::Session;
use gravcal_session::simulation::{Run, Simulation};

const SIMULATION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/seven-joints-tilted/simulation.toml");

/// A simulated session and its joint problem, built from the nominal start.
pub struct SevenJoints {
    /// The session.
    pub session: Session,
    /// Its joint problem.
    pub built: JointProblem,
}

impl SevenJoints {
    /// Draws that many poses, evenly over the tables (bare, the load's first placement, its second).
    ///
    /// # Errors
    /// Where the experiment's simulation cannot be read or built.
    pub fn simulate(poses: usize) -> Result<SevenJoints, String> {
        let mut simulation = Simulation::read(Path::new(SIMULATION)).map_err(|e| e.to_string())?;
        let tables = simulation.runs.len();
        for (table, run) in simulation.runs.iter_mut().enumerate() {
            *run = Run::Random { poses: poses / tables + usize::from(table < poses % tables) };
        }
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let built = build_problem(&session, &readings, &State::nominal(&session)).map_err(|e| e.to_string())?;
        Ok(SevenJoints { session, built })
    }

    /// Number of poses.
    pub fn poses(&self) -> usize {
        self.session.poses.len()
    }
}
