//! Joints that bend under the torque that they carry, which position sensors on the motors' side do not see: one unknown of each joint.
//!
//! ```text
//!     θ_j = s_j q_j + o_j + c_j τ_j        τ_j: the torque that the model gives the joint
//! ```
//!
//! What bends a joint most goes with its angle, and passes for a position gain. Only the rest shows in residuals, and what friction leaves at
//! rest hides it. A compliance of two of its own standard deviations, which no test names, shifts that gain by three or four of its. So where
//! errors beyond the noise show that friction may hide it, it is an unknown; the gain's interval widens to what is known of it then. In slow
//! sweeps it always is one: readings are so many that a gain is many standard deviations off before a test finds why. Arms
//! of one or two joints are taken as stiff there: they sweep too few ways to tell.
//! In tables it is one where residuals show friction or compliance (`in_tables.rs`). In motion it always is one, as in slow sweeps: what it does to the readings
//! of windows is in `bending_in_motion/`.
//!
//! Its prior is zero give or take what bends the joint by [`DEFLECTION`] under the spread of its torque, as gears are built for what
//! they carry. A session that declares compliances, or that there are none, has none of these unknowns, nor has one whose instruments
//! would move with what bends.
//!
//! `τ_j` is a constant of each fit: first that of the fit without them, then that of the one before, until joints bend by what they did before.

use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_estimation::EvaluateError;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{Pose, ReadingId, Searched, Session};

use crate::joint::bodies::inertia_in_pose;
use crate::joint::building::sweep_moments::by_sweep;
use crate::joint::measurement_set::{Bending, Effect, MeasurementSet};
use crate::joint::model_error::at_rest::OfReadings;
use crate::joint::model_error::bending_in_motion::effects_in_motion;
use crate::joint::model_error::unexplained_size::spread;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::joint::variables::{OfJoints, State};

/// By how much the torques that a joint carries bend it, one standard deviation, rad: arms with harmonic drives bend by some milliradians.
const DEFLECTION: f64 = 5e-3;
/// Share of the largest spread of any joint's torque with which each is credited at least: gears are no softer than that.
const LEAST_SHARE: f64 = 0.1;
/// Arms of fewer joints sweep too few ways to tell how far they bend: that would leave most unknowns open.
const FEWEST_JOINTS: usize = 3;
/// Joints that bend otherwise by less than this change no torque by as much as it is known, rad: slow sweeps tell offsets to a few 1e-6.
const SETTLED: f64 = 1e-7;
/// The same of readings of an arm in motion, standard deviations of each.
const SETTLED_READING: f64 = 0.01;
/// Rounds in which what bends and what it carries come to agree: each makes the difference smaller by compliance times stiffness, a few per cent.
const ROUNDS: usize = 8;
/// By what share a standard deviation grows that is worth a remark.
const REMARKABLE: f64 = 0.5;

impl Bending {
    /// Of slow sweeps, of an arm in motion, and of standstills whose errors show that friction may hide it; nothing where the session knows about it.
    pub(in crate::joint) fn of(session: &Session, solved: &Solved) -> Result<Option<Bending>, EvaluateError> {
        let readings = solved.readings();
        let errs = (0..session.joints.len()).any(|joint| readings.errs_beyond_chance(session, joint));
        let looked_for = readings.bending.is_none() && readings.order == Order::Together;
        let told = (swept(session) || moves(session)) && session.joints.len() >= FEWEST_JOINTS;
        match (errs || told) && looked_for && may_bend(session) {
            true => Bending::as_built(session, solved).map(Some),
            false => Ok(None),
        }
    }

    /// Of all joints, as gears are built for what they carry.
    pub(in crate::joint) fn as_built(session: &Session, solved: &Solved) -> Result<Bending, EvaluateError> {
        let torques = solved.bending_torques(session)?;
        // Where the readings are explained badly, the model's torques say little of what a joint is built for.
        let read = |joint: usize| {
            let gain = session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
            let all = session.poses.iter().filter_map(|pose| Some(pose.torque[joint]?.value / gain));
            spread(&all.filter(|torque| torque.is_finite()).collect::<Vec<_>>())
        };
        let of_joint = |joint: usize| {
            let of_model = spread(&torques.iter().map(|pose| pose[joint]).collect::<Vec<_>>());
            if swept(session) { of_model.max(read(joint)) } else { of_model }
        };
        let spreads: Vec<f64> = (0..session.joints.len()).map(of_joint).collect();
        let largest = spreads.iter().copied().fold(0.0, f64::max);
        let turns = |joint: usize| session.robot.chain.joints()[joint].kind != JointKind::Prismatic;
        let std = |(joint, spread): (usize, &f64)| match turns(joint) && *spread > 0.0 {
            true => DEFLECTION / spread.max(LEAST_SHARE * largest),
            false => 0.0,
        };
        let std: Vec<f64> = spreads.iter().enumerate().map(std).collect();
        let in_motion = effects_in_motion(session, solved.readings(), &solved.state(&State::nominal(session)), &std)?;
        Ok(Bending { std, torques, in_motion })
    }
}

