//! The torque readings of each pose as a residual, in the description of the moments that the session chooses.

use std::collections::HashMap;
use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::{BlockId, Residual};
use gravcal_robot_model::residuals::{
    CarriedLoad, LoadMass, MotionTorque, MotionTorqueModel, PoseTorque, PoseTorqueBlocks, PoseTorqueModel, SweepTorque,
    SweepTorqueModel,
};
use gravcal_robot_model::session::{Pose, Session};

use crate::joint::building::sweep_moments::{SweepMoments, by_sweep};
use crate::joint::variables::{VariableIndex, WithPayload};

/// What the poses of a session have in common.
pub(in crate::joint) struct Torques<'a> {
    variables: &'a VariableIndex,
    chain: Arc<Chain>,
    /// Where moments are described by sweep.
    moments: Option<SweepMoments>,
    /// By moments and load.
    by_sweep: HashMap<(Vec<usize>, Option<usize>), Arc<SweepTorqueModel>>,
    /// With nothing attached, then by load.
    by_link: Vec<Option<Arc<PoseTorqueModel>>>,
    /// The same in motion.
    in_motion: Vec<Option<Arc<MotionTorqueModel>>>,
    /// Gain and offset of each joint's position sensor, where derivatives by them are not asked for.
    positions: Option<Vec<[f64; 2]>>,
}

impl<'a> Torques<'a> {
    /// `chain`: the session's, or one of other lengths. `positions`: gain and offset of each joint's position sensor, where derivatives by them are
    /// not asked for.
    pub fn new(
        session: &Session,
        variables: &'a VariableIndex,
        chain: Arc<Chain>,
        positions: Option<Vec<[f64; 2]>>,
    ) -> Self {
        let moments = by_sweep(session).then(|| SweepMoments::of(session));
        let chain = if moments.is_some() { Arc::new(chain.without_lengths()) } else { chain };
        Torques {
            variables,
            chain,
            moments,
            by_sweep: HashMap::new(),
            by_link: vec![None; 1 + session.loads.len()],
            in_motion: vec![None; 1 + session.loads.len()],
            positions,
        }
    }

    /// The readings `(joint, torque)` of a pose.
    ///
    /// # Panics
    /// Where moments are described by sweep, of a pose that belongs to none: its readings are not selected.
    pub fn residual(&mut self, session: &Session, pose: usize, readings: Vec<(usize, f64)>) -> Arc<dyn Residual> {
        let Pose { load, ref position, ref conditions, ref course, .. } = session.poses[pose];
        let of = |model: &Arc<PoseTorqueModel>, readings: Vec<(usize, f64)>| {
            PoseTorque::new(Arc::clone(model), position.clone(), readings).under(conditions.clone())
        };
        let (variables, chain) = (self.variables, &self.chain);
        let model = |inertia: Vec<BlockId>| {
            let blocks = PoseTorqueBlocks {
                gravity: variables.gravity,
                sensors: variables.sensors.clone(),
                inertia,
                terms: variables.further[..session.terms.len()].to_vec(),
                compliance: variables.further[session.compliances()].to_vec(),
            };
            let carried = load.and_then(|load| carried(session, variables, load));
            Arc::new(PoseTorqueModel::new(Arc::clone(chain), &blocks, &session.terms, carried))
        };
        let Some(moments) = &self.moments else {
            let own = &mut self.by_link[load.map_or(0, |load| load + 1)];
            let with = load.and_then(|load| Some((session.loads[load].link, variables.with_payloads[load]?)));
            let own =
                own.get_or_insert_with(|| model(with_payload(&variables.inertia, with, |with| Some(with.moments))));
            let Some(course) = course else { return Arc::new(of(own, readings)) };
            let (links, loads) = variables.tensors.split_at(chain.link_count());
            let positions = &self.positions;
            let moving = || {
                let links = with_payload(links, with, |with| with.tensor);
                let load = load.filter(|_| with.is_none()).map(|load| loads[load]);
                let rotors: Vec<Option<BlockId>> =
                    session.rotors.iter().map(|place| place.map(|place| variables.further[place])).collect();
                let model = MotionTorqueModel::new(Arc::clone(own), &links, load, &rotors);
                Arc::new(model.at_positions(positions.clone()))
            };
            let moving = self.in_motion[load.map_or(0, |load| load + 1)].get_or_insert_with(moving);
            return Arc::new(MotionTorque::new(Arc::clone(moving), Arc::clone(course), readings, conditions.clone()));
        };
        let own = moments.of_pose(pose).expect("only poses of sweeps are selected").to_vec();
        let inertia = own.iter().map(|moment| variables.sweep_moments[*moment]).collect();
        let model = self.by_sweep.entry((own, load)).or_insert_with(|| Arc::new(SweepTorqueModel::new(model(inertia))));
        Arc::new(SweepTorque::new(Arc::clone(model), of(model.pose(), readings)))
    }
}

/// The links' blocks, that of the link which carries an unknown load replaced by the one of both together.
fn with_payload(
    links: &[BlockId],
    with: Option<(usize, WithPayload)>,
    block: impl Fn(&WithPayload) -> Option<BlockId>,
) -> Vec<BlockId> {
    let mut links = links.to_vec();
    if let Some((link, block)) = with.and_then(|(link, with)| Some((link, block(&with)?))) {
        links[link] = block;
    }
    links
}

/// A load that was placed, as poses carry it.
pub(in crate::joint) fn carried(session: &Session, variables: &VariableIndex, load: usize) -> Option<CarriedLoad> {
    let position = variables.loads[load].clone()?;
    let mass = match session.load_mass(load) {
        Some(id) => LoadMass::Unknown(variables.block(id)),
        None => LoadMass::Known(session.loads[load].mass),
    };
    Some(CarriedLoad { position, mass, link: session.loads[load].link })
}
