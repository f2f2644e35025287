//! Step 3: torque gain and position offset of one joint from two placements of a load (paper, section 2.3).

use gravcal_estimation::{Block, BlockId, Factor, Manifold, Noise, ProblemBuilder};
use nalgebra::{Matrix3, Vector3};

use super::bias::readings_of;
use super::fitting::StepFit;
use super::found::{Found, Frozen, Missing};
use super::plan::{LoadPair, Plan};
use super::{Gravity, SequentialValues};
use crate::axis_frames::AxisFrames;
use crate::closed_form::{PositionDifference, fit_sinusoid, gain_and_offset, gain_at_known_offset};
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
    known: &SequentialValues,
    joint: usize,
    workbench: &Workbench<'_>,
) -> Gain {
    let step = Step { session, plan, known, joint };
    step.run(workbench).unwrap_or_else(|missing| Gain {
        position_offset: match step.known_offset() {
            Some(value) => Ok(Frozen { value, std: 0.0 }),
            None => Err(missing.clone()),
        },
        torque_gain: Err(missing),
        iterations: 0,
    })
}

/// What the step looks at.
struct Step<'a> {
    session: &'a Session,
    plan: &'a Plan,
    known: &'a SequentialValues,
    joint: usize,
}

/// What the step reads and takes as given.
struct Given<'a> {
    gravity: &'a Gravity,
    /// `(s, o)` of the joints up to the observed one, whose own offset is still the nominal one.
    upstream: Vec<(f64, f64)>,
    differences: Vec<Difference>,
    /// kg, m.
    mass: f64,
    distance: f64,
}

/// Where the fit starts.
struct Start {
    torque_gain: f64,
    offset: f64,
    /// Of the known length, m.
    displacement: Vector3<f64>,
}

