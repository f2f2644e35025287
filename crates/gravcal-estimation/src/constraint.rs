//! What the unknowns must obey, exactly, whatever the readings say.
//!
//! ```text
//!     range     lower ≤ f(x) ≤ upper                    bounds, linear constraints
//!     cone      ‖(f_1(x), …, f_n(x))‖ ≤ f_0(x)           balls, centres of mass inside a ball
//!     length    ‖x_block‖ = length                       a vector of known length
//! ```
//!
//! `f` are affine functions of stored coordinates. Ranges and cones are convex; a length is not. Methods that cannot
//! take constraints say so ([`Solver::check`](crate::Solver::check)).

use thiserror::Error;

use crate::{BlockId, Values};

/// Share of the numbers that make up a constraint within which it counts as obeyed.
const ROUNDING: f64 = 1e-9;

/// `constant + Σ coefficient · component`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Affine {
    /// Block, stored component, coefficient.
    pub terms: Vec<(BlockId, usize, f64)>,
    /// What is added.
    pub constant: f64,
}

impl Affine {
    /// One component of a block.
    pub fn component(block: BlockId, index: usize) -> Self {
        Affine { terms: vec![(block, index, 1.0)], constant: 0.0 }
    }

    /// A number.
    pub fn constant(value: f64) -> Self {
        Affine { terms: Vec::new(), constant: value }
    }

    /// With one more term.
    #[must_use]
    pub fn plus(mut self, block: BlockId, index: usize, coefficient: f64) -> Self {
        self.terms.push((block, index, coefficient));
        self
    }

    /// With a number added.
    #[must_use]
    pub fn offset(self, value: f64) -> Self {
        Affine { constant: self.constant + value, ..self }
    }

    /// Its value.
    pub fn at(&self, values: &Values) -> f64 {
        self.constant + self.terms.iter().map(|(id, index, c)| c * values.get(*id)[*index]).sum::<f64>()
    }
}

/// One constraint with the name under which it is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Such as `mass of link2 is positive`.
    pub name: String,
    /// What it demands.
    pub kind: ConstraintKind,
}

/// What a constraint demands.
#[derive(Clone, Debug, PartialEq)]
pub enum ConstraintKind {
    /// `lower ≤ function ≤ upper`; either may be infinite, both may be equal.
    Range {
        /// What is constrained.
        function: Affine,
        /// Smallest value allowed, in the unit of the function.
        lower: f64,
        /// Largest value allowed.
        upper: f64,
    },
    /// `‖norm_of‖ ≤ at_most`: a second-order cone.
    Cone {
        /// Components of the vector.
        norm_of: Vec<Affine>,
        /// Largest length allowed; positive on one side of a plane only.
        at_most: Affine,
    },
    /// `‖block‖ = length`: like a [`Sphere`](crate::Sphere), but as an equation.
    Length {
        /// The block, on no manifold.
        block: BlockId,
        /// In the unit of the block, positive.
        length: f64,
    },
}

/// A constraint that makes no sense by itself.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("constraint `{name}`: {reason}")]
pub struct ConstraintError {
    /// Its name.
    pub name: String,
    /// What is wrong with it.
    pub reason: String,
}

/// A constraint on which a solution leans.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveConstraint {
    /// Its name.
    pub name: String,
    /// How much the cost would fall for each unit by which it gives way, in the unit of its function.
    ///
    /// A range gives way at the limit at which it holds, outwards, and a cone by what is added to `f_0`: never
    /// negative. An equation gives way by a larger value or length; where the cost would rise, the multiplier is negative.
    pub multiplier: f64,
    /// Functions that it holds where they are, to first order: one, or all that it is made of at the tip of a cone.
    pub holds: Vec<Affine>,
}

impl Constraint {
    /// `lower ≤ component ≤ upper` of a block.
    pub fn bound(name: impl Into<String>, block: BlockId, component: usize, lower: f64, upper: f64) -> Self {
        Constraint::range(name, Affine::component(block, component), lower, upper)
    }

    /// `lower ≤ function ≤ upper`.
    pub fn range(name: impl Into<String>, function: Affine, lower: f64, upper: f64) -> Self {
        Constraint { name: name.into(), kind: ConstraintKind::Range { function, lower, upper } }
    }

    /// `‖norm_of‖ ≤ at_most`.
    pub fn cone(name: impl Into<String>, norm_of: Vec<Affine>, at_most: Affine) -> Self {
        Constraint { name: name.into(), kind: ConstraintKind::Cone { norm_of, at_most } }
    }

