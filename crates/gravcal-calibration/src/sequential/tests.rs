//! The steps on simulated arms whose distal joints stand differently from pair to pair.

use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, LinkInertia, chain_from_dh};
use gravcal_identification::SolveEnvironment;
use gravcal_recording::{PositionUnit, TorqueUnit};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{
    GravityPrior, JointPriors, Load, LoadDistance, ParameterPrior, PoseTable, PriorKind, Session,
};
use gravcal_session::simulation::{Disturbance, Run, Simulation};
use gravcal_solvers::LevenbergMarquardt;

use super::*;
use crate::joint::State;
use crate::testing::{sarcos_shoulder, shared_session};

const GRAVITY: [f64; 3] = [-3.43, -5.94, -7.0];
const NOISE: f64 = 0.02;

fn steps_handed(session: &Session, handed: Handed<'_>) -> SequentialValues {
    let solver = LevenbergMarquardt::default();
    run_steps_handed(session, &Plan::new(session), handed, &SolveEnvironment::new(&solver, &|_: &str| {}))
}

fn steps(session: &Session) -> SequentialValues {
    steps_handed(session, Handed::default())
}

/// An arm whose twists alternate, with a load on its last link.
fn arm(joints: usize) -> Simulation {
    let row = |i: usize| DhRow {
        name: format!("joint{}", i + 1),
        kind: JointKind::Revolute,
        a: 0.05 * i as f64,
        alpha: if i.is_multiple_of(2) { 90f64 } else { -90f64 }.to_radians(),
        d: 0.3,
        theta: 0.0,
        limits: None,
        link: Link {
            name: format!("link{}", i + 1),
            inertia: Some(LinkInertia { mass: 2.0, first_moment: [0.4, 0.1 * i as f64, 0.3] }),
        },
    };
    let rows: Vec<DhRow> = (0..joints).map(row).collect();
    let chain = chain_from_dh("base", DhConvention::Standard, &rows).unwrap();
    let robot = Robot { name: "arm".into(), chain, sensors: vec![Default::default(); joints] };
    let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
    let joint = || JointPriors {
        torque_unit: Some(TorqueUnit::NewtonMeter),
        torque_sign_declared: false,
        position_unit: PositionUnit::Radian,
        parameters: [1.0, 0.0, 1.0, 0.0].map(start),
    };
    let load = |name: &str| Load { name: name.into(), mass: 1.7, link: joints - 1, position: None, position_std: None };
    let (runs, tables): (Vec<Run>, Vec<PoseTable>) = protocol(joints).into_iter().unzip();
    let hemisphere = Some(GRAVITY.map(|c| c / 9.8));
    let template = Session {
        loads: vec![load("a"), load("b")],
        load_distances: vec![LoadDistance { between: [0, 1], distance: 0.4, std: None }],
        tables,
        ..Session::new(
            robot,
            GravityPrior { magnitude: 9.8, magnitude_std: None, hemisphere },
            (0..joints).map(|_| joint()).collect(),
        )
    };
    let mut truth = State::nominal(&template);
    let length = GRAVITY.iter().map(|c| c * c).sum::<f64>().sqrt();
    truth.gravity = GRAVITY.map(|c| 9.8 * c / length);
    for (i, sensors) in truth.sensors.iter_mut().enumerate() {
        let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        *sensors = [1.0 + 0.05 * sign, 0.3 * sign, 1.0 - 0.006 * sign, if i == 0 { 0.0 } else { 0.03 * sign }];
    }
    truth.loads = vec![[0.15, 0.05, 0.2], [0.15 - 0.4 * 0.64, 0.05 + 0.4 * 0.48, 0.2 - 0.4 * 0.6]];
    Simulation::new(template, truth, runs, Disturbance::noise(vec![NOISE; joints]), 1)
}

