//! What a comparison comes to, and why there is none.

use std::fmt;

use thiserror::Error;

/// The name under which gravity is compared.
pub const GRAVITY: &str = "gravity";

/// Probability with which any sensor at all is named by its own test where none has moved. The test of all together adds a tenth of it.
pub const SIGNIFICANCE: f64 = 0.01;

/// Calibrations cannot be compared.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ComparisonError {
    /// One alone.
    #[error("a comparison takes two calibrations or more")]
    One,
    /// Their joints and instruments have different names.
    #[error("no sensor is in all of these calibrations: they are of different robots, or their joints were renamed")]
    NoSensorInCommon,
    /// They estimate nothing in common.
    #[error("no parameter is estimated by all of these calibrations")]
    NothingInCommon,
    /// A parameter in different units.
    #[error("{name} is in {} in one and in {} in the other: its sensor's unit has changed", units[0], units[1])]
    Units {
        /// The parameter.
        name: String,
        /// The units.
        units: [String; 2],
        /// Indices of the two calibrations.
        calibrations: [usize; 2],
    },
}

/// What a comparison comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Gravity first, then the sensors of all calibrations, those of the first one first.
    pub sensors: Vec<SensorComparison>,
    /// Position offsets that define the base frame: if one of them moves, gravity seems to have moved.
    pub base_frame: Vec<String>,
    /// By calibration, why its intervals may not hold: what seems to have moved may be an error of a model.
    pub doubts: Vec<Vec<String>>,
}

impl Comparison {
    /// The sensors that moved.
    pub fn moved(&self) -> impl Iterator<Item = &SensorComparison> {
        self.sensors.iter().filter(|sensor| sensor.test.as_ref().is_some_and(|test| test.moved))
    }

    /// What may have moved unnoticed, as it cannot be compared.
    pub fn not_seen(&self) -> Vec<&str> {
        let left_out = self.sensors.iter().flat_map(|sensor| &sensor.left_out);
        left_out.filter(|left_out| left_out.can_move).map(|left_out| left_out.name.as_str()).collect()
    }

    /// How many sensors were tested.
    pub fn tests(&self) -> usize {
        self.sensors.iter().filter(|sensor| sensor.test.is_some()).count()
    }
}

/// One sensor in all calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorComparison {
    /// `joint1 torque`, `joint1 position`, `gravity`, or an instrument's name.
    pub name: String,
    /// The parameters that are compared.
    pub parameters: Vec<ComparedParameter>,
    /// Parameters that are not compared.
    pub left_out: Vec<LeftOut>,
    /// Whether all calibrations have it.
    pub in_all: bool,
    /// Parameters that only some of its models have, so that the others need not mean the same.
    pub models_differ_in: Vec<String>,
    /// Absent where nothing of it can be compared.
    pub test: Option<HomogeneityTest>,
    /// Where it moved beside the others only: its own test tells no move.
    pub beside_others: Option<BesideOthers>,
}

/// Why a sensor is named that by itself is where it was.
#[derive(Clone, Debug, PartialEq)]
pub struct BesideOthers {
    /// Probability of such differences of all sensors together, if none has moved.
    pub p_value: f64,
    /// Sensors that may have moved in its stead.
    pub or: Vec<String>,
}

/// What is not compared.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// A parameter, or a sensor.
    pub name: String,
    /// Such as `is not determined in calibration 2`.
    pub why: String,
    /// Whether it can move at all: a torque sensor that is not there cannot.
    pub can_move: bool,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name, self.why)
    }
}

/// A parameter in all calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedParameter {
    /// `joint1.torque_gain`.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// By calibration.
    pub values: Vec<f64>,
    /// Standard deviations, by calibration.
    pub stds: Vec<f64>,
}

/// How unlikely such differences are, if the sensor has not moved.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneityTest {
    /// χ².
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of a χ² at least as large.
    pub p_value: f64,
    /// The same corrected for the number of sensors, by Holm's method.
    pub corrected_p_value: f64,
    /// Whether that is below [`SIGNIFICANCE`].
    pub moved: bool,
    /// Of more than two calibrations, the one after which the sensor moved most (its index), with the χ² of that step.
    pub largest_step: (usize, f64),
}
