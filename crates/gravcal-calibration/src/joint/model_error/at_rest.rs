//! Friction that is left at rest, to the side from which a joint came: one unknown of each joint.
//!
//! ```text
//!     y_i = k τ_i + b + a_i c + u_i        a_i: 1 where the joint rose to its standstill, −1 where it fell, 0 where nobody knows
//!     c = f ρ̄,  u_i = f (ρ_i − ρ̄) a_i      ρ: the share of friction f that is left at rest, of mean ρ̄
//! ```
//!
//! `u` is an error of either sign, as `unexplained.rs` finds it. `c` is not: a joint that came to its highest poses from below, as it does
//! where poses are random, turns `c` into an error of its position gain; one that always rises turns it into a bias. As an unknown it is
//! told from both where the readings tell it, and widens their intervals where they do not. Its prior is zero give or take
//! `2 √v`, with `v` the variance of the errors that were found without it: these scatter by `f σ_ρ` at least, and the mean of what is left is
//! at most about twice its spread. Where noise may explain by chance the errors of all joints there is no such unknown.
//!
//! Where nobody knows from which side a joint came, as at the beginning of each recording, `c` is an error of either sign of that reading; of a joint
//! that never slides, of all of them alike.
//!
//! A joint that comes to each angle from one side only, or never slides, shows no errors at all: `c` is in its bias, gain and gravity. So where one
//! joint shows friction, every other is taken to have at least as much as the nearest of its kind that does, and its readings tell what they can of it.
//!
//! Adding `c`'s effect to the covariance instead would widen intervals and leave errors as large as they were: `c` would not be told.

use std::sync::Arc;

use gravcal_estimation::{Block, BlockId, ProblemBuilder, Residual, Values};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::residuals::{Shift, Shifted};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::measurement_set::{AtRest, Carried, MeasurementSet};
use crate::joint::model_error::sides_by_order::sides_at_rest;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::joint::variables::{OfJoints, State, VariableIndex};

/// Fewest standstills of known direction that say so.
const LEAST: usize = 5;
/// Mean of what is left at rest, over its spread, at most.
pub(super) const LEAN: f64 = 2.0;
/// Errors vary so many standard deviations by chance.
pub(super) const CHANCE: f64 = 3.0;
/// By what share a standard deviation grows that is worth a remark.
const REMARKABLE: f64 = 0.5;
/// Share of its prior's information that readings give of a number whose size they tell.
const TOLD: f64 = 0.1;

/// A number of one joint as the readings alone tell it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OfReadings {
    /// Friction in the unit of the torque reading, positive against the motion; rad/(N·m) by which the joint bends.
    pub size: f64,
    /// Its standard deviation.
    pub std: f64,
}

impl MeasurementSet {
    /// The same with unknowns for what friction leaves at rest; nothing where no joint has any, or the session has them already. `carried`: by each joint.
    pub(in crate::joint) fn with_friction_at_rest(
        &self,
        session: &Session,
        carried: &[Option<Carried>],
    ) -> Option<MeasurementSet> {
        if !self.at_rest.is_empty() || self.order != Order::Together {
            return None;
        }
        let shown = |joint: usize| match self.errs_beyond_chance(session, joint) {
            true => self.unexplained[joint].sqrt(),
            false => 0.0,
        };
        self.with_friction_shown(session, &(0..session.joints.len()).map(shown).collect::<Vec<_>>(), carried)
    }

    /// The same with unknowns for what friction leaves at rest. `errors`: one standard deviation of the errors of each joint that show it, unit of its
    /// torque reading; zero of joints that show none. `carried`: by each joint.
    pub(in crate::joint) fn with_friction_shown(
        &self,
        session: &Session,
        errors: &[f64],
        carried: &[Option<Carried>],
    ) -> Option<MeasurementSet> {
        let estimated = session.terms.with_friction();
        let sides = |joint: usize| self.sides_of(session, joint).filter(|_| !estimated.contains(&joint));
        let shown = |joint: usize| if sides(joint).is_some() { LEAN * errors[joint] } else { 0.0 };
        let shown: Vec<f64> = (0..session.joints.len()).map(shown).collect();
        let std = |joint: usize| match sides(joint) {
            // Its own errors are what its other parameters leave of it: that may be little.
            Some(_) => shown[joint].max(session.of_nearest(&shown, joint)),
            None => 0.0,
        };
        let of_joint = |joint: usize| {
            let (std, carried) = (std(joint), carried.get(joint).copied().flatten());
            let errs_by = if errors[joint] > 0.0 { errors[joint] } else { std / LEAN };
            AtRest { std, carried: carried.and_then(|carried| carried.beside(errs_by)), ..AtRest::default() }
        };
        let at_rest: Vec<AtRest> = (0..shown.len()).map(of_joint).collect();
        at_rest.iter().any(|own| own.std > 0.0).then(|| MeasurementSet { at_rest, ..self.clone() })
    }