/// Every joint alone, joint 2 at three positions of joint 1, then with both placements each joint after the first at two positions of
/// the one before, in two postures of the joints beyond.
fn protocol(joints: usize) -> Vec<(Run, PoseTable)> {
    let rest: Vec<f64> = (0..joints).map(|i| 0.3 + 0.4 * (i as f64).sin()).collect();
    let sweep = |swept: usize, held: Vec<f64>, load: Option<usize>, step: u8| {
        let table = PoseTable { path: "sweep.csv".into(), load, swept: None, step: Some(step) };
        (Run::Sweep { swept, range: [-1.4, 1.4], poses: 25, held }, table)
    };
    let mut all: Vec<_> = (0..joints).map(|joint| sweep(joint, rest.clone(), None, 1)).collect();
    for position in [-1.2, 0.0, 1.3] {
        let mut held = rest.clone();
        held[0] = position;
        all.push(sweep(1, held, None, 2));
    }
    for joint in 1..joints {
        for (position, posture) in [(-0.7, 0.0), (0.8, 0.0), (-0.7, 0.6), (0.8, 0.6)] {
            let mut held = rest.clone();
            held[joint - 1] = position;
            held[joint + 1..].iter_mut().for_each(|beyond| *beyond += posture);
            all.extend([0, 1].map(|load| sweep(joint, held.clone(), Some(load), 3)));
        }
    }
    all
}

/// Errors of what the steps found, each over its standard deviation as `std` tells it from the step's own.
fn z_scores(
    simulation: &Simulation,
    known: &SequentialValues,
    std: impl Fn(usize, SensorParameter, f64) -> f64,
) -> Vec<f64> {
    let every = (0..known.sensors.len()).flat_map(|joint| SensorParameter::ALL.map(|quantity| (joint, quantity)));
    every
        .filter_map(|(joint, quantity)| {
            let found = known.sensors[joint].of(quantity).as_ref().ok().filter(|found| found.std > 0.0)?;
            let error = found.value - simulation.truth.sensors[joint][quantity as usize];
            Some(error / std(joint, quantity, found.std))
        })
        .collect()
}

