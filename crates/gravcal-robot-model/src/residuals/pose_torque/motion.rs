//! All torque readings of a window of an arm in motion.
//!
//! ```text
//!     y_i = Σ_t h(t) k_i [τ_i(θ(t), θ̇(t), θ̈(t); g, links, load) + Ia_i θ̈_i(t)] + b_i,     θ = s q + o,  θ̇ = s q̇,  θ̈ = s q̈
//! ```
//!
//! `τ` is the chain's inverse dynamics (see `gravcal-dynamics`), `h` the weights of the window (see [`Course`]): the model goes through the
//! same window as the readings. Ten parameters a link: mass and first moment are those of the pose torque, the inertia tensor about the
//! link's origin is a block of its own. A load adds its mass, its moment, and a tensor of its own. A joint whose torque is its motor's may have
//! a rotor inertia `Ia`, a part of its torque (Khalil and Dombre, Modeling, Identification and Control of Robots, section 9.6). An arm that
//! stands reads its pose torque.
//!
//! Terms of torque sensors see the window's mean torque and coordinates, and conditions that are means over the window: exact for what is
//! linear in them (friction, drift, crosstalk), and for what is bent as far as they change little within a window. Terms of position sensors
//! have no place here; joints that bend are around it (see [`Displaced`](crate::residuals::Displaced)).

use std::cell::RefCell;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use gravcal_dynamics::{Chain, DynamicParameters};
use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use gravcal_recording::{Conditions, Course, MotionSample};

use super::means::{self, At, Means};
use super::model::{
    BODY, GRAVITY, INERTIA, LoadState, PoseTorqueModel, TENSOR, add, inertia_column, joined, sensor_column,
};
use super::regressors::Regressors;
use super::terms::Slopes;
use crate::parameter::SensorParameter;
use crate::sensors::Moment;

/// What all windows with the same load share.
///
/// Stored columns: those of the pose torque, then the tensor of each link, then that of the load, then the rotor inertias that there are.
#[derive(Debug)]
pub struct MotionTorqueModel {
    pose: Arc<PoseTorqueModel>,
    blocks: Vec<BlockId>,
    /// First stored column of the tensors.
    tensors: usize,
    /// Stored column of each joint's rotor inertia, where it has one.
    rotors: Vec<Option<usize>>,
    /// Stored columns that each joint's torque can touch.
    patterns: Vec<Vec<Range<usize>>>,
    /// Gain and offset of each joint's position sensor, where derivatives by them are not asked for.
    positions: Option<Vec<[f64; 2]>>,
}

impl MotionTorqueModel {
    /// `pose`: the model of static poses with the same load. `tensors`: `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` of each link about its
    /// origin, kg·m². `load`: that of the load, in the frame of the link that carries it. `rotors`: the rotor inertia of each joint that has
    /// one, kg·m² (kg where it slides); empty where none has.
    pub fn new(
        pose: Arc<PoseTorqueModel>,
        tensors: &[BlockId],
        load: Option<BlockId>,
        rotors: &[Option<BlockId>],
    ) -> Self {
        let bodies = pose.blocks.iter().chain(tensors).copied().chain(load);
        let blocks: Vec<BlockId> = bodies.chain(rotors.iter().flatten().copied()).collect();
        let first: usize = (0..pose.blocks.len()).map(|block| pose.stored_length(block)).sum();
        let chain = &pose.chain;
        let carrying = load.and(pose.load.as_ref()).map(|load| load.link);
        let before = first + TENSOR * (tensors.len() + usize::from(load.is_some()));
        let column = |joint: usize| {
            let there = rotors.get(joint).is_some_and(Option::is_some);
            there.then(|| before + rotors[..joint].iter().flatten().count())
        };
        let rotors: Vec<Option<usize>> = (0..chain.joint_count()).map(column).collect();
        let pattern = |joint: usize| {
            let links = (0..chain.link_count()).filter(|link| chain.moves(joint, *link));
            let load = carrying.filter(|link| chain.moves(joint, *link)).map(|_| chain.link_count());
            let columns = links.chain(load).map(|place| first + TENSOR * place..first + TENSOR * (place + 1));
            let rotor = rotors[joint].map(|column| column..column + 1);
            joined(pose.patterns[joint].iter().cloned().chain(columns).chain(rotor))
        };
        // A sensor that reads another joint's torque, too, feels what that joint moves.
        let felt = |joint: usize| match &pose.terms {
            None => pattern(joint),
            Some(terms) => union(std::iter::once(joint).chain(terms.torques(joint).iter().copied()).map(pattern)),
        };
        let patterns = (0..chain.joint_count()).map(felt).collect();
        MotionTorqueModel { blocks, tensors: first, rotors, patterns, pose, positions: None }
    }

