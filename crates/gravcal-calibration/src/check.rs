//! What a session can and cannot determine, before any solve.
//!
//! The Jacobian of the joint problem is judged at nominal values: gravity along the declared direction (of an
//! upright base without one), nominal sensors, the robot's assumed masses. Torque readings are not looked at (only which are there, and their noise).

use serde::Serialize;

use crate::joint::{EstimateError, Readings, Signals, Solved, Unknowns, judge_at_start, select};
use crate::parameter::Quantity;
use crate::result::Undetermined;
use crate::sequential::Plan;
use crate::session::Session;
use crate::sweeps::{HOLD_TOLERANCE, SWEEP_POSES, SWEEP_RANGE};

/// Angles between base and gravity at which the first joint is judged, degrees.
const TILTS_DEG: [f64; 5] = [1.0, 2.0, 5.0, 10.0, 20.0];
/// Largest less smallest of some hundred readings of mere noise, in standard deviations.
const NOISE_SPREAD: f64 = 5.0;
/// Below this angle between gravity and the first axis the effect of a tilt is told, rad.
const NEARLY_UPRIGHT: f64 = 0.1;

/// What a session can determine.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// Where it was judged, in words.
    pub judged_at: String,
    /// Poses by load (`none` first), as `(load, poses)`.
    pub poses: Vec<(String, usize)>,
    /// By joint: name and usable torque readings.
    pub torque_readings: Vec<(String, usize)>,
    /// Rule by which sweeps are detected, in words.
    pub sweep_rule: String,
    /// Sweeps found.
    pub sweeps: Vec<SweepReport>,
    /// What each step of the sequential procedure will read, or why it cannot work.
    pub steps: Vec<StepReport>,
    /// Every sensor parameter and gravity, as the joint estimator can know them.
    pub parameters: Vec<CheckedParameter>,
    /// What the joint estimator cannot determine.
    pub undetermined: Vec<Undetermined>,
    /// What tilting the base would bring to the first joint; empty unless gravity is nearly parallel to its axis.
    pub tilts: Vec<TiltReport>,
    /// Whether everything asked for can be determined.
    pub complete: bool,
}

/// One sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweepReport {
    /// File name of its table.
    pub table: String,
    /// Lines of its first and last pose.
    pub lines: [u64; 2],
    /// The joint that moves.
    pub joint: String,
    /// Number of poses.
    pub poses: usize,
    /// From where to where, degrees (nominal position gain, no offset).
    pub range_deg: [f64; 2],
    /// Load attached, if any.
    pub load: Option<String>,
    /// Steps of the sequential procedure that read it.
    pub steps: Vec<u8>,
}

/// One step of the sequential procedure for one joint.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// 1, 2 or 3.
    pub step: u8,
    /// What it finds: `joint1.torque_bias, joint1.position_gain`.
    pub finds: String,
    /// Number of sweeps it reads.
    pub sweeps: usize,
    /// Why it cannot work, if it cannot.
    pub problem: Option<String>,
}

/// What can be known of one parameter.
#[derive(Clone, Debug, Serialize)]
pub struct CheckedParameter {
    /// `joint1.torque_gain`, `gravity`.
    pub name: String,
    /// Unit of the standard deviation; degrees for gravity's direction.
    pub unit: String,
    /// Whether it is asked for.
    pub asked: bool,
    /// Whether it can be determined.
    pub determined: bool,
    /// Why it is held, if it is.
    pub held: Option<String>,
    /// Predicted standard deviation, where it can be determined and is not held; absent too where the noise of a
    /// torque reading is not stated.
    pub predicted_std: Option<f64>,
}

/// What a tilt of the base brings.
#[derive(Clone, Debug, Serialize)]
pub struct TiltReport {
    /// Angle between gravity and the first axis, degrees.
    pub tilt_deg: f64,
    /// Predicted standard deviation of the first joint's torque gain relative to it; absent where undetermined.
    pub torque_gain_relative_std: Option<f64>,
    /// The same of its position gain.
    pub position_gain_relative_std: Option<f64>,
}

/// Judges a session without solving it.
///
/// # Errors
/// Where the joint problem cannot be posed: no readings, nothing unknown.
pub fn check(session: &Session) -> Result<CheckReport, EstimateError> {
    let plan = Plan::new(session);
    let readings = select(session, Signals::All);
    let nominal = Unknowns::nominal(session);
    let verdict = judge_at(session, &readings, &nominal)?;
    let complete = verdict.parameters.iter().all(|p| p.determined || !p.asked);
    Ok(CheckReport {
        judged_at: judged_at(session),
        poses: count_poses(session),
        torque_readings: count_readings(session, &readings),
        sweep_rule: sweep_rule(),
        sweeps: plan.sweeps.iter().enumerate().map(|(i, _)| tell_sweep(session, &plan, i)).collect(),
        steps: tell_steps(session, &plan),
        parameters: verdict.parameters,
        undetermined: verdict.undetermined,
        tilts: tilts(session, &readings, &nominal)?,
        complete,
    })
}

