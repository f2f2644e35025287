//! Which parameters the data determine.
//!
//! A parameter is *determined* if no direction without information touches it (rank of the whitened, column-scaled
//! Jacobian), and if its standard deviation is within a limit beyond which a number would mislead: its limit of use. The second test is
//! needed because at a noisy estimate a direction without information looks weak instead of empty.
//!
//! ```text
//!     N = null space of J diag(1/‖J e_j‖)       touched: |e_jᵀ N| > 1e-5
//!     σ_j > limit_j                             σ: standard deviation
//! ```
//!
//! Numbers decide; combinations, `Σ c_j (x_j / unit_j)`, are what is told of it, with their small parts left out.
//!
//! Why it is so, and what was tried: `docs/decisions/rank-is-not-enough.md`.

use std::collections::BTreeSet;

use gravcal_estimation::{BlockId, Covariance, Problem, RankAnalysis, sparse_basis};

/// Coefficients of a combination below this share of the largest are not told.
const READABLE: f64 = 0.02;
/// A direction without information touches a column if the column's part of it, in scaled coordinates, exceeds this. Null vectors are
/// accurate to 1e-7 at the tolerance of the rank.
const TOUCHED: f64 = 1e-5;

/// A parameter that is asked for. `Id` is what its owner calls it by.
#[derive(Clone, Copy, Debug)]
pub struct Parameter<Id> {
    /// Which one.
    pub id: Id,
    /// Its block of the problem: one number, a vector, or a direction.
    pub block: BlockId,
    /// Standard deviation beyond which a number would mislead, in the block's unit, more than zero.
    pub limit: f64,
    /// What a coefficient of one in a combination stands for, in the block's unit, more than zero: the value itself for a gain, so that a
    /// common scale shows as such; else the limit.
    pub unit: f64,
}

/// What the data say of the parameters.
#[derive(Clone, Debug)]
pub struct Judgement<Id> {
    /// Combinations without information, and those with too little.
    pub combinations: Vec<Combination<Id>>,
    /// Every parameter that is not determined.
    open: BTreeSet<Id>,
}

impl<Id: Copy + Ord> Judgement<Id> {
    /// Whether a parameter is determined; fixed ones count as such.
    pub fn determines(&self, id: impl Into<Id>) -> bool {
        !self.open.contains(&id.into())
    }

    /// Counts as open what is so in another judgement.
    pub fn leave_open_what_is_open_in(&mut self, other: &Judgement<Id>) {
        self.leave_open(other.open.iter().copied());
    }

    /// Counts parameters as open for a reason that is told elsewhere.
    pub fn leave_unsaid(&mut self, parameters: impl IntoIterator<Item = impl Into<Id>>) {
        self.open.extend(parameters.into_iter().map(Into::into));
    }

    /// Counts parameters as without any information.
    pub fn leave_open(&mut self, parameters: impl IntoIterator<Item = impl Into<Id>>) {
        for id in parameters.into_iter().map(Into::into) {
            if self.open.insert(id) {
                self.combinations.push(Combination::alone(id, None));
            }
        }
    }

    /// Tells by themselves the open parameters that no combination tells.
    fn report_the_rest(&mut self) {
        let reported = |id: &Id| self.combinations.iter().any(|c| c.contains(*id));
        let untold: Vec<Id> = self.open.iter().copied().filter(|id| !reported(id)).collect();
        self.combinations.extend(untold.into_iter().map(|id| Combination::alone(id, None)));
    }
}

/// A combination of parameters that is not determined.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination<Id> {
    /// Parameter and coefficient, in [`Parameter::unit`]; one for each number of a parameter that takes part.
    pub parameters: Vec<(Id, f64)>,
    /// Standard deviation in units of the limit; `None` where there is no information at all.
    pub std_over_limit: Option<f64>,
}

impl<Id: Copy + Ord> Combination<Id> {
    fn alone(parameter: Id, std_over_limit: Option<f64>) -> Self {
        Combination { parameters: vec![(parameter, 1.0)], std_over_limit }
    }

    /// Whether a parameter takes part.
    pub fn contains(&self, parameter: Id) -> bool {
        self.parameters.iter().any(|(id, _)| *id == parameter)
    }
}

/// Judges a solution of a problem by its rank and this covariance.
pub fn judge<Id: Copy + Ord>(
    problem: &Problem,
    analysis: &RankAnalysis,
    covariance: &Covariance,
    parameters: &[Parameter<Id>],
) -> Judgement<Id> {
    let columns = columns(problem, parameters);
    let mut judgement = without_information(analysis, &columns);
    judgement.report_the_rest();
    let is_number = |parameter: &&Parameter<Id>| problem.columns_of(parameter.block).len() < 2;
    let (numbers, vectors): (Vec<_>, Vec<_>) = parameters.iter().partition(is_number);
    for parameter in numbers.into_iter().chain(vectors) {
        add_little_information(problem, covariance, parameter, &mut judgement);
    }
    judgement
}

/// Column and limit of use of each number that is asked for.
pub fn limits_of_use<Id: Copy>(problem: &Problem, parameters: &[Parameter<Id>]) -> Vec<(usize, f64)> {
    columns(problem, parameters).into_iter().map(|(column, parameter)| (column, parameter.limit)).collect()
}

