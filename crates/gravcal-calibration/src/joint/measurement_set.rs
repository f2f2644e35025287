//! Which readings enter the joint problem, and how uncertain they are.

use std::collections::BTreeSet;
use std::sync::Arc;

use gravcal_estimation::Loss;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::sensors::Term;
use gravcal_robot_model::session::{
    AuxiliarySensor, AuxiliarySensorKind, Pose, PriorKind, ReadingId, Session, UnexplainedError,
};

use crate::joint::order::Order;
use crate::joint::stays::Lasting;

/// Which readings enter, and how uncertain they are.
#[derive(Clone, Debug)]
pub struct MeasurementSet {
    /// Channels that enter, for each pose of the session: see [`Session::channel_count`].
    pub used: Vec<Arc<[usize]>>,
    /// Largest less smallest reading of each channel, of all poses of the session: see [`Session::spreads`].
    pub spreads: Arc<[f64]>,
    /// Standard deviation, by channel, of readings that state none; unit of the reading.
    pub noise: Vec<f64>,
    /// Variance, by channel, of errors that the readings' noise does not explain; square of their unit.
    pub unexplained: Vec<f64>,
    /// By joint, what friction leaves at rest; empty as long as it is not looked for.
    pub(super) at_rest: Vec<AtRest>,
    /// By pose and joint, from which side it came to rest there, where the order of rows tells it (`sides_by_order.rs`); empty where the session says it.
    pub(super) sides: Arc<[Vec<f64>]>,
    /// Errors that last as long as a joint stands; nothing where there are none, or as long as they are not looked for (`model_error/lasting.rs`).
    pub(super) lasting: Option<Lasting>,
    /// How far joints may bend, and under which torques; nothing as long as that is not looked for.
    pub(super) bending: Option<Arc<Bending>>,
    /// What displacements of joints do to them; nothing where there are none, or as long as that is not known.
    pub(super) displaced: Option<Arc<Displacements>>,
    /// No reading counts as less uncertain than this, by channel; unit of the reading. Zero but where a start is looked for.
    pub floor: Arc<[f64]>,
    /// How readings far beyond that are to be counted. [`super::build_problem`] leaves it to `JointProblem::with_loss`: at a start
    /// every reading looks far off.
    pub loss: Loss,
    /// In which order they enter.
    pub order: Order,
}

/// What friction leaves at rest of a joint (`model_error/at_rest.rs`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct AtRest {
    /// One standard deviation, unit of the torque reading; zero where it is no unknown.
    pub std: f64,
    /// What the joint carries, where friction may grow with it (`model_error/growing_friction.rs`).
    pub carried: Option<Carried>,
    /// One standard deviation of what it grows by, unit of the torque reading; zero where that is no unknown, or as long as it is not looked for.
    pub growth_std: f64,
    /// How much of it grows so, from 0 to 1, as an earlier solution has it.
    pub growing_share: f64,
}

/// What gravity makes a joint's sensor read in the poses in which it stands, unit of the reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Carried {
    /// What it reads of nothing.
    pub bias: f64,
    /// Mean size of what it reads beyond that.
    pub mean: f64,
}

/// What may bend joints: `bending.rs` finds it.
#[derive(Clone, Debug)]
pub(super) struct Bending {
    /// By joint, rad/(N·m); zero of those that do not bend, or whose torque is not read.
    pub std: Vec<f64>,
    /// By pose and joint, N·m.
    pub torques: Vec<Vec<f64>>,
    /// Of an arm in motion, what each joint that may bend does to the readings of windows, one after the other, unit of the reading for each rad/(N·m).
    pub in_motion: Vec<Effect>,
}

/// What joints do that are not where the robot's description has them: `building/displacements.rs` finds it.
#[derive(Clone, Debug)]
pub(super) struct Displacements {
    /// By number of the unknowns.
    pub by_number: Vec<Effect>,
}

/// What a number does to the readings: by pose and channel, unit of the reading for each unit of it. Of a displacement that is a metre or a radian.
pub(super) type Effect = Vec<Vec<f64>>;