    /// Whether a channel's errors are larger than chance would make them of noise alone.
    pub(in crate::joint) fn errs_beyond_chance(&self, session: &Session, channel: usize) -> bool {
        let poses = (0..session.poses.len()).filter(|pose| self.used[*pose].contains(&channel));
        let own: Vec<f64> = poses.map(|pose| self.own_std(session, ReadingId { pose, channel }).powi(2)).collect();
        let (count, sum) = (own.len().max(1) as f64, own.iter().sum::<f64>());
        self.unexplained[channel] > CHANCE * (2.0 / count).sqrt() * sum / count
    }

    /// Variance of what friction leaves in a reading of which nobody knows from which side its joint came, where no other reading has the same.
    pub(in crate::joint) fn of_unknown_side(&self, session: &Session, id: ReadingId) -> f64 {
        if self.lasts_with_others(id) { 0.0 } else { self.variance_of_unknown_side(session, id) }
    }

    /// The same of one that it shares with others for as long as its joint stands, too.
    pub(in crate::joint) fn variance_of_unknown_side(&self, session: &Session, id: ReadingId) -> f64 {
        let std = self.at_rest.get(id.channel).map_or(0.0, |own| own.std);
        if std > 0.0 && self.side(session, id) == Some(0.0) { std * std } else { 0.0 }
    }

    /// From which side the joint whose torque is read came to a pose in which it stood: 0 where nobody knows, nothing of any other pose. One that never
    /// slides has the same friction always: as from below.
    fn side(&self, session: &Session, id: ReadingId) -> Option<f64> {
        let side = self.side_told(session, id)?;
        Some(if side == 0.0 && !self.slides(session, id.channel) { 1.0 } else { side })
    }

    /// The same as it is told, of one that never slides, too.
    fn side_told(&self, session: &Session, id: ReadingId) -> Option<f64> {
        let pose = &session.poses[id.pose];
        let side = self.sides.get(id.pose).unwrap_or(&pose.conditions.direction).get(id.channel)?;
        let stands = pose.sweep_label.is_none() && pose.course.is_none();
        (stands && session.reading(id).is_some()).then(|| if *side == 0.0 { 0.0 } else { side.signum() })
    }

    /// From which sides a joint came where it stood; nothing where that is hardly known.
    fn sides_of(&self, session: &Session, joint: usize) -> Option<Sides> {
        // What was followed while it moved and what sweeps slid.
        if !session.searched.is_empty() && session.searched.iter().all(|searched| searched.standstills.is_none()) {
            return None;
        }
        let of = |pose| self.side(session, ReadingId { pose, channel: joint });
        let sides = (0..session.poses.len()).filter_map(of).filter(|side| *side != 0.0);
        let (rising, all) = sides.fold((0, 0), |(rising, all), side| (rising + usize::from(side > 0.0), all + 1));
        (all >= LEAST).then_some(Sides { rising, all })
    }

    /// The share of its poses to which a joint that slid came from the side from which it came more often; zero where that is hardly known.
    pub(in crate::joint) fn share_of_one_side(&self, session: &Session, joint: usize) -> f64 {
        if !self.slides(session, joint) {
            return 0.0;
        }
        self.sides_of(session, joint).map_or(0.0, Sides::larger_share)
    }

    /// Whether a joint slid on its way to any pose.
    fn slides(&self, session: &Session, channel: usize) -> bool {
        (0..session.poses.len())
            .any(|pose| self.side_told(session, ReadingId { pose, channel }).is_some_and(|side| side != 0.0))
    }

    /// The sides from which joints came in another session of the same arm, as these readings know them.
    pub(in crate::joint) fn sides_in(&self, session: &Session) -> Arc<[Vec<f64>]> {
        if self.sides.is_empty() { Arc::default() } else { sides_at_rest(session).into() }
    }
}

