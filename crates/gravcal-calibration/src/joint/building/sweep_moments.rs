//! The moments of the sweep description: which of them each pose has, and where they start.
//!
//! What hangs beyond joint i, less what hangs beyond joint i + 1, is one moment `h_i` for each posture of the joints beyond
//! i (see [`SweepTorque`](gravcal_robot_model::residuals::SweepTorque)): poses share it where these joints stand alike, or the same one
//! of them sweeps and the others stand alike, and where the same load hangs beyond i, at whatever placement. The mass
//! beyond a prismatic joint is the same in every posture.

use gravcal_dynamics::{Chain, GravityTorque, JointKind};
use gravcal_estimation::{Block, BlockId, ProblemBuilder};
use gravcal_robot_model::residuals::lumped_directions;
use gravcal_robot_model::session::{InertiaPrior, Pose, Session};
use gravcal_robot_model::sweeps::{HOLD_TOLERANCE, Sweep, find_sweeps};
use nalgebra::{Matrix3, Vector3};

use crate::joint::building::placements::{first_alike, relative_placements};
use crate::joint::variables::State;

/// The moments of all sweeps of a session.
#[derive(Clone, Debug)]
pub(crate) struct SweepMoments {
    moments: Vec<Moment>,
    /// By pose, the moment of each joint; nothing for poses of no sweep.
    of_pose: Vec<Option<Vec<usize>>>,
}

/// One moment, or a prismatic joint's mass.
#[derive(Clone, Debug)]
struct Moment {
    joint: usize,
    /// The joint beyond that sweeps, if one does.
    swept: Option<usize>,
    /// Where the joints stand, nominal coordinates; of no meaning up to `joint`, and for the swept one.
    held: Vec<f64>,
    /// What hangs beyond: the first of the loads that differ by their placement only.
    load: Option<usize>,
    /// A pose that has it.
    pose: usize,
}

/// Whether a session describes the moments by sweep.
pub(crate) fn by_sweep(session: &Session) -> bool {
    session.inertia == InertiaPrior::Sweep
}

/// Which poses the description leaves out, in words.
pub(in crate::joint) fn left_out_note(session: &Session) -> Option<String> {
    let moments = by_sweep(session).then(|| SweepMoments::of(session))?;
    let left_out = moments.of_pose.iter().filter(|moments| moments.is_none()).count();
    (left_out > 0).then(|| {
        let all = session.poses.len();
        format!("Moments are described by sweep: {left_out} of {all} poses belong to no sweep, and are not used.")
    })
}

impl SweepMoments {
    pub fn of(session: &Session) -> SweepMoments {
        let mut found = SweepMoments { moments: Vec::new(), of_pose: vec![None; session.poses.len()] };
        for sweep in find_sweeps(session) {
            let moments: Vec<usize> =
                (0..session.joints.len()).map(|joint| found.place(session, &sweep, joint)).collect();
            sweep.poses.iter().for_each(|pose| found.of_pose[*pose] = Some(moments.clone()));
        }
        found
    }

    /// The moment of `joint` in a sweep, a new one where none is alike.
    fn place(&mut self, session: &Session, sweep: &Sweep, joint: usize) -> usize {
        let chain = &session.robot.chain;
        let wanted = Moment {
            joint,
            swept: Some(sweep.swept).filter(|swept| beyond(chain, joint).any(|other| other == *swept)),
            held: sweep.held.clone(),
            load: sweep
                .load
                .filter(|load| chain.moves(joint, session.loads[*load].link))
                .map(|load| first_alike(session, load)),
            pose: sweep.poses[0],
        };
        self.moments.iter().position(|moment| moment.is_like(&wanted, chain)).unwrap_or_else(|| {
            self.moments.push(wanted);
            self.moments.len() - 1
        })
    }

    /// The moment of each joint in a pose; nothing for poses of no sweep.
    pub fn of_pose(&self, pose: usize) -> Option<&[usize]> {
        self.of_pose[pose].as_deref()
    }

    /// Adds a block for each moment, from the start's own values, or else from those of its links. `used`: by pose, whether
    /// a reading of it enters; `straight`: whether readings are affine in moments.
    pub fn add_blocks(
        &self,
        session: &Session,
        (used, straight): (&[bool], bool),
        start: &State,
        builder: &mut ProblemBuilder,
    ) -> Vec<BlockId> {
        let values =
            if start.sweep_moments.is_empty() { self.lumped(session, start) } else { start.sweep_moments.clone() };
        let mut seen = vec![false; self.moments.len()];
        let of_used = self.of_pose.iter().zip(used).filter_map(|(moments, used)| moments.as_ref().filter(|_| *used));
        of_used.flatten().for_each(|moment| seen[*moment] = true);
        let add = |((moment, value), seen): ((&Moment, &Vec<f64>), bool)| {
            let block = moment.block(session);
            let block = if straight { block.linear() } else { block };
            builder.add_block(if seen { block } else { block.fixed("no reading that is used sees it") }, value)
        };
        self.moments.iter().zip(&values).zip(seen).map(add).collect()
    }