impl MeasurementSet {
    /// Every reading of the session for which `keep` holds, copies of rows left out, with a first guess of unstated noise.
    pub fn select(session: &Session, keep: impl Fn(ReadingId) -> bool) -> MeasurementSet {
        let all: Arc<[usize]> = (0..session.channel_count()).collect();
        let used = vec![all; session.poses.len()];
        let spreads: Arc<[f64]> = session.spreads().into();
        let noise = first_noise(session, &spreads);
        let floor = vec![0.0; noise.len()].into();
        let (unexplained, loss, order) = (stated(session), session.loss, Order::Together);
        let (at_rest, sides, lasting, bending, displaced) = (Vec::new(), Arc::default(), None, None, None);
        let readings = MeasurementSet {
            used,
            spreads,
            noise,
            unexplained,
            at_rest,
            sides,
            lasting,
            bending,
            displaced,
            floor,
            loss,
            order,
        };
        let repeated = |pose: usize| session.repeated.get(pose).is_some_and(|repeated| *repeated);
        readings.only(|id| !repeated(id.pose) && session.reading(id).is_some() && keep(id))
    }

    /// The same, but only readings for which `keep` holds.
    pub fn only(&self, keep: impl Fn(ReadingId) -> bool) -> MeasurementSet {
        let of_pose = |(pose, used): (usize, &Arc<[usize]>)| {
            let kept = || used.iter().copied().filter(|channel| keep(ReadingId { pose, channel: *channel }));
            match kept().count() {
                0 => Arc::default(),
                count if count == used.len() => Arc::clone(used),
                _ => kept().collect(),
            }
        };
        let used = self.used.iter().enumerate().map(of_pose).collect();
        MeasurementSet { used, ..self.clone() }
    }

    /// Every reading of other poses of the arm, with the noise, and what errs beside it, as these readings have them.
    pub(super) fn of_other_poses(&self, session: &Session) -> MeasurementSet {
        let MeasurementSet { spreads, noise, unexplained, at_rest, .. } = self.clone();
        let (sides, lasting) = (self.sides_in(session), self.lasting_elsewhere());
        let all = MeasurementSet::select(session, |_| true);
        MeasurementSet { spreads, noise, unexplained, at_rest, sides, lasting, ..all }
    }

    /// The same readings in a session in which two channels are exchanged in some poses: one may be read where the other is not.
    pub(super) fn exchanged(&self, [a, b]: [usize; 2], in_pose: impl Fn(usize) -> bool) -> MeasurementSet {
        let other = |channel: &usize| match *channel {
            own if own == a => b,
            own if own == b => a,
            own => own,
        };
        let of_pose = |(pose, used): (usize, &Arc<[usize]>)| {
            if used.contains(&a) == used.contains(&b) || !in_pose(pose) {
                return Arc::clone(used);
            }
            let mut used: Vec<usize> = used.iter().map(other).collect();
            used.sort_unstable();
            used.into()
        };
        MeasurementSet { used: self.used.iter().enumerate().map(of_pose).collect(), ..self.clone() }
    }

    /// The same as if each were uncertain by a hundredth of its channel's spread at least. What explains readings so roughly lies where
    /// the reference prior has a say: at plausible values, and not in one of the deep and narrow minima that small noise makes of odd ones.
    pub(super) fn roughly(&self, session: &Session) -> MeasurementSet {
        MeasurementSet { floor: first_noise(session, &self.spreads).into(), ..self.clone() }
    }

    /// How many poses have a reading that enters.
    pub(super) fn poses(&self) -> usize {
        self.used.iter().filter(|used| !used.is_empty()).count()
    }

    /// The channel of every reading that enters.
    fn channels(&self) -> impl Iterator<Item = &usize> {
        self.used.iter().flat_map(|used| used.iter())
    }

    /// How many readings enter.
    pub fn count(&self) -> usize {
        self.used.iter().map(|used| used.len()).sum()
    }

    /// Whether any torque of a joint enters.
    pub(super) fn any_torque(&self, session: &Session) -> bool {
        self.channels().any(|channel| *channel < session.joints.len())
    }

    /// Whether the torque of any joint enters with which this one moves something.
    fn any_torque_met(&self, session: &Session, joint: usize) -> bool {
        let mut torques = self.channels().filter(|channel| **channel < session.joints.len());
        torques.any(|channel| session.robot.chain.meet(*channel, joint))
    }

    /// Free parameters on which no reading that enters depends.
    pub(super) fn unread(&self, session: &Session) -> Vec<ParameterId> {
        let axes = self.used_axes(session);
        let free = |id: &ParameterId| session.fixed(*id).is_none() && !self.reads(session, &axes, *id);
        session.parameters().into_iter().filter(free).collect()
    }

