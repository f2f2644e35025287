//! The problem: seven joints on a tilted base, bare and with a load at two placements a known distance apart.

use std::path::Path;
use std::sync::Arc;

use gravcal_calibration::joint::{JointProblem, Signals, State, build_problem, select};
use gravcal_estimation::{Block, BlockId, Factor, Noise, Problem, ProblemBuilder, Values};
use gravcal_robot_model::Session;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{Prior, Shift, Shifted};
use gravcal_session::simulation::{Run, Simulation};

const SIMULATION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/seven-joints-tilted/simulation.toml");

/// Standard deviation of a joint's position error, rad.
pub const POSITION_ERROR: f64 = 5e-4;

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
            *run = Run::Random { poses: poses / tables + usize::from(table < poses % tables), moving: None };
        }
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let built = build_problem(&session, &readings, &State::nominal(&session)).map_err(|e| e.to_string())?;
        Ok(SevenJoints { session, built })
    }

    /// The problem, and where it starts, with the error of every joint's position in every pose as a further unknown: seven a pose, known beforehand to
    /// [`POSITION_ERROR`], and eliminated if so wished.
    ///
    /// # Errors
    /// Where the problem cannot be built.
    pub fn with_position_errors(&self, eliminated: bool) -> Result<(Problem, Values), String> {
        let SevenJoints { session, built } = self;
        let mut builder = ProblemBuilder::new();
        for id in built.problem.block_ids() {
            builder.add_block(built.problem.block(id).clone(), built.initial.get(id));
        }
        let offset = |ids: &[BlockId; 4]| Shift::of_scalar(ids[SensorParameter::PositionOffset as usize], 1.0);
        let offsets: Vec<Shift> = built.variables.sensors.iter().map(offset).collect();
        let names: Vec<&str> = session.robot.chain.joints().iter().map(|joint| joint.name.as_str()).collect();
        let noise = || Noise::independent(&[POSITION_ERROR; 7]).map_err(|e| e.to_string());
        for (index, factor) in built.problem.factors().iter().enumerate() {
            let block = Block::vector(format!("pose{}.position_error", index + 1), "rad", &names);
            let error = builder.add_block(if eliminated { block.eliminated() } else { block }, &[0.0; 7]);
            let length = |id: BlockId| built.problem.block(id).len();
            let residual = Shifted::new(Arc::clone(&factor.residual), length, &offsets, error);
            builder.add_factor(Factor { residual: Arc::new(residual), ..factor.clone() });
            builder.add_factor(Factor::new(Prior::new(error, vec![0.0; 7]), noise()?));
        }
        builder.build().map_err(|e| e.to_string())
    }

    /// Number of poses.
    pub fn poses(&self) -> usize {
        self.session.poses.len()
    }
}
