//! Step 3: torque gain and position offset of one joint from two placements of a load (paper, section 2.3).
//!
//! The displacement of the load is known by its length alone, and one only where the joints beyond the swept one stand alike: each
//! posture of theirs has its own. Where the offset is unknown, the fit starts from a posture that has two positions of the joint.

use std::collections::BTreeMap;

use gravcal_estimation::{Block, BlockId, Factor, Noise, Sphere};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::axis_frames::AxisFrames;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{LoadDifference, LoadDifferenceBlocks};
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use super::carried::{CarriedErrors, place};
use super::contradiction::refuse_contradiction;
use super::differences::{Difference, Observed};
use super::fitting::{StepFit, StepProblem};
use super::found::{Found, Frozen, Missing};
use super::values::{Gravity, SequentialValues};
use crate::closed_form::{PositionDifference, gain_and_offset, gain_at_known_offset};
use crate::plan::{LoadPair, Plan};

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

/// Finds gain and offset of `joint`, with everything before it frozen in `known`.
pub(super) fn find_gain(
    session: &Session,
    plan: &Plan,
    known: &SequentialValues,
    joint: usize,
    errors: &mut CarriedErrors,
    environment: &SolveEnvironment<'_>,
) -> Gain {
    let step = Step { session, plan, known, joint };
    step.run(errors, environment).unwrap_or_else(|missing| Gain {
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
    swept_gain: Frozen,
    /// By posture: those of one have one displacement.
    differences: Vec<Vec<Difference>>,
    /// kg, m.
    mass: f64,
    distance: f64,
    /// Of the mass.
    relative_mass_std: f64,
}

/// Where the fit starts.
struct Start {
    torque_gain: f64,
    offset: f64,
    /// By posture, of the known length, m; nothing where its positions do not tell it.
    displacements: Vec<Option<Vector3<f64>>>,
}

impl Step<'_> {
    fn run(&self, errors: &mut CarriedErrors, environment: &SolveEnvironment<'_>) -> Result<Gain, Missing> {
        let given = self.given(environment)?;
        let start = self.closed_form(&given)?;
        self.fit(&given, &start, errors, environment)
    }

    fn name(&self, joint: usize) -> &str {
        &self.session.robot.chain.joints()[joint].name
    }

    fn missing(&self, why: String) -> Missing {
        let (name, next) = (self.name(self.joint), self.name(self.joint + 1));
        let cure = format!(
            "sweep {next} with a load at two placements a known distance apart, at two positions of {name} that are \
             neither equal nor 180° apart, with all joints beyond {next} as they stood, and read the torque of {name}"
        );
        Missing::new(why, cure)
    }

    /// The offset where it is no unknown: the first joint's by definition, or one given as exact.
    fn known_offset(&self) -> Option<f64> {
        let held = self.session.fixed_reason(self.joint, SensorParameter::PositionOffset);
        held.map(|_| self.session.joints[self.joint].of(SensorParameter::PositionOffset).nominal)
    }

    fn contradicted(&self) -> String {
        format!(
            "let all joints but {} stand still while it sweeps, and stand alike with both placements; see that the load is what the \
             session says; state the noise as large as it is; or rely on the joint estimator",
            self.name(self.joint + 1),
        )
    }

    fn given(&self, environment: &SolveEnvironment<'_>) -> Result<Given<'_>, Missing> {
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
        let swept_gain = self.known.sensors[self.joint + 1].position_gain.clone();
        let swept_gain = swept_gain.map_err(|_| needs(SensorParameter::PositionGain.name(next), 1))?;
        let pairs = first_distance(&self.plan.gain[self.joint]);
        let (session, plan, known) = (self.session, self.plan, self.known);
        let observed = Observed { session, plan, known, joint: self.joint, swept_gain, cure: self.contradicted() };
        let differences = observed.differences(&pairs, environment)?;
        let found = differences.len();
        let differences = by_posture(differences);
        let most = differences.iter().map(Vec::len).max().unwrap_or(0);
        let needed = if self.known_offset().is_some() { 1 } else { 2 };
        if most < needed {
            let alike = if found >= needed {
                format!(", but only {most} with the joints beyond {next} standing alike")
            } else {
                String::new()
            };
            return Err(self.missing(format!(
                "step 3 found {found} position(s) of {name} at which {next} sweeps with both placements{alike}, and needs {needed}"
            )));
        }
        let known = &self.session.load_distances[pairs[0].distance];
        Ok(Given {
            gravity,
            upstream,
            swept_gain,
            differences,
            mass: self.session.loads[known.between[0]].mass,
            relative_mass_std: self.session.relative_mass_std(known.between[0]),
            distance: known.distance,
        })
    }

    fn upstream(&self) -> Result<Vec<(f64, f64)>, Missing> {
        let value = |joint: usize, quantity: SensorParameter| {
            let found = self.known.sensors[joint].of(quantity).as_ref().map(|found| found.value);
            let name = quantity.name(self.name(joint));
            found.map_err(|_| self.missing(format!("step 3 needs {name}, which was not found")))
        };
        (0..=self.joint)
            .map(|joint| {
                let offset = if joint == self.joint {
                    self.session.joints[joint].of(SensorParameter::PositionOffset).nominal
                } else {
                    value(joint, SensorParameter::PositionOffset)?
                };
                Ok((value(joint, SensorParameter::PositionGain)?, offset))
            })
            .collect()
    }

    /// From the posture with the most positions that determine it; then what the other postures' displacements are with its offset.
    fn closed_form(&self, given: &Given<'_>) -> Result<Start, Missing> {
        let postures: Vec<Vec<PositionDifference>> =
            given.differences.iter().map(|posture| self.positions(given, posture)).collect();
        let to_next = AxisFrames::new(&self.session.robot.chain.axis_rotations()).to_next(self.joint).to_owned();
        let mut by_size: Vec<&Vec<PositionDifference>> = postures.iter().collect();
        by_size.sort_by_key(|positions| std::cmp::Reverse(positions.len()));
        let solve = |positions: &Vec<PositionDifference>| match self.known_offset() {
            Some(offset) => gain_at_known_offset(positions, &to_next, offset).map(|d| (d, offset)),
            None => gain_and_offset(positions, &to_next, given.upstream[self.joint].1),
        };
        let (scaled, offset) = by_size
            .into_iter()
            .find_map(solve)
            .ok_or_else(|| self.missing(format!("the positions of {} determine no gain", self.name(self.joint))))?;
        let sign = self.session.joints[self.joint].of(SensorParameter::TorqueGain).nominal.signum();
        let torque_gain = sign * scaled.norm() / (given.mass * given.distance);
        if !(torque_gain.is_finite() && torque_gain != 0.0) {
            let why = format!("moving the load does not change the torque of {}", self.name(self.joint));
            return Err(self.missing(why));
        }
        let displacement = |positions: &Vec<PositionDifference>| {
            let direction = gain_at_known_offset(positions, &to_next, offset)?.try_normalize(f64::MIN_POSITIVE)?;
            Some(sign * given.distance * direction)
        };
        Ok(Start { torque_gain, offset, displacements: postures.iter().map(displacement).collect() })
    }

    fn positions(&self, given: &Given<'_>, posture: &[Difference]) -> Vec<PositionDifference> {
        let frames = AxisFrames::new(&self.session.robot.chain.axis_rotations());
        let coordinate = |d: &Difference, l: usize| given.upstream[l].0 * d.position[l];
        let position = |d: &Difference| {
            let before: Vec<f64> = (0..self.joint).map(|l| coordinate(d, l) + given.upstream[l].1).collect();
            let g = frames.gravity(&given.gravity.vector, &before).value;
            PositionDifference {
                coordinate: coordinate(d, self.joint),
                gravity_angle: g.y.atan2(g.x),
                gravity_across: g.x.hypot(g.y),
                difference: d.measured.coefficients.into(),
            }
        };
        posture.iter().map(position).collect()
    }

    fn fit(
        &self,
        given: &Given<'_>,
        start: &Start,
        errors: &mut CarriedErrors,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Gain, Missing> {
        let mut step = StepProblem::default();
        let gravity = Block::vector("gravity", "m/s²", &["x", "y", "z"]);
        let gravity = step.freeze(gravity, &given.gravity.vector, errors.gravity());
        let mut positions: Vec<[BlockId; 2]> = Vec::new();
        for (l, (gain, offset)) in given.upstream.iter().enumerate() {
            let block = |quantity: SensorParameter| Block::scalar(quantity.name(self.name(l)), "");
            let gain =
                step.freeze(block(SensorParameter::PositionGain), &[*gain], place(l, SensorParameter::PositionGain));
            let is_unknown = l == self.joint && self.known_offset().is_none();
            let (block, place) = (block(SensorParameter::PositionOffset), place(l, SensorParameter::PositionOffset));
            let offset = match is_unknown {
                true => step.builder.add_block(block, &[start.offset]),
                false => step.freeze(block, &[*offset], place),
            };
            positions.push([gain, offset]);
        }
        let next = self.joint + 1;
        let swept_gain = Block::scalar(SensorParameter::PositionGain.name(self.name(next)), "");
        let swept_gain = step.freeze(swept_gain, &[given.swept_gain.value], place(next, SensorParameter::PositionGain));
        let torque_gain = Block::scalar(SensorParameter::TorqueGain.name(self.name(self.joint)), "").linear();
        let torque_gain = match self.session.fixed_reason(self.joint, SensorParameter::TorqueGain) {
            Some(reason) => {
                let value = self.session.joints[self.joint].of(SensorParameter::TorqueGain).nominal;
                step.builder.add_block(torque_gain.fixed(reason), &[value])
            }
            None => step.builder.add_block(torque_gain, &[start.torque_gain]),
        };
        let position_offset = positions[self.joint][1];
        let rotations = self.session.robot.chain.axis_rotations();
        for (number, (posture, displacement)) in given.differences.iter().zip(&start.displacements).enumerate() {
            let Some(displacement) = displacement else { continue };
            let on_sphere = Block::vector(format!("displacement{number}"), "m", &["x", "y", "z"])
                .on(Sphere { radius: given.distance });
            let displacement = step.builder.add_block(on_sphere, displacement.as_slice());
            let positions = positions.clone();
            let blocks = LoadDifferenceBlocks { gravity, positions, swept_gain, torque_gain, displacement };
            for d in posture {
                let noise = Noise::correlated(d.covariance.as_slice(), 3).map_err(|e| self.missing(e.to_string()))?;
                let residual = LoadDifference::new(&rotations, &blocks, given.mass, d.position.clone(), d.measured);
                step.builder.add_factor(Factor::new(residual, noise));
            }
        }
        let cure = self.missing(String::new()).cure;
        let fitted = StepFit::solve(step, environment, &cure)?;
        let noise = self.known.noise_scale(self.session, self.joint);
        let what = format!("step 3 of {}", self.name(self.joint));
        refuse_contradiction(&fitted, errors, noise, (&what, &self.contradicted()))?;
        errors.take(
            &fitted,
            &[
                (torque_gain, place(self.joint, SensorParameter::TorqueGain)),
                (position_offset, place(self.joint, SensorParameter::PositionOffset)),
            ],
        );
        // The gain is as uncertain as the mass that it is measured against.
        let weighed = |gain: Frozen| Frozen { std: gain.std.hypot(given.relative_mass_std * gain.value), ..gain };
        Ok(Gain {
            torque_gain: fitted.frozen(torque_gain, 0.1 * start.torque_gain.abs(), &cure).map(weighed),
            position_offset: match self.known_offset() {
                Some(value) => Ok(Frozen { value, std: 0.0 }),
                None => fitted.frozen(position_offset, 0.1, &cure),
            },
            iterations: fitted.estimate.iterations.len() - 1,
        })
    }
}

/// The differences of each posture together.
fn by_posture(differences: Vec<Difference>) -> Vec<Vec<Difference>> {
    let mut postures: BTreeMap<usize, Vec<Difference>> = BTreeMap::new();
    for difference in differences {
        postures.entry(difference.posture).or_default().push(difference);
    }
    postures.into_values().collect()
}

/// The pairs of the first known distance that has any.
fn first_distance(pairs: &[LoadPair]) -> Vec<LoadPair> {
    pairs.iter().filter(|pair| pair.distance == pairs[0].distance).copied().collect()
}
