//! A model that sessions name: which terms it declares for the sensor of a joint.

use std::borrow::Cow;
use std::fmt::Debug;
use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_recording::{FurtherColumn, TorqueUnit};

use super::options::{Options, RefusedOption};
use super::term::SensorTerm;
use crate::parameter::{Limit, SensorParameter};
use crate::session::{JointPriors, units};

/// A model of a joint's torque or position sensor, beyond the affine one that every sensor has.
///
/// [`Registry::with_sensor_model`](crate::Registry::with_sensor_model) makes its name known to sessions and simulations.
pub trait SensorModel: Debug + Send + Sync {
    /// Its name in files: `kind = "..."`.
    fn name(&self) -> &str;

    /// What it says of a sensor, in a line.
    fn help(&self) -> &str;

    /// Which sensor it is of.
    fn side(&self) -> Side {
        Side::Torque
    }

    /// Keys of the options that it takes.
    fn options(&self) -> &[&str] {
        &[]
    }

    /// Whether a joint may have it more than once.
    fn is_repeatable(&self) -> bool {
        false
    }

    /// Its terms for the sensor of one joint.
    ///
    /// # Errors
    /// An option that it cannot do with, or a joint that it does not suit.
    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption>;
}

/// The sensor to which a term adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The reading of the joint's torque.
    Torque,
    /// The joint's coordinate at a position reading. Such a term reads neither torques nor coordinates.
    Position,
}

/// A term with the parameters that it declares.
#[derive(Clone, Debug)]
pub struct Declared {
    /// In the order in which the term takes them.
    pub parameters: Vec<ParameterSpec>,
    /// The function.
    pub term: Arc<dyn SensorTerm>,
}

impl Declared {
    /// A term with these parameters.
    pub fn new(parameters: impl Into<Vec<ParameterSpec>>, term: impl SensorTerm + 'static) -> Declared {
        Declared { parameters: parameters.into(), term: Arc::new(term) }
    }
}

/// What is said of a parameter that a term declares.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSpec {
    /// What it is, such as `torque_bias_drift`: its name in files and results, behind that of the joint and a point.
    pub name: String,
    /// Its unit inside the program, such as `N·m/s`.
    pub unit: String,
    /// Where the estimation starts, unless the session says otherwise.
    pub nominal: f64,
    /// Standard deviation beyond which a number would mislead.
    pub limit: Limit,
    /// The equation in which it stands, such as `reading = ... + torque_bias_drift * time`.
    pub convention: Cow<'static, str>,
    /// What would determine it where the data do not, as an order: `record poses ...`.
    pub cure: Cow<'static, str>,
    /// What has it, where several share it: see [`ParameterSpec::shared`].
    pub shared: Option<String>,
}

impl ParameterSpec {
    /// A parameter that starts at zero.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, limit: Limit) -> ParameterSpec {
        let (convention, cure) = (Cow::Borrowed(""), Cow::Borrowed(""));
        ParameterSpec { name: name.into(), unit: unit.into(), nominal: 0.0, limit, convention, cure, shared: None }
    }

    /// The same as a parameter of something that several sensors or residuals have a part in, such as a `compensator`: it is told behind
    /// that name, and whoever declares a shared parameter of the same two names means the same number.
    #[must_use]
    pub fn shared(self, owner: impl Into<String>) -> ParameterSpec {
        ParameterSpec { shared: Some(owner.into()), ..self }
    }

    /// The same, started elsewhere.
    #[must_use]
    pub fn starting_at(self, nominal: f64) -> ParameterSpec {
        ParameterSpec { nominal, ..self }
    }

    /// The same with the equation in which it stands.
    #[must_use]
    pub fn in_equation(self, convention: impl Into<Cow<'static, str>>) -> ParameterSpec {
        ParameterSpec { convention: convention.into(), ..self }
    }

    /// The same with what would determine it.
    #[must_use]
    pub fn cured_by(self, cure: impl Into<Cow<'static, str>>) -> ParameterSpec {
        ParameterSpec { cure: cure.into(), ..self }
    }
}

/// The sensors of one joint, for which a model is declared.
#[derive(Clone, Copy, Debug)]
pub struct Site<'a> {
    pub(crate) joint: usize,
    /// Names of all joints.
    pub(crate) names: &'a [&'a str],
    kinds: &'a [JointKind],
    /// Whether the joint's torque is read, and in which unit.
    reads_torque: bool,
    torque_unit: &'static str,
    /// Further columns that the session names.
    further: &'a [FurtherColumn],
    /// Nominal gains of its sensors.
    torque_gain: f64,
    position_gain: f64,
}

impl<'a> Site<'a> {
    /// The sensors of a joint of which this is known.
    pub fn new(joint: usize, names: &'a [&'a str], kinds: &'a [JointKind], prior: &JointPriors) -> Site<'a> {
        Site {
            joint,
            names,
            kinds,
            reads_torque: prior.torque_unit.is_some(),
            torque_unit: prior.torque_unit.map_or("", TorqueUnit::name),
            further: &[],
            torque_gain: prior.of(SensorParameter::TorqueGain).nominal,
            position_gain: prior.of(SensorParameter::PositionGain).nominal,
        }
    }

    /// The same where a session names further columns.
    #[must_use]
    pub fn with_further_columns(self, further: &'a [FurtherColumn]) -> Site<'a> {
        Site { further, ..self }
    }

    /// The place of the column that a session calls so in `readings.further`.
    ///
    /// # Errors
    /// It names none; the message says what to do.
    pub fn further_column(&self, name: &str) -> Result<usize, String> {
        self.further.iter().position(|known| known.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.further.iter().map(|known| known.name.as_str()).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            format!(
                "there is no further column `{name}`; the session names {known}: add readings.further = {{ {name} = \"…\" }}, the \
                 name of a column"
            )
        })
    }

    /// Index of the joint.
    pub fn joint(&self) -> usize {
        self.joint
    }

    /// Whether the joint's torque is read.
    pub fn reads_torque(&self) -> bool {
        self.reads_torque
    }

    /// Names of all joints.
    pub fn joint_names(&self) -> &'a [&'a str] {
        self.names
    }

    /// Index of the joint of this name.
    pub fn joint_named(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| *own == name)
    }

    /// Whether a joint turns; otherwise it slides.
    pub fn turns(&self, joint: usize) -> bool {
        self.kinds.get(joint) == Some(&JointKind::Revolute)
    }

    /// Unit of the torque reading.
    pub fn torque_unit(&self) -> &'static str {
        self.torque_unit
    }

    /// Unit of what a joint exerts: N·m or N; empty where there is no such joint.
    pub fn effort(&self, joint: usize) -> &'static str {
        self.kinds.get(joint).map_or("", |kind| units::effort(*kind).name())
    }

    /// Unit of the joint's coordinate: rad or m.
    pub fn coordinate(&self) -> &'static str {
        units::si_coordinate(self.kinds[self.joint]).name()
    }

    /// The nominal gain of its torque sensor, in units of the reading a N·m or N.
    pub fn torque_gain(&self) -> f64 {
        self.torque_gain
    }

    /// The nominal gain of its position sensor, rad or m a unit of the reading.
    pub fn position_gain(&self) -> f64 {
        self.position_gain
    }

    /// The limit of what adds to the torque reading like a bias: as much as changes it by half of its spread.
    pub fn half_spread(&self) -> Limit {
        Limit::HalfSpread { channel: self.joint }
    }
}
