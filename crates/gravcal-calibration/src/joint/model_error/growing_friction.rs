//! Friction at rest that grows with what its joint carries: a second unknown of each joint that has friction at rest (`at_rest.rs`).
//!
//! ```text
//!     y_i = k τ_i + b + a_i (c + d (|y_i − b|/m − 1)) + u_i         a_i, c, u_i: as in at_rest.rs;  m: mean of |y_i − b|
//! ```
//!
//! A gear loses a share of what it carries: friction that does not depend on it has `d = 0`, friction that is all of it `d = c`. Random poses are
//! farthest from the middle where their joints came from the middle: there the joint carries most, and has come from below where that is positive. So `d`
//! passes for a larger or a smaller torque gain, and scatter does not show it: with friction of 0.1 N·m and 0.02 of the torque a shoulder's gain came out a
//! standard deviation too small in the mean (`real_arms --line load`). What grows is a part of `c`: where an earlier solution tells `c`, `d` is an unknown whose prior is zero give or take
//! that; where it tells none, there is no `d`: few poses would not tell it from the other parameters.
//!
//! What is left scatters as friction does: where `d/c` is a share `s` from 0 to 1, the variance of `u_i` is `v (1 + s (|y_i − b|/m − 1))²`. The share is that of
//! the solution before, and all is solved again until it stands.
//!
//! What a joint carries is taken from its own readings, as the first solution has their bias. Where errors are more than about a seventh of that, the
//! readings tell friction and not the load, and most of it is what does not grow: such a joint has no `d`, as the first one of an upright arm.
//!
//! A gear that loses more where it lifts than where it lowers is a torque gain by that part of `d`: see `friction_by_load.rs`.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::measurement_set::{AtRest, Carried, MeasurementSet};
use crate::joint::solved::Solved;

/// Errors are at most such a share of what their joint carries, for readings to tell the latter. Friction in them passes for a load of its own size, which is
/// off in `d` to second order. With 0.03 joints whose friction is 0.03 of their torque had none: `load` held as often, with a median standard deviation of
/// 2.98e-3 instead of 2.74e-3 (`real_arms --line load --friction-nm 0.1 --sessions 30 --seed 31`).
const LITTLE: f64 = 0.15;

/// Even where a joint carries nothing its friction scatters by such a share of what it does in the mean.
const LEAST_SCATTER: f64 = 0.2;
/// What friction leaves at rest is told from none by so many standard deviations.
const TOLD: f64 = 3.0;
/// A share stands where it changes by less.
const STEADY: f64 = 0.1;

impl Carried {
    /// By how much more than in the mean the joint carries that has this reading, as a share of the mean.
    fn beyond_mean(self, reading: f64) -> f64 {
        (reading - self.bias).abs() / self.mean - 1.0
    }

    /// The same numbers where friction of such errors is little beside them.
    pub(super) fn beside(self, errors: f64) -> Option<Carried> {
        (errors < LITTLE * self.mean).then_some(self)
    }
}

impl MeasurementSet {
    /// By how many times `d` friction is more than in the mean in a reading of a joint that stands.
    pub(super) fn growth(&self, session: &Session, id: ReadingId) -> f64 {
        let carried = self.at_rest.get(id.channel).and_then(|own| own.carried);
        let reading = session.reading(id).map(|reading| reading.value);
        carried.zip(reading).map_or(0.0, |(carried, reading)| carried.beyond_mean(reading))
    }
}

impl MeasurementSet {
    /// By how many times its joint's unexplained errors are larger than where it carries as much as in the mean.
    pub(in crate::joint) fn growing_scatter(&self, session: &Session, id: ReadingId) -> f64 {
        let share = self.at_rest.get(id.channel).map_or(0.0, |own| own.growing_share);
        if share > 0.0 { (1.0 + share * self.growth(session, id)).max(LEAST_SCATTER) } else { 1.0 }
    }
}

impl Solved {
    /// The readings with friction that grows as this solution has it; nothing where they have it already.
    pub(in crate::joint) fn growing_anew(&self) -> Option<MeasurementSet> {
        let readings = self.readings();
        let anew: Vec<AtRest> = (0..readings.at_rest.len()).map(|joint| self.growing(joint)).collect();
        let moved = |(new, old): (&AtRest, &AtRest)| {
            new.growth_std != old.growth_std || (new.growing_share - old.growing_share).abs() > STEADY
        };
        let moves = anew.iter().zip(&readings.at_rest).any(moved);
        moves.then(|| MeasurementSet { at_rest: anew, ..readings.clone() })
    }

