//! `[recording]`: the tables are recordings in motion.

use gravcal_dynamics::JointKind;

use super::reader::Reader;
use super::tables::{CreepTable, FrictionTable, HarmonicTable, HysteresisTable, RecordingTable, SweepTable};
use crate::document::{Field, FileError, OneOrMany};
use crate::simulation::{Approach, Creep, Dirt, FrictionAtRest, HarmonicMotion, Hysteresis, Motion};

/// Length of pre-sliding where nothing is said, rad or m.
const PRESLIDING: f64 = 2e-4;
/// What is left at rest of Coulomb friction where nothing is said, and how much that differs: together 0.49 rms.
const LEAN: f64 = 0.42;
const SPREAD: f64 = 0.25;
/// Samples of all recordings at most: a day of them, a thousand a second.
const MOST_SAMPLES: f64 = 86.4e6;
/// Sines in a sum at most.
const MOST_HARMONICS: usize = 100;
/// Samples a second at most: times of messages are told in nanoseconds.
const HIGHEST_RATE: f64 = 1e6;
/// Time between the first sample and the last at most, s: a year.
const LONGEST: f64 = 3.2e7;

impl Reader<'_> {
    /// `poses`: of all tables.
    pub fn motion(&self, poses: usize) -> Result<Option<Motion>, FileError> {
        let Some(table) = &self.table.recording else { return Ok(None) };
        let field = |key: &str| Field::new("recording").key(key);
        if self.table.conditions.is_some() {
            let message = "time and direction of approach are those of the motion: delete this, or [recording]";
            return Err(self.document.error(&Field::new("conditions"), message));
        }
        let positive = |key: &str, value: f64, unit: &str| self.document.positive(&field(key), value, "a number", unit);
        let not_negative = |key: &str, value: Option<f64>| {
            let value = value.unwrap_or(0.0);
            self.not_negative(&field(key), &[value]).map(|()| value)
        };
        let share = |key: &str, value: Option<f64>| self.share(&field(key), value.unwrap_or(0.0));
        if table.samples < 2 {
            return Err(self.document.error(&field("samples"), "expected 2 samples at least"));
        }
        let motion = Motion {
            rate: positive("rate_hz", table.rate_hz, "Hz")?,
            samples: table.samples,
            moving: positive("move_s", table.move_s, "s")?,
            settling: not_negative("settling_s", table.settling_s)?,
            vibration: not_negative("vibration", table.vibration)?,
            settling_time: positive("settling_time_constant_s", table.settling_time_constant_s.unwrap_or(0.05), "s")?,
            correlation: not_negative("noise_correlation_s", table.noise_correlation_s)?,
            approach: self.approach(table)?,
            friction: table.friction.as_ref().map(|friction| self.friction(friction)).transpose()?,
            hysteresis: table.hysteresis.as_ref().map(|hysteresis| self.hysteresis(hysteresis)).transpose()?,
            creep: table.creep.as_ref().map(|creep| self.creep(creep)).transpose()?,
            walk: self.walk(table)?,
            harmonic: table.motion.as_ref().map(|motion| self.harmonic(motion)).transpose()?,
            sweeping: self.sweeping(table)?,
            dirt: Dirt {
                outliers: share("outliers", table.outliers)?,
                dropped: share("dropped", table.dropped)?,
                touched: table.touched.unwrap_or(0),
            },
        };
        if motion.friction.is_some() && motion.settling * motion.rate < 1.0 {
            let message = "friction settles to what it is at rest after each move: expected one sample at least";
            return Err(self.document.error(&field("settling_s"), message));
        }
        self.check_size(&motion, poses)?;
        Ok(Some(motion))
    }

    fn approach(&self, table: &RecordingTable) -> Result<Approach, FileError> {
        match table.approach.as_deref() {
            None | Some("any") => Ok(Approach::Any),
            Some("one-way") => Ok(Approach::OneWay),
            Some("both-ways") => Ok(Approach::BothWays),
            Some(other) => {
                let message = format!("`{other}` is no approach: expected `any`, `one-way` or `both-ways`");
                Err(self.document.error(&Field::new("recording").key("approach"), message))
            }
        }
    }

    /// Speed of slow sweeps, rad/s.
    fn sweeping(&self, table: &RecordingTable) -> Result<Option<f64>, FileError> {
        let field = Field::new("recording").key("sweep_deg_per_s");
        let Some(speed) = table.sweep_deg_per_s else { return Ok(None) };
        let slides = |sweep: &SweepTable| {
            let joint = self.robot.chain.joints().iter().find(|joint| joint.name == sweep.joint);
            joint.is_some_and(|joint| joint.kind == JointKind::Prismatic)
        };
        if let Some(sweep) = self.table.sweep.iter().find(|sweep| slides(sweep)) {
            return Err(self
                .document
                .error(&field, format!("{} slides, and only joints that turn sweep", sweep.joint)));
        }
        self.document.positive(&field, speed, "a speed", "deg/s").map(|speed| Some(speed.to_radians()))
    }

    fn harmonic(&self, table: &HarmonicTable) -> Result<HarmonicMotion, FileError> {
        let field = |key: &str| Field::new("recording").key("motion").key(key);
        if !(1..=MOST_HARMONICS).contains(&table.harmonics) {
            let message = format!("{} sines: expected 1 to {MOST_HARMONICS}", table.harmonics);
            return Err(self.document.error(&field("harmonics"), message));
        }
        if !self.table.sweep.is_empty() {
            let message = "an arm that never stands makes no sweeps: delete [[sweep]], or this";
            return Err(self.document.error(&Field::new("recording").key("motion"), message));
        }
        if self.true_tensors().is_none() {
            let message = "the robot's file states no inertia tensors of its links, and motion needs them: give inertia_kg_m2 of \
                           each joint in robot.toml, or name a URDF that states them";
            return Err(self.document.error(&Field::new("recording").key("motion"), message));
        }
        let period = self.document.positive(&field("period_s"), table.period_s, "a period", "s")?;
        Ok(HarmonicMotion { harmonics: table.harmonics, period, seed: table.seed.unwrap_or(1) })
    }

    /// Inertia tensors of all links as the robot's file states them, if it states any.
    pub fn true_tensors(&self) -> Option<Vec<[f64; 6]>> {
        let parameters = self.robot.chain.inertial_parameters().ok()?;
        let tensor = |[_, _, _, _, tensor @ ..]: &[f64; 10]| *tensor;
        let tensors: Vec<[f64; 6]> = parameters.as_chunks().0.iter().map(tensor).collect();
        tensors.iter().flatten().any(|entry| *entry != 0.0).then_some(tensors)
    }

    fn friction(&self, table: &FrictionTable) -> Result<FrictionAtRest, FileError> {
        let field = |key: &str| Field::new("recording").key("friction").key(key);
        let not_negative = |key: &str, value: f64| self.not_negative(&field(key), &[value]).map(|()| value);
        let names = self.names();
        let coulomb = self.document.for_each(&field("coulomb_newton_metre"), &table.coulomb_newton_metre, &names)?;
        self.not_negative(&field("coulomb_newton_metre"), &coulomb)?;
        let lean = table.lean.unwrap_or(LEAN);
        if !(0.0..=1.0).contains(&lean) {
            return Err(self.document.error(&field("lean"), format!("{lean} is no share: expected 0 to 1")));
        }
        let presliding = table.presliding_rad.unwrap_or(PRESLIDING);
        Ok(FrictionAtRest {
            coulomb,
            per_torque: not_negative("per_torque", table.per_torque.unwrap_or(0.0))?,
            presliding: self.document.positive(&field("presliding_rad"), presliding, "a length", "rad")?,
            lean,
            spread: not_negative("spread", table.spread.unwrap_or(SPREAD))?,
        })
    }

    fn hysteresis(&self, table: &HysteresisTable) -> Result<Hysteresis, FileError> {
        let field = |key: &str| Field::new("recording").key("hysteresis").key(key);
        let over = self.document.for_each(&field("over"), &table.over, &self.names())?;
        self.not_negative(&field("over"), &over)?;
        Ok(Hysteresis { share: self.share(&field("share"), table.share)?, over })
    }

    fn creep(&self, table: &CreepTable) -> Result<Creep, FileError> {
        let field = |key: &str| Field::new("recording").key("creep").key(key);
        let time_constant =
            self.document.positive(&field("time_constant_s"), table.time_constant_s, "a time constant", "s")?;
        Ok(Creep { share: self.share(&field("share"), table.share)?, time_constant })
    }

    fn share(&self, field: &Field, value: f64) -> Result<f64, FileError> {
        match (0.0..1.0).contains(&value) {
            true => Ok(value),
            false => Err(self.document.error(field, format!("{value} is no share: expected 0 to 1"))),
        }
    }

    fn walk(&self, table: &RecordingTable) -> Result<Vec<f64>, FileError> {
        let field = Field::new("recording").key("walk_per_root_s");
        let zero = OneOrMany::One(0.0);
        let walk = self.document.for_each(&field, table.walk_per_root_s.as_ref().unwrap_or(&zero), &self.names())?;
        self.not_negative(&field, &walk).map(|()| walk)
    }

    /// Samples of all slow sweeps.
    fn samples_of_sweeps(&self, motion: &Motion) -> f64 {
        let Some(speed) = motion.sweeping else { return 0.0 };
        let range = |sweep: &SweepTable| (sweep.range_deg[1] - sweep.range_deg[0]).abs().to_radians();
        let strokes = self.table.sweep.iter().map(|sweep| 2.0 * (range(sweep) / speed + 2.0 * motion.moving));
        motion.rate * strokes.sum::<f64>()
    }

    /// Whatever is recorded has an end that disks and clocks can hold.
    fn check_size(&self, motion: &Motion, poses: usize) -> Result<(), FileError> {
        let refuse = |key: &str, message: String| Err(self.document.error(&Field::new("recording").key(key), message));
        if motion.rate > HIGHEST_RATE {
            return refuse("rate_hz", format!("{} Hz are too many: expected {HIGHEST_RATE} Hz at most", motion.rate));
        }
        // The first of a move counts, however short the move is.
        let moves = if motion.approach == Approach::Any { 1.0 } else { 2.0 };
        let moving = moves * (motion.rate * motion.moving).max(1.0) + motion.rate * motion.settling;
        let poses = poses * motion.approach.sides().len();
        let samples = poses as f64 * (moving + motion.samples as f64) + self.samples_of_sweeps(motion);
        if samples > MOST_SAMPLES {
            let message = format!(
                "{poses} poses at this rate, with these times, are {samples:.0} samples in all: expected {MOST_SAMPLES} at most"
            );
            return refuse("samples", message);
        }
        if samples / motion.rate > LONGEST {
            let message = format!(
                "{poses} poses at this rate take {:.1e} s: expected {LONGEST} s at most",
                samples / motion.rate
            );
            return refuse("rate_hz", message);
        }
        Ok(())
    }
}
