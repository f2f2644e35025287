//! The readings as factors of the joint problem: one a pose, of everything that reads it.

use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::{BlockId, Factor, Loss, Noise, NoiseError, ProblemBuilder, Residual, Values};
use gravcal_robot_model::residuals::{
    AuxiliarySensorModel, AuxiliarySensorReading, CarriedLoad, GainEntry, PositionTerms, SensedQuantity, SpecificForce,
    Stacked, Wrench, names_a_block_twice,
};
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, Pose, ReadingId, Session};

use crate::joint::building::position_unknowns::Around;
use crate::joint::building::torques::{Torques, carried};
use crate::joint::measurement_set::{MeasurementSet, position_terms};
use crate::joint::model_error::at_rest;
use crate::joint::variables::VariableIndex;

/// Adds the readings; gives that of each row. `positions`: gain and offset of each joint's position sensor, where derivatives by them are not
/// asked for.
pub(in crate::joint) fn add_readings(
    session: &Session,
    readings: &MeasurementSet,
    variables: &VariableIndex,
    positions: Option<Vec<[f64; 2]>>,
    builder: &mut ProblemBuilder,
) -> Result<Vec<ReadingId>, NoiseError> {
    let stored = builder.initial();
    let mut residuals = PoseResiduals::new(session, variables, session.robot.chain.clone(), positions, stored.clone());
    let mut rows = Vec::with_capacity(readings.count());
    let (mut std, mut last): (Vec<f64>, Option<(Vec<f64>, Noise)>) = (Vec::new(), None);
    for (pose, used) in readings.used.iter().enumerate().filter(|(_, used)| !used.is_empty()) {
        std.clear();
        std.extend(used.iter().map(|channel| readings.std(session, ReadingId { pose, channel: *channel })));
        // Most poses are as noisy as the one before.
        let noise = match &last {
            Some((alike, noise)) if *alike == std => noise.clone(),
            _ => last.insert((std.clone(), Noise::independent(&std)?)).1.clone(),
        };
        let residual = residuals.of(pose, used, builder);
        let residual = match &readings.displaced {
            Some(displaced) => displaced.around((session, variables, &stored), (pose, used), residual),
            None => residual,
        };
        let residual = match &variables.lengths {
            Some(lengths) if !session.has_windows() => lengths.around((session, variables, &stored), pose, residual),
            _ => residual,
        };
        let residual = match &variables.static_friction {
            Some(friction) => friction.around((session, variables, &stored), pose, residual),
            None => residual,
        };
        let residual = match &variables.at_rest {
            Some(at_rest) => at_rest::around((session, readings), (variables, &stored), at_rest, pose, residual),
            None => residual,
        };
        let residual = match &readings.lasting {
            Some(lasting) => lasting.around((variables, &stored), pose, residual),
            None => residual,
        };
        let residual = match (&variables.bending, &readings.bending) {
            (Some(unknown), Some(bending)) => {
                bending.around((session, variables, &stored), unknown, (pose, used), residual)
            }
            _ => residual,
        };
        let factor = Factor { residual, noise, loss: Loss::None };
        builder.add_factor(factor);
        rows.extend(used.iter().map(|channel| ReadingId { pose, channel: *channel }));
    }
    Ok(rows)
}

/// The residual of each pose, with the unknowns of positions around it.
pub(in crate::joint::building) struct PoseResiduals<'s> {
    models: Models<'s>,
    around: Around<'s>,
    /// The last one that names each block once.
    single: Option<Arc<dyn Residual>>,
}

impl<'s> PoseResiduals<'s> {
    /// `chain`: the session's, or one whose joints are elsewhere; `stored`: any values of all blocks.
    pub fn new(
        session: &'s Session,
        variables: &'s VariableIndex,
        chain: Chain,
        positions: Option<Vec<[f64; 2]>>,
        stored: Values,
    ) -> PoseResiduals<'s> {
        let models = Models::new(session, variables, chain, positions);
        PoseResiduals { models, around: Around::new(variables, stored), single: None }
    }

    /// That of the readings of a pose, in the order of their channels.
    pub fn of(&mut self, pose: usize, used: &[usize], builder: &ProblemBuilder) -> Arc<dyn Residual> {
        let mut residual = self.models.residual(pose, used, |id| builder.block(id).len());
        // Most poses read the very same blocks as the one before.
        if self.single.as_ref().is_none_or(|single| !std::ptr::eq(single.blocks(), residual.blocks())) {
            residual = once(residual, builder);
            self.single = Some(Arc::clone(&residual));
        }
        self.around.residual(pose, residual)
    }
}

/// A residual that names each of its blocks once: sensors that share a parameter name it twice.
pub(in crate::joint) fn once(residual: Arc<dyn Residual>, builder: &ProblemBuilder) -> Arc<dyn Residual> {
    match names_a_block_twice(residual.as_ref()) {
        false => residual,
        true => Arc::new(Stacked::new(vec![residual], |id| builder.block(id).len())),
    }
}

/// Gain and offset of each joint's position sensor, as the problem starts.
pub(in crate::joint) fn positions(variables: &VariableIndex, builder: &ProblemBuilder) -> Vec<[f64; 2]> {
    let values = builder.initial();
    variables.sensors.iter().map(|[_, _, gain, offset]| [values.scalar(*gain), values.scalar(*offset)]).collect()
}

