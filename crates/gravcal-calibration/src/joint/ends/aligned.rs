//! Arms that may be exactly aligned: gravity along the axis of the first joint, joints that stand at a multiple of a quarter turn, centres of
//! mass on the axis of a joint at the end of the arm, or on those of several.
//!
//! There axes are exactly parallel, or at right angles, or carry nothing, and what a reading says of some unknowns vanishes with the sine of
//! the angle between them, or with the lever. An estimate is off by its errors, and these then pass for what the readings say. So where the truth may be aligned, the readings
//! are judged there, too.

use std::f64::consts::FRAC_PI_2;

use gravcal_dynamics::{Chain, JointKind};
use gravcal_estimation::{BlockId, RankAnalysis};
use gravcal_identification::{IMPLAUSIBLE, SolveEnvironment, as_of_one_direction};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{ReadingId, Session};
use nalgebra::{Matrix3, Vector3};

use crate::joint::ends::surroundings::{Place, Surroundings};
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// A variance times this is the square of five standard deviations.
const WITHIN_FIVE: f64 = 2.0 * IMPLAUSIBLE;
/// A joint stands whose angle varies by less over all poses, rad.
const STANDS: f64 = 0.01;
/// Farther from a quarter turn than this, rad, none is tried: zero positions are known better. Gravity farther from the first axis is not
/// tried along it.
pub(super) const NEAR: f64 = 0.2;
/// Iterations at most in which the rest of the unknowns follow.
const ITERATIONS: usize = 100;

/// Where something is exactly aligned: the values of some unknowns.
type Alignment = Vec<(BlockId, Vec<f64>)>;

/// What hangs on a link.
#[derive(Clone, Copy)]
struct Carried {
    /// In kg.
    mass: f64,
    /// First moment in the link's frame, kg·m.
    moment: Vector3<f64>,
}

const NOTHING: Carried = Carried { mass: 0.0, moment: Vector3::new(0.0, 0.0, 0.0) };

/// Where gravity, a standing joint, the end of the arm, all of a kind, or several kinds are exactly aligned. None where the readings contradict
/// it.
pub(super) fn aligned(
    around: &Surroundings<'_>,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<Place>, EstimateError> {
    let Surroundings { session, solved, .. } = *around;
    let upright = solved.gravity_along_first_axis(session);
    let balanced = solved.balanced_ends(session, |joint| solved.may_carry_nothing(session, joint));
    let standing = solved.standing_joints_at_quarter_turns(session);
    let mut found = Vec::new();
    // Of alignments that hold each other, the last that the readings admit.
    let mut farthest = |nested: Vec<Alignment>| -> Result<Option<Alignment>, EstimateError> {
        let mut farthest = None;
        for alignment in nested {
            let Some(there) = fixed_at(around, &alignment, environment)? else { break };
            farthest = Some(alignment);
            found.push(there);
        }
        Ok(farthest)
    };
    let mut each = |alignments: Vec<Vec<Alignment>>| -> Result<Vec<Alignment>, EstimateError> {
        alignments.into_iter().filter_map(|nested| farthest(nested).transpose()).collect()
    };
    let apart = |alignments: Vec<Alignment>| alignments.into_iter().map(|alignment| vec![alignment]).collect();
    let alone = [each(apart(upright.into_iter().collect()))?, each(balanced)?, each(apart(standing))?];
    each(apart(together(&alone)))?;
    Ok(found)
}

