//! Step 3: torque gain and position offset of one joint from two placements of a load (paper, section 2.3).

use gravcal_estimation::{Block, Factor, Manifold, Noise, ProblemBuilder};
use nalgebra::{Matrix3, Vector3};

use super::bias::readings_of;
use super::fitting::StepFit;
use super::found::{Found, Frozen, Missing};
use super::plan::{LoadPair, Plan};
use super::{Gravity, SequentialValues};
use crate::axis_frames::AxisFrames;
use crate::closed_form::{PositionDifference, fit_sinusoid, gain_and_offset, gain_at_known_offset};
use crate::joint::Readings;
use crate::parameter::Quantity;
use crate::residuals::{LoadDifference, LoadDifferenceBlocks};
use crate::session::Session;
use crate::workbench::Workbench;

/// What step 3 finds for one joint.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Torque gain.
    pub torque_gain: Found,
    /// Position offset.
    pub position_offset: Found,
    /// Solver iterations.
    pub iterations: usize,
}

/// The difference between two placements at one position of the observed joint.
struct Difference {
    /// Mean position readings up to the observed joint.
    position: Vec<f64>,
    /// `(a, c, e)`, unit of the torque reading.
    coefficients: Vector3<f64>,
    covariance: Matrix3<f64>,
}

/// Finds gain and offset of `joint`, with everything before it frozen in `known`.
pub(super) fn find_gain(
    session: &Session,
    plan: &Plan,
    readings: &Readings,
    known: &SequentialValues,
    joint: usize,
    workbench: &Workbench<'_>,
) -> Gain {
    match fit(session, plan, readings, known, joint, workbench) {
        Ok(gain) => gain,
        Err(missing) => {
            let position_offset = match known_offset(session, joint) {
                Some(value) => Ok(Frozen { value, std: 0.0 }),
                None => Err(missing.clone()),
            };
            Gain { torque_gain: Err(missing), position_offset, iterations: 0 }
        }
    }
}

/// The offset where it is no unknown: the first joint's by definition, or one given as exact.
fn known_offset(session: &Session, joint: usize) -> Option<f64> {
    session
        .held_reason(joint, Quantity::PositionOffset)
        .map(|_| session.joints[joint].of(Quantity::PositionOffset).nominal)
}

fn fit(
    session: &Session,
    plan: &Plan,
    readings: &Readings,
    known: &SequentialValues,
    joint: usize,
    workbench: &Workbench<'_>,
) -> Result<Gain, Missing> {
    let joints = session.robot.chain.joints();
    let Some(next) = joints.get(joint + 1) else {
        return Err(Missing::new(
            "the sequential procedure cannot reach the last joint: it reads a joint while the next one sweeps",
            "use the joint estimator, which reads every torque",
        ));
    };
    let name = &joints[joint].name;
    let cure = format!(
        "sweep {} with a load at two placements a known distance apart, at two positions of {name} that are neither \
         equal nor 180° apart, and read the torque of {name}",
        next.name
    );
    let missing = |why: String| Missing::new(why, cure.clone());
    let gravity = known.gravity.as_ref().map_err(|_| missing(format!("step 3 of {name} needs gravity from step 2")))?;
    let upstream = upstream_sensors(session, known, joint).map_err(missing)?;
    let next_gain = known.sensors[joint + 1]
        .position_gain
        .as_ref()
        .map(|f| f.value)
        .map_err(|_| missing(format!("step 3 of {name} needs {}.position_gain from step 1", next.name)))?;
    let pairs = first_distance(&plan.gain[joint]);
    let offset = known_offset(session, joint);
    if pairs.len() < if offset.is_some() { 1 } else { 2 } {
        return Err(missing(format!(
            "step 3 found {} position(s) of {name} at which {} sweeps with both placements",
            pairs.len(),
            next.name
        )));
    }
    let distance = &session.load_distances[pairs[0].distance];
    let mass = session.loads[distance.between[0]].mass;
    let differences: Vec<Difference> =
        pairs.iter().filter_map(|pair| difference(session, plan, readings, pair, joint, next_gain)).collect();

    let task = Task { session, gravity, upstream: &upstream, joint, offset };
    let (displacement, start_offset) =
        task.closed_form(&differences).ok_or_else(|| missing(format!("the positions of {name} determine no gain")))?;
    let sign = session.joints[joint].of(Quantity::TorqueGain).nominal.signum();
    let start_gain = sign * displacement.norm() / (mass * distance.distance);
    if !(start_gain.is_finite() && start_gain != 0.0) {
        return Err(missing(format!("moving the load does not change the torque of {name}")));
    }
    let direction = displacement * (distance.distance * sign / displacement.norm());

    let mut builder = ProblemBuilder::new();
    let frozen = "found by an earlier step";
    let gravity_id =
        builder.add_block(Block::vector("gravity", "m/s²", &["x", "y", "z"]).held(frozen), &gravity.vector);
    let positions: Vec<[_; 2]> = (0..=joint)
        .map(|l| {
            let gain = builder.add_block(Block::scalar(format!("{l}.gain"), "").held(frozen), &[upstream[l].0]);
            let value = if l == joint { start_offset } else { upstream[l].1 };
            let block = Block::scalar(format!("{}.position_offset", joints[l].name), "rad");
            let block = if l < joint || offset.is_some() { block.held(frozen) } else { block };
            [gain, builder.add_block(block, &[value])]
        })
        .collect();
    let torque_gain = builder.add_block(Block::scalar(format!("{name}.torque_gain"), ""), &[start_gain]);
    let on_sphere =
        Block::vector("displacement", "m", &["x", "y", "z"]).on(Manifold::Sphere { radius: distance.distance });
    let displacement_id = builder.add_block(on_sphere, direction.as_slice());
    let position_offset = positions[joint][1];
    let blocks = LoadDifferenceBlocks { gravity: gravity_id, positions, torque_gain, displacement: displacement_id };
    let rotations = session.robot.chain.axis_rotations();
    for d in &differences {
        let noise = Noise::correlated(d.covariance.transpose().as_slice(), 3).map_err(|e| missing(e.to_string()))?;
        let residual = LoadDifference::new(&rotations, &blocks, mass, d.position.clone(), d.coefficients.into());
        builder.add_factor(Factor::new(residual, noise));
    }
    let fitted = StepFit::solve(builder, workbench, &cure)?;
    Ok(Gain {
        torque_gain: fitted.frozen(torque_gain, 0.1 * start_gain.abs(), &cure),
        position_offset: match offset {
            Some(value) => Ok(Frozen { value, std: 0.0 }),
            None => fitted.frozen(position_offset, 0.1, &cure),
        },
        iterations: fitted.estimate.iterations.len() - 1,
    })
}

