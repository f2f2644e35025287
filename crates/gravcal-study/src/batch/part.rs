//! How the trials of a study are cut into parts.

use std::ops::Range;

/// Trials of a part at most: what is lost when a run is killed.
const LARGEST: u64 = 256;
/// Parts that a study is cut into at least, so that every core has some to do.
const FEW: u64 = 64;

/// Some trials of one point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Its number.
    pub number: usize,
    /// Place of the point.
    pub point: usize,
    /// Numbers of the trials.
    pub trials: Range<u64>,
}

/// All parts in their order: point by point, trial by trial.
pub(super) fn parts(points: usize, trials: u64) -> Vec<Part> {
    let size = (points as u64).saturating_mul(trials).div_ceil(FEW).clamp(1, LARGEST);
    let of_point =
        |point: usize| (0..trials.div_ceil(size)).map(move |k| (point, k * size..trials.min((k + 1) * size)));
    let all = (0..points).flat_map(of_point).enumerate();
    all.map(|(number, (point, trials))| Part { number, point, trials }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trial_of_every_point_is_in_one_part() {
        for (points, trials) in [(1, 1), (3, 100), (2, 1000), (1, 100_000)] {
            let parts = parts(points, trials);
            let counted: u64 = parts.iter().map(|part| part.trials.end - part.trials.start).sum();
            assert_eq!(counted, points as u64 * trials);
            assert!(parts.windows(2).all(|pair| {
                let next = pair[0].point == pair[1].point && pair[0].trials.end == pair[1].trials.start;
                next || (pair[0].point + 1 == pair[1].point && pair[1].trials.start == 0)
            }));
            assert!(parts.iter().all(|part| part.trials.end - part.trials.start <= LARGEST));
        }
    }
}