fn rms(z: &[f64]) -> f64 {
    (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt()
}

/// What a session of the arm has no right to leave out: gains, biases of all joints, but what no step reaches.
fn findable(joints: usize) -> usize {
    4 * joints - 3
}

/// Handed the truth, step 3 has its own errors only.
#[test]
fn postures_that_differ_share_the_gain_and_not_the_displacement() {
    for joints in [3, 5] {
        let simulation = arm(joints);
        let handed = Handed { step_1: Some(&simulation.truth), gravity: Some(simulation.truth.gravity) };
        let of_trial = |trial| {
            let session = simulation.session(trial);
            let plan = Plan::new(&session);
            // Beyond the joint that sweeps for the last gain nothing can stand differently.
            for (joint, pairs) in plan.gain.iter().enumerate().take(joints - 1) {
                let postures: Vec<usize> = pairs.iter().map(|pair| pair.posture).collect();
                assert_eq!(postures, if joint + 2 < joints { [0, 0, 1, 1] } else { [0; 4] }, "{joint}");
            }
            z_scores(&simulation, &steps_handed(&session, handed), |_, _, std| std)
        };
        let z: Vec<f64> = (0..20).flat_map(of_trial).collect();
        assert_eq!(z.len(), 20 * (2 * joints - 3));
        assert!((0.8..1.25).contains(&rms(&z)), "{joints}: {}", rms(&z));
    }
}

/// Six joints that stand differently in every pair: joint 1's gain alone is to be had, and it is right.
#[test]
fn pairs_of_different_postures_are_not_pooled() {
    let Some(session) = shared_session("sequential-pairs") else { return };
    let known = steps(&session);
    let gain = known.sensors[0].torque_gain.as_ref().unwrap();
    assert!((gain.value - 1.0705408783661978).abs() < 4.0 * gain.std && gain.std < 0.02, "{gain:?}");
    let missing = known.sensors[1].torque_gain.as_ref().unwrap_err();
    assert!(
        missing.why.contains("standing alike") && missing.cure.contains("beyond joint3 as they stood"),
        "{missing:?}"
    );
}

/// The errors of the steps before explain how far the steps' results are off, and silence no step.
#[test]
fn carried_errors_are_as_large_as_they_say() {
    let simulation = arm(4);
    let of_trial = |trial| {
        let known = steps(&simulation.session(trial));
        let place = |joint, quantity| carried::place(joint, quantity).collect::<Vec<_>>();
        let z =
            z_scores(&simulation, &known, |joint, quantity, _| known.errors.of(&place(joint, quantity))[(0, 0)].sqrt());
        assert_eq!(z.len(), findable(4), "{trial}: {known:?}");
        z
    };
    let z: Vec<f64> = (0..40).flat_map(of_trial).collect();
    assert!((0.85..1.2).contains(&rms(&z)), "{}", rms(&z));
}

#[test]
fn the_reference_protocol_is_not_silenced() {
    for trial in 0..40 {
        let known = steps(&sarcos_shoulder().session(trial));
        assert!(known.gravity.is_ok(), "{trial}: {:?}", known.gravity);
        let missing: Vec<&Missing> = known.sensors.iter().filter_map(|s| s.torque_gain.as_ref().err()).collect();
        assert!(missing.len() == 1 && missing[0].why.contains("last joint"), "{trial}: {missing:?}");
    }
}

#[test]
fn a_step_that_its_readings_rule_out_tells_no_number() {
    let add = |session: &mut Session, table: usize, joint: usize, error: fn(usize) -> f64| {
        let poses = session.poses.iter_mut().filter(|pose| pose.table == table);
        for (index, pose) in poses.enumerate() {
            pose.torque[joint].as_mut().unwrap().value += error(index);
        }
    };
    let reported = |change: &dyn Fn(&mut Session)| {
        let mut session = sarcos_shoulder().session(3);
        change(&mut session);
        let known = steps(&session);
        let why = |found: &Found| found.as_ref().err().map(|missing| missing.why.clone()).unwrap_or_default();
        let gravity = known.gravity.as_ref().err().map(|missing| missing.why.clone()).unwrap_or_default();
        (why(&known.sensors[1].torque_bias), gravity, why(&known.sensors[1].torque_gain))
    };
    let (bias, gravity, gain) = reported(&|_| ());
    assert!([bias, gravity, gain].iter().all(String::is_empty));
    // A kink in a sweep is no sinusoid.
    let (bias, gravity, _) = reported(&|session| add(session, 1, 1, |index| if index < 12 { 12.0 } else { 0.0 }));
    assert!(
        bias.contains("contradict") && bias.contains("p < 0.001") && gravity.contains("step 1"),
        "{bias} {gravity}"
    );
    // Another bias at one position of joint 1.
    let (bias, gravity, _) = reported(&|session| add(session, 4, 1, |_| 40.0));
    assert!(bias.is_empty() && gravity.contains("contradict"), "{bias} {gravity}");
    // The bias has moved before the last load was put on: no displacement of the known length does that at both positions.
    let (bias, _, gain) = reported(&|session| add(session, 10, 1, |_| 40.0));
    assert!(bias.is_empty() && gain.contains("contradict"), "{bias} {gain}");
}

/// What noise nobody states comes from the residuals, in the standard deviations and in what contradicts.
#[test]
fn noise_that_no_reading_states_is_that_of_the_residuals() {
    let stated = sarcos_shoulder().session(5);
    let mut session = stated.clone();
    for reading in session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()) {
        reading.std = None;
    }
    let [stated, found] = [&stated, &session].map(steps);
    for (a, b) in stated.sensors.iter().zip(&found.sensors) {
        for quantity in [SensorParameter::TorqueBias, SensorParameter::PositionGain] {
            let [a, b] = [a, b].map(|sensor| sensor.of(quantity).as_ref().unwrap().std);
            assert!((0.7..1.4).contains(&(b / a)), "{quantity}: {b} instead of {a}");
        }
    }
    assert!(found.gravity.is_ok());
    for pose in session.poses.iter_mut().filter(|pose| pose.table == 4) {
        pose.torque[1].as_mut().unwrap().value += 40.0;
    }
    let why = steps(&session).gravity.unwrap_err().why;
    assert!(why.contains("noise that step 1 found"), "{why}");
}

/// A sweep in two pairs would count twice.
#[test]
fn a_sweep_is_in_one_pair_at_most() {
    let mut simulation = sarcos_shoulder();
    for run in [5, 6, 5] {
        simulation.runs.push(simulation.runs[run].clone());
        simulation.template.tables.push(simulation.template.tables[run].clone());
    }
    let plan = Plan::new(&simulation.session(0));
    let sweeps: Vec<[usize; 2]> = plan.gain[0].iter().map(|pair| pair.sweeps).collect();
    assert_eq!(sweeps, [[5, 6], [11, 12]]);
}
