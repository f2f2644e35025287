//! From where to where measures go: over quantities, and over points.

use gravcal_robot_model::number::significant;
use gravcal_study::measures::{QuantityMeasures, Series};

/// The least and the largest of some numbers; those that are none do not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range([f64; 2]);

impl Range {
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Range> {
        values.filter(|value| value.is_finite()).fold(None, |range, value| match range {
            None => Some(Range([value; 2])),
            Some(Range([low, high])) => Some(Range([low.min(value), high.max(value)])),
        })
    }

    /// Of one measure of all quantities that have an estimate.
    pub fn over_quantities<'s>(
        series: impl Iterator<Item = &'s Series>,
        of: fn(&QuantityMeasures) -> f64,
    ) -> Option<Range> {
        let quantities = series.flat_map(|series| &series.quantities);
        Range::of(quantities.filter(|quantity| quantity.estimates > 0).map(of))
    }

    /// `0.98 to 1.02`, or one number where both look alike.
    pub fn reported(&self) -> String {
        let [low, high] = self.0.map(|value| significant(value, 3));
        if low == high { low } else { format!("{low} to {high}") }
    }
}

/// rms error over the Cramér-Rao bound.
pub(super) fn over_bound(quantity: &QuantityMeasures) -> f64 {
    quantity.ratio.value
}

/// Which of the 95 % intervals hold the truth, in %.
pub(super) fn coverage(quantity: &QuantityMeasures) -> f64 {
    100.0 * quantity.coverage.value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none_do_not_count() {
        let range = |values: &[f64]| Range::of(values.iter().copied()).map(|range| range.reported());
        assert_eq!(range(&[f64::NAN, 34.21, 0.98]), Some("0.980 to 34.2".to_owned()));
        assert_eq!(range(&[1.0001, 1.0]), Some("1.00".to_owned()));
        assert_eq!(range(&[f64::NAN]), None);
    }
}
