//! Terms without derivatives by hand: the same dual numbers as in [`gravcal_estimation::Automatic`].

use std::fmt::Debug;

use gravcal_estimation::Number;
use num_dual::DualSVec64;

use super::term::{Moment, Partials, Reads, SensorTerm, Variable};

/// Derivatives that one evaluation gives: most terms have no more.
const DIRECTIONS: usize = 4;

type Dual = DualSVec64<DIRECTIONS>;

/// `f(x; …)` of a [`SensorTerm`], as a function of generic numbers. [`Differentiated`] makes it a term.
///
/// It must be differentiable where it is evaluated; a branch on values is differentiated as the branch taken. A number stands left of a
/// constant (`x * 2.0`, not `2.0 * x`).
pub trait SensorFormula: Debug + Send + Sync {
    /// What it depends on besides its parameters.
    fn reads(&self) -> Reads;

    /// `f` in the unit of the reading (of a position sensor: rad or m).
    fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N;
}

/// A [`SensorFormula`] as a [`SensorTerm`]: derivatives are exact to rounding. Its value has the same bits with and without them.
#[derive(Clone, Debug)]
pub struct Differentiated<F> {
    formula: F,
    reads: Reads,
    variables: Vec<Variable>,
}

impl<F: SensorFormula> Differentiated<F> {
    /// Of this formula.
    pub fn new(formula: F) -> Self {
        let reads = formula.reads();
        let torques = reads.torques().iter().map(|joint| Variable::Torque(*joint));
        let coordinates = reads.coordinates().iter().map(|joint| Variable::Coordinate(*joint));
        let variables = torques.chain(coordinates).collect();
        Differentiated { formula, reads, variables }
    }
}

impl<F: SensorFormula> SensorTerm for Differentiated<F> {
    fn reads(&self) -> Reads {
        self.reads.clone()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        if let Some(Partials { by_parameter, by_torque, by_coordinate }) = partials {
            self.differentiate(at, x, &mut |place, derivative| match place.checked_sub(x.len()) {
                None => by_parameter[place] = derivative,
                Some(variable) => match self.variables[variable] {
                    Variable::Torque(joint) => by_torque[joint] = derivative,
                    Variable::Coordinate(joint) => by_coordinate[joint] = derivative,
                },
            });
        }
        self.formula.value(at, x)
    }
}

impl<F: SensorFormula> Differentiated<F> {
    /// Tells each derivative with its place: those by parameters, then those by variables.
    fn differentiate(&self, at: &Moment<'_>, x: &[f64], report: &mut dyn FnMut(usize, f64)) {
        let mut parameters: Vec<Dual> = x.iter().map(|value| Dual::from_re(*value)).collect();
        let lifted = self.variables.iter().map(|variable| (*variable, Dual::from_re(at.of(*variable))));
        let mut variables: Vec<(Variable, Dual)> = lifted.collect();
        let all = parameters.len() + variables.len();
        for first in (0..all).step_by(DIRECTIONS) {
            let own = first..all.min(first + DIRECTIONS);
            let numbers = parameters.iter_mut().chain(variables.iter_mut().map(|(_, number)| number));
            for (place, number) in numbers.enumerate() {
                let value = Dual::from_re(number.re);
                *number = if own.contains(&place) { value.derivative(place - first) } else { value };
            }
            let found = self.formula.value(&at.with_derivatives(&variables), &parameters);
            // A value without derivative part does not depend on these.
            if let Some(slopes) = &found.eps.0 {
                own.zip(slopes.iter()).for_each(|(place, slope)| report(place, *slope));
            }
        }
    }
}