struct NominalVerdict {
    parameters: Vec<CheckedParameter>,
    undetermined: Vec<Undetermined>,
}

fn judge_at(session: &Session, readings: &Readings, values: &Unknowns) -> Result<NominalVerdict, EstimateError> {
    let judged = judge_at_start(session, readings, values)?;
    // Readings count, not their values: a bias is judged against the torque that the nominal model predicts.
    let judgement = judged.judge_with_spreads(session, &predicted_spreads(session, readings, &judged)?);
    let (posed, covariance) = (&judged.posed, judged.covariance());
    let stated = !session.noise_estimated().iter().any(|e| *e);
    let std = |id: gravcal_estimation::BlockId| {
        posed.problem.columns_of(id).map(|column| covariance.std(column)).reduce(f64::max).filter(|_| stated)
    };
    let mut parameters = vec![CheckedParameter {
        name: "gravity".into(),
        unit: "deg".into(),
        asked: session.asks("gravity"),
        determined: judgement.gravity,
        held: None,
        predicted_std: std(posed.layout.gravity)
            .filter(|_| judgement.gravity)
            .map(|std| (std / session.gravity.magnitude).to_degrees()),
    }];
    for id in session.parameters() {
        let blank = session.blank_parameter(id);
        let determined = blank.determined && judgement.determines(id);
        parameters.push(CheckedParameter {
            name: blank.name,
            unit: blank.unit,
            asked: blank.asked,
            determined,
            held: blank.held,
            predicted_std: std(posed.layout.block(id)).filter(|_| determined),
        });
    }
    let situation = judged.situation(session);
    let mut undetermined: Vec<Undetermined> = judgement.combinations.iter().map(|c| situation.tell(c)).collect();
    undetermined.extend(crate::joint::last_frame_choice(session));
    Ok(NominalVerdict { parameters, undetermined })
}

/// Largest less smallest reading that the nominal model predicts for each channel, unit of the reading; never less than
/// noise alone spreads them, so that a joint that carries nothing still tells its bias.
fn predicted_spreads(session: &Session, readings: &Readings, judged: &Solved) -> Result<Vec<f64>, EstimateError> {
    let mut range = vec![(f64::INFINITY, f64::NEG_INFINITY, 1.0); session.channel_count()];
    let residuals = judged.posed.problem.residuals(&judged.estimate.values)?;
    for ((pose, channel), residual) in judged.posed.rows.iter().zip(residuals) {
        let std = readings.std(session, *pose, *channel);
        let predicted = session.reading(*pose, *channel).map_or(f64::NAN, |reading| reading.value) + std * residual;
        let (low, high, _) = range[*channel];
        range[*channel] = (low.min(predicted), high.max(predicted), std);
    }
    Ok(range.iter().map(|(low, high, std)| (high - low).max(NOISE_SPREAD * std)).collect())
}

fn tilts(session: &Session, readings: &Readings, nominal: &Unknowns) -> Result<Vec<TiltReport>, EstimateError> {
    let axis = nalgebra::Vector3::from(session.robot.chain.axis_rotations()[0].map(|row| row[2]));
    let gravity = nalgebra::Vector3::from(nominal.gravity);
    let across = gravity.cross(&axis).norm() / gravity.norm();
    if across > NEARLY_UPRIGHT {
        return Ok(Vec::new());
    }
    // Any direction across the axis serves: which one it is makes little difference.
    let side = axis.cross(&nalgebra::Vector3::new(axis.y, axis.z, axis.x + 0.5)).normalize();
    let along = axis * gravity.dot(&axis).signum();
    TILTS_DEG
        .iter()
        .map(|tilt_deg| {
            let (sin, cos) = tilt_deg.to_radians().sin_cos();
            let tilted = gravity.norm() * (cos * along + sin * side);
            let values = Unknowns { gravity: tilted.into(), ..nominal.clone() };
            let verdict = judge_at(session, readings, &values)?;
            let relative = |quantity: Quantity| {
                let name = quantity.name(&session.robot.chain.joints()[0].name);
                let std = verdict.parameters.iter().find(|p| p.name == name)?.predicted_std?;
                Some(std / nominal.sensors[0][quantity as usize].abs())
            };
            Ok(TiltReport {
                tilt_deg: *tilt_deg,
                torque_gain_relative_std: relative(Quantity::TorqueGain),
                position_gain_relative_std: relative(Quantity::PositionGain),
            })
        })
        .collect()
}

