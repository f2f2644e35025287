//! The degenerate cases of a session, each with the cure that `check` names first, and that it is one: readings simulated
//! with the addition determine what was open, at the truth.

use std::f64::consts::FRAC_PI_2;

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
use rand::RngExt;
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use super::additions::additions;
use super::hypothetical::Hypothetical;
use super::*;
use crate::joint::{State, build_problem, estimate_jointly};

/// Standard deviation of a torque reading, count.
const NOISE: f64 = 0.2;
/// On a tilted base.
const TILTED: [f64; 3] = [-0.35, -0.61, -0.71];
const UPRIGHT: [f64; 3] = [0.0, 0.0, -1.0];

/// An arm with these twists, its links 0.3 m long and as heavy as an arm's.
fn arm(twists_deg: &[f64], direction: [f64; 3]) -> Session {
    let row = |(joint, twist): (usize, &f64)| DhRow {
        name: format!("joint{}", joint + 1),
        kind: JointKind::Revolute,
        a: 0.3,
        alpha: twist.to_radians(),
        d: 0.1,
        theta: 0.0,
        limits: Some([-2.0, 2.0]),
        link: Link {
            name: format!("link{}", joint + 1),
            inertia: Some(LinkInertia { mass: 2.0, first_moment: [-0.2, 0.12, 0.15] }),
        },
    };
    let joints = twists_deg.len();
    let rows: Vec<DhRow> = twists_deg.iter().enumerate().map(row).collect();
    let chain = chain_from_dh("base", DhConvention::Standard, &rows).unwrap();
    let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
    let joint = JointPriors {
        torque_unit: Some(TorqueUnit::Count),
        torque_sign_declared: true,
        position_unit: PositionUnit::Radian,
        parameters: [start(6.0), start(2048.0), start(1.0), start(0.0)],
    };
    let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    let gravity = GravityPrior {
        magnitude: 9.8,
        magnitude_std: None,
        hemisphere: Some(direction.map(|component| component / norm)),
    };
    Session::new(
        Robot { name: "arm".into(), sensors: vec![Default::default(); joints], chain },
        gravity,
        vec![joint; joints],
    )
}

/// A load at two placements, a known distance apart if it is said.
fn with_loads(mut session: Session, distance: bool) -> Session {
    let link = session.joints.len() - 1;
    session.loads =
        ["a", "b"].map(|name| Load { name: name.into(), mass: 2.0, link, position: None, position_std: None }).to_vec();
    session.load_distances =
        if distance { vec![LoadDistance { between: [0, 1], distance: 0.3, std: None }] } else { Vec::new() };
    session
}

/// The session with poses of which each run has its load.
fn recorded(mut session: Session, runs: Vec<(Option<usize>, Run)>) -> Session {
    let table = |load| PoseTable { path: "poses.csv".into(), load, swept: None, step: None };
    session.tables = runs.iter().map(|(load, _)| table(*load)).collect();
    let truth = State::nominal(&session);
    let joints = session.joints.len();
    let runs = runs.into_iter().map(|(_, run)| run).collect();
    Simulation::new(session, truth, runs, Disturbance::noise(vec![NOISE; joints]), 5).session(0)
}

fn random(load: Option<usize>) -> (Option<usize>, Run) {
    (load, Run::Random { poses: 40, moving: None })
}

fn sweep(swept: usize, reach: f64, held: &[f64]) -> (Option<usize>, Run) {
    (None, Run::Sweep { swept, range: [-reach, reach], poses: 15, held: held.to_vec() })
}

/// What of a session is open, by its name in the report.
fn open<'r>(report: &'r CheckReport, combination: &str) -> &'r Curable {
    let all: Vec<&str> = report.undetermined.iter().map(|open| open.undetermined.combination.as_str()).collect();
    let found = report.undetermined.iter().find(|open| open.undetermined.combination == combination);
    found.unwrap_or_else(|| panic!("{combination} is not open, but {all:?}"))
}

/// That the first cure of a combination begins with these words, and cures it.
fn assert_first_cure(session: &Session, combination: &str, words: &str) {
    let report = check(session).unwrap();
    let open = open(&report, combination);
    let reported: Vec<&str> = open.cures.iter().map(|cure| cure.addition.as_str()).collect();
    assert!(reported.first().is_some_and(|first| first.starts_with(words)), "{combination}: {reported:?}");
    assert_eq!(open.undetermined.cure, reported[0]);
    assert!(reported.len() <= 3);
    assert_cures(session, &open.undetermined.parameters, &open.cures[0]);
}