/// The same where all are fixed.
pub(in crate::joint) fn fixed_positions(variables: &VariableIndex, builder: &ProblemBuilder) -> Option<Vec<[f64; 2]>> {
    let fixed = |id: &BlockId| builder.block(*id).fixed.is_some();
    let all = variables.sensors.iter().all(|[_, _, gain, offset]| fixed(gain) && fixed(offset));
    all.then(|| positions(variables, builder))
}

/// What poses share: by load, first of poses with nothing attached.
struct Models<'s> {
    session: &'s Session,
    torques: Torques<'s>,
    /// Of each instrument, by its set of biases.
    instruments: Vec<Vec<Vec<Arc<AuxiliarySensorModel>>>>,
}

impl<'s> Models<'s> {
    /// `chain`: the session's, or one whose joints are elsewhere.
    fn new(
        session: &'s Session,
        variables: &'s VariableIndex,
        chain: Chain,
        positions: Option<Vec<[f64; 2]>>,
    ) -> Models<'s> {
        let chain = Arc::new(chain);
        let loads = (0..session.loads.len()).map(|load| carried(session, variables, load));
        let loads: Vec<Option<CarriedLoad>> = std::iter::once(None).chain(loads).collect();
        let instrument = |instrument: &AuxiliarySensor| {
            let model = |table: usize, load: &Option<CarriedLoad>| {
                Arc::new(instrument_model((session, variables), Arc::clone(&chain), (instrument, table), load.clone()))
            };
            (0..instrument.biases).map(|set| loads.iter().map(|load| model(set, load)).collect()).collect()
        };
        Models {
            session,
            instruments: session.instruments.iter().map(instrument).collect(),
            torques: Torques::new(session, variables, chain, positions),
        }
    }

    /// The residual of the readings of one pose, in the order of their channels. `length`: numbers that store a block.
    fn residual(&mut self, index: usize, used: &[usize], length: impl Fn(BlockId) -> usize) -> Arc<dyn Residual> {
        let (session, pose) = (self.session, &self.session.poses[index]);
        let load = pose.load.map_or(0, |load| load + 1);
        let value = |channel: usize| {
            session.reading(ReadingId { pose: index, channel }).map_or(f64::NAN, |reading| reading.value)
        };
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
                let reading = AuxiliarySensorReading::new(model, coordinates, pose.orientation, own);
                let reading = reading.with_terms(position_terms_in(session, pose, instrument.link)).drifting(drifts);
                parts.push(Arc::new(reading));
            }
        }
        if parts.len() == 1 { parts.remove(0) } else { Arc::new(Stacked::new(parts, length)) }
    }
}

/// The model of an instrument in a table.
fn instrument_model(
    (session, variables): (&Session, &VariableIndex),
    chain: Arc<Chain>,
    (instrument, table): (&AuxiliarySensor, usize),
    load: Option<CarriedLoad>,
) -> AuxiliarySensorModel {
    let own = &variables.further[instrument.own_parameters()];
    let sensed: Arc<dyn SensedQuantity> = match instrument.kind {
        AuxiliarySensorKind::ForceTorque => {
            let beyond = load.filter(|load| load.link == instrument.link);
            Arc::new(Wrench::new(&instrument.mounting, [own[0], own[1], own[2], own[3]], beyond))
        }
        AuxiliarySensorKind::Accelerometer => Arc::new(SpecificForce::new([own[0], own[1], own[2]])),
    };
    let gain = |((reading, sensed), block): (&(usize, usize), &BlockId)| GainEntry {
        reading: *reading,
        sensed: *sensed,
        block: *block,
    };
    let biases =
        [&variables.further[instrument.biases_of_table(table)], &variables.further[instrument.drift_parameters()]]
            .concat();
    let gains = instrument.gains.iter().zip(&variables.further[instrument.gain_parameters()]).map(gain);
    AuxiliarySensorModel::new(
        (chain, instrument.link),
        instrument.mounting.rotation(),
        sensed,
        (variables.gravity, &coordinate_blocks(session, variables, instrument.link)),
        (gains.collect(), &biases),
    )
}

/// Blocks on which the coordinates of the joints that move a link depend: position gain and offset of each, then the terms
/// of their position sensors.
fn coordinate_blocks(session: &Session, variables: &VariableIndex, link: usize) -> Vec<BlockId> {
    let affine =
        joints_moving(session, link).flat_map(|joint| [variables.sensors[joint][2], variables.sensors[joint][3]]);
    let terms = position_terms(session, link).flat_map(|term| variables.further[term.places.clone()].to_vec());
    affine.chain(terms).collect()
}

/// `s q + o` of each as `Σ coefficient · block` in one pose: joint, place among those blocks, coefficient.
fn coordinates(session: &Session, pose: usize, link: usize) -> Vec<(usize, usize, f64)> {
    let position = &session.poses[pose].position;
    let affine = joints_moving(session, link).flat_map(|joint| [(joint, position[joint]), (joint, 1.0)]);
    affine.enumerate().map(|(place, (joint, coefficient))| (joint, place, coefficient)).collect()
}

/// What position sensors of the same joints do beyond, in a pose: their parameters stand behind those.
fn position_terms_in(session: &Session, pose: &Pose, link: usize) -> PositionTerms {
    let affine = 2 * joints_moving(session, link).count();
    let terms = position_terms(session, link);
    PositionTerms::new(affine, terms, pose.position.clone(), pose.conditions.clone())
}

fn joints_moving(session: &Session, link: usize) -> impl Iterator<Item = usize> {
    (0..session.joints.len()).filter(move |joint| session.robot.chain.moves(*joint, link))
}