fn judged_at(session: &Session) -> String {
    let gravity = match session.gravity.hemisphere {
        Some([x, y, z]) => format!("along the declared hemisphere ({x:.3}, {y:.3}, {z:.3})"),
        None => "as on an upright base (no hemisphere is declared)".to_owned(),
    };
    format!("nominal values: gravity {gravity}, nominal sensors, assumed masses of {}", session.robot.name)
}

fn count_poses(session: &Session) -> Vec<(String, usize)> {
    let count = |load: Option<usize>| session.poses.iter().filter(|p| p.load == load).count();
    let loads = session.loads.iter().enumerate().map(|(i, load)| (load.name.clone(), count(Some(i))));
    [("none".to_owned(), count(None))].into_iter().chain(loads).collect()
}

fn count_readings(session: &Session, readings: &Readings) -> Vec<(String, usize)> {
    let count = |channel: usize| readings.used.iter().filter(|used| used.contains(&channel)).count();
    (0..session.channel_count()).map(|channel| (session.channel_name(channel), count(channel))).collect()
}

fn sweep_rule() -> String {
    format!(
        "consecutive poses of one table in which one joint moves by {:.0}° or more and no other by more than {:.0}°, \
         {} poses at least",
        SWEEP_RANGE.to_degrees(),
        HOLD_TOLERANCE.to_degrees(),
        SWEEP_POSES
    )
}

fn tell_sweep(session: &Session, plan: &Plan, index: usize) -> SweepReport {
    let sweep = &plan.sweeps[index];
    let (first, last) = (sweep.poses[0], sweep.poses[sweep.poses.len() - 1]);
    let gain = session.joints[sweep.swept].of(Quantity::PositionGain).nominal;
    let coordinate = |pose: usize| (gain * session.poses[pose].position[sweep.swept]).to_degrees();
    let mut steps = Vec::new();
    if plan.bias[sweep.swept].contains(&index) {
        steps.push(1);
    }
    if plan.gravity.contains(&index) {
        steps.push(2);
    }
    if plan.gain.iter().flatten().any(|pair| pair.sweeps.contains(&index)) {
        steps.push(3);
    }
    let path = &session.tables[sweep.table].path;
    SweepReport {
        table: path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        lines: [session.poses[first].line, session.poses[last].line],
        joint: session.robot.chain.joints()[sweep.swept].name.clone(),
        poses: sweep.poses.len(),
        range_deg: [coordinate(first), coordinate(last)],
        load: sweep.load.map(|load| session.loads[load].name.clone()),
        steps,
    }
}

fn tell_steps(session: &Session, plan: &Plan) -> Vec<StepReport> {
    let names: Vec<&str> = session.robot.chain.joints().iter().map(|j| j.name.as_str()).collect();
    let mut steps = Vec::new();
    for (joint, sweeps) in plan.bias.iter().enumerate() {
        steps.push(StepReport {
            step: 1,
            finds: format!("{0}.torque_bias, {0}.position_gain", names[joint]),
            sweeps: sweeps.len(),
            problem: sweeps.is_empty().then(|| format!("no sweep of {}", names[joint])),
        });
    }
    if let [first, second, ..] = names[..] {
        let few = format!("needs sweeps of {second} at two positions of {first} at least");
        let problem = (plan.gravity.len() < 2).then_some(few);
        steps.push(StepReport { step: 2, finds: "gravity".into(), sweeps: plan.gravity.len(), problem });
    }
    for (joint, pairs) in plan.gain.iter().enumerate() {
        let name = names[joint];
        let needed = if joint == 0 { 1 } else { 2 };
        let problem = match names.get(joint + 1) {
            None => Some(format!("{name} is the last joint, which no step reaches")),
            Some(next) if pairs.len() < needed => Some(format!(
                "needs sweeps of {next} with the load at two placements, at {needed} position(s) of {name}"
            )),
            Some(_) => None,
        };
        steps.push(StepReport {
            step: 3,
            finds: if joint == 0 {
                format!("{name}.torque_gain")
            } else {
                format!("{name}.torque_gain, {name}.position_offset")
            },
            sweeps: 2 * pairs.len(),
            problem,
        });
    }
    steps
}
