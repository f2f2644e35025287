//! Which readings enter the joint problem, and how: one factor a pose, of everything that reads it.

use std::collections::BTreeSet;
use std::sync::Arc;

use gravcal_estimation::{BlockId, Factor, Loss, Noise, NoiseError, ProblemBuilder, Residual};
use gravcal_kinematics::Chain;

use super::order::Order;
use super::position_unknowns::Around;
use super::torques::Torques;
use super::unexplained;
use super::unknowns::Layout;
use crate::parameter::{ParameterId, Quantity};
use crate::residuals::{
    CarriedLoad, GainEntry, InstrumentModel, InstrumentReading, SensedQuantity, SpecificForce, Stacked, Wrench,
};
use crate::sensors::PositionFunction;
use crate::session::{Instrument, InstrumentKind, KnowledgeKind, Pose, Session};

/// Which readings enter, and how uncertain they are.
#[derive(Clone, Debug)]
pub struct Readings {
    /// Channels that enter, for each pose of the session: see [`Session::channel_count`].
    pub used: Vec<Arc<[usize]>>,
    /// Largest less smallest reading of each channel, of all poses of the session: see [`Session::spreads`].
    pub spreads: Arc<[f64]>,
    /// Standard deviation, by channel, of readings that state none; unit of the reading.
    pub noise: Vec<f64>,
    /// Variance, by channel, of errors that the readings' noise does not explain; square of their unit.
    pub unexplained: Vec<f64>,
    /// No reading counts as less uncertain than this, by channel; unit of the reading. Zero but where a start is looked for.
    pub floor: Arc<[f64]>,
    /// How readings far beyond that are to be counted. [`super::pose`] leaves it to `JointProblem::with_loss`: at a start
    /// every reading looks far off.
    pub loss: Loss,
    /// In which order they enter.
    pub order: Order,
}

impl Readings {
    /// Every reading of the session for which `keep(pose, channel)` holds, copies of rows left out, with a first guess of unstated noise.
    pub fn select(session: &Session, keep: impl Fn(usize, usize) -> bool) -> Readings {
        let all: Arc<[usize]> = (0..session.channel_count()).collect();
        let used = vec![all; session.poses.len()];
        let spreads: Arc<[f64]> = session.spreads().into();
        let noise = first_noise(session, &spreads);
        let floor = vec![0.0; noise.len()].into();
        let (unexplained, loss, order) = (unexplained::stated(session), session.loss, Order::Together);
        let readings = Readings { used, spreads, noise, unexplained, floor, loss, order };
        let repeated = |pose: usize| session.repeated.get(pose).is_some_and(|repeated| *repeated);
        readings
            .only(|pose, channel| !repeated(pose) && session.reading(pose, channel).is_some() && keep(pose, channel))
    }

    /// The same, but only readings for which `keep(pose, channel)` holds.
    pub fn only(&self, keep: impl Fn(usize, usize) -> bool) -> Readings {
        let of_pose = |(pose, used): (usize, &Arc<[usize]>)| {
            let kept = || used.iter().copied().filter(|channel| keep(pose, *channel));
            match kept().count() {
                0 => Arc::default(),
                count if count == used.len() => Arc::clone(used),
                _ => kept().collect(),
            }
        };
        let used = self.used.iter().enumerate().map(of_pose).collect();
        Readings { used, ..self.clone() }
    }

    /// The same as if each were uncertain by a hundredth of its channel's spread at least. What explains readings so roughly lies where
    /// the reference prior has a say: at plausible values, and not in one of the deep and narrow minima that small noise makes of odd ones.
    pub(super) fn roughly(&self, session: &Session) -> Readings {
        Readings { floor: first_noise(session, &self.spreads).into(), ..self.clone() }
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
        let free = |id: &ParameterId| session.held(*id).is_none() && !self.reads(session, *id);
        session.parameters().into_iter().filter(free).collect()
    }

    /// The same, but for those that are known with a standard deviation.
    pub(super) fn unread_and_unknown(&self, session: &Session) -> Vec<ParameterId> {
        let known = |id: &ParameterId| matches!(session.knowledge(*id).kind, KnowledgeKind::Prior { .. });
        self.unread(session).into_iter().filter(|id| !known(id)).collect()
    }

    fn reads(&self, session: &Session, id: ParameterId) -> bool {
        let of_torque = match id {
            // What gives way under the torque of one joint turns all beyond it, and with them what others carry.
            ParameterId::Sensor(joint, _) if session.compliances().is_empty() => self.any_torque_met(session, joint),
            ParameterId::Further(index) if index >= session.terms.len() => false,
            _ => self.any_torque(session),
        };
        of_torque
            || self
                .used_axes(session)
                .iter()
                .any(|(number, axis, table)| session.instruments[*number].reads(session, (*axis, *table), id))
    }