    /// The same, but for those that are known with a standard deviation.
    pub(super) fn unread_and_unknown(&self, session: &Session) -> Vec<ParameterId> {
        let known = |id: &ParameterId| matches!(session.prior(*id).kind, PriorKind::Gaussian { .. });
        self.unread(session).into_iter().filter(|id| !known(id) && !is_observed(session, *id)).collect()
    }

    /// Whether readings depend on a parameter; `axes`: those that are used.
    fn reads(&self, session: &Session, axes: &UsedAxes, id: ParameterId) -> bool {
        let of_torque = match id {
            // What gives way under the torque of one joint turns all beyond it, and with them what others carry.
            ParameterId::Sensor(joint, _) if session.compliances().is_empty() => self.any_torque_met(session, joint),
            ParameterId::Further(index) if session.rotor_of(index).is_some() => {
                session.rotor_of(index).is_some_and(|joint| self.reads_in_motion(session, joint))
            }
            ParameterId::Further(_) if session.loads_of_mass(id).any(|load| self.carried(session)[load]) => {
                return true;
            }
            ParameterId::Further(index) if session.compliances().contains(&index) => self.any_torque(session),
            ParameterId::Further(index) if index >= session.terms.len() => false,
            _ => self.any_torque(session),
        };
        of_torque
            || axes
                .iter()
                .any(|(number, axis, table)| reads(&session.instruments[*number], session, (*axis, *table), id))
    }

    /// Whether any sensor reads the torque of a joint in a window of an arm in motion: its own, or one that reads other joints' torques, too.
    fn reads_in_motion(&self, session: &Session, joint: usize) -> bool {
        let windows = || session.poses.iter().zip(&self.used).filter(|(pose, _)| pose.course.is_some());
        windows().any(|(_, used)| used.contains(&joint))
    }

    /// Those of the readings that enter.
    fn used_axes(&self, session: &Session) -> UsedAxes {
        let of_pose = |(pose, used): (&Pose, &Arc<[usize]>)| {
            let axes = used.iter().filter_map(|channel| session.axis(*channel));
            axes.map(|(number, axis)| (number, axis, session.instruments[number].bias_set(pose.table)))
                .collect::<Vec<_>>()
        };
        session.poses.iter().zip(&self.used).flat_map(of_pose).collect()
    }

    /// Which loads hang on the robot in a pose of which something is read that feels them.
    pub(super) fn carried(&self, session: &Session) -> Vec<bool> {
        let feels = |channel: &usize| match session.axis(*channel) {
            None => true,
            Some((instrument, _)) => session.instruments[instrument].kind == AuxiliarySensorKind::ForceTorque,
        };
        let poses = || session.poses.iter().zip(&self.used).filter(|(_, used)| used.iter().any(feels));
        (0..session.loads.len()).map(|load| poses().any(|(pose, _)| pose.load == Some(load))).collect()
    }

    /// Which loads are moved in a pose of which a torque is read: only these show their inertia tensors.
    pub(super) fn moved(&self, session: &Session) -> Vec<bool> {
        let poses = || self.moving(session);
        (0..session.loads.len()).map(|load| poses().any(|pose| pose.load == Some(load))).collect()
    }

    /// The poses in motion of which a torque is read.
    pub(super) fn moving<'a>(&'a self, session: &'a Session) -> impl Iterator<Item = &'a Pose> {
        let joints = session.joints.len();
        let poses = session.poses.iter().zip(&self.used);
        let moving =
            poses.filter(move |(pose, used)| pose.course.is_some() && used.iter().any(|channel| *channel < joints));
        moving.map(|(pose, _)| pose)
    }

    /// Standard deviation of one reading, unexplained errors included, unit of the reading.
    pub fn std(&self, session: &Session, id: ReadingId) -> f64 {
        let own = self.own_std(session, id);
        let unexplained = self.unexplained[id.channel] * self.growing_scatter(session, id).powi(2)
            + self.of_unknown_side(session, id)
            + self.lasting_alone(id);
        let std = if unexplained > 0.0 { (own * own + unexplained).sqrt() } else { own };
        std.max(self.floor[id.channel])
    }

    /// The same by its own noise alone.
    pub fn own_std(&self, session: &Session, id: ReadingId) -> f64 {
        session.reading(id).and_then(|r| r.std).unwrap_or(self.noise[id.channel])
    }
}