    /// The same where derivatives by gain and offset of each joint's position sensor are not asked for; at these values of them a window's
    /// regressors are computed once.
    #[must_use]
    pub fn at_positions(self, positions: Option<Vec<[f64; 2]>>) -> Self {
        MotionTorqueModel { positions, ..self }
    }

    fn links(&self) -> usize {
        self.pose.chain.link_count()
    }
}

/// Ranges that hold what any of some patterns holds.
fn union(patterns: impl Iterator<Item = Vec<Range<usize>>>) -> Vec<Range<usize>> {
    let mut columns: Vec<usize> = patterns.flatten().flatten().collect();
    columns.sort_unstable();
    columns.dedup();
    joined(columns.into_iter().map(|column| column..column + 1))
}

/// The torque readings of one window.
#[derive(Clone, Debug)]
pub struct MotionTorque {
    model: Arc<MotionTorqueModel>,
    course: Arc<Course>,
    /// Joint and torque reading of each row.
    readings: Vec<(usize, f64)>,
    conditions: Conditions,
    /// Mean position reading of each joint, and mean acceleration of it.
    position: Vec<f64>,
    acceleration: Vec<f64>,
    /// Its regressors, where positions are known.
    regressors: OnceLock<Arc<Regressors>>,
}

/// What an evaluation computes on the way, kept by each thread from one window to the next.
struct Workspace {
    parameters: Vec<f64>,
    rotors: Vec<f64>,
    moments: means::Workspace,
    mean: Means,
    sensed: Vec<f64>,
    slopes: Slopes,
}

impl Workspace {
    fn new(chain: &Chain) -> Workspace {
        let (n, links) = (chain.joint_count(), chain.link_count());
        Workspace {
            parameters: vec![0.0; BODY * links],
            rotors: vec![0.0; n],
            moments: means::Workspace::new(chain),
            mean: Means::new(chain),
            sensed: vec![0.0; n],
            slopes: Slopes::default(),
        }
    }
}

/// The last workspace, and the chain that it was made for.
type Kept = Option<(Arc<Chain>, Workspace)>;

thread_local! {
    static WORKSPACE: RefCell<Kept> = const { RefCell::new(None) };
}

impl MotionTorque {
    /// `readings`: joint and mean torque reading over the window, one a row; `conditions`: means over the window.
    pub fn new(
        model: Arc<MotionTorqueModel>,
        course: Arc<Course>,
        readings: Vec<(usize, f64)>,
        conditions: Conditions,
    ) -> Self {
        let mean = |of: fn(&MotionSample) -> &[f64]| {
            let mut mean = vec![0.0; model.pose.chain.joint_count()];
            course.moments().for_each(|(weight, moment)| add(&mut mean, weight, of(moment)));
            mean
        };
        let (position, acceleration) = (mean(|sample| &sample.position), mean(|sample| &sample.acceleration));
        MotionTorque { model, course, readings, conditions, position, acceleration, regressors: OnceLock::new() }
    }

    fn joints(&self) -> usize {
        self.model.pose.chain.joint_count()
    }