    /// What friction leaves at rest of a joint, and how it grows where this solution tells it.
    fn growing(&self, joint: usize) -> AtRest {
        let own = self.readings().at_rest[joint];
        let told = self.friction_at_rest(joint).filter(|left| left.size.abs() > TOLD * left.std);
        let Some(left) = told.filter(|_| own.carried.is_some()) else { return own };
        let growth = self.built.variables.growing_friction.as_ref();
        let grown = growth.and_then(|unknown| Some(self.estimate.values.get(unknown.block)[unknown.place(joint)?]));
        match grown {
            Some(grown) => AtRest { growing_share: (grown / left.size).clamp(0.0, 1.0), ..own },
            None => AtRest { growth_std: left.size.abs(), ..own },
        }
    }

    /// By what share of what a joint carries its friction at rest grows; nothing where it does not seem to.
    pub(super) fn slope_at_rest(&self, joint: usize) -> Option<f64> {
        let carried = self.readings().at_rest.get(joint)?.carried?;
        let left = self.friction_at_rest(joint)?.size;
        let growth = self.built.variables.growing_friction.as_ref()?;
        let grown = self.estimate.values.get(growth.block)[growth.place(joint)?] * left.signum();
        (grown > 0.0).then_some(grown / carried.mean)
    }

    /// What each joint carries by this solution in the poses that its own readings are of; nothing of one without readings.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint) fn carried_by_joints(&self, session: &Session) -> Result<Vec<Option<Carried>>, EvaluateError> {
        let mut sizes = vec![Vec::new(); session.joints.len()];
        for (id, reading) in self.built.rows.iter().zip(self.gravity_readings(session)?) {
            if let Some(sizes) = sizes.get_mut(id.channel) {
                sizes.push(reading.abs());
            }
        }
        let of_joint = |(joint, sizes): (usize, &Vec<f64>)| {
            let bias = self.built.variables.sensors[joint][SensorParameter::TorqueBias as usize];
            let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
            (mean > 0.0).then(|| Carried { bias: self.estimate.values.scalar(bias), mean })
        };
        Ok(sizes.iter().enumerate().map(of_joint).collect())
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::session::Searched;