/// Adds the unknowns of the joints that have them, from where `start` has them: what is left in the mean, and what it grows by.
pub(in crate::joint) fn add_unknowns(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    builder: &mut ProblemBuilder,
) -> [Option<OfJoints>; 2] {
    let mut add = |name: &str, std: fn(&AtRest) -> f64, start: &[f64]| {
        let std: Vec<f64> = readings.at_rest.iter().map(std).collect();
        OfJoints::add(|joints| block_of_joints(name, session, joints), &std, start, builder)
    };
    [
        add("friction_at_rest", |own| own.std, &start.at_rest),
        add("growing_friction", |own| own.growth_std, &start.growing_friction),
    ]
}

/// An unknown of some joints in the unit of their torque readings.
fn block_of_joints(name: &str, session: &Session, joints: &[usize]) -> Block {
    let chain = session.robot.chain.joints();
    let names: Vec<&str> = joints.iter().map(|joint| chain[*joint].name.as_str()).collect();
    let mut block = Block::vector(name, "", &names).linear();
    block.units = joints.iter().map(|joint| session.channel_unit(*joint)).collect();
    block
}

/// The residual of a pose with the unknowns around it: what is left in the mean, then what it grows by.
pub(in crate::joint) fn around(
    (session, readings): (&Session, &MeasurementSet),
    (variables, stored): (&VariableIndex, &Values),
    at_rest: &OfJoints,
    pose: usize,
    inner: Arc<dyn Residual>,
) -> Arc<dyn Residual> {
    let bias = |joint: usize| variables.sensors[joint][SensorParameter::TorqueBias as usize];
    let shift = |joint: usize, growth: &dyn Fn(ReadingId) -> f64| {
        let id = ReadingId { pose, channel: joint };
        Shift::of_scalar(bias(joint), readings.side(session, id).map_or(0.0, |side| side * growth(id)))
    };
    let in_mean = at_rest.joints.iter().map(|joint| shift(*joint, &|_| 1.0));
    let growing = variables.growing_friction.iter();
    let beyond = growing.clone().flat_map(|unknown| &unknown.joints);
    let beyond = beyond.map(|joint| shift(*joint, &|id| readings.growth(session, id)));
    let shifted: Vec<Shift> = in_mean.chain(beyond).collect();
    if shifted.iter().all(|shift| shift.scale == 0.0) {
        return inner;
    }
    let blocks: Vec<BlockId> = std::iter::once(at_rest).chain(growing).map(|unknown| unknown.block).collect();
    Arc::new(Shifted::by_blocks(inner, |id| stored.get(id).len(), &shifted, &blocks))
}

impl Solved {
    /// What is left of a joint's friction, without its prior; nothing where it is no unknown, or the readings do not tell it.
    pub(crate) fn friction_at_rest(&self, joint: usize) -> Option<OfReadings> {
        self.without_prior(self.built.variables.at_rest.as_ref()?, joint)
    }

    /// Whether it is an unknown of this joint.
    pub(crate) fn has_friction_at_rest(&self, joint: usize) -> bool {
        self.at_rest(joint).is_some()
    }

    /// A number of a joint as the readings alone tell it; nothing where it is no unknown, or they do not.
    pub(in crate::joint) fn without_prior(&self, unknown: &OfJoints, joint: usize) -> Option<OfReadings> {
        let place = unknown.place(joint)?;
        let column = self.built.problem.columns_of(unknown.block).nth(place)?;
        let prior = unknown.std[place].powi(-2);
        let all = self.covariance().std(column).powi(-2);
        let own = all - prior;
        let size = self.estimate.values.get(unknown.block)[place] * all / own;
        (own > TOLD * prior && size.is_finite()).then(|| OfReadings { size, std: own.sqrt().recip() })
    }

    /// The unknown of a joint: place in its block, and column.
    fn at_rest(&self, joint: usize) -> Option<(&OfJoints, usize, usize)> {
        let at_rest = self.built.variables.at_rest.as_ref()?;
        let place = at_rest.place(joint)?;
        let column = self.built.problem.columns_of(at_rest.block).nth(place)?;
        Some((at_rest, place, column))
    }

    /// Says which biases hold friction, because their joints came to more of their standstills from one side than chance would have it.
    pub(in crate::joint) fn biases_that_hold_friction(&self, session: &Session) -> Vec<String> {
        let joints = 0..session.joints.len();
        joints.filter_map(|joint| self.bias_that_holds_friction(session, joint)).collect()
    }

