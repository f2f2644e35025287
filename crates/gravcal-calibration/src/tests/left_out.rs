//! The joint estimate without some of its poses: what the jackknife says, against solving again, and with all that a session may have.

use gravcal_estimation::LossName;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{Deflection, PoseBlocks, Session, UncertaintyChoice};
use gravcal_solvers::{Clarabel, LevenbergMarquardt};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::joint::{self, Signals, estimate_jointly};
use crate::result::{Brief, EstimatorResult, UncertaintyResult, Verdict};
use crate::testing::{sarcos_shoulder, sarcos_with_instruments};

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

fn briefly(session: &Session) -> Brief {
    let solver = LevenbergMarquardt::default();
    let readings = joint::select(session, Signals::All);
    joint::estimate_briefly(session, &readings, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

fn jackknifed(session: Session, blocks: PoseBlocks) -> Session {
    Session { uncertainty: UncertaintyChoice::Jackknife { blocks }, ..session }
}

/// Neighbouring poses share an error as large as the noise.
fn with_shared_errors(trial: u64) -> Session {
    let mut session = sarcos_shoulder().session(trial);
    let mut random = Pcg64::new(99, u128::from(trial));
    for block in session.poses.chunks_mut(11) {
        for joint in 0..3 {
            let shared: f64 = StandardNormal.sample(&mut random);
            block.iter_mut().filter_map(|pose| pose.torque[joint].as_mut()).for_each(|r| r.value += 0.8 * shared);
        }
    }
    session
}

/// Standard deviations of what was estimated, of parameters that have any.
fn stds(result: &EstimatorResult) -> Vec<f64> {
    let estimated = result.parameters.iter().filter(|p| p.determined && p.held.is_none());
    estimated.filter_map(|p| p.std).collect()
}

/// 33 blocks of 12 or 13 poses, each left out and all solved again.
#[test]
fn it_is_nearly_what_solving_again_gives() {
    // What a test on residuals names widens intervals beyond what leaving out tells.
    let spoilt = |result: &EstimatorResult| result.residual_tests.iter().any(|test| test.spoils_intervals);
    let of_trial = |trial: u64| {
        let session = with_shared_errors(trial);
        let result = estimate(&jackknifed(session.clone(), PoseBlocks::Poses(12)));
        (!spoilt(&result)).then_some((session, result))
    };
    let (session, result) = (0..20).find_map(of_trial).unwrap();
    let Some(UncertaintyResult::Jackknife(reported)) = &result.uncertainty else { panic!("{:?}", result.uncertainty) };
    assert_eq!((reported.blocks, reported.block_poses, reported.correlation), (33, [12, 13], None));
    let all = briefly(&session);
    let mut squares = vec![0.0; all.parameters.len()];
    for table in 0..session.tables.len() {
        let own: Vec<usize> = (0..session.poses.len()).filter(|pose| session.poses[*pose].table == table).collect();
        assert_eq!(own.len(), 37);
        for part in [0..12, 12..24, 24..37] {
            let out = &own[part];
            let mut fewer = session.clone();
            fewer.poses =
                session.poses.iter().enumerate().filter(|(i, _)| !out.contains(i)).map(|(_, p)| p.clone()).collect();
            let without = briefly(&fewer);
            for (sum, (a, b)) in squares.iter_mut().zip(without.parameters.iter().zip(&all.parameters)) {
                *sum += (a.value.unwrap_or(0.0) - b.value.unwrap_or(0.0)).powi(2);
            }
        }
    }
    for (parameter, squares) in result.parameters.iter().zip(squares) {
        if let (true, None, Some(std)) = (parameter.determined, &parameter.held, parameter.std) {
            let ratio = std / (squares * 32.0 / 33.0).sqrt();
            assert!((ratio - 1.0).abs() < 0.1, "{}: {ratio}", parameter.name);
        }
    }
}

/// Mean square of the errors in their own standard deviations, which is 1 where these are right. No block is stated: the length is found.
#[test]
fn errors_that_poses_share_are_found_and_reported_whether_asked_for_or_not() {
    const TRIALS: u64 = 30;
    let truth = sarcos_shoulder().truth;
    let mean_square = |choice: UncertaintyChoice| {
        let errors = |trial| {
            let brief = briefly(&Session { uncertainty: choice, ..with_shared_errors(trial) });
            let estimated = brief.parameters.into_iter().enumerate().filter(|(_, p)| p.determined && p.held.is_none());
            let error = |(i, p): (usize, crate::result::ParameterResult)| {
                (p.value.unwrap() - truth.sensors[i / 4][i % 4]) / p.std.unwrap()
            };
            estimated.map(error).collect::<Vec<f64>>()
        };
        let errors: Vec<f64> = (0..TRIALS).flat_map(errors).collect();
        errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64
    };
    for choice in [UncertaintyChoice::Noise, UncertaintyChoice::Jackknife { blocks: PoseBlocks::Found }] {
        let found = mean_square(choice);
        assert!((0.5..1.5).contains(&found), "{choice:?}: {found}");
    }
    let by_itself = estimate(&with_shared_errors(0));
    let Some(UncertaintyResult::LargerOfNoiseAndJackknife { widened_by: Some(widened), jackknife, .. }) =
        by_itself.uncertainty
    else {
        panic!("{:?}", by_itself.uncertainty)
    };
    assert!((1.2..1.6).contains(&widened) && jackknife.block_poses[0] > 3, "{widened} {jackknife:?}");
    assert!(jackknife.told_by_one_block.is_empty());
}

/// Where only noise is, leaving out poses tells what the noise tells.
#[track_caller]
fn assert_like_noise(session: &Session, blocks: PoseBlocks, [low, high]: [f64; 2]) {
    let noise = estimate(&Session { uncertainty: UncertaintyChoice::Noise, ..session.clone() });
    assert!(matches!(noise.uncertainty, Some(UncertaintyResult::Noise { .. })), "{:?}", noise.uncertainty);
    let result = estimate(&jackknifed(session.clone(), blocks));
    assert!(matches!(result.uncertainty, Some(UncertaintyResult::Jackknife(_))), "{:?}", result.uncertainty);
    let (a, b) = (stds(&result), stds(&noise));
    assert_eq!(a.len(), b.len());
    let ratios: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a / b).collect();
    assert!(ratios.iter().all(|ratio| (low..high).contains(ratio)), "{ratios:?}");
}

#[test]
fn noise_alone_is_reported_by_leaving_out_poses_too() {
    let session = sarcos_shoulder().session(3);
    for blocks in [PoseBlocks::Found, PoseBlocks::Poses(1), PoseBlocks::Poses(4), PoseBlocks::Pairs] {
        assert_like_noise(&session, blocks, [0.6, 1.6]);
    }
}

#[test]
fn instruments_of_a_pose_leave_with_it() {
    assert_like_noise(&sarcos_with_instruments().session(0), PoseBlocks::Poses(3), [0.5, 2.0]);
}

#[test]
fn unknowns_of_single_poses_leave_with_them() {
    let mut session = sarcos_shoulder().session(0);
    session.deflection = Deflection { pose_std: Some(0.002), ..Deflection::default() };
    assert_like_noise(&session, PoseBlocks::Poses(3), [0.5, 2.0]);
}

/// The torque gain that is farthest from its nominal value may be no farther than half a standard deviation less: it leans on that in every fit.
#[test]
fn along_an_active_constraint_leaving_out_poses_tells_what_noise_tells() {
    let mut session = sarcos_shoulder().session(0);
    let free = estimate(&session);
    let farthest = |joint: usize| {
        let gain =
            free.parameter(&session.parameter_name(ParameterId::Sensor(joint, SensorParameter::TorqueGain))).unwrap();
        let nominal = session.joints[joint].of(SensorParameter::TorqueGain).nominal;
        ((gain.value.unwrap() - nominal).abs() - 0.5 * gain.std.unwrap()) / nominal.abs()
    };
    let share = (0..session.joints.len()).map(farthest).fold(0.0, f64::max);
    session.constraints.torque_gains_within = Some(share);
    let constrained = |uncertainty: UncertaintyChoice| {
        let session = Session { uncertainty, ..session.clone() };
        let solver = Clarabel::default();
        let environment = SolveEnvironment::new(&solver, &|_: &str| {});
        let result = estimate_jointly(&session, Signals::All, None, &environment).unwrap();
        assert_eq!(result.active_constraints.len(), 1, "{:?}", result.active_constraints);
        stds(&result)
    };
    let blocks = PoseBlocks::Poses(3);
    let (left_out, noise) =
        (constrained(UncertaintyChoice::Jackknife { blocks }), constrained(UncertaintyChoice::Noise));
    assert_eq!(left_out.len(), noise.len());
    for (left_out, noise) in left_out.iter().zip(&noise) {
        assert!(
            (0.5 * noise..2.0 * noise).contains(left_out) || (*noise == 0.0 && *left_out == 0.0),
            "{left_out} {noise}"
        );
    }
}

#[test]
fn outliers_under_a_loss_hardly_count_where_poses_are_left_out() {
    let mut session = sarcos_shoulder().session(0);
    session.loss = LossName::Huber.efficient();
    for (k, reading) in session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()).enumerate() {
        if k % 20 == 7 {
            reading.value += 60.0;
        }
    }
    assert_like_noise(&session, PoseBlocks::Poses(5), [0.5, 2.0]);
}

