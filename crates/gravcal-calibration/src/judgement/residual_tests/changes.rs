//! How what a sensor senses went from pose to pose, as the model predicts it: errors of a reading are in its residual, too.
//!
//! Hysteresis hangs on the way. From pose to pose coordinates are taken to go on a straight line, and what is sensed on a cubic with the values and slopes
//! of both ends. What a sensor keeps follows it until it is as large as `w`, and turns round with it (a *stop*: Brokate and Sprekels 1996, section 2.1):
//!
//! ```text
//!     s ← min(w, max(−w, s + Δy)),      rose = s/w
//! ```
//!
//! Where the arm did not come on such a way, nothing is known: from a pose in which the channel is not read, or from the pose itself by way of one that no
//! row tells, as where each pose is read from both sides.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{AuxiliarySensorKind, Pose};

use super::columns::Columns;
use super::rows::ReadingRow;

/// `w` in share of the largest that is sensed: hysteresis of small changes builds up over a few hundredths of the range of most sensors.
const HALF_WIDTH: f64 = 0.05;
/// Steps in which a way is followed.
const STEPS: usize = 16;
/// An arm of which a joint is said to be faster, rad/s or m/s, does not stand.
const MOVES: f64 = 0.01;
/// A joint comes from elsewhere where it moves farther, rad.
const ELSEWHERE: f64 = 0.01;

/// What changed on the way to a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// In the unit of the reading; zero where the way is not known.
    pub by: f64,
    /// From −1 where it fell last to 1 where it rose; zero where that is not known.
    pub rose: f64,
}

/// What is sensed at both ends of a way, and how it changes there with the share of the way.
#[derive(Clone, Copy, Debug)]
struct Way {
    values: [f64; 2],
    slopes: [f64; 2],
}

impl Columns<'_> {
    /// Whether what was sensed before may be known of a channel: of an arm of turning joints that stands in poses one after the other, and of its
    /// torque and force-torque sensors.
    pub fn knows_changes(&self, channel: usize) -> bool {
        let session = self.session;
        let turns = session.robot.chain.joints().iter().all(|joint| joint.kind != JointKind::Prismatic);
        let moves = |pose: &Pose| pose.conditions.velocity.iter().any(|velocity| velocity.abs() > MOVES);
        let swept = session.searched.iter().any(|searched| searched.sweeps.is_some());
        let accelerates = session
            .axis(channel)
            .is_some_and(|(instrument, _)| session.instruments[instrument].kind == AuxiliarySensorKind::Accelerometer);
        let stands = !self.in_motion() && !swept && !session.poses.iter().any(moves);
        stands && turns && !session.joints.is_empty() && !accelerates
    }

    /// Of each pose, what changed in a channel since the one before it in the same table.
    pub fn changes(&self, channel: usize) -> Vec<Change> {
        let readings = self.readings_in_order(channel);
        let largest = readings.iter().map(|reading| self.senses(reading.pose, channel).abs()).fold(0.0, f64::max);
        let mut changes = vec![Change::default(); self.session.poses.len()];
        for ends in readings.array_windows() {
            let [before, pose] = ends.map(|reading| reading.pose);
            if self.comes_straight([before, pose]) {
                let way = self.way(ends, channel);
                let rose = way.followed(changes[before].rose, HALF_WIDTH * largest);
                changes[pose] = Change { by: way.values[1] - way.values[0], rose };
            }
        }
        changes
    }

    /// Whether the arm came from one pose to the next of the same table, as far as positions and the sides that are told say.
    fn comes_straight(&self, [before, pose]: [usize; 2]) -> bool {
        let far = self.far([before, pose]);
        let agrees = |(joint, far): (usize, &f64)| far.abs() < ELSEWHERE || self.side(joint, pose) * far >= 0.0;
        let moved = far.iter().any(|far| far.abs() > ELSEWHERE);
        self.follow_each_other([before, pose]) && moved && far.iter().enumerate().all(agrees)
    }

    fn senses(&self, pose: usize, channel: usize) -> f64 {
        match self.is_joint(channel) {
            true => self.predicted.reading(pose, channel),
            false => self.of_axes.reading(pose, channel),
        }
    }

    fn way(&self, ends: &[ReadingRow; 2], channel: usize) -> Way {
        let far = self.far(ends.map(|reading| reading.pose));
        Way {
            values: ends.map(|reading| self.senses(reading.pose, channel)),
            slopes: ends.map(|reading| self.slope_along(reading, &far)),
        }
    }

    /// How far each coordinate goes from one pose to another.
    fn far(&self, ends: [usize; 2]) -> Vec<f64> {
        let [from, to] = ends.map(|pose| &self.session.poses[pose].position);
        let gain = |joint: usize| self.session.joints[joint].of(SensorParameter::PositionGain).nominal;
        (0..from.len()).map(|joint| gain(joint) * (to[joint] - from[joint])).collect()
    }
}

impl Way {
    /// What a stop comes to that begins at `rose`, both in share of its half width.
    fn followed(&self, rose: f64, half_width: f64) -> f64 {
        if half_width <= 0.0 {
            return 0.0;
        }
        let at = |step: usize| self.at(step as f64 / STEPS as f64);
        (1..=STEPS).fold(rose, |rose, step| (rose + (at(step) - at(step - 1)) / half_width).clamp(-1.0, 1.0))
    }

    /// Hermite's cubic after a share of the way.
    fn at(&self, share: f64) -> f64 {
        let ([from, to], [sets_out, arrives]) = (self.values, self.slopes);
        let left = 1.0 - share;
        left * left * (from * (1.0 + 2.0 * share) + share * sets_out)
            + share * share * (to * (1.0 + 2.0 * left) - left * arrives)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic with these ends and slopes; and a way that ends where it began, on which what is sensed rises and falls.
    #[test]
    fn a_way_is_followed_on_its_cubic() {
        let cubic = |share: f64| 1.0 + 2.0 * share - 5.0 * share.powi(2) + 4.0 * share.powi(3);
        let way = Way { values: [cubic(0.0), cubic(1.0)], slopes: [2.0, 2.0 - 10.0 + 12.0] };
        for share in [0.0, 0.3, 0.7, 1.0] {
            assert!((way.at(share) - cubic(share)).abs() < 1e-12, "{share}");
        }
        let there_and_back = Way { values: [1.0, 1.0], slopes: [4.0, -4.0] };
        assert_eq!(there_and_back.followed(0.0, 0.1), -1.0);
        assert_eq!(there_and_back.followed(0.0, 0.0), 0.0, "nothing is sensed");
    }

    /// What changes little turns no hysteresis round, and what stays nothing at all.
    #[test]
    fn a_small_change_turns_a_stop_in_part() {
        let by = |change: f64| Way { values: [0.0, change], slopes: [change; 2] };
        assert!((by(-0.05).followed(1.0, 0.1) - 0.5).abs() < 1e-12);
        assert_eq!([by(0.0).followed(-1.0, 0.1), by(-1.0).followed(1.0, 0.1)], [-1.0, -1.0]);
    }
}