impl Step<'_> {
    fn run(&self, workbench: &Workbench<'_>) -> Result<Gain, Missing> {
        let given = self.given()?;
        let start = self.closed_form(&given)?;
        self.fit(&given, &start, workbench)
    }

    fn name(&self, joint: usize) -> &str {
        &self.session.robot.chain.joints()[joint].name
    }

    fn missing(&self, why: String) -> Missing {
        let (name, next) = (self.name(self.joint), self.name(self.joint + 1));
        let cure = format!(
            "sweep {next} with a load at two placements a known distance apart, at two positions of {name} that are \
             neither equal nor 180° apart, and read the torque of {name}"
        );
        Missing::new(why, cure)
    }

    /// The offset where it is no unknown: the first joint's by definition, or one given as exact.
    fn known_offset(&self) -> Option<f64> {
        let held = self.session.held_reason(self.joint, Quantity::PositionOffset);
        held.map(|_| self.session.joints[self.joint].of(Quantity::PositionOffset).nominal)
    }

    fn given(&self) -> Result<Given<'_>, Missing> {
        if self.joint + 1 == self.session.joints.len() {
            return Err(Missing::new(
                "the sequential procedure cannot reach the last joint: it reads a joint while the next one sweeps",
                "use the joint estimator, which reads every torque",
            ));
        }
        let (name, next) = (self.name(self.joint), self.name(self.joint + 1));
        let needs = |what: String, step: u8| self.missing(format!("step 3 of {name} needs {what} from step {step}"));
        let gravity = self.known.gravity.as_ref().map_err(|_| needs("gravity".into(), 2))?;
        let upstream = self.upstream()?;
        let next_gain = self.known.sensors[self.joint + 1].position_gain.as_ref();
        let next_gain = next_gain.map_err(|_| needs(Quantity::PositionGain.name(next), 1))?.value;
        let pairs = first_distance(&self.plan.gain[self.joint]);
        let needed = if self.known_offset().is_some() { 1 } else { 2 };
        if pairs.len() < needed {
            let found = pairs.len();
            return Err(self.missing(format!(
                "step 3 found {found} position(s) of {name} at which {next} sweeps with both placements, and needs \
                 {needed}"
            )));
        }
        let known = &self.session.load_distances[pairs[0].distance];
        Ok(Given {
            gravity,
            upstream,
            differences: pairs.iter().filter_map(|pair| self.difference(pair, next_gain)).collect(),
            mass: self.session.loads[known.between[0]].mass,
            distance: known.distance,
        })
    }

    fn upstream(&self) -> Result<Vec<(f64, f64)>, Missing> {
        let value = |joint: usize, quantity: Quantity| {
            let found = self.known.sensors[joint].of(quantity).as_ref().map(|found| found.value);
            let name = quantity.name(self.name(joint));
            found.map_err(|_| self.missing(format!("step 3 needs {name}, which was not found")))
        };
        (0..=self.joint)
            .map(|joint| {
                let offset = if joint == self.joint {
                    self.session.joints[joint].of(Quantity::PositionOffset).nominal
                } else {
                    value(joint, Quantity::PositionOffset)?
                };
                Ok((value(joint, Quantity::PositionGain)?, offset))
            })
            .collect()
    }

    /// Second placement's fitted sinusoid less the first's, eqs. (17), (18).
    fn difference(&self, pair: &LoadPair, next_gain: f64) -> Option<Difference> {
        let [first, second] = pair.sweeps.map(|sweep| self.fitted_sinusoid(sweep, next_gain));
        let ((first, first_covariance), (second, second_covariance)) = (first?, second?);
        let poses: Vec<usize> = pair.sweeps.iter().flat_map(|s| self.plan.sweeps[*s].poses.iter().copied()).collect();
        let mean =
            |l: usize| poses.iter().map(|p| self.session.poses[*p].position[l]).sum::<f64>() / poses.len() as f64;
        Some(Difference {
            position: (0..=self.joint).map(mean).collect(),
            coefficients: second - first,
            covariance: first_covariance + second_covariance,
        })
    }

    fn fitted_sinusoid(&self, sweep: usize, next_gain: f64) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let rows = readings_of(self.session, &self.plan.sweeps[sweep].poses, self.joint + 1, self.joint);
        let pairs: Vec<(f64, f64)> = rows.iter().map(|(_, reading)| *reading).collect();
        let fit = fit_sinusoid(&pairs, next_gain, None)?;
        let std = |pose: usize| self.known.readings.std(self.session, pose, self.joint);
        let variance = rows.iter().map(|(pose, _)| std(*pose).powi(2)).sum::<f64>() / rows.len() as f64;
        Some((fit.coefficients, variance * fit.unit_covariance))
    }

    fn closed_form(&self, given: &Given<'_>) -> Result<Start, Missing> {
        let frames = AxisFrames::new(&self.session.robot.chain.axis_rotations());
        let coordinate = |d: &Difference, l: usize| given.upstream[l].0 * d.position[l];
        let positions: Vec<PositionDifference> = given
            .differences
            .iter()
            .map(|d| {
                let before: Vec<f64> = (0..self.joint).map(|l| coordinate(d, l) + given.upstream[l].1).collect();
                let g = frames.gravity(&given.gravity.vector, &before).value;
                PositionDifference {
                    coordinate: coordinate(d, self.joint),
                    gravity_angle: g.y.atan2(g.x),
                    gravity_across: g.x.hypot(g.y),
                    difference: d.coefficients,
                }
            })
            .collect();
        let to_next = frames.to_next(self.joint);
        let (scaled, offset) = match self.known_offset() {
            Some(offset) => gain_at_known_offset(&positions, to_next, offset).map(|d| (d, offset)),
            None => gain_and_offset(&positions, to_next, given.upstream[self.joint].1),
        }
        .ok_or_else(|| self.missing(format!("the positions of {} determine no gain", self.name(self.joint))))?;
        let sign = self.session.joints[self.joint].of(Quantity::TorqueGain).nominal.signum();
        let torque_gain = sign * scaled.norm() / (given.mass * given.distance);
        if !(torque_gain.is_finite() && torque_gain != 0.0) {
            let why = format!("moving the load does not change the torque of {}", self.name(self.joint));
            return Err(self.missing(why));
        }
        Ok(Start { torque_gain, offset, displacement: scaled * (sign * given.distance / scaled.norm()) })
    }

    fn fit(&self, given: &Given<'_>, start: &Start, workbench: &Workbench<'_>) -> Result<Gain, Missing> {
        let frozen = "found by an earlier step";
        let mut builder = ProblemBuilder::new();
        let gravity = Block::vector("gravity", "m/s²", &["x", "y", "z"]).held(frozen);
        let gravity = builder.add_block(gravity, &given.gravity.vector);
        let positions: Vec<[BlockId; 2]> = (0..=self.joint)
            .map(|l| {
                let gain = Block::scalar(Quantity::PositionGain.name(self.name(l)), "").held(frozen);
                let offset = Block::scalar(Quantity::PositionOffset.name(self.name(l)), "rad");
                let is_unknown = l == self.joint && self.known_offset().is_none();
                let offset = if is_unknown { offset } else { offset.held(frozen) };
                let value = if l == self.joint { start.offset } else { given.upstream[l].1 };
                [builder.add_block(gain, &[given.upstream[l].0]), builder.add_block(offset, &[value])]
            })
            .collect();
        let torque_gain = Block::scalar(Quantity::TorqueGain.name(self.name(self.joint)), "").linear();
        let exact_gain = self.session.held_reason(self.joint, Quantity::TorqueGain);
        let torque_gain = match exact_gain {
            Some(reason) => {
                let value = self.session.joints[self.joint].of(Quantity::TorqueGain).nominal;
                builder.add_block(torque_gain.held(reason), &[value])
            }
            None => builder.add_block(torque_gain, &[start.torque_gain]),
        };
        let on_sphere =
            Block::vector("displacement", "m", &["x", "y", "z"]).on(Manifold::Sphere { radius: given.distance });
        let displacement = builder.add_block(on_sphere, start.displacement.as_slice());
        let position_offset = positions[self.joint][1];
        let blocks = LoadDifferenceBlocks { gravity, positions, torque_gain, displacement };
        let rotations = self.session.robot.chain.axis_rotations();
        for d in &given.differences {
            let noise = Noise::correlated(d.covariance.as_slice(), 3).map_err(|e| self.missing(e.to_string()))?;
            let residual =
                LoadDifference::new(&rotations, &blocks, given.mass, d.position.clone(), d.coefficients.into());
            builder.add_factor(Factor::new(residual, noise));
        }
        let cure = self.missing(String::new()).cure;
        let fitted = StepFit::solve(builder, workbench, &cure)?;
        Ok(Gain {
            torque_gain: fitted.frozen(torque_gain, 0.1 * start.torque_gain.abs(), &cure),
            position_offset: match self.known_offset() {
                Some(value) => Ok(Frozen { value, std: 0.0 }),
                None => fitted.frozen(position_offset, 0.1, &cure),
            },
            iterations: fitted.estimate.iterations.len() - 1,
        })
    }
}

/// The pairs of the first known distance that has any.
fn first_distance(pairs: &[LoadPair]) -> Vec<LoadPair> {
    pairs.iter().filter(|pair| pair.distance == pairs[0].distance).copied().collect()
}
