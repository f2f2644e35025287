//! What a reader should know of a solution besides its numbers: what was fixed, what is hardly known, which loss there was.

use gravcal_estimation::{Loss, NamedCombination, fixed_blocks, named_combinations};

use crate::joint::{Solved, VariableIndex};
use crate::result::{FixedBlock, LossResult, WeakCombination};

/// The loss, if there is one.
pub(crate) fn loss(loss: Loss) -> Option<LossResult> {
    loss.width().map(|width| LossResult { kind: loss.name().as_str(), width })
}

/// Everything that was held by the session.
pub(crate) fn held(solved: &Solved) -> Vec<FixedBlock> {
    let problem = &solved.built.problem;
    let values = &solved.estimate.values;
    let report = |(id, why): (_, &str)| FixedBlock {
        name: problem.block(id).name.clone(),
        value: values.get(id).to_vec(),
        why: why.to_owned(),
    };
    fixed_blocks(problem).map(report).collect()
}

/// Steps of gravity and the sensor parameters that change the readings hardly, whatever masses and moments are.
pub(crate) fn weak_combinations(solved: &Solved) -> Vec<WeakCombination> {
    let VariableIndex { gravity, sensors, further, .. } = &solved.built.variables;
    let problem = &solved.built.problem;
    let blocks = [*gravity].into_iter().chain(sensors.iter().flatten().chain(further).copied());
    let columns: Vec<usize> = blocks.flat_map(|id| problem.columns_of(id)).collect();
    let weak = solved.analysis.weak_directions(&columns);
    let steps: Vec<Vec<f64>> = weak.iter().map(|direction| direction.step.clone()).collect();
    let named = named_combinations(problem, &solved.estimate.values, &columns, &steps);
    let report = |(combination, times_worse): (NamedCombination, f64)| WeakCombination {
        combination: combination.to_string(),
        terms: combination.terms.into_iter().map(|term| (term.name, term.unit, term.coefficient)).collect(),
        times_worse,
    };
    named.into_iter().zip(weak.iter().map(|direction| direction.times_worse)).map(report).collect()
}

/// Beyond this factor the figure tells of rounding, not of the data.
const HARDLY_KNOWN: f64 = 1e6;

/// The same for people.
pub(crate) fn weak_note(weak: &WeakCombination) -> String {
    let times = match weak.times_worse {
        times if times < HARDLY_KNOWN => format!("{times:.0} times"),
        _ => "more than a million times".to_owned(),
    };
    format!("Known {times} worse than the rest, because the readings hardly change along it: {}.", weak.combination)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_without_meaning_is_not_reported() {
        let reported = |times_worse: f64| {
            weak_note(&WeakCombination { combination: "1.00 a.torque_gain".into(), terms: Vec::new(), times_worse })
        };
        assert!(reported(1234.4).starts_with("Known 1234 times worse than the rest, "));
        for absurd in [6e13, f64::INFINITY] {
            assert!(reported(absurd).starts_with("Known more than a million times worse than the rest, "));
        }
    }
}