/// That what was foretold of a cure comes true.
fn assert_cures(session: &Session, parameters: &[String], cure: &Cure) {
    assert_determines(&with_cure(session, cure), parameters, cure);
}

/// The session with the additions of a cure.
fn with_cure(session: &Session, cure: &Cure) -> Hypothetical {
    let now = Hypothetical::now(session).unwrap();
    let parts: Vec<&str> = cure.addition.split("; and ").collect();
    let additions: Vec<_> = additions(&now).into_iter().flatten().collect();
    let made: Vec<_> = additions.iter().filter(|addition| parts.contains(&addition.words.as_str())).collect();
    assert_eq!(made.len(), parts.len(), "{parts:?}");
    made.iter().fold(now, |hypothetical, addition| addition.made(&hypothetical))
}

/// Readings simulated at other than the nominal values, with the addition, determine the parameters near the truth, as well as
/// was foretold.
fn assert_determines(hypothetical: &Hypothetical, parameters: &[String], cure: &Cure) {
    let (session, truth) = simulated(hypothetical);
    let solver = LevenbergMarquardt::default();
    let result =
        estimate_jointly(&session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap();
    for name in parameters {
        if name == "gravity" {
            let found =
                result.gravity.as_ref().unwrap_or_else(|| panic!("{}: {:?}", cure.addition, result.undetermined));
            let along: f64 = found.vector_m_per_s2.iter().zip(truth.gravity).map(|(a, b)| a * b).sum();
            assert!(along > 0.99 * 9.8 * 9.8, "{}: {found:?}", cure.addition);
            continue;
        }
        let id = session.parameters().into_iter().find(|id| session.parameter_name(*id) == *name).unwrap();
        let reported = result.parameter(name).unwrap();
        let (value, std) =
            (reported.value.unwrap_or_else(|| panic!("{}: {reported:?}", cure.addition)), reported.std.unwrap());
        assert!(
            (value - truth.value(id)).abs() < 5.0 * std,
            "{}: {reported:?}, not {}",
            cure.addition,
            truth.value(id)
        );
        let foretold = cure.predicted.iter().find(|predicted| predicted.name == *name).unwrap().std.unwrap();
        assert!((0.4..2.5).contains(&(std / foretold)), "{}: {name} ± {std}, foretold {foretold}", cure.addition);
    }
}

/// The session with readings of a truth beside its nominal values, with noise.
fn simulated(hypothetical: &Hypothetical) -> (Session, State) {
    let mut session = hypothetical.session.clone();
    let mut truth = hypothetical.values.clone();
    let mut random = Pcg64::new(9, 0);
    for id in session.parameters() {
        let parameter = session.parameter(id);
        let spread = match parameter.prior.kind {
            PriorKind::Gaussian { std } => std,
            _ => 0.03 * parameter.prior.nominal.abs().clamp(0.5, 10.0),
        };
        if parameter.fixed.is_none() {
            *truth.value_mut(id) += spread * random.random_range(-1.0..1.0);
        }
    }
    let readings = select(&session, Signals::All);
    let predicted = build_problem(&session, &readings, &truth).unwrap().predicted(&session).unwrap();
    for (id, value) in predicted {
        let reading = session.reading_mut(id).unwrap();
        let noise: f64 = random.sample(StandardNormal);
        reading.value = value + reading.std.unwrap() * noise;
    }
    (session, truth)
}

const FOUR: [f64; 4] = [90.0, -90.0, 90.0, 0.0];

#[test]
fn an_upright_base_is_to_be_tilted() {
    let session = recorded(with_loads(arm(&FOUR, UPRIGHT), true), vec![random(None), random(Some(0)), random(Some(1))]);
    for quantity in ["torque_gain", "position_gain"] {
        assert_first_cure(&session, &format!("joint1.{quantity}"), "tilt the base by 10°");
    }
}

#[test]
fn a_tilt_determines_a_gain_whether_or_not_noise_is_stated() {
    let mut session =
        recorded(with_loads(arm(&FOUR, UPRIGHT), true), vec![random(None), random(Some(0)), random(Some(1))]);
    let reported = |session: &Session| {
        let tilt = *check(session).unwrap().tilts.last().unwrap();
        [tilt.torque_gain, tilt.position_gain].map(|gain| (gain.determined, gain.relative_std.is_some()))
    };
    assert_eq!(reported(&session), [(true, true); 2]);
    session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|reading| reading.std = None);
    assert_eq!(reported(&session), [(true, false); 2]);
}