    fn bias_that_holds_friction(&self, session: &Session, joint: usize) -> Option<String> {
        let (at_rest, place, friction) = self.at_rest(joint)?;
        let sides = self.readings().sides_of(session, joint).filter(|sides| sides.one_sided())?;
        let bias = self.built.variables.block(ParameterId::Sensor(joint, SensorParameter::TorqueBias));
        let bias = self.built.problem.columns_of(bias).next()?;
        let both = self.covariance().of(&[vec![(bias, 1.0)], vec![(friction, 1.0)]]);
        // What the bias would be known to if friction were known.
        let alone = both[0] - both[1] * both[2] / both[3];
        (both[0] > (1.0 + REMARKABLE).powi(2) * alone).then(|| {
            let name = &session.robot.chain.joints()[joint].name;
            format!(
                "{name} was approached from one side in {:.0} % of its standstills, and the arm has friction: {} cannot be \
                 separated from static friction, and its interval includes that (± {:.2e} {}). Approach the same poses from both sides.",
                100.0 * sides.larger_share(),
                SensorParameter::TorqueBias.name(name),
                at_rest.std[place],
                session.channel_unit(joint)
            )
        })
    }
}

/// From which sides a joint came.
#[derive(Clone, Copy, Debug)]
struct Sides {
    rising: usize,
    all: usize,
}

impl Sides {
    fn larger_share(self) -> f64 {
        self.rising.max(self.all - self.rising) as f64 / self.all as f64
    }

