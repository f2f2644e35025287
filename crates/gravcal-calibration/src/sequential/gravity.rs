//! Step 2: gravity in base coordinates from sweeps of joint 2 at several positions of joint 1 (paper, section 2.2).

use gravcal_estimation::{Block, BlockId, Factor, Noise, Sphere};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::axis_frames::AxisFrames;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{GravitySweep, GravitySweepBlocks};
use gravcal_robot_model::session::{ReadingId, Session};
use nalgebra::{Complex, Vector3};

use super::bias::readings_of;
use super::carried::{CarriedErrors, place};
use super::contradiction::refuse_contradiction;
use super::fitting::{StepFit, StepProblem};
use super::found::Missing;
use super::values::{Gravity, SequentialValues};
use crate::closed_form::{GravityStart, SweepDirection, fit_sinusoid, gravity_from_sweeps};
use crate::plan::Plan;

/// Joint whose sweeps are used, and the joint before it.
const SWEPT: usize = 1;
const HELD: usize = 0;
/// Direction error above which the step refuses, rad.
const LIMIT: f64 = 0.1;

/// Minimises (16) over gravity and the lumped moment, from the closed-form solution of (14)–(15).
pub(super) fn find_gravity(
    session: &Session,
    plan: &Plan,
    known: &SequentialValues,
    errors: &mut CarriedErrors,
    environment: &SolveEnvironment<'_>,
) -> Result<Gravity, Missing> {
    if session.joints.len() <= SWEPT {
        return Err(Missing::new("step 2 needs two joints", "use the joint estimator"));
    }
    let step = Step { session, plan, known };
    let (sensors, assumed) = step.sensors()?;
    let start = step.closed_form(&sensors)?;
    let (fitted, gravity) = step.fit(&sensors, &start, environment)?;
    let noise = known.noise_scale(session, SWEPT);
    refuse_contradiction(&fitted, errors, noise, ("step 2 (one gravity at every position)", &step.contradicted()))?;
    errors.take(&fitted, &[(gravity, errors.gravity())]);
    step.judge(&fitted, gravity, assumed)
}

/// What the step looks at.
struct Step<'a> {
    session: &'a Session,
    plan: &'a Plan,
    known: &'a SequentialValues,
}

/// What step 1 froze, and the definition of the base frame.
struct Sensors {
    position_gain: f64,
    torque_bias: f64,
    held_gain: f64,
    held_offset: f64,
}

