//! A simulated experiment.

use gravcal_robot_model::State;
use gravcal_robot_model::session::Session;

use super::conditions::SimulatedConditions;
use super::disturbance::Disturbance;
use super::motion::Motion;
use super::unmodelled::Unmodelled;
use crate::sensor_models::DeclaredModels;

/// A simulated experiment.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// What the session will say; its tables are there, its poses are not.
    pub template: Session,
    /// The true values.
    pub truth: State,
    /// What its sensors do besides, and no session says.
    pub unmodelled: Unmodelled,
    /// One for each table of the template.
    pub runs: Vec<Run>,
    /// What disturbs the readings.
    pub disturbance: Disturbance,
    /// Under which conditions they are read.
    pub conditions: SimulatedConditions,
    /// How the arm moves where its tables are recordings; `None` where they are tables of static poses.
    pub motion: Option<Motion>,
    /// What its sensors do beyond gain and bias, as its sessions declare it.
    pub models: DeclaredModels,
    /// Its instruments, as the session declares them.
    pub(crate) instruments: SimulatedInstruments,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Instruments as they stand in the session's file.
#[derive(Clone, Debug, Default)]
pub(crate) struct SimulatedInstruments {
    /// `[[force_torque_sensor]]`.
    pub force_torque_sensor: Vec<toml::Table>,
    /// `[[accelerometer]]`.
    pub accelerometer: Vec<toml::Table>,
    /// Column of each axis, where it is read.
    pub columns: Vec<Option<String>>,
}

/// Poses of one table.
#[derive(Clone, Debug, PartialEq)]
pub enum Run {
    /// One joint moves in even steps, the others stand.
    Sweep {
        /// Index of the joint that moves.
        swept: usize,
        /// Its first and last position reading.
        range: [f64; 2],
        /// Number of poses.
        poses: usize,
        /// Position reading of every joint; that of the swept one is not used.
        held: Vec<f64>,
    },
    /// Every joint at a random place within its limits.
    Random {
        /// Number of poses.
        poses: usize,
        /// How many joints, drawn anew, move from one pose to the next while the others stand; nothing where all do.
        moving: Option<usize>,
    },
}

impl Run {
    /// Number of poses.
    pub fn poses(&self) -> usize {
        match self {
            Run::Sweep { poses, .. } | Run::Random { poses, .. } => *poses,
        }
    }
}

impl Simulation {
    /// An experiment whose sensors are affine, without instruments.
    pub fn new(template: Session, truth: State, runs: Vec<Run>, disturbance: Disturbance, seed: u64) -> Simulation {
        let (conditions, models) = (SimulatedConditions::default(), DeclaredModels::default());
        let (instruments, unmodelled) = (SimulatedInstruments::default(), Unmodelled::none(&template));
        Simulation {
            template,
            truth,
            unmodelled,
            runs,
            disturbance,
            conditions,
            motion: None,
            models,
            instruments,
            seed,
        }
    }

    /// Standard deviation that the session states for a joint's readings: noise and the converter's step,
    /// `√(σ² + Δ²/12)`.
    pub fn stated_std(&self, joint: usize) -> f64 {
        let step = self.disturbance.converter.map_or(0.0, |c| c.step());
        (self.disturbance.torque_std[joint].powi(2) + step * step / 12.0).sqrt()
    }
}
