//! From which side each joint came: the sign of its last movement that turned its friction round.
//!
//! Friction turns round over a distance: a joint that has come back by `d` from where it turned has `1 − 2 exp(−d/x)` of it the other way, with
//! `x` the pre-sliding travel (Dahl 1968). One that goes a little too far and comes back only bends its bristles; one that comes back by a few
//! travels slides to the other side; in between nobody knows how much of its friction has turned.

use super::block::Block;

/// Movements up to this (rad, m) turn no friction round. Gears and bearings begin to slide after some 1e-4 rad; chosen, not measured.
const PRESLIDING: f64 = 3e-4;
/// Movements from this on (rad, m) turn it round whole: seven times the 1.4 mrad that `experiments/kuka-lwr4-in-motion` finds for a travel.
const SLIDING: f64 = 1e-2;

/// Follows the turning points of each joint.
#[derive(Clone, Debug)]
pub(crate) struct Approach {
    /// Of each joint, rad or m in a unit of its position reading.
    gains: Vec<f64>,
    direction: Vec<f64>,
    sides: Vec<Side>,
}

/// Where a joint slid last.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    /// 1 up, −1 down, 0 before it slid anywhere.
    way: f64,
    /// Lowest and highest position since; both are the furthest that it has come its way, where it has slid.
    ends: Option<[f64; 2]>,
}

impl Approach {
    /// `gains`: of each joint, rad or m in a unit of its position reading.
    pub fn new(gains: &[f64]) -> Approach {
        let joints = gains.len();
        Approach { gains: gains.to_vec(), direction: vec![0.0; joints], sides: vec![Side::default(); joints] }
    }

    /// 1 where the joint came from below, −1 where from above, 0 where it has not moved far enough to tell.
    pub fn direction(&self) -> &[f64] {
        &self.direction
    }

    /// Takes the next block. No movement is what does not exceed twice the gate of the joint, in its reading's unit.
    pub fn take(&mut self, block: &Block, gates: &[f64]) {
        let sums = block.sums.iter().zip(gates).zip(&self.gains);
        for ((direction, side), ((sum, gate), gain)) in self.direction.iter_mut().zip(&mut self.sides).zip(sums) {
            if sum.count > 0.0 {
                *direction = side.take(gain * sum.mean, 2.0 * gate * gain.abs());
            }
        }
    }
}

impl Side {
    /// Takes the next position, and tells from which side the joint is there.
    fn take(&mut self, position: f64, gate: f64) -> f64 {
        let [low, high] = self.ends.unwrap_or([position, position]);
        let slides = SLIDING.max(gate);
        let way = match self.way {
            way if way <= 0.0 && position > low + slides => 1.0,
            way if way >= 0.0 && position < high - slides => -1.0,
            way => way,
        };
        let ends = match way {
            _ if way != self.way => [position, position],
            1.0 => [high.max(position); 2],
            -1.0 => [low.min(position); 2],
            _ => [low.min(position), high.max(position)],
        };
        *self = Side { way, ends: Some(ends) };
        let back = way * (ends[0] - position);
        if back > PRESLIDING.max(gate) { 0.0 } else { way }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::block::Sum;

    fn followed(positions: &[f64]) -> Vec<f64> {
        with_gate(0.1, positions)
    }

    fn with_gate(gate: f64, positions: &[f64]) -> Vec<f64> {
        by_gain(1.0, gate, positions)
    }

    /// Of coordinates that are read by a gain; the gate is one of coordinates.
    fn by_gain(gain: f64, gate: f64, coordinates: &[f64]) -> Vec<f64> {
        let mut approach = Approach::new(&[gain]);
        let direction = |coordinate: &f64| {
            let sums = vec![Sum { count: 1.0, mean: coordinate / gain, ..Sum::default() }];
            approach.take(&Block { from: 0.0, until: 0.0, row: 0, sums }, &[(gate / gain).abs()]);
            approach.direction()[0]
        };
        coordinates.iter().map(direction).collect()
    }

    #[test]
    fn the_last_movement_tells_the_side() {
        assert_eq!(followed(&[0.0, 0.1, 0.3, 1.0, 0.9, 1.05]), [0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(followed(&[0.0, -1.0, -1.1, -1.0, -0.8, -1.0, -1.1]), [0.0, -1.0, -1.0, -1.0, 1.0, 1.0, -1.0]);
    }

    /// A very good encoder sees how a controller comes back from a little too far.
    #[test]
    fn what_only_bends_bristles_turns_no_side() {
        assert_eq!(with_gate(1e-6, &[0.0, 0.2, 0.1999, 0.2001, 0.1999]), [0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(with_gate(1e-6, &[0.0, 0.2, 0.189]), [0.0, 1.0, -1.0]);
    }

    /// A joint that comes back by a few thousandths of a radian has turned some of its friction; at its turning point it has all of it again.
    #[test]
    fn small_movements_leave_the_side_open() {
        assert_eq!(
            with_gate(1e-6, &[0.0, 0.2, 0.197, 0.1999, 0.195, 0.18, 0.183]),
            [0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0]
        );
        assert_eq!(with_gate(1e-6, &[0.0, 0.005, 0.002, 0.011, 0.02]), [0.0, 0.0, 0.0, 1.0, 1.0]);
    }

    /// An encoder counts in steps of its own, and may count backwards: sides are those of the coordinate, and so are the movements that turn them.
    #[test]
    fn sides_do_not_hang_on_how_the_encoder_counts() {
        let coordinates = [0.0, 0.2, 0.197, 0.1999, 0.195, 0.18, 0.183];
        for gain in [2.0_f64.powi(-20), -2.0_f64.powi(-20), -1.0] {
            assert_eq!(by_gain(gain, 1e-6, &coordinates), with_gate(1e-6, &coordinates), "{gain}");
        }
    }

    #[test]
    fn noise_is_no_movement_and_a_joint_without_movement_has_no_side() {
        assert_eq!(followed(&[0.0, 0.1, -0.1, 0.1, 0.0]), [0.0; 5]);
    }
}
