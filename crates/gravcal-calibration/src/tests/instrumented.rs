//! Wrist sensor and accelerometer beside the joints' torques: they tighten gravity as their information says.

use gravcal_robot_model::session::Session;
use gravcal_session::simulation::Simulation;
use nalgebra::{DMatrix, Matrix3};

use crate::joint::{self, JointProblem, MeasurementSet, Signals, Solved, estimate_jointly};
use crate::result::Verdict;
use crate::testing::{sarcos_with_instruments, with_environment};

/// Only the channels for which `keep` holds.
fn part(session: &Session, keep: impl Fn(usize) -> bool) -> MeasurementSet {
    joint::select(session, Signals::All).only(|id| keep(id.channel))
}

fn at_truth(simulation: &Simulation, session: &Session, readings: MeasurementSet) -> Solved {
    let built = joint::build_problem(session, &readings, &simulation.truth).unwrap();
    Solved::at_start(built).unwrap()
}

/// Information of a problem at its start about its columns, and what these are.
fn information(built: &JointProblem) -> (DMatrix<f64>, Vec<String>) {
    let problem = &built.problem;
    let width = problem.columns().len();
    let rows = problem.augmented_jacobian(&built.initial).unwrap();
    let jacobian = DMatrix::from_fn(rows.len() / (width + 1), width, |i, j| rows[i * (width + 1) + j]);
    let name = |c: &gravcal_estimation::Column| format!("{} {}", problem.block(c.block).name, c.index);
    (jacobian.tr_mul(&jacobian), problem.columns().iter().map(name).collect())
}

/// Information about some of the columns, all others being unknown: the Schur complement, with the pseudo-inverse of what
/// is eliminated, as some of it may be undetermined.
fn marginal((full, names): &(DMatrix<f64>, Vec<String>), kept: &[String]) -> DMatrix<f64> {
    let place = |name: &String| names.iter().position(|other| other == name);
    let other: Vec<usize> = (0..names.len()).filter(|i| !kept.contains(&names[*i])).collect();
    let entry = |i: Option<usize>, j: Option<usize>| i.zip(j).map_or(0.0, |(i, j)| full[(i, j)]);
    let n = kept.len();
    let own = DMatrix::from_fn(n, n, |i, j| entry(place(&kept[i]), place(&kept[j])));
    let across = DMatrix::from_fn(n, other.len(), |i, j| entry(place(&kept[i]), Some(other[j])));
    let scale: Vec<f64> = other.iter().map(|i| full[(*i, *i)].sqrt().max(1e-12)).collect();
    let eliminated =
        DMatrix::from_fn(other.len(), other.len(), |i, j| full[(other[i], other[j])] / (scale[i] * scale[j]));
    let across = DMatrix::from_fn(n, other.len(), |i, j| across[(i, j)] / scale[j]);
    let eigen = eliminated.symmetric_eigen();
    let rotated = &across * &eigen.eigenvectors;
    let largest = eigen.eigenvalues.max();
    let weight = |value: f64| if value > 1e-11 * largest { 1.0 / value } else { 0.0 };
    own - DMatrix::from_fn(n, n, |i, j| {
        (0..other.len()).map(|k| rotated[(i, k)] * weight(eigen.eigenvalues[k]) * rotated[(j, k)]).sum()
    })
}

#[test]
fn the_joint_problem_has_the_sum_of_their_informations() {
    let simulation = sarcos_with_instruments();
    let session = simulation.session(0);
    let solved = |keep: &dyn Fn(usize) -> bool| at_truth(&simulation, &session, part(&session, keep));
    let kinds: [&dyn Fn(usize) -> bool; 3] = [&|c| c < 3, &|c| (3..9).contains(&c), &|c| c >= 9];
    let parts = kinds.map(|keep| information(&solved(keep).built));
    // What more than one of them depends on: gravity, positions, placements.
    let shared: Vec<String> = {
        let all = information(&solved(&|_| true).built).1;
        let own = |name: &String| {
            ["gain", "bias", "link", "tool"].iter().any(|own| name.contains(own)) && !name.contains("position_gain")
        };
        all.into_iter().filter(|name| !own(name)).collect()
    };
    let sum: DMatrix<f64> = parts.iter().map(|part| marginal(part, &shared)).sum();
    let gravity = &shared[..2];
    let expected = marginal(&(sum, shared.clone()), gravity).try_inverse().unwrap();
    let all = solved(&|_| true);
    let columns: Vec<usize> = all.built.problem.columns_of(all.built.variables.gravity).collect();
    for (i, row) in columns.iter().enumerate() {
        for (j, column) in columns.iter().enumerate() {
            let found = all.covariance().at(*row, *column);
            let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
            assert!((found - expected[(i, j)]).abs() < 1e-6 * scale, "{found} {expected}");
        }
    }
    // Each of them is worth something.
    let trace = |keep: &dyn Fn(usize) -> bool| Matrix3::from_row_slice(&solved(keep).gravity_covariance()).trace();
    let [all, without_wrist, without_imu] = [trace(&|_| true), trace(&|c| !(3..9).contains(&c)), trace(&|c| c < 9)];
    assert!(all < 0.9 * without_wrist && all < 0.9 * without_imu, "{all} {without_wrist} {without_imu}");
}

