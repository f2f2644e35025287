//! What a reader should know of a solution besides its numbers: what was held, what is hardly known, which loss there was.

use gravcal_estimation::{Loss, NamedCombination, held_blocks, named_combinations};

use crate::joint::{GAUGE, Layout, Solved};
use crate::result::{HeldBlock, LossResult, WeakCombination};

/// The loss, if there is one.
pub(crate) fn loss(loss: Loss) -> Option<LossResult> {
    loss.width().map(|width| LossResult { kind: loss.name().as_str(), width })
}

/// Everything that was held: by the session, because the data say too little of it, or to fix a gauge.
pub(crate) fn held(solved: &Solved) -> Vec<HeldBlock> {
    let problem = solved.posed.problem.holding(&solved.gauges, GAUGE);
    let values = &solved.estimate.values;
    let tell = |(id, why): (_, &str)| HeldBlock {
        name: problem.block(id).name.clone(),
        value: values.get(id).to_vec(),
        why: why.to_owned(),
    };
    held_blocks(&problem).map(tell).collect()
}

/// Steps of gravity and the sensor parameters that change the readings hardly, whatever masses and moments are.
pub(crate) fn weak_combinations(solved: &Solved) -> Vec<WeakCombination> {
    let Layout { gravity, sensors, further, .. } = &solved.posed.layout;
    let problem = &solved.posed.problem;
    let blocks = [*gravity].into_iter().chain(sensors.iter().flatten().chain(further).copied());
    let columns: Vec<usize> = blocks.flat_map(|id| problem.columns_of(id)).collect();
    let weak = solved.spectrum.weak_directions(&columns);
    let steps: Vec<Vec<f64>> = weak.iter().map(|direction| direction.step.clone()).collect();
    let named = named_combinations(problem, &solved.estimate.values, &columns, &steps);
    let tell = |(combination, times_worse): (NamedCombination, f64)| WeakCombination {
        combination: combination.to_string(),
        terms: combination.terms.into_iter().map(|term| (term.name, term.unit, term.coefficient)).collect(),
        times_worse,
    };
    named.into_iter().zip(weak.iter().map(|direction| direction.times_worse)).map(tell).collect()
}

/// The same for people.
pub(crate) fn weak_note(weak: &WeakCombination) -> String {
    format!(
        "Known {:.0} times worse than the rest, because the readings hardly change along it: {}.",
        weak.times_worse, weak.combination
    )
}