impl Step<'_> {
    fn joint(&self, index: usize) -> &str {
        &self.session.robot.chain.joints()[index].name
    }

    fn missing(&self, why: String) -> Missing {
        let (first, second) = (self.joint(HELD), self.joint(SWEPT));
        let cure = format!(
            "sweep {second} at three or more positions of {first}, spread over its range (and not a multiple of \
             180° apart)"
        );
        Missing::new(why, cure)
    }

    fn contradicted(&self) -> String {
        format!(
            "let all joints but {} stand still while it sweeps, and those beyond it stand alike at every position of {}; state the \
             noise as large as it is; or rely on the joint estimator",
            self.joint(SWEPT),
            self.joint(HELD),
        )
    }

    fn sensors(&self) -> Result<(Sensors, Option<String>), Missing> {
        let frozen = |quantity: SensorParameter| {
            let found = self.known.sensors[SWEPT].of(quantity).as_ref().map(|found| found.value);
            let name = quantity.name(self.joint(SWEPT));
            found.map_err(|_| self.missing(format!("step 2 needs {name}, which step 1 did not find")))
        };
        let nominal = |quantity: SensorParameter| self.session.joints[HELD].of(quantity).nominal;
        // On an upright base joint 1 carries no gravity and step 1 cannot find its gain. Then gravity hardly depends on
        // it either: the nominal gain serves, and the result says so.
        let (held_gain, assumed) = match &self.known.sensors[HELD].position_gain {
            Ok(found) => (found.value, None),
            Err(_) => {
                let (name, gain) =
                    (SensorParameter::PositionGain.name(self.joint(HELD)), nominal(SensorParameter::PositionGain));
                (gain, Some(format!("Step 2 takes {name} at its nominal {gain}: step 1 did not find it.")))
            }
        };
        let sensors = Sensors {
            position_gain: frozen(SensorParameter::PositionGain)?,
            torque_bias: frozen(SensorParameter::TorqueBias)?,
            held_gain,
            held_offset: nominal(SensorParameter::PositionOffset),
        };
        Ok((sensors, assumed))
    }

    /// Gravity's direction and the lumped moment in closed form, refused where gravity has a free direction.
    fn closed_form(&self, sensors: &Sensors) -> Result<GravityStart, Missing> {
        let (first, second) = (self.joint(HELD), self.joint(SWEPT));
        if self.plan.gravity.len() < 2 {
            return Err(self.missing(format!("step 2 needs sweeps of {second} at two positions of {first} at least")));
        }
        let sweeps: Vec<SweepDirection> =
            self.plan.gravity.iter().filter_map(|sweep| self.sweep_direction(*sweep, sensors)).collect();
        let hemisphere = self.session.gravity.hemisphere.ok_or_else(|| {
            let cure = "state gravity's rough direction: [gravity] hemisphere";
            Missing::new("the sweeps do not tell gravity from its opposite", cure)
        })?;
        let start = gravity_from_sweeps(&sweeps, Vector3::from(hemisphere))
            .ok_or_else(|| self.missing(format!("the sweeps of {second} carry no gravity")))?;
        if start.direction_std <= LIMIT {
            return Ok(start);
        }
        let known_to = match start.direction_std.to_degrees() {
            degrees if degrees > 57.0 => "nothing".to_owned(),
            degrees => format!("±{degrees:.0}°"),
        };
        Err(self.missing(format!(
            "gravity has a free direction: the sweeps of {second} at {} positions of {first} agree in amplitude and \
             phase (as they do on an upright base), which leaves its direction known to {known_to}",
            self.plan.gravity.len(),
        )))
    }

    /// Amplitude and phase of one sweep, about the bias of step 1, and how they depend on gravity in the base.
    fn sweep_direction(&self, sweep: usize, sensors: &Sensors) -> Option<SweepDirection> {
        let poses = &self.plan.sweeps[sweep].poses;
        let rows = readings_of(self.session, poses, SWEPT, SWEPT);
        let pairs: Vec<(f64, f64)> = rows.iter().map(|(_, reading)| *reading).collect();
        let fit = fit_sinusoid(&pairs, sensors.position_gain, Some(sensors.torque_bias))?;
        let held = poses.iter().map(|p| self.session.poses[*p].position[HELD]).sum::<f64>() / poses.len() as f64;
        let frames = AxisFrames::new(&self.session.robot.chain.axis_rotations());
        let moved = frames.gravity(&[0.0; 3], &[sensors.held_gain * held + sensors.held_offset]);
        let row = |i: usize| Vector3::new(moved.derivatives[0][i], moved.derivatives[1][i], moved.derivatives[2][i]);
        let variance = fit.unit_covariance[(0, 0)].max(fit.unit_covariance[(1, 1)]);
        Some(SweepDirection {
            u: row(0),
            v: row(1),
            measured: Complex::new(fit.coefficients[0], -fit.coefficients[1]),
            std: variance.sqrt() * self.known.readings.std(self.session, ReadingId { pose: rows[0].0, channel: SWEPT }),
        })
    }

    fn fit(
        &self,
        sensors: &Sensors,
        start: &GravityStart,
        environment: &SolveEnvironment<'_>,
    ) -> Result<(StepFit, BlockId), Missing> {
        let magnitude = self.session.gravity.magnitude;
        let mut step = StepProblem::default();
        let on_sphere = Block::vector("gravity", "m/s²", &["x", "y", "z"]).on(Sphere { radius: magnitude });
        let gravity = step.builder.add_block(on_sphere, (magnitude * start.direction).as_slice());
        let mut frozen = |name: &str, value: f64, joint: usize, quantity: SensorParameter| {
            step.freeze(Block::scalar(name, ""), &[value], place(joint, quantity))
        };
        let before = [
            frozen("held.position_gain", sensors.held_gain, HELD, SensorParameter::PositionGain),
            frozen("held.position_offset", sensors.held_offset, HELD, SensorParameter::PositionOffset),
        ];
        let position_gain = frozen("position_gain", sensors.position_gain, SWEPT, SensorParameter::PositionGain);
        let torque_bias = frozen("torque_bias", sensors.torque_bias, SWEPT, SensorParameter::TorqueBias);
        let moment = Block::vector("moment", "", &["p", "q"]).linear();
        let moment = step.builder.add_block(moment, &start.moment.map(|m| m / magnitude));
        let blocks = GravitySweepBlocks { gravity, before: vec![before], position_gain, torque_bias, moment };
        let (rows, std): (Vec<_>, Vec<f64>) = self
            .plan
            .gravity
            .iter()
            .flat_map(|sweep| readings_of(self.session, &self.plan.sweeps[*sweep].poses, SWEPT, SWEPT))
            .map(|(pose, (_, torque))| {
                let position = self.session.poses[pose].position[..=SWEPT].to_vec();
                ((position, torque), self.known.readings.std(self.session, ReadingId { pose, channel: SWEPT }))
            })
            .unzip();
        let noise = Noise::independent(&std).map_err(|e| self.missing(e.to_string()))?;
        let residual = GravitySweep::new(&self.session.robot.chain.axis_rotations(), &blocks, rows);
        step.builder.add_factor(Factor::new(residual, noise));
        Ok((StepFit::solve(step, environment, &self.missing(String::new()).cure)?, gravity))
    }

    fn judge(&self, fitted: &StepFit, gravity: BlockId, assumed: Option<String>) -> Result<Gravity, Missing> {
        let covariance = fitted.covariance.stored(&fitted.problem, fitted.values(), &[gravity]);
        let largest = nalgebra::Matrix3::from_row_slice(&covariance).symmetric_eigenvalues().max().max(0.0).sqrt();
        let angle = largest / self.session.gravity.magnitude;
        if angle > LIMIT {
            return Err(self.missing(format!("gravity is known only to ±{:.0}°", angle.to_degrees())));
        }
        let g = fitted.values().get(gravity);
        let declared = self.session.gravity.assumed();
        if g.iter().zip(declared).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
            return Err(self.missing("the fit left the declared hemisphere of gravity".into()));
        }
        Ok(Gravity {
            vector: [g[0], g[1], g[2]],
            covariance,
            assumed,
            iterations: fitted.estimate.iterations.len() - 1,
        })
    }
}