    /// Instrument, axis and table (one of those that share its biases) of the readings of instruments that enter, each once.
    fn used_axes(&self, session: &Session) -> BTreeSet<(usize, usize, usize)> {
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
            Some((instrument, _)) => session.instruments[instrument].kind == InstrumentKind::ForceTorque,
        };
        let poses = || session.poses.iter().zip(&self.used).filter(|(_, used)| used.iter().any(feels));
        (0..session.loads.len()).map(|load| poses().any(|(pose, _)| pose.load == Some(load))).collect()
    }

    /// Standard deviation of one reading, unexplained errors included, unit of the reading.
    pub fn std(&self, session: &Session, pose: usize, channel: usize) -> f64 {
        let own = self.own_std(session, pose, channel);
        let unexplained = self.unexplained[channel];
        let std = if unexplained > 0.0 { (own * own + unexplained).sqrt() } else { own };
        std.max(self.floor[channel])
    }

    /// The same by its own noise alone.
    pub fn own_std(&self, session: &Session, pose: usize, channel: usize) -> f64 {
        session.reading(pose, channel).and_then(|r| r.std).unwrap_or(self.noise[channel])
    }
}

/// A first standard deviation for channels whose readings state none: a hundredth of the readings' spread, but of a joint at least a
/// thousandth of the largest torque's. The readings of a joint that carries nothing spread by their noise alone.
pub(super) fn first_noise(session: &Session, spreads: &[f64]) -> Vec<f64> {
    let gain = |joint: usize| session.nominal(ParameterId::Sensor(joint, Quantity::TorqueGain)).abs();
    let largest = (0..session.joints.len()).map(|joint| spreads[joint] / gain(joint)).fold(0.0, f64::max);
    let of_channel = |(channel, spread): (usize, &f64)| {
        let floor = if channel < session.joints.len() { 1e-3 * largest * gain(channel) } else { 0.0 };
        let noise = floor.max(0.01 * spread);
        if noise > 0.0 { noise } else { 1.0 }
    };
    spreads.iter().enumerate().map(of_channel).collect()
}

impl Instrument {
    /// Whether the readings of an axis in a table depend on a parameter.
    fn reads(&self, session: &Session, (axis, table): (usize, usize), id: ParameterId) -> bool {
        match id {
            ParameterId::Sensor(joint, quantity) => {
                let position = matches!(quantity, Quantity::PositionGain | Quantity::PositionOffset);
                session.robot.chain.moves(joint, self.link) && position
            }
            ParameterId::Further(place) => {
                let gain =
                    self.gains.iter().zip(self.gain_parameters()).any(|((row, _), own)| own == place && *row == axis);
                let term = position_terms(session, self.link).any(|(own, ..)| own == place);
                let axes = self.kind.axes().len();
                let drift = self.drift_parameters().skip(axis).step_by(axes).any(|own| own == place);
                gain || term
                    || drift
                    || self.biases_of_table(table).start + axis == place
                    || self.own_parameters().contains(&place)
            }
        }
    }
}

/// Adds the readings; gives pose and channel of each row.
pub(super) fn add_readings(
    session: &Session,
    readings: &Readings,
    layout: &Layout,
    builder: &mut ProblemBuilder,
) -> Result<Vec<(usize, usize)>, NoiseError> {
    let around = Around::new(layout, builder.initial());
    let mut models = Models::new(session, layout);
    let mut rows = Vec::with_capacity(readings.count());
    let (mut std, mut last): (Vec<f64>, Option<(Vec<f64>, Noise)>) = (Vec::new(), None);
    for (pose, used) in readings.used.iter().enumerate().filter(|(_, used)| !used.is_empty()) {
        std.clear();
        std.extend(used.iter().map(|channel| readings.std(session, pose, *channel)));
        // Most poses are as noisy as the one before.
        let noise = match &last {
            Some((alike, noise)) if *alike == std => noise.clone(),
            _ => last.insert((std.clone(), Noise::independent(&std)?)).1.clone(),
        };
        let residual = models.residual(pose, used, |id| builder.block(id).len());
        let factor = Factor { residual: around.residual(pose, residual), noise, loss: Loss::None };
        builder.add_factor(factor);
        rows.extend(used.iter().map(|channel| (pose, *channel)));
    }
    Ok(rows)
}

/// What poses share: by load, first of poses with nothing attached.
struct Models<'s> {
    session: &'s Session,
    torques: Torques<'s>,
    /// Of each instrument, by its set of biases.
    instruments: Vec<Vec<Vec<Arc<InstrumentModel>>>>,
}

