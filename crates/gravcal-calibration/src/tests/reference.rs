//! The estimators on the reference protocol, against the figures of an independent program (NumPy, SciPy).

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{PriorKind, Session};

use crate::joint::{self, Signals, Solved, State, estimate_jointly};
use crate::result::{EstimatorResult, Verdict};
use crate::sequential::{Plan, report_steps, run_steps};
use crate::testing::{sarcos_shoulder, with_environment};

fn at_truth(session: &Session, truth: &State) -> Solved {
    let readings = joint::select(session, Signals::All);
    Solved::at_start(joint::build_problem(session, &readings, truth).unwrap()).unwrap()
}

/// Cramér-Rao bound with all torques read: model of the independent program, printed to two or three digits.
#[test]
fn the_bound_is_that_of_an_independent_program() {
    let simulation = sarcos_shoulder();
    let judged = at_truth(&simulation.session(0), &simulation.truth);
    let close = |found: f64, expected: f64, what: &str| {
        assert!((found / expected - 1.0).abs() < 0.03, "{what}: {found}, not {expected}");
    };
    let gravity = judged.gravity_covariance();
    for (axis, expected) in [0.0032, 0.0028, 0.0027].into_iter().enumerate() {
        close(gravity[4 * axis].sqrt(), expected, "gravity");
    }
    let expected: [[f64; 3]; 3] = [[0.0206, 0.0173, 0.0187], [0.114, 0.0579, 0.0779], [0.00044, 0.00043, 0.00036]];
    for joint in 0..3 {
        for (quantity, expected) in
            [SensorParameter::TorqueGain, SensorParameter::TorqueBias, SensorParameter::PositionGain]
                .iter()
                .zip(expected)
        {
            close(judged.sensor_std(joint, *quantity), expected[joint], &quantity.name(&joint.to_string()));
        }
    }
    close(judged.sensor_std(1, SensorParameter::PositionOffset), 0.0240_f64.to_radians(), "offset of joint 2");
}

#[test]
fn without_noise_both_estimators_find_the_truth() {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance.torque_std = vec![1e-9; 3];
    let mut session = simulation.session(0);
    for reading in session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()) {
        reading.std = Some(0.8);
    }
    with_environment(|environment| {
        let steps = run_steps(&session, &Plan::new(&session), environment);
        let found = steps.as_start(&session).unwrap();
        for joint in 0..2 {
            for quantity in 0..4 {
                let (value, truth) = (found.sensors[joint][quantity], simulation.truth.sensors[joint][quantity]);
                assert!(
                    (value - truth).abs() < 1e-6 * truth.abs().max(1.0),
                    "step: {joint} {quantity} {value} {truth}"
                );
            }
        }
        let solved = joint::solve(&session, &joint::select(&session, Signals::All), None, environment).unwrap();
        let found = solved.state(&simulation.truth);
        for joint in 0..3 {
            for quantity in SensorParameter::ALL.into_iter().filter(|q| session.fixed_reason(joint, *q).is_none()) {
                let truth = simulation.truth.sensors[joint][quantity as usize];
                let value = found.sensors[joint][quantity as usize];
                assert!((value - truth).abs() < 1e-6 * truth.abs(), "joint: {joint} {quantity} {value} {truth}");
            }
        }
        assert!((0..3).all(|i| (found.gravity[i] - simulation.truth.gravity[i]).abs() < 1e-6));
    });
}

#[test]
fn the_joint_estimate_determines_everything_and_fits_its_noise() {
    let session = sarcos_shoulder().session(3);
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(result.verdict, Verdict::Determined);
    let undetermined: Vec<&str> = result.parameters.iter().filter(|p| !p.determined).map(|p| p.name.as_str()).collect();
    assert_eq!(undetermined, ["joint3.position_offset"]);
    let fit = result.fit.unwrap();
    assert!(fit.p_value.unwrap() > 1e-4, "p = {:?}", fit.p_value);
    let held_out = fit.held_out.unwrap();
    let excess = held_out.chi_squared / held_out.readings as f64;
    assert!((0.6..1.6).contains(&excess), "{excess}");
    assert!(fit.joints.iter().all(|j| (0.6..1.0).contains(&j.rms) && !j.noise_estimated));
}

