//! Where a trial's robot, poses and truth come from.

use gravcal_calibration::Session;
use gravcal_calibration::simulation::{Run, Simulation};

use super::draw::Draw;
use crate::random_arms::{Knowing, arm};

#[derive(Debug)]
pub(super) enum Source {
    /// One simulation, and what its sessions say: the poses of that session are those of a first trial.
    Simulation { simulation: Box<Simulation>, session: Box<Session>, draw: Option<Draw> },
    /// Another robot each time.
    RandomArms(Knowing),
}

/// What one trial is drawn from.
pub(super) struct Drawn {
    pub simulation: Simulation,
    pub session: Session,
}

impl Source {
    pub fn draw(&self, seed: u64, trial: u64) -> Result<Drawn, String> {
        match self {
            Source::Simulation { simulation, session, draw } => {
                let mut simulation = (**simulation).clone();
                simulation.seed = seed;
                if let Some(draw) = draw {
                    draw.draw(&mut simulation, seed, trial);
                }
                Ok(Drawn { simulation, session: (**session).clone() })
            }
            Source::RandomArms(knowing) => {
                let simulation = arm(seed, trial, *knowing).map_err(|error| error.to_string())?;
                Ok(Drawn { session: simulation.template.clone(), simulation })
            }
        }
    }

    /// Whether poses or truth differ from trial to trial.
    pub fn varies(&self) -> bool {
        match self {
            Source::Simulation { simulation, draw, .. } => {
                draw.is_some() || simulation.runs.iter().any(|run| matches!(run, Run::Random { .. }))
            }
            Source::RandomArms(_) => true,
        }
    }
}