/// Each free number that is asked for.
fn columns<Id: Copy>(problem: &Problem, parameters: &[Parameter<Id>]) -> Vec<(usize, Parameter<Id>)> {
    let of = |parameter: &Parameter<Id>| {
        let parameter = *parameter;
        problem.columns_of(parameter.block).map(move |column| (column, parameter))
    };
    parameters.iter().flat_map(of).collect()
}

fn without_information<Id: Copy + Ord>(analysis: &RankAnalysis, asked: &[(usize, Parameter<Id>)]) -> Judgement<Id> {
    let touched = asked.iter().filter(|(column, _)| analysis.null_share(*column) > TOUCHED);
    let open = touched.map(|(_, parameter)| parameter.id).collect();
    let columns: Vec<usize> = asked.iter().map(|(column, _)| *column).collect();
    let in_units = |v: Vec<f64>| unit_length(v.iter().zip(asked).map(|(c, (_, of))| c / of.unit).collect());
    let directions: Vec<Vec<f64>> = analysis.null_space_within(&columns).into_iter().map(in_units).collect();
    let basis = sparse_basis(&directions, TOUCHED);
    Judgement { combinations: basis.iter().map(|direction| combination(direction, asked)).collect(), open }
}

fn combination<Id: Copy>(direction: &[f64], asked: &[(usize, Parameter<Id>)]) -> Combination<Id> {
    let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let readable = direction.iter().zip(asked).filter(|(coefficient, _)| coefficient.abs() > READABLE * largest);
    let parameters = readable.map(|(coefficient, (_, parameter))| (parameter.id, *coefficient)).collect();
    Combination { parameters, std_over_limit: None }
}

/// A parameter beyond its limit is told by itself.
fn add_little_information<Id: Copy + Ord>(
    problem: &Problem,
    covariance: &Covariance,
    parameter: &Parameter<Id>,
    judgement: &mut Judgement<Id>,
) {
    let ratios = problem.columns_of(parameter.block).map(|column| covariance.std(column) / parameter.limit);
    let ratio = ratios.fold(0.0, f64::max);
    if ratio > 1.0 && judgement.open.insert(parameter.id) {
        judgement.combinations.push(Combination::alone(parameter.id, Some(ratio)));
    }
}

fn unit_length(v: Vec<f64>) -> Vec<f64> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.iter().map(|c| c / length).collect()
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Loss;

    use super::*;
    use crate::testing::{line, sensor};

    const READINGS: [(f64, f64, f64); 4] = [(0.0, 1.0, 0.1), (1.0, 3.0, 0.1), (2.0, 5.0, 0.1), (3.0, 7.0, 0.1)];

    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    enum Of {
        Gain,
        Offset,
        Bias,
    }

    /// Judged where the gain is 2, and offset and bias are somewhere; `fixed` as in [`sensor`].
    fn judged(limits: [f64; 3], fixed: &[usize]) -> Judgement<Of> {
        let (problem, values, blocks) = sensor(&READINGS, [2.0, 0.2, 0.6], fixed, Loss::None);
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let asked = [Of::Gain, Of::Offset, Of::Bias].into_iter().zip(blocks).zip(limits);
        let asked = asked.map(|((id, block), limit)| Parameter { id, block, limit, unit: limit });
        judge(&problem, &analysis, &analysis.covariance(), &asked.collect::<Vec<_>>())
    }

    #[test]
    fn what_cannot_be_distinguished_is_one_combination() {
        let judgement = judged([1.0, 0.5, 0.25], &[]);
        assert!(judgement.determines(Of::Gain) && !judgement.determines(Of::Offset) && !judgement.determines(Of::Bias));
        let [Combination { parameters, std_over_limit: None }] = &judgement.combinations[..] else {
            panic!("{judgement:?}");
        };
        // gain · δoffset + δbias = 0, in halves of an offset and quarters of a bias.
        let coefficient = |wanted: Of| parameters.iter().find(|(id, _)| *id == wanted).unwrap().1;
        let ratio = coefficient(Of::Bias) / coefficient(Of::Offset);
        assert!(parameters.len() == 2 && (ratio + 2.0 * 0.5 / 0.25).abs() < 1e-9, "{parameters:?}");
    }

    #[test]
    fn what_is_known_beyond_its_limit_is_reported_by_itself() {
        // The slope of a line has the standard deviation σ/√Σ(x − x̄)².
        let std = 0.1 / line(&READINGS).2.sqrt();
        assert!(judged([1.001 * std, 1.0, 1.0], &[1]).combinations.is_empty());
        let judgement = judged([0.5 * std, 1.0, 1.0], &[1]);
        let [Combination { parameters, std_over_limit: Some(ratio) }] = &judgement.combinations[..] else {
            panic!("{judgement:?}");
        };
        assert!(!judgement.determines(Of::Gain) && judgement.determines(Of::Bias));
        assert!(parameters[..] == [(Of::Gain, 1.0)] && (ratio - 2.0).abs() < 1e-9, "{judgement:?}");
    }

    #[test]
    fn what_is_open_elsewhere_is_open_and_reported_once() {
        let mut judgement = judged([1.0; 3], &[1]);
        let other = judged([1.0; 3], &[]);
        judgement.leave_open_what_is_open_in(&other);
        judgement.leave_open_what_is_open_in(&other);
        judgement.leave_unsaid([Of::Gain]);
        assert!([Of::Gain, Of::Offset, Of::Bias].iter().all(|id| !judgement.determines(*id)));
        assert_eq!(judgement.combinations.len(), 2);
    }
}