/// Whether there are slow sweeps.
pub(in crate::joint) fn swept(session: &Session) -> bool {
    session.fitted_recordings().any(|searched| searched.sweeps.is_some())
}

/// Whether any pose that is fitted is a window of an arm in motion.
fn moves(session: &Session) -> bool {
    session.poses.iter().any(|pose| pose.course.is_some())
}

/// Whether joints stood, swept slowly or moved, and nothing says how stiff they are. Where moments are those of sweeps, they leave too much of it open.
fn may_bend(session: &Session) -> bool {
    let found = |searched: &Searched| searched.standstills.is_some() || searched.sweeps.is_some();
    (session.searched.iter().any(found) || moves(session))
        && !(swept(session) && by_sweep(session))
        && is_stiffness_unsaid(session)
}

/// Whether joints are taken as stiff because nothing says otherwise, where the session could say it.
pub(crate) fn is_stiffness_unsaid(session: &Session) -> bool {
    let deflection = &session.deflection;
    !(deflection.stiff || deflection.hold_std.is_some() || deflection.pose_std.is_some())
        && session.compliances().is_empty()
        && session.instruments.is_empty()
        && session.residuals.is_empty()
}

/// What gravity makes each joint of an arm that bends as `state` has it carry, N·m or N, by pose.
fn carried_by_joints(session: &Session, state: &State) -> Vec<Vec<f64>> {
    let carried = |pose: usize| {
        let mut torques = vec![0.0; session.joints.len()];
        let inertia = inertia_in_pose(session, state, pose);
        let Pose { position, conditions, .. } = &session.poses[pose];
        let stiff = session.terms.coordinates(position, conditions, state);
        for _ in 0..if state.bending.is_empty() { 1 } else { ROUNDS } {
            let bent = |(joint, coordinate): (usize, &f64)| {
                coordinate + state.bending.get(joint).map_or(0.0, |compliance| compliance * torques[joint])
            };
            let coordinates: Vec<f64> = stiff.iter().enumerate().map(bent).collect();
            session.robot.chain.gravity_torque(&coordinates, state.gravity, inertia.as_flattened(), &mut torques);
        }
        torques
    };
    (0..session.poses.len()).map(carried).collect()
}