#[test]
fn tables_for_validation_enter_no_fit_and_are_predicted_by_it() {
    let alone = sarcos_shoulder().session(3);
    let session = Session { validation: sarcos_shoulder().session(4).poses, ..alone.clone() };
    let [without, with] =
        [&alone, &session].map(|s| with_environment(|w| estimate_jointly(s, Signals::All, None, w)).unwrap());
    let values = |result: &EstimatorResult| result.parameters.iter().map(|p| p.value).collect::<Vec<_>>();
    assert_eq!(values(&without), values(&with));
    let held_out = with.fit.unwrap().held_out.unwrap();
    assert_eq!(held_out.poses, session.validation.len());
    let excess = held_out.chi_squared / held_out.readings as f64;
    assert!((0.9..1.2).contains(&excess), "{excess}");
    assert_eq!(held_out.files.len(), session.tables.len());
    // Readings that are off by ten counts are told, though the fit is the same.
    let mut off = session.clone();
    off.validation
        .iter_mut()
        .flat_map(|pose| pose.torque.iter_mut().flatten())
        .for_each(|reading| reading.value += 10.0);
    let result = with_environment(|w| estimate_jointly(&off, Signals::All, None, w)).unwrap();
    assert!(result.fit.unwrap().held_out.unwrap().joints.iter().all(|joint| joint.rms > 9.0));
}

#[test]
fn what_is_held_out_are_stretches_of_each_sweep_or_table() {
    let mut session = sarcos_shoulder().session(3);
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    let held_out = result.fit.unwrap().held_out.unwrap();
    assert_eq!(held_out.stretches, session.tables.len());
    assert!(held_out.poses > 3 * held_out.stretches, "{held_out:?}");
    // One table, in which no joint sweeps.
    session.poses.iter_mut().for_each(|pose| pose.table = 0);
    let poses = session.poses.len();
    session.poses = (0..poses).map(|k| session.poses[k * 123 % poses].clone()).collect();
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    let held_out = result.fit.unwrap().held_out.unwrap();
    assert_eq!((held_out.stretches, held_out.poses), (1, (poses + 5) / 10));
}

#[test]
fn noise_that_no_reading_states_is_estimated_and_no_p_value_given() {
    let mut session = sarcos_shoulder().session(0);
    for reading in session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()) {
        reading.std = None;
    }
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    let fit = result.fit.unwrap();
    assert_eq!(fit.p_value, None);
    assert!(fit.joints.iter().all(|j| j.noise_estimated && (j.noise_std - 0.8).abs() < 0.1));
    assert_eq!(result.verdict, Verdict::Determined);
}

#[test]
fn missing_and_unusable_readings_drop_their_row_only() {
    let mut session = sarcos_shoulder().session(0);
    let all: usize = joint::select(&session, Signals::All).count();
    for pose in session.poses.iter_mut().step_by(7) {
        pose.torque[1] = None;
    }
    let dropped = session.poses.len().div_ceil(7);
    let used: usize = joint::select(&session, Signals::All).count();
    assert_eq!(used, all - dropped);
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(result.verdict, Verdict::Determined);
    let steps = with_environment(|w| report_steps(&session, &run_steps(&session, &Plan::new(&session), w), w)).unwrap();
    assert!(steps.gravity.is_some());
}

/// Section 4 of the estimation model: bare sweeps leave one scale common to all torque gains.
#[test]
fn bare_sweeps_leave_the_common_scale_of_the_torque_gains() {
    let mut session = sarcos_shoulder().session(0);
    session.poses.retain(|pose| pose.load.is_none());
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(result.verdict, Verdict::PartlyDetermined);
    let reported: Vec<&str> = result.undetermined.iter().map(|u| u.combination.as_str()).collect();
    assert_eq!(reported, ["common scale of all torque gains", "joint3.position_offset"]);
    assert!(result.undetermined[0].cure.contains("attach a load"));
    let value = |name: &str| result.parameter(name).and_then(|p| p.value);
    assert_eq!(value("joint1.torque_gain"), None);
    assert!(value("joint2.position_offset").is_some() && result.gravity.is_some());
}

#[test]
fn an_exact_gain_fixes_the_scale_and_a_prior_enters_with_its_width() {
    let mut session = sarcos_shoulder().session(0);
    session.poses.retain(|pose| pose.load.is_none());
    session.joints[0].parameters[0].nominal = 7.12;
    session.joints[0].parameters[0].kind = PriorKind::Fixed;
    let fixed = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(fixed.verdict, Verdict::Determined);
    session.joints[0].parameters[0].kind = PriorKind::Gaussian { std: 0.1 };
    let prior = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    let std = prior.parameters[0].std.unwrap();
    assert!((std - 0.1).abs() < 1e-3, "{std}");
}