#[test]
fn an_upright_base_without_a_load_needs_both() {
    let session = recorded(arm(&FOUR, UPRIGHT), vec![random(None)]);
    let report = check(&session).unwrap();
    let gain = open(&report, "joint1.torque_gain");
    let first = &gain.cures.first().unwrap().addition;
    assert!(first.contains("load of known mass") && first.contains("; and tilt the base"), "{first}");
    assert_cures(&session, &gain.undetermined.parameters, &gain.cures[0]);
}

#[test]
fn without_a_load_a_gain_is_to_be_stated_or_a_load_attached() {
    let session = recorded(arm(&FOUR, TILTED), vec![random(None)]);
    let scale = "common scale of all torque gains";
    assert_first_cure(&session, scale, "state joint1.torque_gain within 1 %");
    let report = check(&session).unwrap();
    let second = &open(&report, scale).cures[1];
    assert!(second.addition.starts_with("record 20 poses with a load of known mass (1 kg)"), "{second:?}");
    assert_cures(&session, &open(&report, scale).undetermined.parameters, second);
}

#[test]
fn loaded_poses_alone_want_bare_ones() {
    let session = recorded(with_loads(arm(&FOUR, TILTED), false), vec![random(Some(0))]);
    let report = check(&session).unwrap();
    let scale = open(&report, "common scale of all torque gains");
    let bare = scale.cures.iter().find(|cure| cure.addition.starts_with("record 20 bare poses")).unwrap();
    assert_cures(&session, &scale.undetermined.parameters, bare);
    assert_first_cure(&session, "common scale of all torque gains", "state joint1.torque_gain within 1 %");
}

/// All axes meet in a point: a load at one place adds to the unknown moment, and its weight says nothing of a length.
#[test]
fn a_load_at_one_placement_wants_a_second_one() {
    let mut session = crate::testing::sarcos_shoulder().template;
    session.loads.truncate(1);
    session.load_distances.clear();
    let session = recorded(session, vec![random(None), random(Some(0))]);
    let report = check(&session).unwrap();
    let scale = open(&report, "common scale of all torque gains");
    let second = scale.cures.iter().find(|cure| cure.addition.contains("second placement a known distance")).unwrap();
    assert_cures(&session, &scale.undetermined.parameters, second);
}

/// Joint 2 alone is read, while it sweeps at two positions of joint 1 that are half a turn apart.
#[test]
fn two_positions_half_a_turn_apart_want_a_third() {
    let mut session = arm(&[90.0, 0.0], TILTED);
    session.joints[0].torque_unit = None;
    for quantity in [SensorParameter::PositionGain, SensorParameter::PositionOffset] {
        session.joints[0].parameters[quantity as usize].kind = PriorKind::Fixed;
    }
    session.joints[1].parameters[SensorParameter::TorqueGain as usize].kind = PriorKind::Fixed;
    let session = recorded(session, [-FRAC_PI_2, FRAC_PI_2].map(|q| sweep(1, 2.0, &[q, 0.0])).to_vec());
    let report = check(&session).unwrap();
    let gravity = report.undetermined.iter().find(|open| open.undetermined.parameters[0] == "gravity").unwrap();
    let reported: Vec<&str> = gravity.cures.iter().map(|cure| cure.addition.as_str()).collect();
    assert!(reported[0].starts_with("record 20 more poses, spread"), "{reported:?}");
    assert!(reported[1].starts_with("record 20 of the poses again with joint1 at "), "{reported:?}");
    gravity.cures.iter().for_each(|cure| assert_cures(&session, &gravity.undetermined.parameters, cure));
}

/// Axes 2 and 3 are parallel: bare poses see only the sum of their offsets.
#[test]
fn offsets_of_parallel_axes_want_a_load() {
    let session = recorded(arm(&[90.0, 0.0, 0.0, 90.0, 0.0], TILTED), vec![random(None)]);
    let report = check(&session).unwrap();
    let offsets: Vec<&Curable> = report
        .undetermined
        .iter()
        .filter(|open| open.undetermined.parameters.iter().any(|name| name == "joint2.position_offset"))
        .collect();
    assert_eq!(offsets.len(), 1, "{:?}", report.undetermined);
    let first = offsets[0].cures.first().unwrap();
    assert!(first.addition.contains("load of known mass"), "{first:?}");
    assert_cures(&session, &offsets[0].undetermined.parameters, first);
}

