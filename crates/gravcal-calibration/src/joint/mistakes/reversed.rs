//! Torque sensors that read the other way than the session takes them to.
//!
//! Where the sign of a sensor is not declared, two things tell that it is reversed (see the discrete symmetries of the model):
//!
//! - *Beside the others.* A sensor that is reversed and others that are not contradict each other, whatever the moments. Signs are
//!   turned one by one, as long as the start of the joint problem explains the readings better; the outcome is solved, and counts
//!   if χ² falls below half.
//! - *All together.* Turning all sensors and all moments changes no reading of a bare arm. Then the robot's assumed masses
//!   decide: where the torques of the estimated moments oppose those of the assumed ones, all sensors are reversed (or gravity is
//!   declared upside down, which no reading tells from that). Only torques that change count, as a bias takes up the rest, and only
//!   those of joints that themselves turn far: within a narrow range a centre of mass that lies a little elsewhere does the same. Where gravity's
//!   direction is open, or where noise hides either torques, nothing opposes anything.
//!
//! A force-torque sensor is reversed where the mass of its tool comes out negative: the same readings are those of a positive mass
//! with gains of the other sign.
//!
//! A declared sign is taken at its word, `"normal"` included.

use gravcal_estimation::in_parallel;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{AuxiliarySensorKind, Session};

use nalgebra::{Matrix3, Vector3};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::mistakes::assumed_masses::{OPPOSED, agreement};
use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::mistakes::likelihood::decisively_likelier;
use crate::joint::solved::Solved;
use crate::joint::starting::sample::{Sample, telling_part};
use crate::joint::starting::start::{best_start, start_cost};
use crate::joint::variables::State;

/// A turned sign must lower the cost of a start to this share of it; the cost of a solution likewise.
const BETTER_START: f64 = 0.8;
const BETTER: f64 = 0.5;
/// Turning everything must not raise the cost beyond this share of it.
pub(super) const AS_GOOD: f64 = 1.05;
/// Gravity is known where no direction without information has so large a share of it, and so many standard deviations are no right angle.
const OPEN: f64 = 1e-5;
const WITHIN: f64 = 5.0;
/// A mass is negative where it is so by so many of its standard deviations.
const NEGATIVE: f64 = 5.0;

/// Sensors that are reversed, and how that is known.
#[derive(Clone, Debug, PartialEq)]
struct Reversed {
    /// Indices of the joints.
    joints: Vec<usize>,
    /// In words.
    why: String,
}

impl Reversed {
    fn report(&self, session: &Session) -> Mistake {
        let names: Vec<&str> = self.joints.iter().map(|j| session.robot.chain.joints()[*j].name.as_str()).collect();
        let (names, sensors, each) = match names.as_slice() {
            [only] => ((*only).to_owned(), "sensor", "in its [[joint]]"),
            several => (several.join(", "), "sensors", "in the [[joint]] of each"),
        };
        Mistake {
            what: format!("reversed torque {sensors}: {names}"),
            advice: format!(
                "The torque {sensors} of {names} read the other way: {}. Say torque_sign = \"reversed\" {each}; or \
                 \"normal\", if that is how it is.",
                self.why
            ),
        }
    }
}

/// Looks for torque sensors that are reversed beside the others, behind a solution whose fit says nothing for its signs.
pub(super) fn reversed_beside_others(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    let (_, open) = read_and_open(session, solved);
    let reversed = if open.is_empty() { None } else { beside_the_others(session, solved, &open, environment)? };
    Ok(reversed.map(|reversed| reversed.report(session)))
}

/// Looks for torque sensors that are reversed all together, which changes no residual.
pub(super) fn all_reversed(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    let (read, open) = read_and_open(session, solved);
    let all = !open.is_empty() && open.len() == read.len();
    let reversed = if all { all_together(session, solved, &open, environment)? } else { None };
    Ok(reversed.map(|reversed| reversed.report(session)))
}

/// Joints whose torque is read, and those of them whose sign is not declared.
fn read_and_open(session: &Session, solved: &Solved) -> (Vec<usize>, Vec<usize>) {
    let is_read = |joint: &usize| solved.built.rows.iter().any(|id| id.channel == *joint);
    let read: Vec<usize> = (0..session.joints.len()).filter(is_read).collect();
    let open = read.iter().copied().filter(|joint| !session.joints[*joint].torque_sign_declared).collect();
    (read, open)
}

