//! Both descriptions of the moments: what each can know (second table of section 4 of the estimation model), and that they
//! agree.

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{InertiaPrior, ReadingId, Session};
use gravcal_session::simulation::{Run, Simulation};
use gravcal_solvers::LevenbergMarquardt;

use crate::joint::{self, Signals, Solved, State, estimate_jointly};
use crate::result::{EstimatorResult, Verdict};
use crate::testing::sarcos_shoulder;

/// What the data determine of `g`, all `s` and `b`, `o_2 … o_{n−1}`, and how many directions of the gains `k` they leave open.
#[derive(Debug, PartialEq)]
struct Known {
    gravity: bool,
    gains_and_biases: bool,
    offsets: bool,
    open_torque_gains: usize,
}

/// Judges the reference protocol's session at the truth, with the readings that are kept.
fn known(session: &Session, truth: &State, keep: impl Fn(ReadingId) -> bool) -> Known {
    let readings = joint::select(session, Signals::All).only(keep);
    let built = joint::build_problem(session, &readings, truth).unwrap();
    let solved = Solved::at_start(built).unwrap();
    let open = |blocks: Vec<gravcal_estimation::BlockId>| {
        let columns: Vec<usize> = blocks.into_iter().flat_map(|id| solved.built.problem.columns_of(id)).collect();
        solved.analysis.null_space_within(&columns).len()
    };
    let sensors = &solved.built.variables.sensors;
    let of = |quantity: SensorParameter| sensors.iter().map(|ids| ids[quantity as usize]).collect::<Vec<_>>();
    Known {
        gravity: open(vec![solved.built.variables.gravity]) == 0,
        gains_and_biases: open([of(SensorParameter::PositionGain), of(SensorParameter::TorqueBias)].concat()) == 0,
        offsets: open(of(SensorParameter::PositionOffset)) == 0,
        open_torque_gains: open(of(SensorParameter::TorqueGain)),
    }
}

/// The joint that sweeps in each pose.
fn swept(simulation: &Simulation, session: &Session) -> Vec<usize> {
    let of_table = |table: usize| match simulation.runs[table] {
        Run::Sweep { swept, .. } => swept,
        Run::Random { .. } => unreachable!("the reference protocol has sweeps only"),
    };
    session.poses.iter().map(|pose| of_table(pose.table)).collect()
}

/// The reference protocol described by sweep. Of the loaded sweeps those with one of the first `placements` placements are
/// kept; joint 2 stands at two positions while joint 3 sweeps also without a load.
fn protocol(placements: usize) -> (Simulation, Session) {
    let mut simulation = sarcos_shoulder();
    simulation.template.inertia = InertiaPrior::Sweep;
    for table in 7..11 {
        let (run, mut of_table) = (simulation.runs[table].clone(), simulation.template.tables[table].clone());
        of_table.load = None;
        if table % 2 == 1 {
            simulation.runs.push(run);
            simulation.template.tables.push(of_table);
        }
    }
    let mut session = simulation.session(0);
    session.poses.retain(|pose| pose.load.is_none_or(|load| load < placements));
    (simulation, session)
}

const EVERYTHING_BUT_GAINS: Known =
    Known { gravity: true, gains_and_biases: true, offsets: true, open_torque_gains: 3 };

#[test]
fn the_swept_joints_own_torque_tells_no_torque_gain_and_the_offset_only_from_two_positions() {
    let (simulation, session) = protocol(0);
    let swept = swept(&simulation, &session);
    let own = |id: ReadingId| swept[id.pose] == id.channel;
    assert_eq!(known(&session, &simulation.truth, own), EVERYTHING_BUT_GAINS);
    let steps_1_and_2 = |id: ReadingId| own(id) && session.poses[id.pose].table < 5;
    let known = known(&session, &simulation.truth, steps_1_and_2);
    assert_eq!(known, Known { offsets: false, ..EVERYTHING_BUT_GAINS });
}