    /// A block within `radius` of `centre`.
    pub fn ball(name: impl Into<String>, block: BlockId, centre: &[f64], radius: f64) -> Self {
        let norm_of = centre.iter().enumerate().map(|(i, c)| Affine::component(block, i).offset(-c)).collect();
        Constraint::cone(name, norm_of, Affine::constant(radius))
    }

    /// `‖block‖ = length`.
    pub fn length(name: impl Into<String>, block: BlockId, length: f64) -> Self {
        Constraint { name: name.into(), kind: ConstraintKind::Length { block, length } }
    }

    /// By how much it is violated, in the unit of its function; zero or less where it holds.
    pub fn violation(&self, values: &Values) -> f64 {
        match &self.kind {
            ConstraintKind::Range { function, lower, upper } => {
                let value = function.at(values);
                (lower - value).max(value - upper)
            }
            ConstraintKind::Cone { norm_of, at_most } => {
                norm(norm_of.iter().map(|f| f.at(values))) - at_most.at(values)
            }
            ConstraintKind::Length { block, length } => (norm(values.get(*block).iter().copied()) - length).abs(),
        }
    }

    /// Whether it holds, up to rounding: a violation by 1e-9 of the numbers that it is made of is none, nor is one by
    /// 2e-16 in its unit, where they all vanish (the tip of a cone).
    pub fn is_obeyed_by(&self, values: &Values) -> bool {
        let limits = match &self.kind {
            ConstraintKind::Range { lower, upper, .. } => {
                [lower, upper].map(|v| if v.is_finite() { v.abs() } else { 0.0 })
            }
            ConstraintKind::Cone { .. } => [0.0; 2],
            ConstraintKind::Length { length, .. } => [*length, 0.0],
        };
        let size: f64 = limits.into_iter().chain(self.functions().iter().map(|f| f.size_at(values))).sum();
        self.violation(values) <= (ROUNDING * size).max(f64::EPSILON)
    }

    /// What is wrong with values that break it, in words: `` `mass of link2` (is -1, must be at least 0) ``.
    pub fn complaint(&self, values: &Values) -> String {
        let (found, demanded) = match &self.kind {
            ConstraintKind::Range { function, lower, upper } => {
                (format!("is {}", function.at(values)), reported(*lower, *upper))
            }
            ConstraintKind::Cone { norm_of, at_most } => {
                let length = norm(norm_of.iter().map(|f| f.at(values)));
                (format!("has length {length}"), format!("at most {}", at_most.at(values)))
            }
            ConstraintKind::Length { block, length } => {
                (format!("has length {}", norm(values.get(*block).iter().copied())), length.to_string())
            }
        };
        format!("`{}` ({found}, must be {demanded})", self.name)
    }

    /// Blocks that it reads.
    pub fn blocks(&self) -> Vec<BlockId> {
        let mut blocks: Vec<BlockId> = match &self.kind {
            ConstraintKind::Length { block, .. } => vec![*block],
            _ => self.functions().iter().flat_map(|f| f.terms.iter().map(|(id, ..)| *id)).collect(),
        };
        blocks.sort_unstable();
        blocks.dedup();
        blocks
    }

    fn functions(&self) -> Vec<&Affine> {
        match &self.kind {
            ConstraintKind::Range { function, .. } => vec![function],
            ConstraintKind::Cone { norm_of, at_most } => norm_of.iter().chain([at_most]).collect(),
            ConstraintKind::Length { .. } => Vec::new(),
        }
    }

    /// # Errors
    /// Where no values could obey it, or it reads what does not exist. `stored`: numbers of each block.
    pub(crate) fn check(&self, stored: &[usize]) -> Result<(), ConstraintError> {
        match self.fault(stored) {
            Some(reason) => Err(ConstraintError { name: self.name.clone(), reason }),
            None => Ok(()),
        }
    }

    fn fault(&self, stored: &[usize]) -> Option<String> {
        match &self.kind {
            ConstraintKind::Range { lower, upper, .. } if lower.is_nan() || upper.is_nan() => {
                return Some(format!("its bounds {lower} and {upper} must be numbers or infinite"));
            }
            ConstraintKind::Range { lower, upper, .. } if lower > upper => {
                return Some(format!("its lower bound {lower} exceeds its upper bound {upper}"));
            }
            ConstraintKind::Range { lower, upper, .. } if *lower == f64::INFINITY || *upper == f64::NEG_INFINITY => {
                return Some(format!("nothing is between {lower} and {upper}"));
            }
            ConstraintKind::Length { length, .. } if !(length.is_finite() && *length > 0.0) => {
                return Some(format!("the length {length} must be positive and finite"));
            }
            ConstraintKind::Length { block, .. } if block.index() >= stored.len() => {
                return Some("it reads a block of another problem".into());
            }
            ConstraintKind::Range { .. } | ConstraintKind::Cone { .. } if self.blocks().is_empty() => {
                return Some("it reads no block".into());
            }
            _ => {}
        }
        self.functions().into_iter().find_map(|f| f.fault(stored))
    }
}