/// Looks for a force-torque sensor by which its tool would have a negative mass, gravity's sign being known.
pub(in crate::joint) fn reversed_wrist(session: &Session, solved: &Solved) -> Option<Mistake> {
    let values = solved.state(&State::nominal(session));
    let wrists = session.instruments.iter().filter(|instrument| instrument.kind == AuxiliarySensorKind::ForceTorque);
    let (wrist, mass, std) = wrists.filter(|wrist| solved.sign_known && !wrist.sign_declared).find_map(|wrist| {
        let mass = wrist.own_parameters().start;
        let (value, std) = (values.further[mass], solved.parameter_std(ParameterId::Further(mass)));
        let kept = |gain: usize| values.further[gain] * session.further[gain].prior.nominal;
        let gains_kept = wrist.gain_parameters().map(kept).sum::<f64>() > 0.0;
        let negative = value < -NEGATIVE * std && session.further[mass].fixed.is_none();
        (negative && gains_kept).then_some((wrist, value, std))
    })?;
    let name = &wrist.name;
    // Of what nothing but its sign is known no number is told.
    let known = solved.judge(session).determines(ParameterId::Further(wrist.own_parameters().start));
    let size = if known { format!(", {mass:.3} ± {std:.3} kg") } else { String::new() };
    Some(Mistake {
        what: format!("reversed force-torque sensor: {name}"),
        advice: format!(
            "The mass of what hangs beyond {name} would be negative{size}: it reads the other way, the force that the \
             tool exerts on the link. Say sign = \"reversed\" in its [[force_torque_sensor]]; or \"normal\", if that is \
             how it is."
        ),
    })
}

