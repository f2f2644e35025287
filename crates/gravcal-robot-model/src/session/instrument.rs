//! Instruments that read gravity besides the joints' torque sensors.

use std::ops::Range;

use gravcal_dynamics::Transform;
use gravcal_recording::Conditions;

/// What an instrument is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuxiliarySensorKind {
    /// Six-axis sensor of the force and the moment that carry what hangs beyond it; on a last link.
    ForceTorque,
    /// Three-axis accelerometer.
    Accelerometer,
}

impl AuxiliarySensorKind {
    /// Names of its axes, in the order of its readings.
    pub fn axes(self) -> &'static [&'static str] {
        match self {
            AuxiliarySensorKind::ForceTorque => &["fx", "fy", "fz", "nx", "ny", "nz"],
            AuxiliarySensorKind::Accelerometer => &["x", "y", "z"],
        }
    }

    /// Unit of what an axis senses.
    pub fn sensed_unit(self, axis: usize) -> &'static str {
        match self {
            AuxiliarySensorKind::ForceTorque if axis < 3 => "N",
            AuxiliarySensorKind::ForceTorque => "(N·m)",
            AuxiliarySensorKind::Accelerometer => "(m/s²)",
        }
    }

    /// How many parameters it has besides gains and biases: mass and first moment of the tool, or the mounting's rotation.
    fn own_parameters(self) -> usize {
        match self {
            AuxiliarySensorKind::ForceTorque => 4,
            AuxiliarySensorKind::Accelerometer => 3,
        }
    }
}

/// What the bias of every axis of an instrument drifts with: `reading = … + d · φ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drift {
    /// `φ = t`: s since the session's first pose, of all tables.
    Time,
    /// `φ = T − T₀`.
    Temperature {
        /// Place of the instrument's temperature in [`Conditions::temperature`](gravcal_recording::Conditions).
        place: usize,
        /// `T₀`, °C.
        reference: f64,
    },
}

impl Drift {
    /// Its name in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Drift::Time => "bias-in-time",
            Drift::Temperature { .. } => "bias-with-temperature",
        }
    }

    /// `φ`, s or K.
    pub fn value(self, conditions: &Conditions) -> f64 {
        match self {
            Drift::Time => conditions.time.unwrap_or(0.0),
            Drift::Temperature { place, reference } => {
                conditions.temperature.get(place).map_or(0.0, |temperature| temperature - reference)
            }
        }
    }
}

/// An instrument that a link carries: `reading = gains · sensed + bias + Σ d · φ`.
///
/// Its parameters stand in [`Session::further`](crate::session::Session): gains, then one bias an axis (of each table), then one an
/// axis of each drift, then its own.
#[derive(Clone, Debug, PartialEq)]
pub struct AuxiliarySensor {
    /// Name.
    pub name: String,
    /// What it is.
    pub kind: AuxiliarySensorKind,
    /// Index of the link that carries it.
    pub link: usize,
    /// Its frame in the link's.
    pub mounting: Transform,
    /// Whether tables give what it reads in the base's frame. Readings here are in its own, which they are turned into.
    pub in_base: bool,
    /// Whether the session says which way it reads.
    pub sign_declared: bool,
    /// Unit of each axis' reading; `None` where the axis is not read.
    pub units: Vec<Option<String>>,
    /// Axis of the reading and axis sensed of each gain.
    pub gains: Vec<(usize, usize)>,
    /// How many biases each axis has: one, or one for each table of poses.
    pub biases: usize,
    /// What its biases drift with, each with a parameter of every axis.
    pub drifts: Vec<Drift>,
    /// Place of its first parameter.
    pub first_parameter: usize,
    /// Place of its first axis among [`Pose::instruments`](crate::session::Pose).
    pub first_reading: usize,
}

impl AuxiliarySensor {
    /// Places of the gains among the further parameters.
    pub fn gain_parameters(&self) -> Range<usize> {
        self.first_parameter..self.first_parameter + self.gains.len()
    }

    /// Places of the biases, those of one table after those of another.
    pub fn bias_parameters(&self) -> Range<usize> {
        let first = self.gain_parameters().end;
        first..first + self.biases * self.kind.axes().len()
    }

    /// Places of the biases, one an axis, that hold in a table. Poses that only `check` supposes are of no table of the session: they
    /// have those of the last one.
    pub fn biases_of_table(&self, table: usize) -> Range<usize> {
        let axes = self.kind.axes().len();
        let first = self.bias_parameters().start + self.bias_set(table) * axes;
        first..first + axes
    }

    /// Which of its sets of biases holds in a table.
    pub fn bias_set(&self, table: usize) -> usize {
        table.min(self.biases - 1)
    }

    /// Places of the drifts, in the order of their declaration, one an axis.
    pub fn drift_parameters(&self) -> Range<usize> {
        let first = self.bias_parameters().end;
        first..first + self.drifts.len() * self.kind.axes().len()
    }

    /// The drift of which this is a parameter, if it is one.
    pub(crate) fn drift_of(&self, parameter: usize) -> Option<Drift> {
        let place = parameter.checked_sub(self.drift_parameters().start)?;
        self.drifts.get(place / self.kind.axes().len()).copied()
    }

    /// Places of its own parameters: mass and first moment of the tool, or the mounting's rotation vector.
    pub fn own_parameters(&self) -> Range<usize> {
        let first = self.drift_parameters().end;
        first..first + self.kind.own_parameters()
    }

    /// Places of its axes among the readings of all instruments.
    pub fn readings(&self) -> Range<usize> {
        self.first_reading..self.first_reading + self.kind.axes().len()
    }
}
