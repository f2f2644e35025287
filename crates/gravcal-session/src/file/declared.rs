//! What `session.toml` says, before any table is opened.

use std::path::Path;

use gravcal_estimation::Loss;
use gravcal_recording::{Memory, PoseMapping};
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::{Parameter, SensorParameter};
use gravcal_robot_model::residual_models::ResidualInUse;
use gravcal_robot_model::sensors::SensorTerms;
use gravcal_robot_model::session::{
    Ask, AuxiliarySensor, Constraints, Deflection, GravityPrior, InertiaPrior, JointPriors, Load, LoadDistance,
    PoseTable, PriorKind, Session,
};

use super::context::{Context, SessionError};
use super::poses::{ReadPoses, WrittenTables};
use super::readings::ReadingsTable;
use super::recordings::{InMotion, Recordings};
use super::session_table::SessionTable;
use super::{
    ask, base_frame, constraints, deflection, gravity, inertia, instruments, joints, loads, loss, models, motion,
    poses, readings, residuals, rotors, still, sweeps, unexplained,
};
use crate::document::FileError;

/// Who is told which recording is read, and which share of it is.
pub(super) type Watch<'w> = &'w dyn Fn(&Path, f64);

/// What `session.toml` says, before any table is opened.
pub(super) struct Declared {
    gravity: GravityPrior,
    pub inertia: InertiaPrior,
    length_std: Option<f64>,
    axis_std: Option<f64>,
    joints: Vec<JointPriors>,
    instruments: Vec<AuxiliarySensor>,
    terms: SensorTerms,
    residuals: Vec<ResidualInUse>,
    further: Vec<Parameter>,
    rotors: Vec<Option<usize>>,
    load_masses: Vec<Option<usize>>,
    mapping: PoseMapping,
    pub motion: InMotion,
    pub unexplained: Vec<Option<unexplained::Said>>,
    pub loads: Vec<Load>,
    load_distances: Vec<LoadDistance>,
    deflection: Deflection,
    loss: Loss,
    constraints: Constraints,
    ask: Ask,
}

impl Declared {
    pub fn resolve(context: &Context<'_>, registry: &Registry, written: &SessionTable) -> Result<Declared, FileError> {
        let document = context.document;
        let gravity = gravity::resolve(document, &written.gravity)?;
        let inertia = inertia::resolve(context, &written.inertia)?;
        let length_std = inertia::length_std(document, &written.inertia)?;
        let axis_std = inertia::axis_std(document, &written.inertia)?;
        let (wrists, accelerometers) = (&written.force_torque_sensor, &written.accelerometer);
        let instruments = instruments::resolve(context, wrists, accelerometers, written.poses.len())?;
        let mut mapping = readings::mapping(context, &written.readings, &instruments)?;
        let unexplained =
            [readings::unexplained(context, &written.readings)?, instruments.unexplained.clone()].concat();
        let said = joints::said(context, &written.joint, written.joints.as_ref())?;
        let joints = joints::resolve(context, &mapping, &said)?;
        for (position, joint) in mapping.positions.iter_mut().zip(&joints) {
            position.nominal_gain = joint.of(SensorParameter::PositionGain).nominal;
        }
        let mut motion = in_motion(context, &written.readings, &mapping, &joints)?;
        let (terms, mut further) = models::resolve(context, registry, &mapping, &motion, &joints, &said)?;
        motion::follow_friction(&mut motion, terms.with_friction());
        let instruments = instruments.behind(&mut further);
        instruments::check_conditions(document, &instruments, &mapping, motion.is_any())?;
        let observed = (&mut mapping, &mut further);
        let residuals = residuals::resolve(context, registry, &written.residual, &instruments, observed)?;
        residuals::check_recordings(document, &residuals, &mapping, motion.is_any())?;
        refuse_prior_on_base_frame(context, &joints, &said)?;
        let loads = loads::resolve(context, &written.load)?;
        Ok(Declared {
            load_distances: loads::resolve_distances(document, &loads, &written.load_distance)?,
            deflection: deflection::resolve(context, &written.deflection, &written.readings, &mut further)?,
            rotors: rotors::resolve(context, &said, (&joints, motion.windows.is_some()), &mut further)?,
            load_masses: loads::masses(context, &written.load, &loads, &mut further)?,
            loss: loss::resolve(context, written.loss.as_ref())?,
            constraints: constraints::resolve(context, &written.constraints)?,
            ask: ask::resolve(context, &joints, &further, &written.ask)?,
            gravity,
            inertia,
            length_std,
            axis_std,
            joints,
            instruments,
            terms,
            residuals,
            further,
            mapping,
            motion,
            unexplained,
            loads,
        })
    }

