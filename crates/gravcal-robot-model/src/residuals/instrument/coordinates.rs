//! What position sensors do beyond gain and offset, in one pose.

use gravcal_recording::Conditions;

use crate::sensors::{Moment, Partials, Term};

/// Terms of the position sensors of joints that move a link, and what they read in one pose.
#[derive(Clone, Debug, Default)]
pub struct PositionTerms {
    /// Each with the place of its first parameter among the coordinates' blocks.
    terms: Vec<(usize, Term)>,
    position: Vec<f64>,
    conditions: Conditions,
}

/// How a coordinate depends on a parameter.
pub(in crate::residuals) struct Further {
    pub joint: usize,
    /// Among the coordinates' blocks.
    pub place: usize,
    pub slope: f64,
}

impl PositionTerms {
    /// `first`: the place of the first parameter of the first of them among the coordinates' blocks; the others follow.
    pub fn new<'t>(
        first: usize,
        terms: impl Iterator<Item = &'t Term>,
        position: Vec<f64>,
        conditions: Conditions,
    ) -> PositionTerms {
        let mut place = first;
        let placed = terms.map(|term| {
            let own = place;
            place += term.places.len();
            (own, term.clone())
        });
        PositionTerms { terms: placed.collect(), position, conditions }
    }

    /// Adds what they say to the coordinates; `x` is of the coordinates' blocks, which store a number each.
    pub(in crate::residuals) fn add_to(&self, coordinates: &mut [f64], x: &[f64]) -> Vec<Further> {
        let at = Moment::new(&[], &[], &self.position, &self.conditions);
        let mut all = Vec::new();
        for (first, term) in &self.terms {
            let count = term.places.len();
            let mut by_parameter = vec![0.0; count];
            let partials = Partials { by_parameter: &mut by_parameter, by_torque: &mut [], by_coordinate: &mut [] };
            coordinates[term.joint] += term.value_of(&at, &x[*first..*first + count], Some(partials));
            let further = |(place, slope)| Further { joint: term.joint, place, slope };
            all.extend((*first..).zip(by_parameter).map(further));
        }
        all
    }
}