#[test]
fn a_short_sweep_wants_a_wider_one() {
    let stands = [[0.4, -0.7], [-1.0, 0.3], [1.4, 1.2]];
    let runs = stands.map(|[first, second]| sweep(2, 0.01, &[first, second, 0.0]));
    let mut session = with_loads(arm(&[90.0, -90.0, 0.0], TILTED), true);
    for joint in 0..2 {
        session.joints[joint].parameters.iter_mut().for_each(|known| known.kind = PriorKind::Fixed);
    }
    let session = recorded(session, runs.to_vec());
    let report = check(&session).unwrap();
    let gain =
        report.undetermined.iter().find(|open| open.undetermined.parameters.contains(&"joint3.position_gain".into()));
    let gain = gain.unwrap_or_else(|| panic!("{:?}", report.undetermined));
    let reported: Vec<&str> = gain.cures.iter().map(|cure| cure.addition.as_str()).collect();
    assert!(reported[0].starts_with("record 20 more poses, spread"), "{reported:?}");
    let wider = gain.cures.iter().find(|cure| cure.addition.starts_with("record a sweep of joint3 from -115° to 115°"));
    assert_cures(&session, &gain.undetermined.parameters, wider.unwrap_or_else(|| panic!("{reported:?}")));
}

#[test]
fn the_last_offset_wants_a_load_at_a_known_place() {
    let session = recorded(with_loads(arm(&FOUR, TILTED), true), vec![random(None), random(Some(0)), random(Some(1))]);
    assert_first_cure(&session, "joint4.position_offset", "state the position of load `");
}

#[test]
fn an_unread_joint_is_to_be_read() {
    let mut session = arm(&FOUR, TILTED);
    session.joints[3].parameters[SensorParameter::TorqueGain as usize].kind = PriorKind::Fixed;
    let mut session = recorded(session, vec![random(None)]);
    session.poses.iter_mut().for_each(|pose| pose.torque[1] = None);
    let report = check(&session).unwrap();
    let gain =
        report.undetermined.iter().find(|open| open.undetermined.parameters.contains(&"joint2.torque_gain".into()));
    let cure = gain.unwrap().cures.first().unwrap();
    assert_eq!(cure.addition, "record the torque of joint2, too, in all poses");
}

#[test]
fn the_sign_of_gravity_is_open_until_stated_or_determined_by_a_load() {
    let mut bare = arm(&FOUR, TILTED);
    bare.gravity.hemisphere = None;
    let session = recorded(bare.clone(), vec![random(None)]);
    let report = check(&session).unwrap();
    assert!(!report.parameters[0].determined && !report.complete && report.assumes_upright);
    let sign = open(&report, "sign of gravity");
    assert!(sign.cures[0].addition.starts_with("state gravity's rough direction"), "{:?}", sign.cures);
    assert!(sign.cures.iter().any(|cure| cure.addition.contains("with a load of known mass")), "{:?}", sign.cures);
    // Without a declared direction it was judged on an upright base; the base of the simulation is tilted.
    let mut stated = with_cure(&session, &sign.cures[0]);
    stated.values.gravity = (9.8 * nalgebra::Vector3::from(TILTED).normalize()).into();
    assert_determines(&stated, &sign.undetermined.parameters, &sign.cures[0]);
    let session = recorded(with_loads(bare, true), vec![random(None), random(Some(0)), random(Some(1))]);
    let report = check(&session).unwrap();
    assert!(report.parameters[0].determined, "{:?}", report.undetermined);
}

/// What many poses say is weighed as if all had been kept.
#[test]
fn thinning_keeps_what_the_poses_say() {
    let session = recorded(
        with_loads(arm(&FOUR, TILTED), true),
        [None, Some(0), Some(1)].map(|load| (load, Run::Random { poses: 400, moving: None })).to_vec(),
    );
    let now = Hypothetical::now(&session).unwrap();
    let (all, part) = (now.judge().unwrap(), now.clone().thinned().judge().unwrap());
    assert_eq!(now.thinned().session.poses.len(), 300);
    for (all, part) in all.parameters.iter().zip(&part.parameters) {
        if let (Some(all_std), Some(part_std)) = (all.predicted_std, part.predicted_std) {
            assert!((part_std - all_std).abs() <= 0.25 * all_std, "{}: {all_std}, {part_std}", all.name);
        }
    }
}

