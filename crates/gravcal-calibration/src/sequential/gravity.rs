//! Step 2: gravity in base coordinates from sweeps of joint 2 at several positions of joint 1 (paper, section 2.2).

use gravcal_estimation::{Block, Factor, Manifold, Noise, ProblemBuilder};
use nalgebra::{Complex, Vector3};

use super::SequentialValues;
use super::bias::readings_of;
use super::fitting::StepFit;
use super::found::Missing;
use super::plan::Plan;
use crate::axis_frames::AxisFrames;
use crate::closed_form::{GravityStart, SweepDirection, fit_sinusoid, gravity_from_sweeps};
use crate::joint::Readings;
use crate::parameter::Quantity;
use crate::residuals::{GravitySweep, GravitySweepBlocks};
use crate::session::Session;
use crate::workbench::Workbench;

/// Joint whose sweeps are used, and the joint before it.
const SWEPT: usize = 1;
const HELD: usize = 0;
/// Direction error above which the step refuses, rad.
const LIMIT: f64 = 0.1;

/// Gravity as step 2 found it.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// Base coordinates, m/s².
    pub vector: [f64; 3],
    /// Its covariance, 3 × 3, row-major, conditional on step 1.
    pub covariance: Vec<f64>,
    /// What had to be taken at its nominal value, in words.
    pub assumed: Option<String>,
    /// Solver iterations.
    pub iterations: usize,
}

/// Minimises (16) over gravity and the lumped moment, from the closed-form solution of (14)–(15).
pub(super) fn find_gravity(
    session: &Session,
    plan: &Plan,
    readings: &Readings,
    known: &SequentialValues,
    workbench: &Workbench<'_>,
) -> Result<Gravity, Missing> {
    let joints = session.robot.chain.joints();
    if joints.len() <= SWEPT {
        return Err(Missing::new("step 2 needs two joints", "use the joint estimator"));
    }
    let (first, second) = (&joints[HELD].name, &joints[SWEPT].name);
    let cure = format!(
        "sweep {second} at three or more positions of {first}, spread over its range (and not a multiple of 180° apart)"
    );
    let missing = |why: String| Missing::new(why, cure.clone());
    let frozen = |quantity: &super::Found, name: String| {
        quantity
            .clone()
            .map(|f| f.value)
            .map_err(|_| missing(format!("step 2 needs {name}, which step 1 did not find")))
    };
    let position_gain = frozen(&known.sensors[SWEPT].position_gain, format!("{second}.position_gain"))?;
    let torque_bias = frozen(&known.sensors[SWEPT].torque_bias, format!("{second}.torque_bias"))?;
    // On an upright base joint 1 carries no gravity and step 1 cannot find its gain. Then gravity hardly depends on it
    // either: the nominal gain serves, and the result says so.
    let (held_gain, assumed) = match &known.sensors[HELD].position_gain {
        Ok(found) => (found.value, None),
        Err(_) => {
            let nominal = session.joints[HELD].of(Quantity::PositionGain).nominal;
            (
                nominal,
                Some(format!("Step 2 takes {first}.position_gain at its nominal {nominal}: step 1 did not find it.")),
            )
        }
    };
    if plan.gravity.len() < 2 {
        return Err(missing(format!("step 2 needs sweeps of {second} at two positions of {first} at least")));
    }
    let start = closed_form(session, plan, readings, [position_gain, torque_bias, held_gain])
        .ok_or_else(|| missing(format!("the sweeps of {second} carry no gravity")))?;
    if start.direction_std > LIMIT {
        return Err(missing(format!(
            "gravity has a free direction: the sweeps of {second} at {} positions of {first} agree in amplitude and \
             phase (as they do on an upright base), which leaves its direction known to {}",
            plan.gravity.len(),
            if start.direction_std > 1.0 {
                "nothing".into()
            } else {
                format!("±{:.0}°", start.direction_std.to_degrees())
            },
        )));
    }

    let mut builder = ProblemBuilder::new();
    let magnitude = session.gravity.magnitude;
    let on_sphere = Block::vector("gravity", "m/s²", &["x", "y", "z"]).on(Manifold::Sphere { radius: magnitude });
    let gravity = builder.add_block(on_sphere, (magnitude * start.direction).as_slice());
    let mut held =
        |name: &str, value: f64| builder.add_block(Block::scalar(name, "").held("found by step 1"), &[value]);
    let before = vec![[held("held.position_gain", held_gain), held("held.position_offset", 0.0)]];
    let (position_gain_id, torque_bias_id) = (held("position_gain", position_gain), held("torque_bias", torque_bias));
    let moment = builder.add_block(Block::vector("moment", "", &["p", "q"]), &[0.0, 0.0]);
    let blocks =
        GravitySweepBlocks { gravity, before, position_gain: position_gain_id, torque_bias: torque_bias_id, moment };
    let (rows, std): (Vec<_>, Vec<f64>) = plan
        .gravity
        .iter()
        .flat_map(|sweep| readings_of(session, &plan.sweeps[*sweep].poses, SWEPT, SWEPT))
        .map(|(pose, (_, torque))| {
            ((session.poses[pose].position[..=SWEPT].to_vec(), torque), readings.std(session, pose, SWEPT))
        })
        .unzip();
    let noise = Noise::independent(&std).map_err(|e| missing(e.to_string()))?;
    let residual = GravitySweep::new(&session.robot.chain.axis_rotations(), &blocks, rows);
    builder.add_factor(Factor::new(residual, noise));
    let fitted = StepFit::solve(builder, workbench, &cure)?;
    let covariance = fitted.covariance.stored(&fitted.problem, fitted.values(), &[gravity]);
    let largest = nalgebra::Matrix3::from_row_slice(&covariance).symmetric_eigenvalues().max().max(0.0).sqrt();
    if largest > LIMIT * magnitude {
        return Err(missing(format!("gravity is known only to ±{:.0}°", (largest / magnitude).to_degrees())));
    }
    let g = fitted.values().get(gravity);
    if g.iter().zip(session.gravity.hemisphere).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
        return Err(missing("the fit left the declared hemisphere of gravity".into()));
    }
    Ok(Gravity { vector: [g[0], g[1], g[2]], covariance, assumed, iterations: fitted.estimate.iterations.len() - 1 })
}

