//! Masses, moments and placements in the combinations that the data determine (base parameters).
//!
//! Any masses and moments that reproduce these combinations predict the same gravity torques; of an arm in motion inertia tensors and rotor
//! inertias take part in them, and the same holds of all torques. (Khalil and Dombre, chapter 9: minimal inertial parameters; found
//! numerically, as by Gautier, Numerical calculation of the base inertial parameters of robots, 1991.)
//!
//! What moves with a parameter that is not determined is no number either: of combinations only those are told that stay where they are
//! when such a parameter takes another value, and everything else follows (to first order `cov(·, p) / var(p)`). And where the scale of torque
//! gains is open, so is that of all moments: combinations that do not change with it are zero by themselves and say nothing, and linear
//! knowledge of them would not hold at another scale.

use std::collections::HashMap;

use gravcal_estimation::statistics::{LinearFunction, stored_coordinates};
use gravcal_estimation::{BlockId, Covariance, Problem, RankAnalysis, Values, sparse_basis};
use gravcal_robot_model::parameter::SensorParameter;

use crate::joint::VariableIndex;
use crate::result::MomentResult;

/// Part in directions without information, in scaled coordinates, from which on one counts; all but as much is a direction of its own.
const SHARED: f64 = 1e-5;
/// Weight of what an arm feels that stands, beside what it feels in motion only, where both are combined.
const OF_STANDING: f64 = 1e-3;

/// A combination, and how it depends on the problem's columns.
pub(crate) struct DeterminedMoment {
    pub reported: MomentResult,
    pub function: LinearFunction,
}

/// The combinations with value and standard deviation. `open`: columns of parameters that are not determined.
pub(crate) fn determined_moments(
    problem: &Problem,
    values: &Values,
    variables: &VariableIndex,
    analysis: &RankAnalysis,
    covariance: &Covariance,
    open: &[usize],
) -> Vec<DeterminedMoment> {
    if scale_is_open(problem, variables, analysis) {
        return Vec::new();
    }
    let mut placements: Vec<BlockId> = variables.loads.iter().flatten().flatten().copied().collect();
    placements.sort_unstable();
    placements.dedup();
    let (on_sphere, euclidean): (Vec<BlockId>, Vec<BlockId>) =
        placements.into_iter().partition(|id| !problem.block(*id).is_euclidean());
    // A rotor inertia that is determined is told by itself.
    let rotors = variables.rotors.iter().filter(|id| problem.columns_of(**id).any(|column| open.contains(&column)));
    let of_motion: Vec<BlockId> = variables.tensors.iter().chain(rotors).copied().collect();
    let first = of_motion.iter().map(|id| problem.columns_of(*id).len()).sum();
    let standing = variables.inertia.iter().chain(&variables.sweep_moments).copied().chain(euclidean);
    let blocks: Vec<BlockId> = of_motion.into_iter().chain(standing).collect();
    let mut results = combinations(problem, values, (&blocks, first), analysis, covariance, open);
    for id in on_sphere {
        results.extend(determined_vector(problem, values, id, analysis, covariance));
    }
    results
}

/// Whether a torque gain takes part in a direction without information, together with something else.
fn scale_is_open(problem: &Problem, variables: &VariableIndex, analysis: &RankAnalysis) -> bool {
    let gains = variables.sensors.iter().flat_map(|ids| problem.columns_of(ids[SensorParameter::TorqueGain as usize]));
    gains.map(|column| analysis.null_share(column)).any(|share| (SHARED..1.0 - SHARED).contains(&share))
}

/// Combinations of blocks whose columns are their stored coordinates; the `first` columns are felt in motion only, and whoever knows the others
/// from an arm that stands finds combinations of these alone.
fn combinations(
    problem: &Problem,
    values: &Values,
    (blocks, first): (&[BlockId], usize),
    analysis: &RankAnalysis,
    covariance: &Covariance,
    open: &[usize],
) -> Vec<DeterminedMoment> {
    let coordinates: Vec<(usize, BlockId, usize)> = blocks
        .iter()
        .flat_map(|id| problem.columns_of(*id).enumerate().map(|(component, column)| (column, *id, component)))
        .collect();
    let columns: Vec<usize> = coordinates.iter().map(|(column, _, _)| *column).collect();
    let moves_with = |open: &usize| -> Option<Vec<f64>> {
        let variance = covariance.at(*open, *open);
        // What moves without any information is in the null space already.
        (variance > 0.0 && analysis.null_share(*open) < SHARED)
            .then(|| columns.iter().map(|column| covariance.at(*column, *open) / variance).collect())
    };
    let moved: Vec<Vec<f64>> = open.iter().filter_map(moves_with).collect();
    // What stands in few combinations comes first in a sparse basis: the rest is left with none of it.
    let weigh = |mut vector: Vec<f64>, weight: f64| {
        vector.iter_mut().skip(first).for_each(|entry| *entry *= weight);
        vector
    };
    let weight = if first > 0 { OF_STANDING } else { 1.0 };
    // What is known no better than without any reading is no number, and its covariance nothing but rounding.
    let widths: HashMap<usize, f64> =
        problem.reference().map(|reference| reference.std_by_column(problem)).into_iter().flatten().collect();
    let wide = |function: &LinearFunction| {
        let squares =
            function.iter().map(|(column, c)| (c * widths.get(column).copied().unwrap_or(f64::INFINITY)).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let determined = analysis.determined_within(&columns, &moved).into_iter();
    let determined: Vec<Vec<f64>> = determined.map(|vector| weigh(vector, weight)).collect();
    let plain = |vector: Vec<f64>| match vector[..first].iter().any(|entry| *entry != 0.0) {
        true => weigh(vector, 1.0 / weight),
        // All of it is weighed alike.
        false => vector,
    };
    sparse_basis(&determined, 1e-7)
        .into_iter()
        .map(plain)
        .filter_map(|coefficients| {
            let used = || coordinates.iter().zip(&coefficients).filter(|(_, c)| **c != 0.0);
            let by_column: Vec<(usize, f64)> = used().map(|((column, _, _), c)| (*column, *c)).collect();
            let reported = MomentResult {
                terms: used().map(|((_, id, i), c)| (problem.block(*id).component_name(*i), *c)).collect(),
                value: used().map(|((_, id, i), c)| c * values.get(*id)[*i]).sum(),
                std: covariance.std_of(&by_column),
            };
            (reported.std < wide(&by_column)).then_some(DeterminedMoment { reported, function: by_column })
        })
        .collect()
}

/// The components of a vector of known length, where its direction is determined.
fn determined_vector(
    problem: &Problem,
    values: &Values,
    id: BlockId,
    analysis: &RankAnalysis,
    covariance: &Covariance,
) -> Vec<DeterminedMoment> {
    let columns: Vec<usize> = problem.columns_of(id).collect();
    if !analysis.null_space_within(&columns).is_empty() {
        return Vec::new();
    }
    let component = |(i, function): (usize, LinearFunction)| {
        let reported = MomentResult {
            terms: vec![(problem.block(id).component_name(i), 1.0)],
            value: values.get(id)[i],
            std: covariance.std_of(&function),
        };
        DeterminedMoment { reported, function }
    };
    stored_coordinates(problem, values, &[id]).into_iter().enumerate().map(component).collect()
}