/// Where the rest of the unknowns is best with some held; how much ½ χ² is larger there counts as if in one direction. None where the readings
/// contradict it.
fn fixed_at(
    Surroundings { session, solved, plausible, .. }: &Surroundings<'_>,
    alignment: &Alignment,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Place>, EstimateError> {
    let problem = solved.judged_problem();
    let mut start = solved.estimate.values.clone();
    alignment.iter().for_each(|(block, value)| start.set(*block, value));
    let blocks: Vec<BlockId> = alignment.iter().map(|(block, _)| *block).collect();
    let held = problem.with_reference(plausible.centered_at(&start)).with_fixed(&blocks, "exactly aligned");
    // What cannot be solved there says nothing.
    let Ok(there) = environment.within(ITERATIONS).solve(&held, &start) else { return Ok(None) };
    let alone = problem.without_reference();
    let growth = alone.cost(&there.values)? - alone.cost(&solved.estimate.values)?;
    // What has no effect there explains no noise there.
    let lost = solved.analysis.rank().saturating_sub(RankAnalysis::new(problem, &there.values)?.rank());
    let growth = as_of_one_direction(growth, lost.max(1), solved.freedom_of_found_noise(session));
    Ok((growth < IMPLAUSIBLE).then(|| Place::of_growth(there.values, growth)))
}

impl Solved {
    /// Gravity along the axis of the first joint, if it is near, or may be for all that is known of it. The readings there say
    /// whether that is plausible: at an estimate that is a little off, gravity's standard deviations are too small to tell.
    fn gravity_along_first_axis(&self, session: &Session) -> Option<Alignment> {
        let (chain, block) = (&session.robot.chain, self.built.variables.gravity);
        chain.movers().first().filter(|mover| mover.kind == JointKind::Revolute)?;
        // No coordinate turns the first axis.
        let axis = Vector3::from(chain.axes(&vec![0.0; chain.joints().len()])[0]);
        let g = Vector3::from_column_slice(self.estimate.values.get(block));
        let along = axis * axis.dot(&g);
        let (off, covariance) = (g - along, Matrix3::from_row_slice(&self.gravity_covariance()));
        let is_near =
            off.norm() < NEAR * g.norm() || off.norm_squared().powi(2) < WITHIN_FIVE * off.dot(&(covariance * off));
        is_near.then(|| vec![(block, (along.normalize() * g.norm()).as_slice().to_vec())])
    }

    /// By joint at the end of the arm that turns, masses and moments of its links with which their centres of mass lie on its axis: such a
    /// joint carries nothing, and how it turns does not show in the joints before it. Then the same with the joint before it, which carries
    /// nothing either, and so on as far as `carry_nothing` says of these.
    fn balanced_ends(&self, session: &Session, carry_nothing: impl Fn(usize) -> bool) -> Vec<Vec<Alignment>> {
        let (chain, bodies) = (&session.robot.chain, &self.built.variables.inertia);
        let is_free =
            |link: &usize| bodies.get(*link).is_some_and(|block| !self.judged_problem().columns_of(*block).is_empty());
        let turns_free = |joint: &usize| {
            chain.joints()[*joint].kind == JointKind::Revolute && chain.links_of(*joint).all(|link| is_free(&link))
        };
        let ends = (0..chain.joint_count()).filter(|joint| chain.is_last(*joint) && turns_free(joint));
        let of_end = |end: usize| {
            let links: Vec<usize> = chain.links_of(end).collect();
            let alone: Alignment = links.iter().map(|link| self.balanced(chain, *link, NOTHING).0).collect();
            let mut nested = vec![alone];
            let [mut last] = links[..] else { return nested };
            let (_, mut carried) = self.balanced(chain, last, NOTHING);
            while let Some((_, link)) =
                hung_on(chain, last).filter(|(joint, _)| turns_free(joint) && carry_nothing(*joint))
            {
                let (balanced, carried_before) = self.balanced(chain, link, carried);
                nested.push(nested.last().into_iter().flatten().cloned().chain([balanced]).collect());
                (last, carried) = (link, carried_before);
            }
            nested
        };
        ends.map(of_end).collect()
    }

    /// Whether a joint's readings of bare poses are as constant as their noise lets them be: `χ² < n + 5 √(2n) + 25` of `n` readings about their
    /// mean, five standard deviations of many and of few.
    fn may_carry_nothing(&self, session: &Session, joint: usize) -> bool {
        let poses = (0..session.poses.len()).filter(|pose| self.readings().used[*pose].contains(&joint));
        let weighed = poses.filter(|pose| session.poses[*pose].load.is_none()).filter_map(|pose| {
            let reading = session.poses[pose].torque[joint]?;
            Some((reading.value, self.readings().std(session, ReadingId { pose, channel: joint }).powi(-2)))
        });
        let weighed: Vec<(f64, f64)> = weighed.collect();
        let all: f64 = weighed.iter().map(|(_, weight)| weight).sum();
        let mean: f64 = weighed.iter().map(|(value, weight)| value * weight / all).sum();
        let chi_squared: f64 = weighed.iter().map(|(value, weight)| (value - mean).powi(2) * weight).sum();
        let count = weighed.len() as f64;
        chi_squared < count + (WITHIN_FIVE * 2.0 * count).sqrt() + WITHIN_FIVE
    }

    /// A link's mass and moment with which it and what it carries have their centre of mass on the axis of the joint that moves it; and what
    /// the link that this joint hangs on carries then.
    fn balanced(&self, chain: &Chain, link: usize, carried: Carried) -> ((BlockId, Vec<f64>), Carried) {
        let (block, mover) = (self.built.variables.inertia[link], &chain.movers()[link]);
        let body = self.estimate.values.get(block);
        let (own, mass) = (Vector3::new(body[1], body[2], body[3]), body[0] + carried.mass);
        let all = mover.moment_on_axis(mass, own + carried.moment);
        let balanced = [&[body[0]], (all - carried.moment).as_slice()].concat();
        ((block, balanced), Carried { mass, moment: mover.moment_on_parent(mass, all) })
    }

    /// By joint that stands in all poses, gain and offset of its position sensor with which it stands at a multiple of a quarter turn; of no
    /// joint that is far from it.
    fn standing_joints_at_quarter_turns(&self, session: &Session) -> Vec<Alignment> {
        self.standing_angles(session)
            .into_iter()
            .filter_map(|(joint, angle)| self.at_quarter_turn(joint, angle))
            .collect()
    }

    /// Joints that stand in all poses with an unknown offset, and at which angle, rad.
    pub(super) fn standing_angles(&self, session: &Session) -> Vec<(usize, f64)> {
        let unknowns = self.state(&State::nominal(session));
        let used = session.poses.iter().zip(&self.readings().used).filter(|(_, used)| !used.is_empty());
        let coordinates = used.map(|(p, _)| session.terms.coordinates(&p.position, &p.conditions, &unknowns));
        let turns = |joint: usize| session.robot.chain.joints()[joint].kind == JointKind::Revolute;
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; session.joints.len()];
        for of_pose in coordinates {
            for ([low, high], angle) in ranges.iter_mut().zip(of_pose) {
                (*low, *high) = (low.min(angle), high.max(angle));
            }
        }
        let stands = |(joint, [low, high]): (usize, [f64; 2])| {
            let offset = self.built.variables.sensors[joint][SensorParameter::PositionOffset as usize];
            let is_free = !self.judged_problem().columns_of(offset).is_empty();
            (is_free && turns(joint) && high - low < STANDS).then(|| (joint, f64::midpoint(low, high)))
        };
        ranges.into_iter().enumerate().filter_map(stands).collect()
    }

    /// Gain and offset with which a joint that stands at this angle (rad) stands at the nearest multiple of a quarter turn.
    fn at_quarter_turn(&self, joint: usize, angle: f64) -> Option<Alignment> {
        let off = off_quarter_turn(angle);
        let [gain, offset] = [SensorParameter::PositionGain, SensorParameter::PositionOffset]
            .map(|quantity| self.built.variables.sensors[joint][quantity as usize]);
        let [gain_value, offset_value] = [gain, offset].map(|block| self.estimate.values.scalar(block));
        (off.abs() < NEAR).then(|| vec![(gain, vec![gain_value]), (offset, vec![offset_value - off])])
    }
}