    /// Whether rows have a time.
    pub fn has_clock(&self) -> bool {
        self.motion.is_any() || self.mapping.conditions.time.is_some()
    }

    /// All poses of all tables, what instruments read in their own frames.
    pub fn read_poses(
        &self,
        context: &Context<'_>,
        (memory, watch): (&Memory, Watch<'_>),
        written: WrittenTables<'_>,
        tables: &mut [PoseTable],
    ) -> Result<ReadPoses, SessionError> {
        let (document, loads) = (context.document, &self.loads);
        let mut read = if self.motion.is_any() {
            let (chain, joints, terms) = (&context.robot.chain, &self.joints[..], &self.terms);
            let recordings = Recordings { document, memory, written, chain, joints, loads, terms, watch };
            recordings.read(tables, &self.mapping, &self.motion)?
        } else {
            poses::read_all(document, memory, written, tables, &self.mapping)?
        };
        for wrist in self.instruments.iter().filter(|instrument| instrument.in_base) {
            base_frame::turn_back(context.robot, &self.joints, wrist, &mut read.poses);
        }
        Ok(read)
    }

    /// The session without what comes of its tables.
    pub fn session(self, context: &Context<'_>, written: &SessionTable) -> Session {
        Session {
            inertia: self.inertia,
            length_std: self.length_std,
            axis_std: self.axis_std,
            loads: self.loads,
            load_distances: self.load_distances,
            instruments: self.instruments,
            terms: self.terms,
            residuals: self.residuals,
            further: self.further,
            rotors: self.rotors,
            load_masses: self.load_masses,
            readings: self.mapping,
            deflection: self.deflection,
            loss: self.loss,
            constraints: self.constraints,
            ask: self.ask,
            estimators: written.estimators.clone(),
            solver: written.solver.clone().map(|solver| solver.choice(context.document)),
            ..Session::new(context.robot.clone(), self.gravity, self.joints)
        }
    }
}

/// What of recordings in motion counts.
fn in_motion(
    context: &Context<'_>,
    written: &ReadingsTable,
    mapping: &PoseMapping,
    joints: &[JointPriors],
) -> Result<InMotion, FileError> {
    let still = written.still.as_ref().map(|still| still::resolve(context, still, mapping)).transpose()?;
    let sweeps = written.sweeps.as_ref();
    let sweeps = sweeps.map(|sweeps| sweeps::resolve(context, sweeps, mapping, joints)).transpose()?;
    let windows = written.motion.as_ref();
    let windows = windows.map(|windows| motion::resolve(context, windows, mapping, joints)).transpose()?;
    let motion = InMotion { still, sweeps, windows };
    motion::check_beside(context, &motion)?;
    Ok(motion)
}

/// The offset of the joint on which all others hang defines the base frame: it has a value, but it cannot be uncertain.
fn refuse_prior_on_base_frame(
    context: &Context<'_>,
    joints: &[JointPriors],
    said: &[joints::Said<'_>],
) -> Result<(), FileError> {
    let Some(root) = context.robot.chain.root_joint() else { return Ok(()) };
    let PriorKind::Gaussian { .. } = joints[root].of(SensorParameter::PositionOffset).kind else { return Ok(()) };
    let Some(entry) = said[root].of(SensorParameter::PositionOffset) else { return Ok(()) };
    let message = match entry.of_all {
        false => {
            "the first joint's offset defines the base frame, so it cannot be uncertain: leave std away".to_owned()
        }
        true => format!(
            "the first joint's offset defines the base frame, so it cannot be uncertain: add [[joint]] name = \"{}\", \
             position_offset = {{ nominal = 0, unit = \"rad\" }}",
            context.joint_names[root]
        ),
    };
    Err(context.document.error(&entry.field.key("std"), message))
}
