//! Combinations of parameters in words, and which blocks are fixed.
//!
//! A step of the parameters, such as one without information, reads `1.00 joint1.torque_gain − 0.35 joint2.torque_gain`:
//! with the first of them goes that much of the others. Units stand behind the names where they are not all alike.

use std::fmt;

use crate::{BlockId, Problem, Values};

/// A part below this share of the largest of its block does not show in two digits.
const SHOWN: f64 = 0.005;

/// One parameter's part of a combination.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTerm {
    /// Component of a block, such as `gravity.x`.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// How much it moves, in its unit; 1 for the first.
    pub coefficient: f64,
}

/// A combination of named parameters, in the order of the blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCombination {
    /// Its parts; none is zero.
    pub terms: Vec<NamedTerm>,
}

/// Puts steps into words: `steps` hold the change of each of `columns`, in the columns' units.
pub fn named_combinations(
    problem: &Problem,
    values: &Values,
    columns: &[usize],
    steps: &[Vec<f64>],
) -> Vec<NamedCombination> {
    steps.iter().map(|step| named(problem, values, columns, step)).collect()
}

fn named(problem: &Problem, values: &Values, columns: &[usize], step: &[f64]) -> NamedCombination {
    let mut terms = Vec::new();
    for id in problem.block_ids() {
        let own = problem.columns_of(id);
        let moved = |column: usize| columns.iter().position(|c| *c == column).map_or(0.0, |place| step[place]);
        let basis = problem.tangent_basis(values, id);
        let stored = |s: usize| own.clone().enumerate().map(|(t, c)| basis[s * own.len() + t] * moved(c)).sum::<f64>();
        let parts: Vec<f64> = (0..problem.block(id).len()).map(stored).collect();
        let largest = parts.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        for (component, coefficient) in parts.into_iter().enumerate().filter(|(_, p)| p.abs() > SHOWN * largest) {
            let block = problem.block(id);
            terms.push(NamedTerm {
                name: block.component_name(component),
                unit: block.units[component].clone(),
                coefficient,
            });
        }
    }
    let first = terms.first().map_or(1.0, |term| term.coefficient);
    terms.iter_mut().for_each(|term| term.coefficient /= first);
    NamedCombination { terms }
}

impl fmt::Display for NamedCombination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let alike = self.terms.windows(2).all(|pair| pair[0].unit == pair[1].unit);
        for (index, NamedTerm { name, unit, coefficient }) in self.terms.iter().enumerate() {
            match (index, *coefficient < 0.0) {
                (0, false) => {}
                (0, true) => f.write_str("−")?,
                (_, false) => f.write_str(" + ")?,
                (_, true) => f.write_str(" − ")?,
            }
            match coefficient.abs() {
                size @ 0.01..1000.0 => write!(f, "{size:.2} {name}")?,
                size => write!(f, "{size:.2e} {name}")?,
            }
            if !alike && !unit.is_empty() {
                write!(f, " [{unit}]")?;
            }
        }
        Ok(())
    }
}

/// The blocks that are fixed at their values, and why: choices of a gauge among them.
pub fn fixed_blocks(problem: &Problem) -> impl Iterator<Item = (BlockId, &str)> {
    problem.block_ids().filter_map(|id| Some((id, problem.block(id).fixed.as_deref()?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Line;
    use crate::{Block, Factor, Noise, ProblemBuilder, RankAnalysis};

    /// `y = Σ coefficient · x`, one a row, over scalar blocks of the given names and units.
    fn problem(blocks: &[(&str, &str)], rows: &[&[f64]]) -> (Problem, Values, RankAnalysis) {
        let mut builder = ProblemBuilder::new();
        let ids: Vec<BlockId> = blocks.iter().map(|(n, u)| builder.add_block(Block::scalar(*n, *u), &[1.0])).collect();
        for row in rows {
            builder.add_factor(Factor::new(Line::new(&ids, row, 0.0), Noise::independent(&[1.0]).unwrap()));
        }
        let (problem, values) = builder.build().unwrap();
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        (problem, values, analysis)
    }

    fn reported(problem: &Problem, values: &Values, columns: &[usize], steps: &[Vec<f64>]) -> Vec<String> {
        named_combinations(problem, values, columns, steps).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_has_no_effect_is_named() {
        // Only 0.7 a + 2 b is measured, and c by itself.
        let (problem, values, analysis) =
            problem(&[("a", "m"), ("b", "m"), ("c", "s")], &[&[0.7, 2.0, 0.0], &[0.0, 0.0, 1.0]]);
        let columns = [0, 1, 2];
        assert_eq!(reported(&problem, &values, &columns, &analysis.null_directions(&columns)), ["1.00 a − 0.35 b"]);
        assert!(analysis.weak_directions(&columns).is_empty());
    }

    #[test]
    fn a_direction_known_a_thousand_times_worse_is_named_with_its_units() {
        let a = [1.0, 2e-3, 0.0, 0.0];
        let b = [1.0, 2e-3 + 1e-6, 0.0, 0.0];
        let blocks = [("a", "m"), ("b", "s"), ("c", ""), ("d", "")];
        let (problem, values, analysis) = problem(&blocks, &[&a, &b, &[0.0, 0.0, 1.0, 0.0], &[0.0, 0.0, 0.0, 3.0]]);
        let columns = [0, 1, 2, 3];
        assert!(analysis.null_directions(&columns).is_empty());
        let weak = analysis.weak_directions(&columns);
        assert_eq!(reported(&problem, &values, &columns, &[weak[0].step.clone()]), ["1.00 a [m] − 499.88 b [s]"]);
        // Columns (1, 1) and (1, 1.0005) of unit length: the smaller singular value is 0.00025/√2.
        assert_eq!(weak.len(), 1);
        assert!((weak[0].times_worse / (2.0_f64.sqrt() / 2.5e-4) - 1.0).abs() < 0.01, "{}", weak[0].times_worse);
        // Seen alone, a and b are both badly known, but neither is worse than the other.
        assert!(analysis.weak_directions(&[2, 3]).is_empty());
    }

    #[test]
    fn held_blocks_are_listed_with_their_reasons() {
        let mut builder = ProblemBuilder::new();
        let free = builder.add_block(Block::scalar("a", ""), &[1.0]);
        let fixed = builder.add_block(Block::scalar("b", "").fixed("fixes the scale"), &[1.0]);
        builder.add_factor(Factor::new(Line::new(&[free], &[1.0], 0.0), Noise::independent(&[1.0]).unwrap()));
        let (problem, _) = builder.build().unwrap();
        assert_eq!(fixed_blocks(&problem).collect::<Vec<_>>(), [(fixed, "fixes the scale")]);
    }
}