/// A first standard deviation for channels whose readings state none: a hundredth of the readings' spread, but of a joint at least a
/// thousandth of the largest torque's. The readings of a joint that carries nothing spread by their noise alone.
pub(super) fn first_noise(session: &Session, spreads: &[f64]) -> Vec<f64> {
    let gain = |joint: usize| session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain)).abs();
    let largest = (0..session.joints.len()).map(|joint| spreads[joint] / gain(joint)).fold(0.0, f64::max);
    let of_channel = |(channel, spread): (usize, &f64)| {
        let floor = if channel < session.joints.len() { 1e-3 * largest * gain(channel) } else { 0.0 };
        let noise = floor.max(0.01 * spread);
        if noise > 0.0 { noise } else { 1.0 }
    };
    spreads.iter().enumerate().map(of_channel).collect()
}

/// Whether any residual of one's own depends on a parameter.
fn is_observed(session: &Session, id: ParameterId) -> bool {
    session.residuals.iter().any(|residual| match id {
        ParameterId::Sensor(joint, quantity) => {
            let position = matches!(quantity, SensorParameter::PositionGain | SensorParameter::PositionOffset);
            residual.sees.joints().contains(&joint) && position
        }
        ParameterId::Further(place) => {
            let seen = |term: &Term| residual.sees.joints().contains(&term.joint) && has(session, term, place);
            residual.places.contains(&place) || session.terms.of_positions().any(seen)
        }
    })
}

/// Instrument, axis and table (one of those that share its biases) of readings of instruments, each once.
type UsedAxes = BTreeSet<(usize, usize, usize)>;

/// Whether the readings of an axis in a table depend on a parameter.
fn reads(instrument: &AuxiliarySensor, session: &Session, (axis, table): (usize, usize), id: ParameterId) -> bool {
    match id {
        ParameterId::Sensor(joint, quantity) => {
            let position = matches!(quantity, SensorParameter::PositionGain | SensorParameter::PositionOffset);
            session.robot.chain.moves(joint, instrument.link) && position
        }
        ParameterId::Further(place) => {
            let gain = instrument
                .gains
                .iter()
                .zip(instrument.gain_parameters())
                .any(|((row, _), own)| own == place && *row == axis);
            let term = position_terms(session, instrument.link).any(|term| has(session, term, place));
            let axes = instrument.kind.axes().len();
            let drift = instrument.drift_parameters().skip(axis).step_by(axes).any(|own| own == place);
            gain || term
                || drift
                || instrument.biases_of_table(table).start + axis == place
                || instrument.own_parameters().contains(&place)
        }
    }
}

/// Whether a term has a parameter, for itself or as one that it shares.
fn has(session: &Session, term: &Term, place: usize) -> bool {
    term.places.clone().any(|own| own == place || session.further[own].same_as == Some(place))
}

/// Terms of the position sensors of the joints that move a link.
pub(super) fn position_terms(session: &Session, link: usize) -> impl Iterator<Item = &Term> {
    session.terms.of_positions().filter(move |term| session.robot.chain.moves(term.joint, link))
}

/// Variance of unexplained errors of each channel where it is stated; else zero.
pub(super) fn stated(session: &Session) -> Vec<f64> {
    let variance = |error: UnexplainedError| if let UnexplainedError::Stated { std } = error { std * std } else { 0.0 };
    session.unexplained_errors().into_iter().map(variance).collect()
}

#[cfg(test)]
mod tests {
    use super::first_noise;
    use crate::testing::{sarcos_shoulder, sarcos_with_instruments};

    /// Sensors differ in their units: torques are compared.
    #[test]
    fn a_first_guess_of_noise_is_a_share_of_the_spread_but_of_no_joint_less_than_of_the_largest_torque() {
        let mut session = sarcos_shoulder().session(0);
        for (joint, gain) in [10.0, 10.0, -1000.0].into_iter().enumerate() {
            session.joints[joint].parameters[0].nominal = gain;
        }
        // Torques of 30, 0.5 and 40 N·m: the second carries nothing.
        let noise = first_noise(&session, &[300.0, 5.0, 40_000.0]);
        for (found, expected) in noise.iter().zip([3.0, 1e-3 * 40.0 * 10.0, 400.0]) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{noise:?}");
        }
        assert_eq!(first_noise(&session, &[0.0; 3]), [1.0; 3], "of no readings any will do");
    }

    #[test]
    fn instruments_have_no_share_of_the_largest_torque() {
        let session = sarcos_with_instruments().session(0);
        let spreads: Vec<f64> = (0..12).map(|channel| if channel < 3 { 1e6 } else { 1.0 }).collect();
        assert_eq!(first_noise(&session, &spreads)[3..], [0.01; 9]);
    }
}