impl Solved {
    /// The torque that the model gives a joint, N·m, by pose and joint: what bends it whether it stands or passes the angle slowly. Zero where it is
    /// not read, but for slow sweeps of a recording, in which a joint that stands may not be read because of its friction: moments of links tell it.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(crate) fn bending_torques(&self, session: &Session) -> Result<Vec<Vec<f64>>, EvaluateError> {
        if swept(session) && !by_sweep(session) {
            return Ok(carried_by_joints(session, &self.state(&State::nominal(session))));
        }
        let mut torques = vec![vec![0.0; session.joints.len()]; session.poses.len()];
        for (ReadingId { pose, channel }, reading) in self.built.rows.iter().zip(self.gravity_readings(session)?) {
            if *channel < session.joints.len() {
                let gain = self.built.variables.sensors[*channel][SensorParameter::TorqueGain as usize];
                torques[*pose][*channel] = reading / self.estimate.values.scalar(gain);
            }
        }
        Ok(torques)
    }

    /// Its readings with the torques that bend joints, and what that does in motion, as it has them; nothing where joints bend by what it says already.
    pub(in crate::joint) fn bent_anew(&self, session: &Session) -> Result<Option<MeasurementSet>, EvaluateError> {
        let (Some(bending), Some(unknown)) = (&self.readings().bending, &self.built.variables.bending) else {
            return Ok(None);
        };
        if !self.estimate.termination.converged() {
            return Ok(None);
        }
        let (torques, found) = (self.bending_torques(session)?, self.estimate.values.get(unknown.block));
        let in_motion =
            effects_in_motion(session, self.readings(), &self.state(&State::nominal(session)), &bending.std)?;
        let moves = |(pose, (new, old)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let of_joint = |(joint, compliance): (&usize, &f64)| (compliance * (new[*joint] - old[*joint])).abs();
            let stands = session.poses[pose].course.is_none();
            unknown.joints.iter().zip(found).filter(|_| stands).map(of_joint).fold(0.0, f64::max)
        };
        let largest = torques.iter().zip(&bending.torques).enumerate().map(moves).fold(0.0, f64::max);
        let as_before = |id: &ReadingId| {
            let of_joint = |(compliance, (new, old)): (&f64, (&Effect, &Effect))| {
                compliance * (new[id.pose][id.channel] - old[id.pose][id.channel])
            };
            let moved: f64 = found.iter().zip(in_motion.iter().zip(&bending.in_motion)).map(of_joint).sum();
            moved.abs() < SETTLED_READING * self.readings().std(session, *id)
        };
        if largest <= SETTLED && self.built.rows.iter().all(as_before) {
            return Ok(None);
        }
        let bending = Bending { std: bending.std.clone(), torques, in_motion };
        Ok(Some(MeasurementSet { bending: Some(Arc::new(bending)), ..self.readings().clone() }))
    }

    /// How far a joint bends, without its prior; nothing where that is no unknown, or the readings do not tell it.
    pub(crate) fn bending(&self, joint: usize) -> Option<OfReadings> {
        self.without_prior(self.built.variables.bending.as_ref()?, joint)
    }

    /// Whether how far it bends is an unknown of this joint.
    pub(crate) fn has_bending(&self, joint: usize) -> bool {
        self.built.variables.bending.as_ref().is_some_and(|bending| bending.place(joint).is_some())
    }

    /// Says which position gains are known less well because joints may bend.
    pub(in crate::joint) fn gains_that_hold_bending(&self, session: &Session) -> Option<String> {
        let bending = self.built.variables.bending.as_ref()?;
        let widened: Vec<(String, f64)> =
            bending.joints.iter().filter_map(|joint| self.widened_by_bending(session, bending, *joint)).collect();
        let most = widened.iter().map(|(_, times)| *times).reduce(f64::max)?;
        let names: Vec<&str> = widened.iter().map(|(name, _)| name.as_str()).collect();
        let hidden = if swept(session) || moves(session) { "" } else { ", and friction hides how much" };
        Some(format!(
            "Joints may bend under their torque, which position sensors on the motors' side do not see{hidden}: the \
             intervals of {} include it, and are up to {most:.1} times as wide as for stiff joints. If the position sensors sit \
             behind the gears, say so ([deflection] compliance_std_rad_per_newton_metre = 0); else hold these joints at the same angles \
             under other torques: with a heavier load, or with the joints beyond them elsewhere.",
            names.join(", ")
        ))
    }

    /// Name of a position gain, and how many times its standard deviation is that of a stiff joint, where that is worth a word.
    fn widened_by_bending(&self, session: &Session, bending: &OfJoints, joint: usize) -> Option<(String, f64)> {
        let gain = ParameterId::Sensor(joint, SensorParameter::PositionGain);
        let column = self.built.problem.columns_of(self.built.variables.block(gain)).next()?;
        let own = self.built.problem.columns_of(bending.block).nth(bending.place(joint)?)?;
        let both = self.covariance().of(&[vec![(column, 1.0)], vec![(own, 1.0)]]);
        let stiff = both[0] - both[1] * both[2] / both[3];
        let times = (both[0] / stiff).sqrt();
        (times > 1.0 + REMARKABLE && times.is_finite()).then(|| (session.parameter_name(gain), times))
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Termination;
    use gravcal_robot_model::session::{Deflection, Searched};

    use super::*;
    use crate::joint::{Signals, build_problem, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A shoulder on an upright base that was found standing in a recording, with these errors beyond the noise.
    fn standing(unexplained: f64) -> (Session, Solved) {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [0.0, 0.0, -9.8];
        simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        let mut session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        session.searched = vec![Searched { standstills: Some(Default::default()), ..Searched::default() }];
        let readings = MeasurementSet { unexplained: vec![unexplained; 3], ..solved.readings().clone() };
        let built = build_problem(&session, &readings, &solved.state(&State::nominal(&session))).unwrap();
        (session, Solved::at_start(built).unwrap())
    }

    /// `DEFLECTION` under the spread of each joint's torque, but no joint softer than for a tenth of the largest spread.
    #[test]
    fn joints_are_built_for_what_they_carry() {
        let (session, solved) = standing(1.0);
        let bending = Bending::of(&session, &solved).unwrap().unwrap();
        let state = solved.state(&State::nominal(&session));
        let spreads: Vec<f64> = (0..3)
            .map(|joint| {
                let [gain, bias, ..] = state.sensors[joint];
                let torques = session.poses.iter().map(|pose| (pose.torque[joint].unwrap().value - bias) / gain);
                spread(&torques.collect::<Vec<f64>>())
            })
            .collect();
        assert!(spreads[0] < 0.05 * spreads[1], "the first joint carries nothing: {spreads:?}");
        for joint in [1, 2] {
            assert!((bending.std[joint] * spreads[joint] / 5e-3 - 1.0).abs() < 0.02, "{:?} {spreads:?}", bending.std);
        }
        let softest = 5e-3 / (0.1 * spreads[1].max(spreads[2]));
        assert!((bending.std[0] / softest - 1.0).abs() < 0.02, "{:?} {spreads:?}", bending.std);
    }

    #[test]
    fn bending_is_looked_for_where_errors_may_hide_it_and_nothing_says_how_stiff_joints_are() {
        let (session, solved) = standing(1.0);
        let looked_for = |session: &Session, solved: &Solved| Bending::of(session, solved).unwrap().is_some();
        assert!(looked_for(&session, &solved));
        let table = Session { searched: Vec::new(), ..session.clone() };
        let stiff = [
            Deflection { stiff: true, ..Deflection::default() },
            Deflection { hold_std: Some(1e-3), ..Deflection::default() },
            Deflection { pose_std: Some(1e-3), ..Deflection::default() },
        ];
        let stiff = stiff.map(|deflection| Session { deflection, ..session.clone() });
        for other in stiff.iter().chain([&table]) {
            assert!(!looked_for(other, &solved));
        }
        let (mut session, solved) = standing(1e-6);
        assert!(!looked_for(&session, &solved), "noise alone");
        session.searched[0].sweeps = Some(Default::default());
        assert!(looked_for(&session, &solved), "slow sweeps");
    }

    /// The torques that bend joints are taken anew where the deflections of the others are wrong by more than `SETTLED`.
    #[test]
    fn torques_are_taken_anew_where_joints_bend_otherwise_by_more_than_matters() {
        let (session, solved) = standing(1.0);
        let bending = Bending::of(&session, &solved).unwrap().unwrap();
        let start = State { bending: vec![0.0, 1e-4, 0.0], ..solved.state(&State::nominal(&session)) };
        // Solved for with joints that bend under these torques.
        let under = |torques: Vec<Vec<f64>>, termination: Termination| {
            let bending = Some(Arc::new(Bending { torques, ..bending.clone() }));
            let readings = MeasurementSet { bending, ..solved.readings().clone() };
            let mut bent = Solved::at_start(build_problem(&session, &readings, &start).unwrap()).unwrap();
            bent.estimate.termination = termination;
            bent
        };
        let as_found = |torques| under(torques, Termination::ZeroResidual).bending_torques(&session).unwrap();
        let torques = as_found(as_found(as_found(bending.torques.clone())));
        let anew = |joint: usize, off: f64, termination: Termination| {
            let mut other = torques.clone();
            other[40][joint] += off;
            let readings = under(other, termination).bent_anew(&session).unwrap()?;
            Some(readings.bending.unwrap().torques[40][joint])
        };
        // 1e-4 rad/(N·m) times 0.001 N·m is `SETTLED`.
        assert_eq!(anew(1, 0.0009, Termination::ZeroResidual), None);
        let found = anew(1, -0.0011, Termination::ZeroResidual).unwrap();
        assert!((found - torques[40][1]).abs() < 1e-4, "{found} {}", torques[40][1]);
        assert_eq!(anew(2, 1e3, Termination::ZeroResidual), None, "the third joint does not bend");
        assert_eq!(anew(1, 1.0, Termination::AsGiven), None, "what has not converged says nothing");
    }
}