    /// The moments that links of known masses come to, tip first, because each joint's depends on those beyond it.
    ///
    /// Of `∂τ_i/∂g = M_i × z_i` (or `−m_i⁺ z_i`) the chain without lengths gives what is known so far, and the chain itself
    /// all of it; their difference is that of `h_i`.
    fn lumped(&self, session: &Session, start: &State) -> Vec<Vec<f64>> {
        let without_lengths = session.robot.chain.without_lengths();
        let placements = relative_placements(session, &start.loads);
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); self.moments.len()];
        let mut order: Vec<usize> = (0..self.moments.len()).collect();
        order.sort_by_key(|moment| std::cmp::Reverse(self.moments[*moment].joint));
        for index in order {
            let Moment { joint, pose, .. } = self.moments[index];
            let coordinates = {
                let Pose { position, conditions, .. } = &session.poses[pose];
                session.terms.coordinates(position, conditions, start)
            };
            let whole = by_gravity(session, &session.robot.chain, pose, (&coordinates, &start.inertia), &start.loads);
            let known = self.link_inertia(session, pose, &values);
            let known = by_gravity(session, &without_lengths, pose, (&coordinates, &known), &placements);
            let difference =
                Vector3::from_iterator((0..3).map(|axis| whole[3 * joint + axis] - known[3 * joint + axis]));
            values[index] = across_the_axis(&without_lengths, joint, &coordinates, &difference);
        }
        values
    }

    /// Mass and first moment of each link in a pose, zero where not known yet.
    fn link_inertia(&self, session: &Session, pose: usize, values: &[Vec<f64>]) -> Vec<[f64; 4]> {
        let moments = self.of_pose(pose).unwrap_or(&[]);
        let joints = session.robot.chain.joints();
        let link = |(moment, joint): (&usize, _)| {
            let parts = lumped_directions(joint).into_iter().zip(&values[*moment]);
            parts.fold([0.0; 4], |sum, (direction, value)| std::array::from_fn(|i| sum[i] + value * direction[i]))
        };
        moments.iter().zip(joints).map(link).collect()
    }
}

impl Moment {
    fn is_like(&self, other: &Moment, chain: &Chain) -> bool {
        if self.joint != other.joint || chain.joints()[self.joint].kind == JointKind::Prismatic {
            return self.joint == other.joint;
        }
        let stands =
            |joint: usize| Some(joint) == self.swept || (self.held[joint] - other.held[joint]).abs() <= HOLD_TOLERANCE;
        self.swept == other.swept && self.load == other.load && beyond(chain, self.joint).all(stands)
    }

    fn block(&self, session: &Session) -> Block {
        let joint = &session.robot.chain.joints()[self.joint];
        if joint.kind == JointKind::Prismatic {
            return Block::scalar(format!("{}.mass_beyond", joint.name), "kg");
        }
        Block::vector(format!("{}.moment_beyond[{}]", joint.name, self.posture(session)), "kg·m", &["u", "v"])
    }

    /// Where the joints beyond stand and what hangs there, in words.
    fn posture(&self, session: &Session) -> String {
        let chain = &session.robot.chain;
        let joints = beyond(chain, self.joint).map(|index| (index, &chain.joints()[index]));
        let place = |(index, joint): (usize, &gravcal_dynamics::Joint)| match (joint.kind, self.held[index]) {
            _ if self.swept == Some(index) => format!("{} sweeps", joint.name),
            (JointKind::Revolute, angle) => format!("{} at {:.1}°", joint.name, angle.to_degrees()),
            (JointKind::Prismatic, way) => format!("{} at {way:.3} m", joint.name),
        };
        let load = self.load.map_or_else(|| "bare".to_owned(), |load| session.loads[load].name.clone());
        joints.map(place).chain([load]).collect::<Vec<_>>().join(", ")
    }
}

/// The joints that a joint moves. Where moments are described by sweep none mimics another, and joint k moves link k.
fn beyond(chain: &Chain, joint: usize) -> impl Iterator<Item = usize> {
    (joint + 1..chain.joint_count()).filter(move |other| chain.moves(joint, *other))
}

