//! From which side each joint came: the sign of its last movement that is more than noise, and that turns its friction round. A joint that
//! goes a little too far and comes back bends its bristles less, and slides to neither side.

use super::block::Block;

/// Movements up to this (rad, m) turn no friction round. Gears and bearings begin to slide after some 1e-4 rad; chosen, not measured.
const PRESLIDING: f64 = 3e-4;

/// Follows the turning points of each joint.
#[derive(Clone, Debug)]
pub(crate) struct Approach {
    direction: Vec<f64>,
    /// The furthest that each joint has come in its direction; both ends while there is none.
    furthest: Vec<Option<[f64; 2]>>,
}

impl Approach {
    pub fn new(joints: usize) -> Approach {
        Approach { direction: vec![0.0; joints], furthest: vec![None; joints] }
    }

    /// 1 where the joint's last movement was a rise, −1 where a fall, 0 where it has not moved.
    pub fn direction(&self) -> &[f64] {
        &self.direction
    }

    /// Takes the next block. A movement is what exceeds twice the gate of the joint, and pre-sliding.
    pub fn take(&mut self, block: &Block, gates: &[f64]) {
        for (joint, gate) in gates.iter().enumerate() {
            let sum = block.sums[joint];
            if sum.count == 0.0 {
                continue;
            }
            let least = PRESLIDING.max(2.0 * gate);
            let [low, high] = self.furthest[joint].get_or_insert([sum.mean, sum.mean]);
            *low = low.min(sum.mean);
            *high = high.max(sum.mean);
            let fell = sum.mean < *high - least;
            let rose = sum.mean > *low + least;
            if self.direction[joint] <= 0.0 && rose {
                self.direction[joint] = 1.0;
                (*low, *high) = (sum.mean, sum.mean);
            } else if self.direction[joint] >= 0.0 && fell {
                self.direction[joint] = -1.0;
                (*low, *high) = (sum.mean, sum.mean);
            }
            // In its direction only the furthest counts: behind it nothing is to be remembered.
            if self.direction[joint] > 0.0 {
                *low = *high;
            } else if self.direction[joint] < 0.0 {
                *high = *low;
            }
        }
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
        let mut approach = Approach::new(1);
        let direction = |position: &f64| {
            let sums = vec![Sum { count: 1.0, mean: *position, ..Sum::default() }];
            approach.take(&Block { from: 0.0, until: 0.0, row: 0, sums }, &[gate]);
            approach.direction()[0]
        };
        positions.iter().map(direction).collect()
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
        assert_eq!(with_gate(1e-6, &[0.0, 0.2, 0.199]), [0.0, 1.0, -1.0]);
    }

    #[test]
    fn noise_is_no_movement_and_a_joint_without_movement_has_no_side() {
        assert_eq!(followed(&[0.0, 0.1, -0.1, 0.1, 0.0]), [0.0; 5]);
    }
}
