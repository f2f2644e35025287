//! What a sensor model is declared for, and what it declares.

use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_recording::TorqueUnit;

use super::terms::{Function, PositionFunction, TorqueFunction};
use crate::parameter::{Limit, Parameter, Quantity};
use crate::session::units;
use crate::session::{JointKnowledge, Knowledge, KnowledgeKind};

/// The sensors of one joint, for which a model is declared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Site<'a> {
    pub joint: usize,
    /// Names of all joints.
    pub names: &'a [&'a str],
    pub kinds: &'a [JointKind],
    /// Whether the joint's torque is read, and in which unit.
    pub reads_torque: bool,
    pub torque_unit: &'static str,
    /// Nominal gains of its sensors.
    pub torque_gain: f64,
    pub position_gain: f64,
}

/// What a declaration may say besides the name of the model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Options {
    pub reference_degc: Option<f64>,
    pub degree: Option<i32>,
    pub from: Option<Vec<String>>,
    pub orders: Option<Vec<u32>>,
}

/// An option that a model cannot do with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RefusedOption {
    /// Its key in the file.
    pub key: &'static str,
    pub message: String,
}

/// The function of a term with the parameter that it declares.
#[derive(Clone, Debug)]
pub(crate) struct Declared {
    pub parameter: Parameter,
    pub function: Function,
}

/// What is told of a parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Words {
    /// The equation in which it stands.
    pub convention: &'static str,
    /// What would determine it where the data do not.
    pub cure: &'static str,
}

impl<'a> Site<'a> {
    /// The sensors of a joint of which this is known.
    pub fn new(joint: usize, names: &'a [&'a str], kinds: &'a [JointKind], knowledge: &JointKnowledge) -> Site<'a> {
        Site {
            joint,
            names,
            kinds,
            reads_torque: knowledge.torque_unit.is_some(),
            torque_unit: knowledge.torque_unit.map_or("", TorqueUnit::name),
            torque_gain: knowledge.of(Quantity::TorqueGain).nominal,
            position_gain: knowledge.of(Quantity::PositionGain).nominal,
        }
    }

    /// A term of the joint's torque sensor, which starts at zero.
    pub fn torque(
        &self,
        quantity: impl Into<String>,
        unit: String,
        words: Words,
        limit: Limit,
        function: impl TorqueFunction + 'static,
    ) -> Declared {
        let linear = function.source().is_none();
        let parameter = Parameter { linear, ..self.parameter(quantity.into(), unit, words, limit) };
        Declared { parameter, function: Function::Torque(Arc::new(function)) }
    }

    /// A term of the joint's position sensor, which starts at zero. `useful`: largest standard deviation that is of use.
    pub fn position(
        &self,
        quantity: String,
        words: Words,
        useful: f64,
        function: impl PositionFunction + 'static,
    ) -> Declared {
        let parameter = self.parameter(quantity, self.coordinate().to_owned(), words, Limit::Absolute(useful));
        Declared { parameter, function: Function::Position(Arc::new(function)) }
    }

    /// Unit of what a joint exerts.
    pub fn effort(&self, joint: usize) -> &'static str {
        units::effort(self.kinds[joint]).name()
    }

    /// Unit of the joint's coordinate.
    pub fn coordinate(&self) -> &'static str {
        units::si_coordinate(self.kinds[self.joint]).name()
    }

    fn parameter(&self, quantity: String, unit: String, words: Words, limit: Limit) -> Parameter {
        Parameter {
            owner: self.names[self.joint].to_owned(),
            quantity,
            unit,
            convention: words.convention,
            knowledge: Knowledge { nominal: 0.0, kind: KnowledgeKind::Start },
            held: None,
            limit,
            cure: words.cure,
            linear: false,
        }
    }
}