impl Affine {
    /// Sum of the sizes of its terms.
    fn size_at(&self, values: &Values) -> f64 {
        self.constant.abs() + self.terms.iter().map(|(id, i, c)| (c * values.get(*id)[*i]).abs()).sum::<f64>()
    }

    fn fault(&self, stored: &[usize]) -> Option<String> {
        if !self.constant.is_finite() || self.terms.iter().any(|(_, _, c)| !c.is_finite()) {
            return Some("a coefficient is not finite".into());
        }
        let unknown = self.terms.iter().find(|(id, index, _)| stored.get(id.index()).is_none_or(|n| index >= n));
        unknown.map(|(id, index, _)| format!("there is no component {index} of block {}", id.index()))
    }
}

fn reported(lower: f64, upper: f64) -> String {
    match (lower.is_finite(), upper.is_finite()) {
        _ if lower == upper => lower.to_string(),
        (true, false) => format!("at least {lower}"),
        (false, true) => format!("at most {upper}"),
        _ => format!("between {lower} and {upper}"),
    }
}

fn norm(components: impl Iterator<Item = f64>) -> f64 {
    components.map(|c| c * c).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, ProblemBuilder};

    fn block_at(initial: &[f64]) -> (BlockId, Values) {
        let mut builder = ProblemBuilder::new();
        let id = builder.add_block(Block::vector("x", "m", &["x", "y", "z"]), initial);
        (id, builder.initial())
    }

    #[test]
    fn violations_are_reported_in_the_unit_of_the_function() {
        let (x, values) = block_at(&[3.0, 4.0, 0.0]);
        assert_eq!(Constraint::bound("b", x, 1, 5.0, f64::INFINITY).violation(&values), 1.0);
        assert_eq!(Constraint::bound("b", x, 1, f64::NEG_INFINITY, 3.5).violation(&values), 0.5);
        assert_eq!(Constraint::ball("s", x, &[0.0; 3], 7.0).violation(&values), -2.0);
        assert_eq!(Constraint::length("l", x, 6.0).violation(&values), 1.0);
    }

    #[test]
    fn values_that_break_a_constraint_are_reported_with_its_limits() {
        let (x, values) = block_at(&[3.0, 4.0, 0.0]);
        let reported = |constraint: Constraint| constraint.complaint(&values);
        assert_eq!(reported(Constraint::bound("b", x, 0, f64::NEG_INFINITY, 2.0)), "`b` (is 3, must be at most 2)");
        assert_eq!(reported(Constraint::bound("b", x, 0, 4.0, 5.0)), "`b` (is 3, must be between 4 and 5)");
        assert_eq!(reported(Constraint::bound("b", x, 0, 4.0, 4.0)), "`b` (is 3, must be 4)");
        assert_eq!(reported(Constraint::ball("s", x, &[0.0; 3], 4.5)), "`s` (has length 5, must be at most 4.5)");
        assert_eq!(reported(Constraint::length("l", x, 6.0)), "`l` (has length 5, must be 6)");
        assert!(Constraint::bound("b", x, 0, 3.0 + 1e-12, 5.0).is_obeyed_by(&values));
        assert!(!Constraint::bound("b", x, 0, 3.0 + 1e-7, 5.0).is_obeyed_by(&values));
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let (x, _) = block_at(&[0.0; 3]);
        let error = Constraint::bound("mass", x, 0, 2.0, 1.0).check(&[3]).unwrap_err();
        assert_eq!(error.to_string(), "constraint `mass`: its lower bound 2 exceeds its upper bound 1");
        assert!(Constraint::bound("mass", x, 3, 0.0, 1.0).check(&[3]).is_err());
        assert!(Constraint::bound("mass", x, 0, f64::NAN, 1.0).check(&[3]).is_err());
        assert!(Constraint::bound("mass", x, 0, f64::INFINITY, f64::INFINITY).check(&[3]).is_err());
        assert!(Constraint::range("nothing", Affine::constant(1.0), 0.0, 1.0).check(&[3]).is_err());
        assert!(Constraint::length("g", x, 0.0).check(&[3]).is_err());
    }
}