    use super::*;
    use crate::joint::solving::solve_from::solve_built;
    use crate::joint::variables::{OfJoints, State};
    use crate::joint::{Signals, build_problem, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// The shoulder, whose second joint came to its poses from both sides and has friction of `friction(what gravity makes it read, counts)`.
    fn standing(friction: impl Fn(f64) -> f64) -> (Session, Carried) {
        let simulation = sarcos_shoulder();
        let mut session = simulation.session(0);
        let bias = simulation.truth.sensors[1][SensorParameter::TorqueBias as usize];
        let mut sizes = Vec::new();
        for (number, pose) in session.poses.iter_mut().enumerate() {
            // To twice as many from below where the joint reads more than nothing, as joints come to their farthest poses.
            let reading = pose.torque[1].as_mut().unwrap();
            let carried = reading.value - bias;
            let side = if number % 3 == 0 { -carried.signum() } else { carried.signum() };
            sizes.push(carried.abs());
            reading.value += side * friction(carried.abs());
            pose.conditions.direction = vec![0.0, side, 0.0];
        }
        session.searched = vec![Searched { standstills: Some(Default::default()), ..Searched::default() }];
        let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
        (session, Carried { bias, mean })
    }

    fn with_friction(session: &Session, own: AtRest) -> MeasurementSet {
        let at_rest = vec![AtRest::default(), own, AtRest::default()];
        MeasurementSet { at_rest, ..select(session, Signals::All) }
    }

    fn solved(session: &Session, readings: &MeasurementSet) -> Solved {
        let built = build_problem(session, readings, &State::nominal(session)).unwrap();
        with_environment(|environment| solve_built(built, environment)).unwrap()
    }

    #[test]
    fn friction_grows_with_what_a_reading_says_that_its_joint_carries() {
        let (session, carried) = standing(|_| 0.0);
        let own = AtRest { std: 1.0, carried: Some(carried), growth_std: 1.0, growing_share: 0.5 };
        let readings = with_friction(&session, own);
        let id = |channel| ReadingId { pose: 3, channel };
        let expected = (session.reading(id(1)).unwrap().value - carried.bias).abs() / carried.mean - 1.0;
        assert!((readings.growth(&session, id(1)) - expected).abs() < 1e-12);
        assert!((readings.growing_scatter(&session, id(1)) - (1.0 + 0.5 * expected)).abs() < 1e-12);
        assert_eq!((readings.growth(&session, id(0)), readings.growing_scatter(&session, id(0))), (0.0, 1.0));
        let steady = with_friction(&session, AtRest { growing_share: 0.0, ..own });
        assert_eq!(steady.growing_scatter(&session, id(1)), 1.0);
        // A joint that carries nothing just then: the mean's friction, less all of it.
        let bias = session.reading(id(1)).unwrap().value;
        let of_load = AtRest { carried: Some(Carried { bias, ..carried }), growing_share: 1.0, ..own };
        assert_eq!(with_friction(&session, of_load).growing_scatter(&session, id(1)), LEAST_SCATTER);
    }

    #[test]
    fn readings_tell_a_load_where_friction_is_little_beside_it_alone() {
        let carried = Carried { bias: 3.0, mean: 20.0 };
        assert_eq!(carried.beside(2.9), Some(carried));
        assert_eq!(carried.beside(3.1), None);
    }

    #[test]
    fn what_a_joint_carries_is_what_gravity_makes_it_read() {
        let (session, expected) = standing(|_| 0.0);
        let found = solved(&session, &select(&session, Signals::All)).carried_by_joints(&session).unwrap()[1].unwrap();
        assert!(
            (found.mean / expected.mean - 1.0).abs() < 1e-3 && (found.bias - expected.bias).abs() < 0.5,
            "{found:?}"
        );
    }

    /// `c` and `d` of friction of 2 counts and 0.02 of what the joint carries, and the gain, which is off without `d`.
    #[test]
    fn friction_that_grows_is_told_from_the_gain() {
        let (share, constant) = (0.02, 2.0);
        let (session, carried) = standing(|size| constant + share * size);
        // First what is left in the mean, which says how much may grow.
        let own = AtRest { std: 20.0, carried: Some(carried), ..AtRest::default() };
        let without = solved(&session, &with_friction(&session, own));
        let looked_for = without.growing_anew().unwrap();
        assert!(looked_for.at_rest[1].growth_std > 1.0 && looked_for.at_rest[0] == AtRest::default());
        let with = solved(&session, &looked_for);
        let value = |unknown: &Option<OfJoints>| with.estimate.values.get(unknown.as_ref().unwrap().block)[0];
        let (in_mean, growth) = (value(&with.built.variables.at_rest), value(&with.built.variables.growing_friction));
        let grown = share * carried.mean;
        assert!(
            (in_mean / (constant + grown) - 1.0).abs() < 0.05 && (growth / grown - 1.0).abs() < 0.05,
            "{in_mean} {growth} {grown}"
        );
        let truth = sarcos_shoulder().truth.sensors[1][SensorParameter::TorqueGain as usize];
        let gain = |solved: &Solved| {
            let block = solved.built.variables.sensors[1][SensorParameter::TorqueGain as usize];
            let column = solved.built.problem.columns_of(block).next().unwrap();
            (solved.estimate.values.scalar(block) - truth) / solved.covariance().std(column)
        };
        assert!(gain(&with).abs() < 0.5 && gain(&without) > 1.0, "{} {}", gain(&with), gain(&without));
        // A third of its slope is what the gain may be off, if it is not the same where the joint lifts and where it lowers.
        let moved = with.moved_by_friction_of_load(&session);
        let block = with.built.variables.sensors[1][SensorParameter::TorqueGain as usize];
        let (column, value) =
            (with.built.problem.columns_of(block).next().unwrap(), with.estimate.values.scalar(block));
        assert!(moved.len() == 1 && (moved[0][column] / (share / 3.0 * value) - 1.0).abs() < 0.05, "{moved:?}");
        assert!(
            with.gains_that_hold_friction_of_load(&session)[0].starts_with("Friction that is left at rest in joint2")
        );
        assert!(without.moved_by_friction_of_load(&session).is_empty());
        // Errors scatter so then, and nothing is to be taken anew.
        let anew = with.growing_anew().unwrap();
        let found = anew.at_rest[1].growing_share;
        assert!(
            (found / (grown / (constant + grown)) - 1.0).abs() < 0.1 && anew.at_rest[0].growing_share == 0.0,
            "{found}"
        );
        assert!(solved(&session, &anew).growing_anew().is_none());
    }
}
