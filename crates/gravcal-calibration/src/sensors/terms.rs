//! The terms that sensors have beyond their affine models: functions with one parameter each.

use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use gravcal_recording::Conditions;

use super::name::{Need, SensorModelName};

/// A function that a torque sensor adds to its reading: `φ(τ, conditions)`, of the torque of one joint at most.
pub trait TorqueFunction: Debug + Send + Sync {
    /// The joint on whose torque it depends; `None` where it depends on conditions alone, and the reading is affine in its
    /// parameter.
    fn source(&self) -> Option<usize> {
        None
    }

    /// `φ`, in units of the reading a unit of the parameter. `torque`: of the source, N·m or N; 0 where there is none.
    fn value(&self, torque: f64, conditions: &Conditions) -> f64;

    /// Its derivative by that torque.
    fn slope(&self, _torque: f64) -> f64 {
        0.0
    }

    /// Whether that derivative is the same at every torque.
    fn is_straight(&self) -> bool {
        true
    }
}

/// A function that a position sensor's true coordinate has beyond `s q + o`: `ψ(q)`.
pub trait PositionFunction: Debug + Send + Sync {
    /// `ψ`, in rad (or m) a unit of the parameter. `reading`: of the joint, rad, m or the sensor's own unit.
    fn value(&self, reading: f64) -> f64;
}

/// The function of a term, and so the side on which it acts.
#[derive(Clone, Debug)]
pub enum Function {
    /// Adds to a torque reading.
    Torque(Arc<dyn TorqueFunction>),
    /// Adds to a joint's coordinate.
    Position(Arc<dyn PositionFunction>),
}

/// One parameter of a sensor with its function.
#[derive(Clone, Debug)]
pub(crate) struct Term {
    /// The sensor's joint.
    pub joint: usize,
    /// The model that it is a part of.
    pub model: SensorModelName,
    pub function: Function,
}

/// What all sensors do beyond their affine models.
///
/// Its parameters are the first ones of [`Session::further`](crate::Session), in the order of the terms.
#[derive(Clone, Debug, Default)]
pub struct SensorTerms {
    terms: Vec<Term>,
}

impl SensorTerms {
    pub(crate) fn new(terms: Vec<Term>) -> SensorTerms {
        SensorTerms { terms }
    }

    pub(crate) fn extend(&mut self, terms: Vec<Term>) {
        self.terms.extend(terms);
    }

    /// Whether all sensors are affine.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// Whether any tells poses apart by how the joint came there or moves.
    pub(crate) fn need_direction(&self) -> bool {
        self.terms.iter().any(|term| matches!(term.model.need(), Some(Need::Direction | Need::Velocity)))
    }

    /// Joints whose torque readings depend on the side from which they came.
    pub(crate) fn with_friction(&self) -> Vec<usize> {
        self.terms.iter().filter(|term| term.model == SensorModelName::CoulombFriction).map(|term| term.joint).collect()
    }

    /// Whether all readings are affine in the torques.
    pub(crate) fn are_straight(&self) -> bool {
        self.terms.iter().all(|term| match &term.function {
            Function::Torque(function) => function.is_straight(),
            Function::Position(_) => true,
        })
    }

    /// How many parameters there are.
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// The joint of a term's sensor, and whether that is one of torque.
    pub(crate) fn site(&self, place: usize) -> (usize, bool) {
        let term = &self.terms[place];
        (term.joint, matches!(term.function, Function::Torque(_)))
    }

    /// The terms of one joint's torque sensor, each with the place of its parameter.
    pub(crate) fn of_torque(&self, joint: usize) -> impl Iterator<Item = (usize, &dyn TorqueFunction)> {
        self.terms.iter().enumerate().filter_map(move |(place, term)| match &term.function {
            Function::Torque(function) if term.joint == joint => Some((place, function.as_ref())),
            _ => None,
        })
    }

    /// The terms of all position sensors: place of the parameter, joint, function.
    pub(crate) fn of_positions(&self) -> impl Iterator<Item = (usize, usize, &dyn PositionFunction)> {
        self.terms.iter().enumerate().filter_map(|(place, term)| match &term.function {
            Function::Position(function) => Some((place, term.joint, function.as_ref())),
            Function::Torque(_) => None,
        })
    }

    /// The models of all joints' sensors, each with the places of its parameters.
    pub(crate) fn models(&self) -> Vec<(usize, SensorModelName, Range<usize>)> {
        let places: Vec<usize> = (0..self.terms.len()).collect();
        let model = |place: usize| (self.terms[place].joint, self.terms[place].model);
        let together = places.chunk_by(|a, b| model(*a) == model(*b));
        together.map(|own| (self.terms[own[0]].joint, self.terms[own[0]].model, own[0]..own[0] + own.len())).collect()
    }

    /// By how much, at most, a unit of a parameter changes the readings of its torque sensor under these conditions,
    /// where that does not depend on torque; otherwise, and where it changes none, 1.
    pub(crate) fn lever<'c>(&self, place: usize, conditions: impl Iterator<Item = &'c Conditions>) -> f64 {
        match self.terms.get(place).map(|term| &term.function) {
            Some(Function::Torque(function)) if function.source().is_none() => {
                let largest = conditions.map(|pose| function.value(0.0, pose).abs()).fold(0.0, f64::max);
                if largest > 0.0 { largest } else { 1.0 }
            }
            _ => 1.0,
        }
    }
}