/// The joint whose one link carries nothing beside a link and what hangs on that, and this link.
fn hung_on(chain: &Chain, carried: usize) -> Option<(usize, usize)> {
    let moved_by = |joint: usize| (0..chain.links().len()).filter(move |link| chain.moves(joint, *link));
    let links_of = |joint: usize| chain.links_of(joint).collect::<Vec<_>>();
    let own = (0..chain.joint_count()).find(|joint| links_of(*joint) == [carried])?;
    let beyond = moved_by(own).count();
    let joint = (0..chain.joint_count())
        .find(|joint| chain.moves(*joint, carried) && moved_by(*joint).count() == beyond + 1)?;
    let [link] = links_of(joint)[..] else { return None };
    Some((joint, link))
}

/// By how much an angle is off the nearest multiple of a quarter turn, rad.
pub(super) fn off_quarter_turn(angle: f64) -> f64 {
    angle - (angle / FRAC_PI_2).round() * FRAC_PI_2
}

/// All alignments of a kind at once, and of several kinds, where these are more than one.
fn together(alone: &[Vec<Alignment>; 3]) -> Vec<Alignment> {
    let choices: [&[usize]; 7] = [&[0], &[1], &[2], &[0, 1], &[0, 2], &[1, 2], &[0, 1, 2]];
    let chosen = choices.into_iter().filter(|kinds| kinds.iter().all(|kind| !alone[*kind].is_empty()));
    let alignments = chosen.map(|kinds| kinds.iter().flat_map(|kind| &alone[*kind]).collect::<Vec<_>>());
    let several = alignments.filter(|alignments| alignments.len() > 1);
    several.map(|alignments| alignments.into_iter().flatten().cloned().collect()).collect()
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{Block, ProblemBuilder};
    use gravcal_session::simulation::Run;

    use super::{Alignment, together};
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// Whether the readings are judged with gravity exactly along the first axis.
    fn is_judged_upright(tilt: f64) -> bool {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [9.8 * tilt.sin(), 0.0, -9.8 * tilt.cos()];
        simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|w| solve(&session, &readings, None, w)?.with_nearby(&session, w)).unwrap();
        let gravity = solved.built.variables.gravity;
        solved.nearby.iter().any(|near| near.values.get(gravity)[..2] == [0.0, 0.0])
    }

    #[test]
    fn a_base_that_may_be_upright_is_judged_as_if_it_were() {
        assert!(is_judged_upright(0.0));
        assert!(!is_judged_upright(0.3));
    }

    /// Angles of the second joint, which stands at this one, at which the readings are judged with it exactly aligned, rad.
    fn aligned_angles(standing: f64) -> Vec<f64> {
        let mut simulation = sarcos_shoulder();
        let [_, _, gain, offset] = simulation.truth.sensors[1];
        let reading = (standing - offset) / gain;
        for run in &mut simulation.runs {
            let Run::Sweep { swept, held, .. } = run else { panic!("all are sweeps") };
            (*swept, held[1]) = (if *swept == 0 { 0 } else { 2 }, reading);
        }
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|w| solve(&session, &readings, None, w)).unwrap();
        let aligned = solved.standing_joints_at_quarter_turns(&session);
        let angle = |gain_and_offset: &Alignment| gain_and_offset[0].1[0] * reading + gain_and_offset[1].1[0];
        aligned.iter().map(angle).collect()
    }

    #[test]
    fn a_standing_joint_that_may_be_at_a_quarter_turn_is_judged_as_if_it_were() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for exact in [0.0, quarter, -quarter] {
            let found = aligned_angles(exact);
            assert!(found.len() == 1 && (found[0] - exact).abs() < 1e-12, "{found:?}");
        }
        assert!(aligned_angles(0.5).is_empty());
    }

    #[test]
    fn what_is_aligned_alone_is_aligned_together() {
        let id = ProblemBuilder::new().add_block(Block::scalar("any", ""), &[0.0]);
        let named = |value: f64| -> Alignment { vec![(id, vec![value])] };
        let values = |alone: [Vec<Alignment>; 3]| -> Vec<Vec<f64>> {
            together(&alone).iter().map(|parts| parts.iter().map(|(_, value)| value[0]).collect()).collect()
        };
        assert!(values([vec![named(1.0)], vec![], vec![]]).is_empty());
        assert_eq!(values([vec![], vec![], vec![named(1.0), named(2.0)]]), [[1.0, 2.0]]);
        let all = [vec![named(1.0)], vec![named(2.0)], vec![named(3.0)]];
        assert_eq!(values(all), [vec![1.0, 2.0], vec![1.0, 3.0], vec![2.0, 3.0], vec![1.0, 2.0, 3.0]]);
    }

    /// The last joint's readings of the bare arm do not change over the poses where its link is balanced, and only that link is.
    #[test]
    fn a_balanced_end_carries_nothing() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let mut solved = with_environment(|w| solve(&session, &readings, None, w)).unwrap();
        let of_joint = |solved: &super::Solved, joint: usize| -> f64 {
            let rows = solved.built.rows.iter().zip(solved.gravity_readings(&session).unwrap());
            let bare = rows.filter(|(row, _)| row.channel == joint && session.poses[row.pose].load.is_none());
            bare.map(|(_, reading)| reading.abs()).fold(0.0, f64::max)
        };
        let of_last = |solved: &super::Solved| of_joint(solved, 2);
        assert!(of_last(&solved) > 100.0, "{}", of_last(&solved));
        let ends = solved.balanced_ends(&session, |_| true);
        let [nested] = ends.as_slice() else { panic!("{} ends", ends.len()) };
        let [end, both, _] = nested.as_slice() else { panic!("{} joints", nested.len()) };
        let [(block, body)] = end.as_slice() else { panic!("{} links", end.len()) };
        assert_eq!(*block, solved.built.variables.inertia[2]);
        assert_eq!(body[0], solved.estimate.values.get(*block)[0], "its mass stays");
        solved.estimate.values.set(*block, body);
        assert!(of_last(&solved) < 1e-6, "{}", of_last(&solved));
        assert!(of_joint(&solved, 1) > 50.0, "{}", of_joint(&solved, 1));
        assert!((1..3).all(|joint| !solved.may_carry_nothing(&session, joint)), "each is read to carry something");
        both.iter().for_each(|(block, body)| solved.estimate.values.set(*block, body));
        assert!(of_joint(&solved, 1) < 1e-6 && of_last(&solved) < 1e-6, "{}", of_joint(&solved, 1));
    }

    #[test]
    fn an_end_whose_moments_are_fixed_cannot_be_balanced() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let mut solved = with_environment(|w| solve(&session, &readings, None, w)).unwrap();
        let last = solved.built.variables.inertia[2];
        solved.built.problem = solved.built.problem.with_fixed(&[last], "known");
        assert!(solved.balanced_ends(&session, |_| true).is_empty());
    }
}