impl<'s> Models<'s> {
    fn new(session: &'s Session, layout: &'s Layout) -> Models<'s> {
        let chain = Arc::new(session.robot.chain.clone());
        let loads = session.loads.iter().zip(&layout.loads).map(|(load, position)| {
            position.clone().map(|position| CarriedLoad { position, mass: load.mass, link: load.link })
        });
        let loads: Vec<Option<CarriedLoad>> = std::iter::once(None).chain(loads).collect();
        let instrument = |instrument: &Instrument| {
            let model = |table: usize, load: &Option<CarriedLoad>| {
                Arc::new(instrument_model((session, layout), Arc::clone(&chain), (instrument, table), load.clone()))
            };
            (0..instrument.biases).map(|set| loads.iter().map(|load| model(set, load)).collect()).collect()
        };
        Models {
            session,
            torques: Torques::new(session, layout),
            instruments: session.instruments.iter().map(instrument).collect(),
        }
    }

    /// The residual of the readings of one pose, in the order of their channels. `length`: numbers that store a block.
    fn residual(&mut self, index: usize, used: &[usize], length: impl Fn(BlockId) -> usize) -> Arc<dyn Residual> {
        let (session, pose) = (self.session, &self.session.poses[index]);
        let load = pose.load.map_or(0, |load| load + 1);
        let value = |channel: usize| session.reading(index, channel).map_or(f64::NAN, |reading| reading.value);
        let torques: Vec<(usize, f64)> =
            used.iter().filter(|channel| **channel < session.joints.len()).map(|c| (*c, value(*c))).collect();
        // Most poses are read by joints alone.
        if torques.len() == used.len() {
            return self.torques.residual(session, index, torques);
        }
        let mut parts: Vec<Arc<dyn Residual>> = Vec::new();
        if !torques.is_empty() {
            parts.push(self.torques.residual(session, index, torques));
        }
        for (number, instrument) in session.instruments.iter().enumerate() {
            let own = used.iter().filter_map(|channel| match session.axis(*channel) {
                Some((owner, axis)) if owner == number => Some((axis, value(*channel))),
                _ => None,
            });
            let own: Vec<(usize, f64)> = own.collect();
            if !own.is_empty() {
                let model = Arc::clone(&self.instruments[number][instrument.bias_set(pose.table)][load]);
                let coordinates = coordinates(session, index, instrument.link);
                let drifts = instrument.drifts.iter().map(|drift| drift.value(&pose.conditions)).collect();
                let reading = InstrumentReading::new(model, coordinates, pose.orientation, own).drifting(drifts);
                parts.push(Arc::new(reading));
            }
        }
        if parts.len() == 1 { parts.remove(0) } else { Arc::new(Stacked::new(parts, length)) }
    }
}

/// The model of an instrument in a table.
fn instrument_model(
    (session, layout): (&Session, &Layout),
    chain: Arc<Chain>,
    (instrument, table): (&Instrument, usize),
    load: Option<CarriedLoad>,
) -> InstrumentModel {
    let own = &layout.further[instrument.own_parameters()];
    let sensed: Arc<dyn SensedQuantity> = match instrument.kind {
        InstrumentKind::ForceTorque => {
            let beyond = load.filter(|load| load.link == instrument.link);
            Arc::new(Wrench::new(&instrument.mounting, [own[0], own[1], own[2], own[3]], beyond))
        }
        InstrumentKind::Accelerometer => Arc::new(SpecificForce::new([own[0], own[1], own[2]])),
    };
    let gain = |((reading, sensed), block): (&(usize, usize), &BlockId)| GainEntry {
        reading: *reading,
        sensed: *sensed,
        block: *block,
    };
    let biases =
        [&layout.further[instrument.biases_of_table(table)], &layout.further[instrument.drift_parameters()]].concat();
    let gains = instrument.gains.iter().zip(&layout.further[instrument.gain_parameters()]).map(gain);
    InstrumentModel::new(
        (chain, instrument.link),
        instrument.mounting.rotation(),
        sensed,
        (layout.gravity, &coordinate_blocks(session, layout, instrument.link)),
        (gains.collect(), &biases),
    )
}

/// Blocks on which the coordinates of the joints that move a link depend: position gain and offset of each, then the terms
/// of their position sensors.
fn coordinate_blocks(session: &Session, layout: &Layout, link: usize) -> Vec<BlockId> {
    let affine = joints_moving(session, link).flat_map(|joint| [layout.sensors[joint][2], layout.sensors[joint][3]]);
    let terms = position_terms(session, link).map(|(place, ..)| layout.further[place]);
    affine.chain(terms).collect()
}

/// `θ_j = Σ coefficient · block` in one pose: joint, place among those blocks, coefficient.
fn coordinates(session: &Session, pose: usize, link: usize) -> Vec<(usize, usize, f64)> {
    let position = &session.poses[pose].position;
    let affine = joints_moving(session, link).flat_map(|joint| [(joint, position[joint]), (joint, 1.0)]);
    let terms = position_terms(session, link);
    let terms = terms.map(|(_, joint, function)| (joint, function.value(position[joint])));
    affine.chain(terms).enumerate().map(|(place, (joint, coefficient))| (joint, place, coefficient)).collect()
}

fn joints_moving(session: &Session, link: usize) -> impl Iterator<Item = usize> {
    (0..session.joints.len()).filter(move |joint| session.robot.chain.moves(*joint, link))
}

/// Terms of the position sensors of the joints that move a link: place of the parameter, joint, function.
fn position_terms(session: &Session, link: usize) -> impl Iterator<Item = (usize, usize, &dyn PositionFunction)> {
    session.terms.of_positions().filter(move |(_, joint, _)| session.robot.chain.moves(*joint, link))
}