/// Where moments are described by sweep, poses of no sweep are of no use: cures are sweeps.
#[test]
fn cures_are_sweeps_where_moments_are_described_by_sweep() {
    let mut session = crate::testing::sarcos_shoulder().template;
    session.inertia = gravcal_robot_model::session::InertiaPrior::Sweep;
    session.loads.clear();
    session.load_distances.clear();
    let runs = [[0.3, -0.6], [-0.9, 0.8]].map(|[first, second]| {
        [sweep(1, 1.5, &[first, 0.0, 0.4]), sweep(2, 1.5, &[first, second, 0.0]), sweep(0, 1.5, &[0.0, second, first])]
    });
    let session = recorded(session, runs.into_iter().flatten().collect());
    let report = check(&session).unwrap();
    let scale = open(&report, "common scale of all torque gains");
    let load = scale.cures.iter().find(|cure| {
        cure.addition.starts_with("record sweeps of each joint at two positions of the one before it each with a load")
    });
    let load = load.unwrap_or_else(|| panic!("{:?}", scale.cures));
    assert_cures(&session, &scale.undetermined.parameters, load);
}

/// All poses were approached from one side: friction looks like a bias.
#[test]
fn friction_wants_poses_approached_from_the_other_side() {
    use gravcal_robot_model::sensors::Options;

    use crate::testing::sensor_models::{shoulder, with_model};

    let friction = with_model(shoulder(), 1, "coulomb-friction", &Options::default(), &[3.0]);
    let mut session = friction.session(0);
    session.poses.iter_mut().for_each(|pose| pose.conditions.direction = vec![1.0; 3]);
    let report = check(&session).unwrap();
    let with_friction = report
        .undetermined
        .iter()
        .find(|open| open.undetermined.parameters.contains(&"joint2.coulomb_friction".into()));
    let open = with_friction.unwrap_or_else(|| panic!("{:?}", report.undetermined));
    assert_eq!(open.cures[0].addition, "record 20 of the poses again, each approached from the other side");
    assert_cures(&session, &open.undetermined.parameters, &open.cures[0]);
}

/// A load at a place that is given as exact stays there when gravity is turned over, so that it tells the sign.
#[test]
fn what_is_given_as_exact_is_not_turned_over() {
    let mut session = with_loads(arm(&FOUR, TILTED), false);
    session.loads[0].position = Some([0.1, 0.2, 0.3]);
    let over = State::nominal(&session).upside_down(&session);
    assert_eq!(over.loads[0], [0.1, 0.2, 0.3]);
    assert_eq!(over.loads[1], State::nominal(&session).loads[1].map(|component| -component));
}

/// Where a fit would find no noise `check` must not promise numbers: as many readings as unknowns.
#[test]
fn readings_that_leave_nothing_to_tell_their_noise_determine_nothing() {
    let few = |stated: bool, poses: usize| {
        let mut session = crate::testing::sarcos_shoulder().session(0);
        let every = session.poses.len() / poses;
        let mut place = 0;
        session.poses.retain(|_| {
            place += 1;
            place % every == 0
        });
        if !stated {
            session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|r| r.std = None);
        }
        check(&session).unwrap()
    };
    let determined = |report: &CheckReport| {
        report.parameters.iter().filter(|parameter| parameter.determined && parameter.held.is_none()).count()
    };
    let untold = |report: &CheckReport| {
        report.undetermined.iter().any(|open| open.undetermined.combination == "the size of the noise")
    };
    let of = |poses: usize| (few(true, poses), few(false, poses));
    let counts: Vec<(usize, bool, usize, bool)> = (4..10)
        .map(of)
        .map(|(stated, unstated)| (determined(&stated), untold(&stated), determined(&unstated), untold(&unstated)))
        .collect();
    assert!(counts.iter().all(|(_, stated, left, unstated)| !stated && (*left == 0 || !unstated)), "{counts:?}");
    assert!(counts.iter().any(|(known, _, _, unstated)| *known > 0 && *unstated), "{counts:?}");
    let (_, more) = of(40);
    assert!(!untold(&more) && determined(&more) > 0, "{:?}", more.undetermined);
}