    fn sensors<'x>(&self, x: &'x [f64], quantity: SensorParameter) -> &'x [f64] {
        let joints = self.joints();
        &x[sensor_column(joints, quantity, 0)..sensor_column(joints, quantity, joints)]
    }

    /// Ten numbers of each link, the load's included.
    fn set_parameters(&self, x: &[f64], parameters: &mut [f64]) {
        let links = self.model.links();
        let moments = inertia_column(self.joints(), 0);
        let (bodies, _) = parameters.as_chunks_mut::<BODY>();
        for (link, body) in bodies.iter_mut().enumerate() {
            let (moments, tensors) = (moments + INERTIA * link, self.model.tensors + TENSOR * link);
            body[..INERTIA].copy_from_slice(&x[moments..moments + INERTIA]);
            body[INERTIA..].copy_from_slice(&x[tensors..tensors + TENSOR]);
        }
        let Some(load) = &self.model.pose.load else { return };
        let carried = &mut bodies[load.link];
        let LoadState { mass, position } = load.at(&x[moments + INERTIA * links..]);
        carried[0] += mass;
        add(&mut carried[1..INERTIA], mass, &position);
        add(&mut carried[INERTIA..], 1.0, &x[self.model.tensors + TENSOR * links..]);
    }

    /// `Ia θ̈`, a part of the torque; linear in the acceleration, so that its mean is that of the mean acceleration.
    fn add_rotors(&self, x: &[f64], mean: &mut Means) {
        let (n, gains) = (self.joints(), self.sensors(x, SensorParameter::PositionGain));
        for (joint, column) in self.model.rotors.iter().enumerate() {
            let Some(column) = column else { continue };
            mean.torque[joint] += x[*column] * gains[joint] * self.acceleration[joint];
            mean.by_position_gains[n * joint + joint] += x[*column] * self.acceleration[joint];
        }
    }

    fn evaluate_in(&self, workspace: &mut Workspace, x: &[f64], residual: &mut [f64], jacobian: Option<RowsMut<'_>>) {
        let Workspace { parameters, rotors, moments, mean, sensed, slopes } = workspace;
        let chain = &self.model.pose.chain;
        let gravity = [x[0], x[1], x[2]];
        let (gains, offsets) =
            (self.sensors(x, SensorParameter::PositionGain), self.sensors(x, SensorParameter::PositionOffset));
        self.set_parameters(x, parameters);
        mean.clear();
        // What terms take for the coordinates.
        for (joint, sensed) in sensed.iter_mut().enumerate() {
            *sensed = gains[joint] * self.position[joint] + offsets[joint];
        }
        if let Some(regressors) = self.regressors(gains, offsets) {
            regressors.evaluate(gravity, parameters, &self.model.pose.links, mean);
            self.add_rotors(x, mean);
            return self.finish(x, (mean, sensed), slopes, residual, jacobian);
        }
        let at = At {
            chain,
            course: &self.course,
            gains,
            offsets,
            gravity,
            inertia: DynamicParameters { links: parameters, rotor_inertia: rotors },
            felt: &self.model.pose.links,
            derivatives: jacobian.is_some(),
        };
        moments.add(&at, mean);
        self.add_rotors(x, mean);
        self.finish(x, (mean, sensed), slopes, residual, jacobian);
    }

    /// Those for these gains and offsets of positions, where they are the ones at which regressors are kept.
    fn regressors(&self, gains: &[f64], offsets: &[f64]) -> Option<&Regressors> {
        let held = self.model.positions.as_ref()?;
        let same = held.iter().zip(gains).zip(offsets).all(|(([s, o], gain), offset)| s == gain && o == offset);
        same.then(|| &**self.regressors.get_or_init(|| Regressors::kept(&self.model.pose.chain, &self.course, held)))
    }

    /// From mean torques and coordinates to readings.
    fn finish(
        &self,
        x: &[f64],
        (mean, sensed): (&Means, &[f64]),
        slopes: &mut Slopes,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) {
        let (gain, bias) = (self.sensors(x, SensorParameter::TorqueGain), self.sensors(x, SensorParameter::TorqueBias));
        let terms = self.model.pose.terms.as_ref();
        let at = Moment::new(&mean.torque, sensed, &self.position, &self.conditions);
        for (residual, (joint, reading)) in residual.iter_mut().zip(&self.readings) {
            let by_terms = terms.map_or(0.0, |terms| terms.reading(*joint, &at, x, None));
            *residual = gain[*joint] * mean.torque[*joint] + bias[*joint] + by_terms - reading;
        }
        let Some(mut rows) = jacobian else { return };
        terms.iter().for_each(|terms| terms.fit(slopes));
        for (row, (joint, _)) in self.readings.iter().enumerate() {
            self.fill_row(*joint, x, (mean, &at), slopes, rows.row(row));
        }
    }

    /// `∂y_i/∂x = Σ_j (∂y_i/∂τ_j) ∂τ_j/∂x`, and what the sensor adds by itself.
    fn fill_row(
        &self,
        joint: usize,
        x: &[f64],
        (mean, at): (&Means, &Moment<'_>),
        slopes: &mut Slopes,
        row: &mut [f64],
    ) {
        let n = self.joints();
        row.fill(0.0);
        let gain = x[sensor_column(n, SensorParameter::TorqueGain, joint)];
        self.add_torque(gain, joint, x, mean, row);
        row[sensor_column(n, SensorParameter::TorqueGain, joint)] = mean.torque[joint];
        row[sensor_column(n, SensorParameter::TorqueBias, joint)] = 1.0;
        let Some(terms) = &self.model.pose.terms else { return };
        terms.reading(joint, at, x, Some(slopes));
        for source in terms.torques(joint) {
            self.add_torque(slopes.by_torque[*source], *source, x, mean, row);
        }
        for source in terms.coordinates(joint) {
            row[sensor_column(n, SensorParameter::PositionGain, *source)] +=
                slopes.by_coordinate[*source] * self.position[*source];
            row[sensor_column(n, SensorParameter::PositionOffset, *source)] += slopes.by_coordinate[*source];
        }
        for place in terms.of_torque(joint).flat_map(|term| term.places.clone()) {
            row[terms.column + place] = slopes.by_parameter[place];
        }
    }

    /// Adds a joint's torque, so many times, to a row.
    fn add_torque(&self, times: f64, joint: usize, x: &[f64], mean: &Means, row: &mut [f64]) {
        let (n, links) = (self.joints(), self.model.links());
        add(&mut row[..GRAVITY], times, &mean.by_gravity[GRAVITY * joint..GRAVITY * (joint + 1)]);
        if self.model.positions.is_none() {
            let own = n * joint..n * (joint + 1);
            let at = |quantity| sensor_column(n, quantity, 0)..sensor_column(n, quantity, n);
            add(&mut row[at(SensorParameter::PositionGain)], times, &mean.by_position_gains[own.clone()]);
            add(&mut row[at(SensorParameter::PositionOffset)], times, &mean.by_offsets[own]);
        }
        let (by_bodies, _) = mean.by_parameters[BODY * links * joint..BODY * links * (joint + 1)].as_chunks::<BODY>();
        let moments = inertia_column(n, 0);
        for link in self.model.pose.links[joint].clone() {
            let (own, tensors) = (moments + INERTIA * link, self.model.tensors + TENSOR * link);
            add(&mut row[own..own + INERTIA], times, &by_bodies[link][..INERTIA]);
            add(&mut row[tensors..tensors + TENSOR], times, &by_bodies[link][INERTIA..]);
        }
        if let Some(column) = self.model.rotors[joint] {
            let gain = self.sensors(x, SensorParameter::PositionGain)[joint];
            row[column] += times * gain * self.acceleration[joint];
        }
        let Some(load) = &self.model.pose.load else { return };
        let (by_carrying, column) = (&by_bodies[load.link], moments + INERTIA * links);
        let LoadState { mass, position } = load.at(&x[column..]);
        let (parts, by_mass) = row[column..column + load.columns()].split_at_mut(load.position_columns());
        for part in parts.as_chunks_mut::<3>().0 {
            add(part, times * mass, &by_carrying[1..INERTIA]);
        }
        for entry in by_mass {
            let by_moment = position.iter().zip(&by_carrying[1..INERTIA]).map(|(r, by)| r * by).sum::<f64>();
            *entry += times * (by_carrying[0] + by_moment);
        }
        let tensor = self.model.tensors + TENSOR * links;
        add(&mut row[tensor..tensor + TENSOR], times, &by_carrying[INERTIA..]);
    }
}

impl Residual for MotionTorque {
    fn blocks(&self) -> &[BlockId] {
        &self.model.blocks
    }

    fn len(&self) -> usize {
        self.readings.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.model.patterns[self.readings[row].0])
    }

    fn work(&self) -> usize {
        self.course.moments().count()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        WORKSPACE.with_borrow_mut(|kept| {
            let chain = &self.model.pose.chain;
            if !kept.as_ref().is_some_and(|(of, _)| Arc::ptr_eq(of, chain)) {
                *kept = Some((Arc::clone(chain), Workspace::new(chain)));
            }
            if let Some((_, workspace)) = kept {
                self.evaluate_in(workspace, x.as_slice(), residual, jacobian);
            }
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests;