/// Gravity torques predicted from the determined combinations alone equal those of the solution.
#[test]
fn the_determined_moments_predict_gravity_torques() {
    let simulation = sarcos_shoulder();
    let session = simulation.session(0);
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    let names: Vec<String> = (1..=3)
        .flat_map(|k| ["mass", "first_moment.x", "first_moment.y", "first_moment.z"].map(|c| format!("link{k}.{c}")))
        .collect();
    let links: Vec<_> = result.moments.iter().filter(|m| m.terms.iter().all(|(n, _)| names.contains(n))).collect();
    // Least-norm masses and moments that reproduce the combinations.
    let system = faer::Mat::from_fn(links.len(), names.len(), |i, j| {
        links[i].terms.iter().find(|(n, _)| *n == names[j]).map_or(0.0, |(_, c)| *c)
    });
    let values = faer::Mat::from_fn(links.len(), 1, |i, _| links[i].value);
    let inertia = system.thin_svd().unwrap().pseudoinverse() * values;
    let inertia: Vec<f64> = (0..names.len()).map(|i| inertia[(i, 0)]).collect();
    let gravity = result.gravity.unwrap().vector_m_per_s2;
    for coordinates in [[0.1, 2.0, -0.4], [-1.0, 3.0, 1.2]] {
        let torque = |inertia: &[f64], gravity: [f64; 3]| {
            let mut torque = vec![0.0; 3];
            session.robot.chain.gravity_torque(&coordinates, gravity, inertia, &mut torque);
            torque
        };
        let predicted = torque(&inertia, gravity);
        let truth: Vec<f64> = simulation.truth.inertia.iter().flatten().copied().collect();
        let truth = torque(&truth, simulation.truth.gravity);
        assert!(predicted.iter().zip(&truth).all(|(p, t)| (p - t).abs() < 0.15), "{predicted:?} {truth:?}");
    }
}

#[test]
fn step_2_refuses_an_upright_base_with_two_positions_and_takes_a_third() {
    let mut simulation = sarcos_shoulder();
    simulation.truth.gravity = [0.0, 0.0, -9.8];
    simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
    let steps = |session: &Session| with_environment(|w| run_steps(session, &Plan::new(session), w));
    let refused = steps(&simulation.session(0)).gravity.unwrap_err();
    assert!(refused.why.contains("free direction") && refused.cure.contains("three or more"), "{refused:?}");

    let (run, table) = (simulation.runs[4].clone(), simulation.template.tables[4].clone());
    let gravcal_session::simulation::Run::Sweep { swept, range, poses, mut held } = run else { unreachable!() };
    held[0] = 0.15;
    simulation.runs.push(gravcal_session::simulation::Run::Sweep { swept, range, poses, held });
    simulation.template.tables.push(table);
    let found = steps(&simulation.session(0)).gravity.unwrap();
    let error = (0..3).map(|i| (found.vector[i] - simulation.truth.gravity[i]).powi(2)).sum::<f64>().sqrt() / 9.8;
    assert!(error < 0.02, "{error} rad");

    let joint = with_environment(|w| estimate_jointly(&sarcos_upright_two_positions(), Signals::All, None, w)).unwrap();
    assert!(joint.gravity.is_some());
}

fn sarcos_upright_two_positions() -> Session {
    let mut simulation = sarcos_shoulder();
    simulation.truth.gravity = [0.0, 0.0, -9.8];
    simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
    simulation.session(0)
}

#[test]
fn same_bits_on_one_thread_and_on_two() {
    let session = sarcos_shoulder().session(5);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let result = pool.install(|| with_environment(|w| estimate_jointly(&session, Signals::All, None, w))).unwrap();
        format!("{result:?}")
    };
    assert_eq!(run(1), run(2));
}

/// Gravity of uncertain magnitude is a free vector with its norm as a residual (paper, eq. (9)).
#[test]
fn an_uncertain_magnitude_widens_gravity_along_itself_only() {
    let mut session = sarcos_shoulder().session(0);
    session.gravity.magnitude_std = Some(0.05);
    let free = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(free.verdict, Verdict::Determined);
    let gravity = free.gravity.unwrap();
    let norm = gravity.vector_m_per_s2.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!((norm - 9.8).abs() < 1e-3, "{norm}");
    // Moments and masses take up the scale, so the norm is known by its prior alone.
    let along: f64 = gravity.std_m_per_s2.iter().map(|s| s * s).sum::<f64>().sqrt();
    assert!((along - 0.05).abs() < 0.005, "{along}");
    assert!(gravity.cone95_deg < 0.1);
}