/// `∂τ/∂g` of all joints in a pose, its load included.
fn by_gravity(
    session: &Session,
    chain: &Chain,
    pose: usize,
    (coordinates, inertia): (&[f64], &[[f64; 4]]),
    placements: &[[f64; 3]],
) -> Vec<f64> {
    let mut inertia = inertia.to_vec();
    if let Some(load) = session.poses[pose].load {
        let (mass, link) = (session.loads[load].mass, session.loads[load].link);
        inertia[link][0] += mass;
        (0..3).for_each(|axis| inertia[link][1 + axis] += mass * placements[load][axis]);
    }
    let mut torque = GravityTorque::new(chain.joint_count(), chain.link_count());
    chain.linearize_gravity_torque(coordinates, [0.0; 3], inertia.as_flattened(), &mut torque);
    torque.by_gravity
}

/// The moment whose `∂τ/∂g` in base coordinates is given, along the directions that stand for the joint's link.
fn across_the_axis(chain: &Chain, joint: usize, coordinates: &[f64], by_gravity: &Vector3<f64>) -> Vec<f64> {
    let link = chain.forward(coordinates)[joint].rotation();
    let to_base = Matrix3::from_fn(|row, column| link[row][column]);
    let source = &chain.joints()[joint];
    let after = source.after.rotation();
    let axis = to_base * Matrix3::from_fn(|row, column| after[row][column]).tr_mul(&Vector3::from(source.axis));
    match source.kind {
        JointKind::Prismatic => vec![-axis.dot(by_gravity)],
        JointKind::Revolute => {
            let moment = to_base.tr_mul(&axis.cross(by_gravity));
            lumped_directions(source).iter().map(|[_, x, y, z]| Vector3::new(*x, *y, *z).dot(&moment)).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use gravcal_dynamics::{Attachment, Transform};

    use super::*;
    use crate::joint::{self, Signals, build_problem};
    use crate::testing::sarcos_shoulder;

    /// With links of known masses both descriptions predict the same readings, at any lengths, beside a joint that slides, and
    /// on two branches.
    #[test]
    fn lumped_links_predict_the_readings_of_the_links() {
        let simulation = sarcos_shoulder();
        for (sliding, branched) in [(None, false), (Some(1), false), (None, true), (Some(1), true)] {
            let mut session = simulation.session(0);
            session.robot.chain = other_chain(&session.robot.chain, sliding, branched);
            let built = |session: &Session| {
                let readings = joint::select(session, Signals::All);
                let built = build_problem(session, &readings, &simulation.truth).unwrap();
                let residuals = built.problem.residuals(&built.initial).unwrap();
                built.rows.into_iter().zip(residuals).collect::<BTreeMap<_, _>>()
            };
            let by_link = built(&session);
            session.inertia = InertiaPrior::Sweep;
            let by_sweep = built(&session);
            let sweeps = if sliding.is_some() { 6 } else { 11 };
            assert_eq!(by_sweep.len(), 3 * 37 * sweeps);
            for (row, residual) in by_sweep {
                assert!((residual - by_link[&row]).abs() < 1e-8 * residual.abs().max(1.0), "{row:?}");
            }
        }
    }

    /// What hangs beyond a joint of one branch does not depend on where the other branch stands.
    #[test]
    fn a_branch_has_one_moment_for_all_postures_of_the_other() {
        let mut session = sarcos_shoulder().session(0);
        let count = |session: &Session, joint: usize| {
            SweepMoments::of(session).moments.iter().filter(|moment| moment.joint == joint).count()
        };
        let serial = [count(&session, 0), count(&session, 1), count(&session, 2)];
        session.robot.chain = other_chain(&session.robot.chain, None, true);
        let branched = [count(&session, 0), count(&session, 1), count(&session, 2)];
        // Joint 2 carries neither joint 3 nor the load any more; joint 3 has it at one of the placements, or not.
        assert_eq!((serial[0], serial[2], branched[1]), (branched[0], branched[2], 1), "{serial:?} {branched:?}");
        assert!(serial[1] > 1);
    }

    /// The chain with lengths, maybe a joint that slides, and maybe the last two joints both on the first link.
    fn other_chain(chain: &Chain, sliding: Option<usize>, branched: bool) -> Chain {
        let mut joints: Vec<_> = chain.joints().to_vec();
        joints.iter_mut().for_each(|joint| joint.after = joint.after * Transform::along([0.3, -0.2, 0.1]));
        sliding.into_iter().for_each(|joint| joints[joint].kind = JointKind::Prismatic);
        let parents = [None, Some(0), Some(if branched { 0 } else { 1 })];
        let attachments = parents.map(|parent| Attachment { parent, mimic: None });
        Chain::branched("base", joints, chain.links().to_vec(), &attachments).unwrap()
    }
}
