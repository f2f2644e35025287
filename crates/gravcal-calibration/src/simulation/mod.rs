//! Sessions with known truth: what the sensors of a known robot would read.
//!
//! ```text
//!     θ_i = s_i q_i + o_i + δ_i,     y_i = convert(k_i τ_i(θ) + b_i + noise)
//! ```
//!
//! and whatever else its sensors do ([`crate::sensors`]).
//!
//! `δ` is the deflection of a joint that stands still, which its position sensor does not see (unless it is told to). Everything random
//! comes from one generator with a stream a trial, so that a trial depends on the seed and its number only.

mod conditions;
mod draw;
mod file;
mod friction;
mod instruments;
mod recording;
mod statics;
mod unmodelled;
mod write;
mod write_conditions;
mod write_recording;

use std::path::Path;

use gravcal_recording::is_saturated;

use crate::document::{Document, FileError};
use crate::joint::Unknowns;
use crate::sensors::DeclaredModels;
use crate::session::Session;

pub use conditions::SimulatedConditions;
pub use friction::FrictionAtRest;
pub use recording::{Approach, Dirt, Motion, Recorded, Sink, TrueStandstill, record};
pub use unmodelled::Unmodelled;
pub use write::{SimulateError, session_files, write_session};

/// A simulated experiment.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// What the session will say; its tables are there, its poses are not.
    pub template: Session,
    /// The true values.
    pub truth: Unknowns,
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
    },
}

impl Run {
    /// Number of poses.
    pub fn poses(&self) -> usize {
        match self {
            Run::Sweep { poses, .. } | Run::Random { poses } => *poses,
        }
    }
}

/// What disturbs the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// Standard deviation of the averaged torque reading of each joint, unit of the reading.
    pub torque_std: Vec<f64>,
    /// Standard deviation of the averaged position reading of each joint, unit of the reading (rad for an angle).
    pub position_std: Vec<f64>,
    /// Standard deviation of the averaged reading of each axis of the instruments, unit of the reading.
    pub instrument_std: Vec<f64>,
    /// Converter of the torque readings, if they pass through one.
    pub converter: Option<Converter>,
    /// Torque readings that are far off, if there are some.
    pub outliers: Option<Outliers>,
    /// Deflection of stationary joints.
    pub deflection: Deflection,
}

/// Torque readings that are far off: each with the same probability, by a normal error of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outliers {
    /// Probability of one, 0 to 1.
    pub share: f64,
    /// Standard deviation of its error, unit of the reading.
    pub std: f64,
}

impl Disturbance {
    /// Nothing but noise of the torque readings, by joint.
    pub fn noise(torque_std: Vec<f64>) -> Disturbance {
        let none = vec![0.0; torque_std.len()];
        let deflection = Deflection { hold_std: 0.0, pose_std: 0.0, compliance: none.clone(), seen: false };
        Disturbance {
            torque_std,
            instrument_std: Vec::new(),
            position_std: none,
            converter: None,
            outliers: None,
            deflection,
        }
    }
}

/// An analogue-to-digital converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converter {
    /// Number of bits.
    pub bits: u32,
    /// Reading at the lowest and, one step above, the highest code; unit of the reading.
    pub range: [f64; 2],
}

impl Converter {
    /// Width of one step, unit of the reading.
    pub fn step(&self) -> f64 {
        (self.range[1] - self.range[0]) / 2f64.powi(self.bits as i32)
    }

    /// The lowest and the highest reading it can give.
    pub fn ends(&self) -> [f64; 2] {
        [self.range[0], self.convert(self.range[1])]
    }

    /// The reading it gives: the nearest step within its range.
    pub fn convert(&self, value: f64) -> f64 {
        let code = ((value - self.range[0]) / self.step()).round();
        self.range[0] + self.step() * code.clamp(0.0, 2f64.powi(self.bits as i32) - 1.0)
    }
}

/// Deflection of joints that stand still: true coordinate less what the calibrated position sensor says.
#[derive(Clone, Debug, PartialEq)]
pub struct Deflection {
    /// Standard deviation of one draw for each joint and hold, rad: a hold is a sweep, or one random pose.
    pub hold_std: f64,
    /// Standard deviation of a further draw for each joint and pose, rad.
    pub pose_std: f64,
    /// `δ = c τ` of each joint, rad/(N·m).
    pub compliance: Vec<f64>,
    /// Whether the position sensors see it: their readings then say where the joints are, not where they were sent.
    pub seen: bool,
}

impl Simulation {
    /// An experiment whose sensors are affine, without instruments.
    pub fn new(template: Session, truth: Unknowns, runs: Vec<Run>, disturbance: Disturbance, seed: u64) -> Simulation {
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

    /// Reads `simulation.toml` and the robot that it names.
    ///
    /// # Errors
    /// Names the file, the line and the field.
    pub fn read(path: &Path) -> Result<Simulation, FileError> {
        file::read(&Document::read(path)?)
    }

    /// The same from a document, which may be another text than that of the file.
    ///
    /// # Errors
    /// As for [`Simulation::read`].
    pub fn of(document: &Document) -> Result<Simulation, FileError> {
        file::read(document)
    }

    /// The session of one trial.
    pub fn session(&self, trial: u64) -> Session {
        let mut session = draw::session(self, trial);
        let Some([lowest, highest]) = self.disturbance.converter.map(|converter| converter.ends()) else {
            return session;
        };
        for pose in &mut session.poses {
            for (reading, saturated) in pose.torque.iter_mut().zip(&mut session.saturated) {
                if reading.is_some_and(|reading| is_saturated(reading.value, Some(lowest), Some(highest))) {
                    *reading = None;
                    *saturated += 1;
                }
            }
        }
        session
    }

    /// Standard deviation that the session states for a joint's readings: noise and the converter's step,
    /// `√(σ² + Δ²/12)`.
    pub fn stated_std(&self, joint: usize) -> f64 {
        let step = self.disturbance.converter.map_or(0.0, |c| c.step());
        (self.disturbance.torque_std[joint].powi(2) + step * step / 12.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn converter_rounds_and_saturates() {
        let converter = Converter { bits: 12, range: [0.0, 4096.0] };
        assert_eq!(converter.step(), 1.0);
        assert_eq!([2047.6, -5.0, 5000.0].map(|v| converter.convert(v)), [2048.0, 0.0, 4095.0]);
        let volts = Converter { bits: 12, range: [-10.0, 10.0] };
        assert!((volts.convert(0.001) - 0.0).abs() < 1e-12 && volts.convert(11.0) < 10.0);
    }
}