#[test]
fn readings_that_contradict_the_model_determine_nothing() {
    let mut session = sarcos_shoulder().session(0);
    for reading in session.poses.iter_mut().filter_map(|pose| pose.torque[1].as_mut()) {
        reading.value = 4096.0 - reading.value; // reversed, and not declared so
    }
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(result.verdict, Verdict::Failed);
    let reported = result.notes.join(" ");
    assert!(reported.contains("times worse than their stated noise") || reported.contains("reversed"), "{reported}");
}

#[test]
fn a_moderate_misfit_widens_the_standard_deviations() {
    let session = sarcos_shoulder().session(0);
    let mut optimistic = session.clone();
    for reading in optimistic.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()) {
        reading.std = Some(0.4); // half of what it is
    }
    let [honest, widened] =
        [&session, &optimistic].map(|s| with_environment(|w| estimate_jointly(s, Signals::All, None, w)).unwrap());
    assert_eq!(widened.verdict, Verdict::PartlyDetermined, "its intervals cannot be relied on");
    assert!(widened.notes.iter().any(|note| note.contains("2.0 times worse")), "{:?}", widened.notes);
    let std = |result: &crate::result::EstimatorResult| result.parameters[0].std.unwrap();
    // At least by the misfit; by what leaving out poses tells where that is more, by chance here.
    let ratio = std(&widened) / std(&honest);
    assert!((0.95..1.5).contains(&ratio), "{ratio}");
}

/// A joint without a torque sensor tells nothing itself, and takes nothing from the others.
#[test]
fn a_first_joint_without_a_torque_sensor_leaves_the_others_determined() {
    let mut session = sarcos_shoulder().session(0);
    session.joints[0].torque_unit = None;
    session.poses.iter_mut().for_each(|pose| pose.torque[0] = None);
    let result = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(result.verdict, Verdict::Determined);
    let truth = sarcos_shoulder().truth;
    for (joint, quantity) in
        [(1, SensorParameter::TorqueGain), (2, SensorParameter::TorqueGain), (0, SensorParameter::PositionGain)]
    {
        let reported = &result.parameters[4 * joint + quantity as usize];
        let error = reported.value.unwrap() - truth.sensors[joint][quantity as usize];
        assert!(error.abs() < 4.5 * reported.std.unwrap(), "{}: {error}", reported.name);
    }
    assert!(result.fit.unwrap().p_value.unwrap() > 1e-4);
}

/// Without lengths the readings cannot tell gravity from its opposite; a load at the end of known lengths can.
#[test]
fn without_a_hemisphere_known_lengths_decide_the_sign_of_gravity() {
    let mut session = sarcos_shoulder().session(0);
    session.gravity.hemisphere = None;
    let shoulder = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert!(shoulder.verdict == Verdict::PartlyDetermined && shoulder.gravity.is_none());
    assert!(shoulder.undetermined.iter().any(|u| u.combination == "sign of gravity" && u.cure.contains("hemisphere")));
    // The moments, negative, explain as much.
    assert!(shoulder.moments.is_empty());
    let gain = &shoulder.parameters[0];
    assert!((gain.value.unwrap() - 7.12).abs() < 4.5 * gain.std.unwrap());

    let mut long = sarcos_shoulder();
    long.template.robot.chain = long_arm();
    let mut session = long.session(0);
    session.gravity.hemisphere = None;
    let arm = with_environment(|w| estimate_jointly(&session, Signals::All, None, w)).unwrap();
    assert_eq!(arm.verdict, Verdict::Determined, "{:?}", arm.undetermined);
    assert!(!arm.moments.is_empty());
    let found = arm.gravity.unwrap().vector_m_per_s2;
    assert!(found.iter().zip(long.truth.gravity).all(|(a, b)| (a - b).abs() < 0.05), "{found:?}");
}

/// The shoulder's axes with lengths between them.
fn long_arm() -> gravcal_dynamics::Chain {
    use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};
    let row = |i: usize, alpha: f64| DhRow {
        name: format!("joint{i}"),
        kind: JointKind::Revolute,
        a: 0.3,
        alpha: alpha.to_radians(),
        d: 0.1,
        theta: 0.0,
        limits: None,
        link: Link { name: format!("link{i}"), inertia: None },
    };
    chain_from_dh("base", DhConvention::Standard, &[row(1, 90.0), row(2, -90.0), row(3, 90.0)]).unwrap()
}