/// Its first moment by its mass, with the standard deviation of that.
#[test]
fn the_centre_of_mass_of_the_tool_is_reported() {
    let simulation = sarcos_with_instruments();
    let session = simulation.session(0);
    let result = with_environment(|environment| estimate_jointly(&session, Signals::All, None, environment)).unwrap();
    let reported =
        result.notes.iter().find_map(|note| note.strip_prefix("What hangs beyond wrist has its centre of mass at "));
    let reported = reported.unwrap_or_else(|| panic!("{:?}", result.notes));
    let wrist = session.instruments.iter().find(|instrument| instrument.name == "wrist").unwrap();
    let [mass, moment @ ..] = &simulation.truth.further[wrist.own_parameters()] else { panic!() };
    let numbers: Vec<f64> = reported.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    assert_eq!((numbers.len(), moment.len()), (6, 3), "{reported}");
    for (reported, moment) in numbers.chunks(2).zip(moment) {
        assert!(
            (reported[0] - moment / mass).abs() < 4.5 * reported[1] && reported[1] > 0.0 && reported[1] < 0.01,
            "{reported:?} {moment}"
        );
    }
}

#[test]
fn errors_of_gravity_fall_with_them_as_the_bound_says() {
    let simulation = sarcos_with_instruments();
    let mut ratios = [0.0, 0.0];
    let trials = 40;
    with_environment(|environment| {
        for trial in 0..trials {
            let session = simulation.session(trial);
            for (ratio, last) in ratios.iter_mut().zip([3, 12]) {
                let readings = part(&session, |channel| channel < last);
                let built = joint::build_problem(&session, &readings, &simulation.truth).unwrap();
                let solved = joint::solve_built(built, environment).unwrap();
                let found = solved.state(&simulation.truth).gravity;
                let square: f64 = found.iter().zip(simulation.truth.gravity).map(|(a, b)| (a - b).powi(2)).sum();
                let bound = at_truth(&simulation, &session, readings);
                let variance = Matrix3::from_row_slice(&bound.gravity_covariance()).trace();
                *ratio += square / variance / trials as f64;
            }
        }
    });
    // Mean of a sum of two squares of unit variance in all, 40 times: standard deviation 0.16 at most.
    assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.5), "{ratios:?}");
}

/// Many arms have no torque sensors at the joints.
#[test]
fn an_arm_without_torque_sensors_is_calibrated_by_its_instruments() {
    let mut simulation = sarcos_with_instruments();
    simulation.template.joints.iter_mut().for_each(|joint| joint.torque_unit = None);
    let session = simulation.session(0);
    assert!(session.poses.iter().all(|pose| pose.torque.iter().all(Option::is_none)));
    let result = with_environment(|environment| estimate_jointly(&session, Signals::All, None, environment)).unwrap();
    assert_eq!(result.verdict, Verdict::Determined, "{:?} {}", result.undetermined, result.termination);
    let gravity = result.gravity.unwrap();
    for ((value, std), truth) in gravity.vector_m_per_s2.iter().zip(gravity.std_m_per_s2).zip(simulation.truth.gravity)
    {
        assert!((value - truth).abs() < 4.0 * std && std < 0.02, "{value} ± {std}, not {truth}");
    }
    for parameter in result.parameters.iter().filter(|p| p.asked && p.held.is_none()) {
        let (value, std) = (parameter.value.unwrap(), parameter.std.unwrap());
        let joint = session.parameters().into_iter().find(|id| session.parameter_name(*id) == parameter.name).unwrap();
        let truth = simulation.truth.value(joint);
        assert!((value - truth).abs() < 4.5 * std, "{}: {value} ± {std}, not {truth}", parameter.name);
    }
    let fit = result.fit.unwrap();
    assert_eq!(fit.joints.len(), 9);
    assert_eq!((fit.joints[0].joint.as_str(), fit.joints[6].joint.as_str()), ("wrist.fx", "imu.x"));
}