/// `(s, o)` of the joints up to the observed one (whose own offset is still the nominal one).
fn upstream_sensors(session: &Session, known: &SequentialValues, joint: usize) -> Result<Vec<(f64, f64)>, String> {
    (0..=joint)
        .map(|l| {
            let name = &session.robot.chain.joints()[l].name;
            let needs = |what: Quantity| format!("step 3 needs {}, which was not found", what.name(name));
            let gain = known.sensors[l].position_gain.as_ref().map_err(|_| needs(Quantity::PositionGain))?;
            let offset = if l == joint {
                session.joints[l].of(Quantity::PositionOffset).nominal
            } else {
                known.sensors[l].position_offset.as_ref().map_err(|_| needs(Quantity::PositionOffset))?.value
            };
            Ok((gain.value, offset))
        })
        .collect()
}

/// The pairs of the first known distance that has any.
fn first_distance(pairs: &[LoadPair]) -> Vec<LoadPair> {
    pairs.iter().filter(|pair| pair.distance == pairs[0].distance).copied().collect()
}

/// Second placement's fitted sinusoid less the first's, eqs. (17), (18).
fn difference(
    session: &Session,
    plan: &Plan,
    readings: &Readings,
    pair: &LoadPair,
    joint: usize,
    next_gain: f64,
) -> Option<Difference> {
    let fit = |sweep: usize| {
        let rows = readings_of(session, &plan.sweeps[sweep].poses, joint + 1, joint);
        let pairs: Vec<(f64, f64)> = rows.iter().map(|(_, r)| *r).collect();
        let fit = fit_sinusoid(&pairs, next_gain, None)?;
        let variance =
            rows.iter().map(|(p, _)| readings.std(session, *p, joint).powi(2)).sum::<f64>() / rows.len() as f64;
        Some((fit.coefficients, variance * fit.unit_covariance))
    };
    let [(first, first_covariance), (second, second_covariance)] = [fit(pair.sweeps[0])?, fit(pair.sweeps[1])?];
    let poses: Vec<usize> = pair.sweeps.iter().flat_map(|s| plan.sweeps[*s].poses.iter().copied()).collect();
    let mean = |l: usize| poses.iter().map(|p| session.poses[*p].position[l]).sum::<f64>() / poses.len() as f64;
    Some(Difference {
        position: (0..=joint).map(mean).collect(),
        coefficients: second - first,
        covariance: first_covariance + second_covariance,
    })
}

/// What the closed form needs to know.
struct Task<'a> {
    session: &'a Session,
    gravity: &'a Gravity,
    upstream: &'a [(f64, f64)],
    joint: usize,
    offset: Option<f64>,
}

impl Task<'_> {
    /// `D` (unit of the reading per m/s²) and the offset.
    fn closed_form(&self, differences: &[Difference]) -> Option<(Vector3<f64>, f64)> {
        let frames = AxisFrames::new(&self.session.robot.chain.axis_rotations());
        let positions: Vec<PositionDifference> = differences
            .iter()
            .map(|d| {
                let coordinate = |l: usize| self.upstream[l].0 * d.position[l] + self.upstream[l].1;
                let before: Vec<f64> = (0..self.joint).map(coordinate).collect();
                let g = frames.gravity(&self.gravity.vector, &before).value;
                PositionDifference {
                    coordinate: self.upstream[self.joint].0 * d.position[self.joint],
                    gravity_angle: g.y.atan2(g.x),
                    gravity_across: g.x.hypot(g.y),
                    difference: d.coefficients,
                }
            })
            .collect();
        let to_next = frames.to_next(self.joint);
        match self.offset {
            Some(offset) => Some((gain_at_known_offset(&positions, to_next, offset)?, offset)),
            None => gain_and_offset(&positions, to_next, self.upstream[self.joint].1),
        }
    }
}