    /// Whether chance would not have it so.
    fn one_sided(self) -> bool {
        (2.0 * self.larger_share() - 1.0).powi(2) > 4.0 / self.all as f64
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::session::Searched;

    use super::*;
    use crate::joint::solving::solve_from::solve_built;
    use crate::joint::{Signals, build_problem, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A shoulder that was found standing in a recording, with the side from which each joint came to each pose.
    fn standing(side: impl Fn(usize, usize) -> f64) -> Session {
        let mut session = sarcos_shoulder().session(0);
        for (number, pose) in session.poses.iter_mut().enumerate() {
            pose.conditions.direction = (0..3).map(|joint| side(number, joint)).collect();
        }
        session.searched = vec![Searched { standstills: Some(Default::default()), ..Searched::default() }];
        session
    }

    /// The readings of all joints with errors of these variances.
    fn with_errors(session: &Session, unexplained: [f64; 3]) -> MeasurementSet {
        MeasurementSet { unexplained: unexplained.to_vec(), ..select(session, Signals::All) }
    }

    fn stds(readings: &MeasurementSet) -> Vec<f64> {
        readings.at_rest.iter().map(|own| own.std).collect()
    }

    /// Friction of the first of three joints.
    fn of_first(std: f64) -> Vec<AtRest> {
        vec![AtRest { std, ..AtRest::default() }, AtRest::default(), AtRest::default()]
    }

    /// Three times the scatter of a mean square of `n` readings, `√(2/n) σ²`.
    #[test]
    fn errors_are_beyond_chance_where_noise_would_hardly_scatter_so() {
        let session = sarcos_shoulder().session(0);
        let (readings, noise) = (session.poses.len() as f64, 0.8_f64 * 0.8);
        let least = 3.0 * (2.0 / readings).sqrt() * noise;
        let errs = |variance: f64| with_errors(&session, [0.0, variance, 0.0]).errs_beyond_chance(&session, 1);
        assert!(errs(1.001 * least) && !errs(0.999 * least));
        assert!(!with_errors(&session, [0.0, 1.0, 0.0]).errs_beyond_chance(&session, 2));
    }

    #[test]
    fn what_friction_leaves_is_an_unknown_where_errors_and_known_sides_say_so() {
        let known = [LEAST, LEAST - 1, LEAST];
        let session = standing(|pose, joint| if pose < known[joint] { 1.0 } else { 0.0 });
        let readings = with_errors(&session, [0.49, 0.49, 1e-6]);
        let with = readings.with_friction_at_rest(&session, &[]).unwrap();
        // Two standard deviations of the errors; the second joint's sides are too few, the third's errors are noise: it has the first one's friction.
        assert_eq!(stds(&with), [2.0 * 0.7, 0.0, 2.0 * 0.7]);
        assert!(with.with_friction_at_rest(&session, &[]).is_none(), "it is looked for once");
        assert!(with_errors(&session, [0.0; 3]).with_friction_at_rest(&session, &[]).is_none());
        let of_tables = Session { searched: Vec::new(), ..session.clone() };
        let table = readings.with_friction_at_rest(&of_tables, &[]).unwrap();
        assert_eq!(stds(&table), stds(&with), "a table that says from which side joints came");
        let mut untold = of_tables;
        untold.poses.iter_mut().for_each(|pose| pose.conditions.direction.clear());
        assert!(readings.with_friction_at_rest(&untold, &[]).is_none(), "a table that does not");
        let by_order = MeasurementSet { sides: vec![vec![1.0; 3]; untold.poses.len()].into(), ..readings.clone() };
        assert!(by_order.with_friction_at_rest(&untold, &[]).is_some(), "a table whose order of rows tells it");
        let mut moving = session;
        moving.searched[0].standstills = None;
        assert!(readings.with_friction_at_rest(&moving, &[]).is_none(), "an arm in motion");
    }

    #[test]
    fn where_nobody_knows_the_side_what_friction_leaves_is_an_error_of_either_sign() {
        let session = standing(|pose, _| [1.0, 0.0, -1.0][pose % 3]);
        let readings = MeasurementSet { at_rest: of_first(1.5), ..select(&session, Signals::All) };
        let of = |pose, channel| readings.of_unknown_side(&session, ReadingId { pose, channel });
        assert_eq!([of(0, 0), of(1, 0), of(2, 0), of(1, 1)], [0.0, 2.25, 0.0, 0.0]);
        let mut tables = session.clone();
        tables.poses[1].conditions.direction.clear();
        assert_eq!(readings.of_unknown_side(&tables, ReadingId { pose: 1, channel: 0 }), 0.0);
    }

    /// In torque, as gains differ.
    #[test]
    fn a_joint_that_shows_nothing_has_the_friction_of_the_nearest_that_does() {
        let mut session = sarcos_shoulder().session(0);
        for (joint, gain) in [10.0, -100.0, 1.0].into_iter().enumerate() {
            session.joints[joint].parameters[SensorParameter::TorqueGain as usize].nominal = gain;
        }
        assert_eq!(session.of_nearest(&[2.0, 7.0, 0.5], 1), 50.0);
        assert_eq!(session.of_nearest(&[2.0, 30.0, 0.0], 2), 0.3);
        assert_eq!(session.of_nearest(&[0.0; 3], 1), 0.0);
    }

    /// Its friction is the same in all of its poses.
    #[test]
    fn a_joint_that_never_slides_has_one_side() {
        let session = standing(|_, joint| if joint == 0 { 0.0 } else { 1.0 });
        let readings = MeasurementSet { at_rest: of_first(1.5), ..select(&session, Signals::All) };
        let sides = readings.sides_of(&session, 0).unwrap();
        assert_eq!((sides.rising, sides.all), (session.poses.len(), session.poses.len()));
        assert_eq!(readings.of_unknown_side(&session, ReadingId { pose: 3, channel: 0 }), 0.0);
    }

    /// Friction of the first joint with a prior of this standard deviation, as the readings alone tell it.
    fn told(std: f64) -> Option<OfReadings> {
        let friction = 0.6;
        let mut session = standing(|pose, _| if pose % 2 == 0 { 1.0 } else { -1.0 });
        for pose in &mut session.poses {
            let side = pose.conditions.direction[0];
            pose.torque[0].as_mut().unwrap().value += friction * side;
        }
        let readings = MeasurementSet { at_rest: of_first(std), ..select(&session, Signals::All) };
        let built = build_problem(&session, &readings, &State::nominal(&session)).unwrap();
        let solved = with_environment(|environment| solve_built(built, environment)).unwrap();
        solved.friction_at_rest(0)
    }

    #[test]
    fn a_prior_is_taken_off_what_the_readings_tell() {
        let free = told(1e3).unwrap();
        assert!((free.size - 0.6).abs() < 4.0 * free.std, "{free:?}");
        // As firm as the readings: half of the size is the prior's.
        let firm = told(free.std).unwrap();
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.02;
        assert!(near(firm.size, free.size) && near(firm.std, free.std), "{firm:?} {free:?}");
        // The readings have a tenth of the prior's information at least: (1 / 0.33)² is 9.2 of it, (1 / 0.3)² is 11.1.
        assert!(told(0.33 * free.std).is_some() && told(0.3 * free.std).is_none());
    }

    #[test]
    fn chance_makes_no_joint_one_sided() {
        let one_sided = |rising, all| Sides { rising, all }.one_sided();
        assert!(!one_sided(10, 20) && !one_sided(13, 20) && one_sided(16, 20) && one_sided(4, 20));
        assert!(one_sided(9, 9) && one_sided(0, 9) && one_sided(260, 400) && !one_sided(210, 400));
    }
}