#[test]
fn all_torques_without_a_second_placement_leave_the_common_scale() {
    let common_scale = Known { open_torque_gains: 1, ..EVERYTHING_BUT_GAINS };
    for placements in [0, 1] {
        let (simulation, session) = protocol(placements);
        let steps_1_and_2 = |id: ReadingId| session.poses[id.pose].table < 11;
        assert_eq!(known(&session, &simulation.truth, steps_1_and_2), common_scale, "{placements}");
    }
}

#[test]
fn two_placements_tell_the_gain_of_every_joint_that_is_read() {
    let (simulation, session) = protocol(2);
    let swept = swept(&simulation, &session);
    // Step 3 reads joint i while i + 1 sweeps; the last joint's own torque only without a load.
    let paper = |ReadingId { pose, channel }: ReadingId| match session.poses[pose].load {
        None => swept[pose] == channel,
        Some(_) => swept[pose] == channel + 1,
    };
    let all_but_last = Known { open_torque_gains: 1, ..EVERYTHING_BUT_GAINS };
    assert_eq!(known(&session, &simulation.truth, paper), all_but_last);
    let and_swept = |id: ReadingId| paper(id) || swept[id.pose] == id.channel;
    let all = Known { open_torque_gains: 0, ..EVERYTHING_BUT_GAINS };
    assert_eq!(known(&session, &simulation.truth, and_swept), all);
}

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

/// The same data through both descriptions: the sweep moments know less, and what they say holds the other's answer.
#[test]
fn both_descriptions_agree_within_their_intervals() {
    for trial in 0..4 {
        let mut session = sarcos_shoulder().session(trial);
        let links = estimate(&session);
        session.inertia = InertiaPrior::Sweep;
        let sweeps = estimate(&session);
        assert_eq!((links.verdict, sweeps.verdict), (Verdict::Determined, Verdict::Determined));
        assert!(sweeps.fit.as_ref().unwrap().p_value.unwrap() > 1e-3);
        for (link, sweep) in links.parameters.iter().zip(&sweeps.parameters).filter(|(p, _)| p.held.is_none()) {
            let (of_links, of_sweeps) = (link.std.unwrap(), sweep.std.unwrap());
            assert!(of_sweeps > 0.999 * of_links, "{}: {of_sweeps}, {of_links}", link.name);
            // Links know everything that sweeps know, so that the variance of the difference is that of the variances.
            let difference = (sweep.value.unwrap() - link.value.unwrap()).abs();
            let std = (of_sweeps * of_sweeps - of_links * of_links).max(0.0).sqrt();
            assert!(difference <= 4.0 * std + 1e-3 * of_links, "{}: {difference}, {std}", link.name);
        }
    }
}

/// Lengths that are wrong make the links' answer wrong, and the sweeps' does not see them.
#[test]
fn sweeps_need_no_lengths() {
    let mut session = sarcos_shoulder().session(0);
    session.inertia = InertiaPrior::Sweep;
    let right = estimate(&session);
    session.robot.chain = with_lengths(&session);
    let other = estimate(&session);
    for (a, b) in right.parameters.iter().zip(&other.parameters).filter(|(a, _)| a.held.is_none()) {
        assert!((a.value.unwrap() - b.value.unwrap()).abs() < 0.02 * a.std.unwrap(), "{}", a.name);
    }
}

/// The reference robot with some lengths that it does not have.
fn with_lengths(session: &Session) -> gravcal_dynamics::Chain {
    let chain = &session.robot.chain;
    let longer = |joint: &gravcal_dynamics::Joint| gravcal_dynamics::Joint {
        after: joint.after * gravcal_dynamics::Transform::along([0.3, -0.2, 0.1]),
        ..joint.clone()
    };
    gravcal_dynamics::Chain::new("base", chain.joints().iter().map(longer).collect(), chain.links().to_vec()).unwrap()
}
