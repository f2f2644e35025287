//! Angles that jump by about a full turn from row to row, because their sensor begins anew there.

use std::f64::consts::PI;

use crate::unit::PositionUnit;

/// Shares of a turn by which a reading jumps where an angle wraps: no joint turns by the rest from one row to the next.
const SHARES: std::ops::Range<f64> = 0.95..1.01;

/// Counts them, joint by joint.
#[derive(Clone, Debug)]
pub(crate) struct Wraps {
    /// Of each joint whether its unit is one of angles, its last position, rad, and how often it wrapped.
    joints: Vec<(bool, f64, u64)>,
}

impl Wraps {
    /// `units`: those of the position columns.
    pub fn new(units: impl Iterator<Item = PositionUnit>) -> Wraps {
        let is_angle = |unit| matches!(unit, PositionUnit::Radian | PositionUnit::Degree);
        Wraps { joints: units.map(|unit| (is_angle(unit), f64::NAN, 0)).collect() }
    }

    /// Takes the positions of a row, in SI units; what it does not say is NaN.
    pub fn take(&mut self, positions: &[f64]) {
        for ((is_angle, last, count), at) in self.joints.iter_mut().zip(positions) {
            if at.is_nan() {
                continue;
            }
            let step = (at - std::mem::replace(last, *at)).abs() / (2.0 * PI);
            *count += u64::from(*is_angle && SHARES.contains(&step));
        }
    }

    /// By joint.
    pub fn counts(&self) -> Vec<u64> {
        self.joints.iter().map(|(.., count)| *count).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_by_a_turn_are_counted_where_positions_are_angles() {
        let mut wraps = Wraps::new([PositionUnit::Radian, PositionUnit::Meter].into_iter());
        for at in [3.10, 3.13, f64::NAN, -3.13, -3.0, 3.1, 0.0] {
            wraps.take(&[at, at]);
        }
        assert_eq!(wraps.counts(), [2, 0]);
    }
}