/// The torque gains' common scale is told by one sweep with each load. Where each is one block, neither can be left out.
#[test]
fn what_one_block_of_poses_tells_is_named_and_no_verdict_leans_on_it() {
    let mut session = sarcos_shoulder().session(1);
    let of_load = |load| session.poses.iter().find(|pose| pose.load == Some(load)).unwrap().table;
    let kept = [of_load(0), of_load(1)];
    session.poses.retain(|pose| pose.load.is_none() || kept.contains(&pose.table));
    let mut time = 0.0;
    for pose in &mut session.poses {
        time += if pose.load.is_some() { 0.01 } else { 1.0 };
        pose.conditions.time = Some(time);
    }
    let gains = ["joint1.torque_gain", "joint2.torque_gain", "joint3.torque_gain"];
    let reported = |blocks| {
        let result = estimate(&jackknifed(session.clone(), blocks));
        let reported = result.uncertainty.as_ref().unwrap().jackknife().unwrap().told_by_one_block.clone();
        assert!(result.parameter(gains[1]).unwrap().std.unwrap().is_finite());
        (reported, result.verdict, result.notes)
    };
    let (by_few, verdict, _) = reported(PoseBlocks::Poses(3));
    assert_eq!((by_few, verdict), (vec![], Verdict::Determined));
    let (by_one, verdict, notes) = reported(PoseBlocks::Seconds(10.0));
    assert_eq!((by_one, verdict), (gains.map(str::to_owned).to_vec(), Verdict::PartlyDetermined));
    assert!(notes.iter().any(|note| note.starts_with("A part of joint1.torque_gain, ")), "{notes:?}");
}
