//! The terms that sensors have beyond their affine models.

use std::ops::Range;
use std::sync::Arc;

use super::declare::Term;
use super::model::Side;
use super::term::{Moment, Need, Partials};
use crate::session::Pose;

/// What all sensors do beyond their affine models.
///
/// The parameters of its terms are the first ones of [`Session::further`](crate::Session), in the order of the terms.
#[derive(Clone, Debug, Default)]
pub struct SensorTerms {
    terms: Vec<Term>,
    /// How many parameters all of them have.
    parameters: usize,
}

/// A model of one joint's sensor, as its session has it.
pub struct ModelInUse<'t> {
    /// The sensor's joint.
    pub joint: usize,
    /// Its name in files.
    pub name: &'t str,
    /// Its terms.
    pub terms: &'t [Term],
}

impl ModelInUse<'_> {
    /// Places of its parameters.
    pub fn places(&self) -> Range<usize> {
        self.terms[0].places.start..self.terms[self.terms.len() - 1].places.end
    }

    /// Whether it does nothing where all of its parameters are zero: then it can be tested against its absence.
    pub fn vanishes_at_zero(&self, poses: &[Pose]) -> bool {
        let zeros = vec![0.0; self.places().end];
        let vanishes = |pose: &Pose| {
            // Neither zero nor alike.
            let numbers: Vec<f64> = (1..=pose.position.len()).map(|joint| 0.7 * joint as f64).collect();
            let at = Moment::new(&numbers, &pose.position, &pose.position, &pose.conditions);
            self.terms.iter().all(|term| term.value(&at, &zeros, None) == 0.0)
        };
        poses.iter().all(vanishes)
    }

    /// Whether any of its terms reads this.
    pub fn needs(&self, need: Need) -> bool {
        self.terms.iter().any(|term| term.reads.needs().contains(&need))
    }
}

impl SensorTerms {
    /// Adds terms, whose parameters come behind those of the terms before.
    pub fn extend(&mut self, terms: impl IntoIterator<Item = Term>) {
        for mut term in terms {
            let first = self.parameters;
            self.parameters += term.places.len();
            term.places = first..self.parameters;
            self.terms.push(term);
        }
    }

    /// Whether all sensors are affine.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// How many parameters there are.
    pub fn len(&self) -> usize {
        self.parameters
    }

    /// Whether any tells poses apart by how the joint came there or moves.
    pub fn need_direction(&self) -> bool {
        let tells = |need: &Need| matches!(need, Need::Direction | Need::Velocity | Need::Presliding);
        self.terms.iter().any(|term| term.reads.needs().iter().any(tells))
    }

    /// Joints whose torque readings depend on the side from which they came.
    pub fn with_friction(&self) -> Vec<usize> {
        self.of_torque_that_need(&[Need::Direction, Need::Presliding])
    }

    /// Joints whose friction builds up before they slide.
    pub fn with_presliding(&self) -> Vec<usize> {
        self.of_torque_that_need(&[Need::Presliding])
    }

    fn of_torque_that_need(&self, any: &[Need]) -> Vec<usize> {
        let needs =
            |term: &&Term| term.side == Side::Torque && term.reads.needs().iter().any(|need| any.contains(need));
        self.terms.iter().filter(needs).map(|term| term.joint).collect()
    }

    /// Whether all readings are affine in the torques.
    pub fn are_straight(&self) -> bool {
        self.terms.iter().all(|term| term.reads.is_affine_in_torques())
    }

    /// The joint of a parameter's sensor, and whether that is one of torque; nothing where no term has the parameter.
    pub fn site(&self, place: usize) -> Option<(usize, bool)> {
        let term = self.terms.iter().find(|term| term.places.contains(&place))?;
        Some((term.joint, term.side == Side::Torque))
    }

    /// The terms of one joint's torque sensor.
    pub fn of_torque(&self, joint: usize) -> impl Iterator<Item = &Term> {
        self.terms.iter().filter(move |term| term.side == Side::Torque && term.joint == joint)
    }

    /// The places of the terms of one joint's torque sensor in [`all`](Self::all).
    pub(crate) fn places_of_torque(&self, joint: usize) -> Vec<usize> {
        let own = |term: &Term| term.side == Side::Torque && term.joint == joint;
        (0..self.terms.len()).filter(|place| own(&self.terms[*place])).collect()
    }

    /// All terms.
    pub(crate) fn all(&self) -> &[Term] {
        &self.terms
    }

    /// The terms of all position sensors.
    pub fn of_positions(&self) -> impl Iterator<Item = &Term> {
        self.terms.iter().filter(|term| term.side == Side::Position)
    }

    /// The models of all joints' sensors.
    pub fn models(&self) -> impl Iterator<Item = ModelInUse<'_>> {
        let together = self.terms.chunk_by(|a, b| Arc::ptr_eq(&a.model, &b.model));
        together.map(|terms| ModelInUse { joint: terms[0].joint, name: &terms[0].model, terms })
    }

    /// By how much, at most, a unit of a parameter changes the readings of its torque sensor in these poses, where that does not depend
    /// on torque; otherwise, and where it changes none, 1. `values`: of the parameters of all terms; `position`: nominal gain and offset
    /// of each position sensor.
    pub(crate) fn lever(&self, place: usize, values: &[f64], position: &[[f64; 2]], poses: &[Pose]) -> f64 {
        let suits =
            |term: &&Term| term.places.contains(&place) && term.side == Side::Torque && term.reads.torques().is_empty();
        let Some(term) = self.terms.iter().find(suits) else { return 1.0 };
        let [mut coordinate, mut by_torque, mut by_coordinate] = [(); 3].map(|()| vec![0.0; position.len()]);
        let torque = vec![0.0; position.len()];
        let mut by_parameter = vec![0.0; term.places.len()];
        let change = |pose: &Pose| {
            let affine = position.iter().zip(&pose.position).map(|([gain, offset], q)| gain * q + offset);
            coordinate.iter_mut().zip(affine).for_each(|(coordinate, affine)| *coordinate = affine);
            by_parameter.fill(0.0);
            let partials = Partials {
                by_parameter: &mut by_parameter,
                by_torque: &mut by_torque,
                by_coordinate: &mut by_coordinate,
            };
            term.value(&Moment::new(&torque, &coordinate, &pose.position, &pose.conditions), values, Some(partials));
            by_parameter[place - term.places.start].abs()
        };
        let largest = poses.iter().map(change).filter(|change| change.is_finite()).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }
}
