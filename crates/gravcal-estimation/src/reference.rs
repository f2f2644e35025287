//! A reference prior: where unknowns rest of which the readings say nothing, and how firmly.
//!
//! ```text
//!     ½ Σ ((x − x₀)/σ)²      over stored numbers of free blocks, added to the cost
//! ```
//!
//! It makes every fit well posed: without it a method walks anywhere along a direction without information, and what it finds
//! there (a gain of 10⁶, a gain of 0) spoils the linear model of all the rest. With a σ that is wide beside what would be of use
//! it moves what the readings determine by next to nothing, and moving x₀ to where a fit ended takes even that away.
//!
//! **It is no information.** Methods see it ([`Problem::cost`](crate::Problem::cost), [`Linearization`](crate::Linearization));
//! residuals, weights, rank, covariance and what is passed on do not. What a user knows beforehand is a factor, and is judged.

use crate::{BlockId, Problem, Values};

/// Centre and width for some of a problem's numbers.
#[derive(Clone, Debug)]
pub struct Reference {
    center: Values,
    /// 1/σ of each stored number; zero where there is none.
    weights: Vec<f64>,
}

impl Reference {
    /// Of nothing yet, about these values.
    pub fn new(center: Values) -> Reference {
        let weights = vec![0.0; center.as_slice().len()];
        Reference { center, weights }
    }

    /// The same that lets each number of a block vary by its `std`, in the number's unit. Numbers whose `std` is zero, infinite or no
    /// number are left alone, and so are blocks that are eliminated or on a manifold.
    #[must_use]
    pub fn with(mut self, id: BlockId, std: &[f64]) -> Reference {
        let start = self.center.offsets[id.index()];
        let weight = |std: &f64| if std.is_finite() && *std > 0.0 { 1.0 / std } else { 0.0 };
        self.weights[start..].iter_mut().zip(std).for_each(|(own, std)| *own = weight(std));
        self
    }

    /// The same, so many times as firm: every σ divided by it.
    pub fn times_as_firm(&self, times: f64) -> Reference {
        Reference { center: self.center.clone(), weights: self.weights.iter().map(|weight| times * weight).collect() }
    }

    /// Columns of a problem that it holds, each with its σ.
    pub fn std_by_column(&self, problem: &Problem) -> Vec<(usize, f64)> {
        let entries = Pull::to(self, problem, &self.center).entries;
        entries.into_iter().map(|(column, weight, _)| (column, 1.0 / weight)).collect()
    }

    /// What it adds to the cost of a problem at these values.
    pub fn cost(&self, problem: &Problem, values: &Values) -> f64 {
        Pull::to(self, problem, values).cost()
    }

    /// Whether a problem's values can be held against it.
    pub(crate) fn is_of(&self, problem: &Problem) -> bool {
        problem.fits(&self.center)
    }

    /// The same about other values of the same problem.
    pub fn centered_at(&self, center: &Values) -> Reference {
        Reference { center: center.clone(), weights: self.weights.clone() }
    }
}

/// What a reference does to the columns of a problem at a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pull {
    /// Column, 1/σ, and (x − x₀)/σ.
    pub entries: Vec<(usize, f64, f64)>,
}

impl Pull {
    /// That of the problem's reference; of a problem without one, nothing.
    pub fn of(problem: &Problem, values: &Values) -> Pull {
        problem.reference().map_or_else(Pull::default, |reference| Pull::to(reference, problem, values))
    }

    fn to(reference: &Reference, problem: &Problem, values: &Values) -> Pull {
        let free = problem.block_ids().filter(|id| {
            let block = problem.block(*id);
            !block.eliminated && block.is_euclidean()
        });
        let of_block = |id: BlockId| {
            let start = values.offsets[id.index()];
            problem.columns_of(id).enumerate().filter_map(move |(index, column)| {
                let (at, weight) = (start + index, reference.weights[start + index]);
                let distance = values.data[at] - reference.center.data[at];
                (weight > 0.0).then_some((column, weight, weight * distance))
            })
        };
        Pull { entries: free.flat_map(of_block).collect() }
    }

    /// ½ Σ ((x − x₀)/σ)².
    pub fn cost(&self) -> f64 {
        0.5 * self.entries.iter().map(|(_, _, distance)| distance * distance).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Line, Newton, add};
    use crate::{Block, ProblemBuilder, RankAnalysis, SolveContext, Solver};

    /// Readings of a + b alone, and of c.
    fn sum_and_number() -> (Problem, Values, [BlockId; 3]) {
        let mut builder = ProblemBuilder::new();
        let ids = ["a", "b", "c"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        for k in 0..40 {
            let error = f64::from(k % 2) - 0.5;
            add(&mut builder, Line::new(&ids[..2], &[1.0, 1.0], 3.0 + error));
            add(&mut builder, Line::new(&ids[2..], &[1.0], 5.0 + error));
        }
        let (problem, values) = builder.build().unwrap();
        (problem, values, ids)
    }

    #[test]
    fn what_the_readings_leave_open_rests_at_the_reference_and_nothing_else_is_moved_in_the_end() {
        let (problem, values, [a, b, c]) = sum_and_number();
        let reference = [a, b, c].iter().fold(Reference::new(values.clone()), |r, id| r.with(*id, &[10.0]));
        let mut held = problem.with_reference(reference);
        let mut estimate = Newton.solve(&held, &values, &mut SolveContext::default()).unwrap();
        // By hand: 40 readings of c of unit noise and one of 0 ± 10.
        assert!((estimate.values.scalar(c) - 5.0 * 40.0 / 40.01).abs() < 1e-9);
        for _ in 0..3 {
            held = held.with_reference(held.reference().unwrap().centered_at(&estimate.values));
            estimate = Newton.solve(&held, &estimate.values, &mut SolveContext::default()).unwrap();
        }
        let [a, b, c] = [a, b, c].map(|id| estimate.values.scalar(id));
        assert!((a - b).abs() < 1e-9 && (a + b - 3.0).abs() < 1e-9 && (c - 5.0).abs() < 1e-9, "{a} {b} {c}");
    }

    #[test]
    fn it_is_in_the_cost_and_not_in_what_is_judged() {
        let (problem, values, [a, ..]) = sum_and_number();
        let held = problem.with_reference(Reference::new(values.clone()).with(a, &[0.5]));
        let mut moved = values.clone();
        moved.set(a, &[2.0]);
        let difference = held.cost(&moved).unwrap() - problem.cost(&moved).unwrap();
        assert!((difference - 8.0).abs() < 1e-9, "½ (2/0.5)²: {difference}");
        assert_eq!(RankAnalysis::new(&held, &values).unwrap().rank(), 2);
        assert_eq!(held.residuals(&moved).unwrap(), problem.residuals(&moved).unwrap());
    }
}