fn beside_the_others(
    session: &Session,
    solved: &Solved,
    open: &[usize],
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Reversed>, EstimateError> {
    environment.report("looking for reversed sensors");
    // Noise found from residuals would excuse the very joint that is reversed.
    let unexcused = solved.readings().unexcused(session);
    let readings = telling_part(session, &unexcused);
    let mut joints: Vec<usize> = Vec::new();
    let mut cost = start_cost(session, &readings)?;
    loop {
        let with = |joint: usize| {
            let turned = turned(session, &[&joints[..], &[joint]].concat());
            Ok((start_cost(&turned, &readings)?, joint))
        };
        let left = open.iter().copied().filter(|joint| !joints.contains(joint));
        let costs: Result<Vec<(f64, usize)>, EstimateError> = in_parallel(left, with).into_iter().collect();
        match costs?.into_iter().min_by(|(a, _), (b, _)| a.total_cmp(b)) {
            Some((lower, joint)) if lower < BETTER_START * cost => {
                joints.push(joint);
                cost = lower;
            }
            _ => break,
        }
    }
    // Turning the others instead explains bare readings as well: fewer are likelier.
    if 2 * joints.len() > open.len() {
        joints = open.iter().copied().filter(|joint| !joints.contains(joint)).collect();
    }
    if joints.is_empty() {
        return Ok(None);
    }
    joints.sort_unstable();
    let (before, _) = solve_with(session, &readings, solved, environment)?;
    let (after, state) = solve_with(&turned(session, &joints), &readings, solved, environment)?;
    if after >= BETTER * before {
        return Ok(None);
    }
    let by_position = match joints[..] {
        [joint] => solve_with(&with_position_turned(session, joint), &readings, solved, environment)?.0,
        _ => f64::INFINITY,
    };
    // Then it is a position sensor, which is looked for with whatever else may be mistaken.
    if by_position < BETTER * after {
        return Ok(None);
    }
    let (made, tried) = (turned(session, &joints), open.len());
    let made = (&made, telling_part(session, solved.readings()).into_owned(), state.clone());
    if !decisively_likelier(made, (session, solved), tried as f64, environment)? {
        return Ok(None);
    }
    // All others may be the reversed ones: the assumed masses tell.
    if open.len() == session.joints.len() && agreement(session, solved, &state).is_some_and(|c| c < OPPOSED) {
        joints = open.iter().copied().filter(|joint| !joints.contains(joint)).collect();
    }
    let share = 100.0 * (after / before).sqrt();
    let mut why = format!("with the sign turned, the residuals of all readings fall to {share:.2} % of what they were");
    if by_position <= AS_GOOD * after {
        why += ", and so they do with the sign of its position sensor turned instead (position_sign): look which it is";
    }
    Ok(Some(Reversed { joints, why }))
}

/// Whether gravity's direction is known so well that the truth is not a right angle away: there all torques may be the opposite ones.
fn gravity_is_known(solved: &Solved) -> bool {
    let (covariance, g) = (Matrix3::from_row_slice(&solved.gravity_covariance()), solved.built.variables.gravity);
    let largest = covariance.symmetric_eigenvalues().max().max(0.0).sqrt();
    let size = Vector3::from_column_slice(solved.estimate.values.get(g)).norm();
    solved.judged_problem().columns_of(g).all(|column| solved.analysis.null_share(column) < OPEN)
        && WITHIN * largest < size
}

fn all_together(
    session: &Session,
    solved: &Solved,
    open: &[usize],
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Reversed>, EstimateError> {
    if !gravity_is_known(solved) {
        return Ok(None);
    }
    let now = agreement(session, solved, &solved.state(&State::nominal(session)));
    let Some(now) = now.filter(|correlation| *correlation < OPPOSED) else { return Ok(None) };
    let (cost, state) = solve_with(&turned(session, open), solved.readings(), solved, environment)?;
    let Some(then) = agreement(session, solved, &state).filter(|correlation| *correlation > -OPPOSED) else {
        return Ok(None);
    };
    let why = format!(
        "as they are taken, gravity torques oppose those of the robot's assumed masses (correlation {now:.2}), with \
         their signs turned they follow them ({then:.2}), and the readings are explained as well; or gravity's \
         hemisphere is declared upside down"
    );
    Ok((cost <= AS_GOOD * solved.least_cost()).then(|| Reversed { joints: open.to_vec(), why }))
}

/// The session with the torque gains of these joints of the other sign.
fn turned(session: &Session, joints: &[usize]) -> Session {
    let mut turned = session.clone();
    for joint in joints {
        turned.joints[*joint].parameters[SensorParameter::TorqueGain as usize].nominal *= -1.0;
    }
    turned
}

/// The session with the position gain of a joint of the other sign.
fn with_position_turned(session: &Session, joint: usize) -> Session {
    let mut turned = session.clone();
    turned.joints[joint].parameters[SensorParameter::PositionGain as usize].nominal *= -1.0;
    turned
}

/// Cost and unknowns of a session with these readings and their noise, under the loss of the solution.
pub(in crate::joint) fn solve_with(
    session: &Session,
    readings: &MeasurementSet,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<(f64, State), EstimateError> {
    let start = best_start(session, &Sample::new(session, readings)?, None, environment)?;
    let built = build_with_constraints(session, readings, &start)?.with_loss(solved.built.loss)?;
    let estimate = environment.solve(&built.problem, &built.initial)?;
    Ok((estimate.cost, built.variables.state(&estimate.values, &start)))
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::session::{PriorKind, Session};

    use crate::result::{EstimatorResult, Verdict};
    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::estimate;

    /// The reference protocol with sensors mounted the other way round, and not declared so.
    fn with_reversed(joints: &[usize]) -> Session {
        let mut simulation = sarcos_shoulder();
        joints.iter().for_each(|joint| simulation.truth.sensors[*joint][0] *= -1.0);
        simulation.session(0)
    }

    fn assert_named(result: &EstimatorResult, names: &str) {
        assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
        let reported =
            result.notes.iter().any(|note| note.contains(names) && note.contains("torque_sign = \"reversed\""));
        assert!(reported, "{:?}", result.notes);
        let accusing = result.notes.iter().filter(|note| note.contains("the other way")).count();
        assert_eq!(accusing, 1, "the cause is named once, and nobody else: {:?}", result.notes);
        assert!(result.parameters.iter().all(|reported| reported.value.is_none() || reported.held.is_some()));
    }

    #[test]
    fn one_of_three_is_named() {
        for (joint, name) in ["sensor of joint1 ", "sensor of joint2 ", "sensor of joint3 "].into_iter().enumerate() {
            let mut session = with_reversed(&[joint]);
            assert_named(&estimate(&session), name);
            session.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
            assert_named(&estimate(&session), name);
        }
    }

    #[test]
    fn one_of_three_is_named_where_gains_are_given_and_noise_is_not() {
        let mut session = with_reversed(&[1]);
        for (joint, gain) in session.joints.iter_mut().zip([7.12, 5.97, 6.5]) {
            joint.parameters[0].nominal = gain;
            joint.parameters[0].kind = PriorKind::Fixed;
        }
        for reading in session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()) {
            reading.std = None;
        }
        assert_named(&estimate(&session), "sensor of joint2 ");
    }

    #[test]
    fn all_of_them_are_named_by_the_assumed_masses_and_not_without() {
        let session = with_reversed(&[0, 1, 2]);
        assert_named(&estimate(&session), "sensors of joint1, joint2, joint3 ");
        let mut declared = session.clone();
        declared.joints.iter_mut().for_each(|joint| joint.torque_sign_declared = true);
        assert_eq!(estimate(&declared).verdict, Verdict::Determined, "taken at its word");
    }

    #[test]
    fn two_of_three_are_named_by_the_assumed_masses() {
        assert_named(&estimate(&with_reversed(&[0, 2])), "sensors of joint1, joint3 ");
    }

    #[test]
    fn a_misfit_of_another_kind_names_no_sensor() {
        let mut session = with_reversed(&[]);
        for pose in session.poses.iter_mut().step_by(5) {
            if let Some(reading) = &mut pose.torque[1] {
                reading.value += 400.0;
            }
        }
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::Failed);
        assert!(!result.notes.iter().any(|note| note.contains("read the other way")), "{:?}", result.notes);
    }
}