/// Gravity's direction in closed form; `[s₂, b₂, s₁]` are step 1's.
fn closed_form(
    session: &Session,
    plan: &Plan,
    readings: &Readings,
    [position_gain, torque_bias, held_gain]: [f64; 3],
) -> Option<GravityStart> {
    let frames = AxisFrames::new(&session.robot.chain.axis_rotations());
    let directions: Vec<SweepDirection> = plan
        .gravity
        .iter()
        .filter_map(|sweep| {
            let poses = &plan.sweeps[*sweep].poses;
            let rows = readings_of(session, poses, SWEPT, SWEPT);
            let pairs: Vec<(f64, f64)> = rows.iter().map(|(_, r)| *r).collect();
            let fit = fit_sinusoid(&pairs, position_gain, Some(torque_bias))?;
            let held = poses.iter().map(|p| session.poses[*p].position[HELD]).sum::<f64>() / poses.len() as f64;
            // Rows of the map from gravity in the base to the swept joint's axis frame.
            let moved = frames.gravity(&[0.0; 3], &[held_gain * held]);
            let row =
                |i: usize| Vector3::new(moved.derivatives[0][i], moved.derivatives[1][i], moved.derivatives[2][i]);
            let variance = fit.unit_covariance[(0, 0)].max(fit.unit_covariance[(1, 1)]);
            Some(SweepDirection {
                u: row(0),
                v: row(1),
                measured: Complex::new(fit.coefficients[0], -fit.coefficients[1]),
                std: variance.sqrt() * readings.std(session, rows[0].0, SWEPT),
            })
        })
        .collect();
    gravity_from_sweeps(&directions, Vector3::from(session.gravity.hemisphere))
}
