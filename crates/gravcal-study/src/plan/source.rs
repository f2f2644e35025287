//! Where a trial's robot, poses and truth come from.

use std::borrow::Cow;

use gravcal_recording::Reading;
use gravcal_robot_model::Session;
use gravcal_session::simulation::{Run, Simulation};

use super::draw::Draw;
use crate::random_arms::{Knowing, arm};

#[derive(Debug)]
pub(super) enum Source {
    /// One simulation, and what its sessions say.
    Simulation { simulation: Box<Simulation>, said: Box<Said>, draw: Option<Draw> },
    /// Another robot each time.
    RandomArms(Knowing),
}

/// What the sessions of a simulation say, whatever is read.
#[derive(Debug)]
pub(super) struct Said {
    /// Without poses.
    pub session: Session,
    /// The torque readings of some trial, pose by pose, with the noise that they state: a session may keep it to itself.
    pub torque: Vec<Vec<Option<Reading>>>,
}

impl Said {
    /// `session`: with the poses of any trial.
    pub fn of(mut session: Session) -> Said {
        let poses = std::mem::take(&mut session.poses);
        Said { session, torque: poses.into_iter().map(|pose| pose.torque).collect() }
    }
}

/// What one trial is drawn from.
pub(super) struct Drawn<'s> {
    pub simulation: Cow<'s, Simulation>,
    pub session: Session,
    /// As [`Said::torque`]; empty where readings say it themselves.
    pub stated: &'s [Vec<Option<Reading>>],
}

impl Source {
    pub fn draw(&self, seed: u64, trial: u64) -> Result<Drawn<'_>, String> {
        match self {
            Source::Simulation { simulation, said, draw } => {
                let mut simulation = Cow::Borrowed(simulation.as_ref());
                if let Some(draw) = draw {
                    draw.draw(simulation.to_mut(), seed, trial);
                }
                Ok(Drawn { simulation, session: said.session.clone(), stated: &said.torque })
            }
            Source::RandomArms(knowing) => {
                let simulation = arm(seed, trial, *knowing).map_err(|error| error.to_string())?;
                let session = simulation.template.clone();
                Ok(Drawn { session, simulation: Cow::Owned(simulation), stated: &[] })
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
